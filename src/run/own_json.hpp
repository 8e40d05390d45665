// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "run/support.hpp"

/// The JSON files of a run. A stranger may have written them, as whoever sends a run: each is read strictly
/// (nesting, repeated fields), and the fields that this program uses are of the types it writes. Throws Error
/// (input) naming file and field. Fields it does not know pass.
namespace splinevox::run {

/// metrics.json: an object. Numbers that were not finite are not there. @param path  of the file
Json read_metrics(const std::string& path);
/// The same of a run that need not have one; then it is empty.
Json read_metrics_if_there(const std::string& path);

/// A line of metrics.jsonl as it is in the file, and what it says.
struct MetricsLine {
  std::string text;
  Json json;  ///< an object
};
/// metrics.jsonl without the lines that are torn, as a full disk or a kill leaves them. Empty if there is
/// none.
std::vector<MetricsLine> read_metrics_lines(const std::string& path);

/// effects.json; null if there is none.
Json read_effects_if_there(const std::string& path);

/// What edit.json says was done, the newest last: an array. Empty if there is no such file.
Json read_history_if_there(const std::string& path);

}  // namespace splinevox::run
