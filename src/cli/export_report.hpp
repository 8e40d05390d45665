// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "cli/command.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox::cli {

/// What the user is told of an export: a bar or JSON lines while it runs, a summary at its end.
class ExportReport {
 public:
  enum class Talk { quiet, json, bar, summary };
  /// @param options  must outlive the report
  ExportReport(Talk talk, const ExportOptions& options);
  /// One more of `total` frames is there.
  void add(const ExportedFrame& frame, int done, int total);
  /// After the last one. @param processes  that made the frames @param model  that they show
  void summarise(const ExportResult& result, const std::string& folder, int processes,
                 const VoxelModel& model) const;

 private:
  /// What is not in the frames, and how to open them.
  void advise(const std::string& folder, const VoxelModel& model) const;
  void print_line(const ExportedFrame& frame) const;

  Talk talk_;
  const ExportOptions& options_;
  double bytes_ = 0, speed_ = 0, writing_ = 0;
  double short_ = 0;   ///< voxels of velocity that the fastest matter asks for and does not get
  bool wide_ = false;  ///< some grid did not fit 16-bit floats
  int kept_ = 0;
  std::chrono::steady_clock::time_point start_;
  double cpu_;
};

}  // namespace splinevox::cli
