// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace splinevox::cost {

using Json = nlohmann::ordered_json;

/// A figure with the 95% interval of its median.
struct Figure {
  double value = 0, lo = 0, hi = 0;
};

/// One measured setting: a point of the diagram, a row of the table, a line of cost.jsonl. Everything that is
/// shown is made from these lines alone.
struct Record {
  std::string suite;        ///< "train", "render", "spline" or "versus"
  std::string scene;        ///< what it was measured on
  std::string knob, value;  ///< what was changed, to what; knob "default" for the settings as they are
  double order = 0;         ///< place of the value along its knob
  Figure error, seconds;    ///< see the suite for what they are an error and a time of
  double quality = 0;       ///< train, versus: PSNR in dB; else 0
  double samples = 0;       ///< per ray where there are rays, else 0
  double memory = 0;        ///< versus: the process' peak, bytes; else 0
  double instructions = 0;  ///< of one run, 0 where the machine does not count them
  int runs = 0;             ///< seeds or repetitions behind the figures
  bool is_default = false, expected_dominated = false, failed = false;
  std::string note;
  std::string where;  ///< machine, threads, compiler and commit of the measurement
};

/// Figures that are not finite become null, and come back as NaN.
Json to_json(const Record& r);
/// Throws nlohmann's exceptions for a line that is not one of ours. Lines from before `where` come without.
Record from_json(const Json& j);

/// Indices of the records no other of the same suite and scene beats in both error and time, by time. Failed
/// ones never are.
std::vector<std::size_t> pareto_front(const std::vector<Record>& records);
/// How many times as long as the fastest record of at most its error (and of its suite and scene) a record
/// takes; 1 on the front.
double distance_to_front(const std::vector<Record>& records, const Record& of);

}  // namespace splinevox::cost
