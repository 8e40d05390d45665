// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "view/page.hpp"

namespace splinevox::run {

/// A model as the page fetches it: the length of the header in four bytes, the lowest first; the header,
/// JSON; the bytes of PackedScene.
struct LiveModel {
  std::shared_ptr<const std::string> bytes;
  std::int64_t step = -1;
};

/// Packs models on a thread of its own, one at a time, while training goes on.
class ModelPacker {
 public:
  ModelPacker();
  ~ModelPacker();

  /// Whether no model is being packed.
  bool idle() const;
  /// @param page  what is on the page beside the model @pre idle()
  void take(VoxelModel model, const ViewPage& page, std::int64_t step);
  /// The last that was packed. bytes is null: none was.
  LiveModel latest() const;
  /// Seconds of a processor that packing has taken, and that the last model took.
  double spent() const;
  double last() const;

 private:
  struct Job {
    VoxelModel model;
    ViewPage page;
    std::int64_t step;
  };
  void work();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Job> job_;
  bool busy_ = false, closing_ = false;
  LiveModel latest_;
  double spent_ = 0, last_ = 0;
  std::thread thread_;
};

}  // namespace splinevox::run
