// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace splinevox::run {

/// Bounds of what may be asked for.
inline constexpr int kMostTrueViews = 100, kLeastViewSize = 16, kMostViewSize = 4096;
inline constexpr double kLeastMb = 0.05, kMostMb = 1000;

/// What `splinevox view` is asked for.
struct ViewRequest {
  std::string run, out;        ///< folder of a run; the page
  std::string data;            ///< folder of its data set; empty: the run's own
  std::string split = "test";  ///< of the true pictures
  int views = 6;               ///< of those
  int view_size = 400;         ///< their longest side at most, pixels
  double max_mb = 20;          ///< of the page, 10^6 bytes
};

struct WrittenView {
  std::size_t bytes = 0, true_pictures = 0;
  std::string note;                ///< how numbers are kept
  std::vector<std::string> lacks;  ///< what the page is without, and why
};

/// Writes the page of a run. Throws Error: input if a number is out of its bounds or if it does not fit,
/// output.
WrittenView write_view(const ViewRequest& request);

}  // namespace splinevox::run
