// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "run/support.hpp"
#include "splinevox/run/evaluate.hpp"

namespace splinevox::run {

/// Figures that other programs work out of a render and its truth, such as LPIPS. Each is "NAME=COMMAND", a
/// line for `sh`. COMMAND is given the two files and prints one number. With {list} in it, it is called once
/// at the end: {list} becomes a file with "RENDER<tab>TRUTH" a line, and it prints a number for each line.
/// Pictures are PNG of 8 bits a channel; where pixels are ignored the render has the truth.
class OuterMetrics {
 public:
  /// Throws Error (input) for a name that is none or is there twice, and for no command.
  explicit OuterMetrics(const std::vector<std::string>& words);
  OuterMetrics(const OuterMetrics&) = delete;
  OuterMetrics& operator=(const OuterMetrics&) = delete;
  ~OuterMetrics();

  /// A view, in order. Throws Error: input naming the command and what it said if it fails or prints no
  /// finite number, output.
  void take(const Frame& frame, const View& view);
  /// After the last one: `metrics` of the figures gets the means, that of each of its `frames` its own.
  /// Throws as take.
  void finish(Json& figures);

 private:
  struct Metric {
    std::string name, command;
    bool at_once = false;
    std::vector<double> values = {};  ///< of the views so far
  };
  std::vector<double> ask(const Metric& metric, const std::vector<std::string>& words) const;
  std::vector<Metric> metrics_;
  std::filesystem::path folder_;  ///< of pictures; empty until there are any
  std::string list_;
  std::size_t views_ = 0;
};

}  // namespace splinevox::run
