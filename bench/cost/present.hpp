// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "record.hpp"

namespace splinevox::cost {

/// Work-precision diagram of the records of one suite and scene: time against error, both logarithmic, the
/// Pareto front as a line, intervals as bars, failures as crosses on the upper rim. A whole SVG file.
std::string diagram(const std::vector<Record>& records, const std::string& title);
/// A Markdown table of the same, fastest first, with the A/A row.
std::string table(const std::vector<Record>& records);
/// One sentence per setting: what it costs and gains beside the default. Differences within the A/A row's
/// interval are called none.
std::string sentences(const std::vector<Record>& records);

/// The name, among the systems of suite "versus", of a picture without anything in it.
inline constexpr const char* kBackgroundAlone = "background alone";

/// Of the records of suite "versus" of one scene: processor seconds to 24, 27 and 30 dB, PSNR after 1, 5 and
/// 15 minutes of two cores, peak memory, and how many times as long a perceptron took to its best PSNR as the
/// voxels took to the same. Markdown.
std::string versus_table(const std::vector<Record>& records);

/// Records of each suite and scene on their own, in order of appearance.
std::vector<std::vector<Record>> by_scene(const std::vector<Record>& records);

}  // namespace splinevox::cost
