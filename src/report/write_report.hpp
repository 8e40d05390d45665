// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace splinevox::run {

/// What `splinevox report` is asked for.
struct ReportRequest {
  std::vector<std::string> runs;  ///< folders, one or more
  std::string out;                ///< the page
  std::string data;               ///< folder of their data set; empty: each run's own
  int views = 6;                  ///< pictures of each
};

/// Writes the page and returns its size, bytes. Throws Error: input, output.
std::size_t write_report(const ReportRequest& request);

}  // namespace splinevox::run
