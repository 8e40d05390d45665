// SPDX-License-Identifier: Apache-2.0
#include "cli/scores_print.hpp"

#include <fmt/format.h>

#include "run/events.hpp"
#include "run/standard_output.hpp"

namespace splinevox::cli {

void print_scores_head(const std::string& split, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) fmt::print("note: {}\n", note);
  fmt::print("{:<16} {:>7} {:>8} {:>8} {:>8}\n", split + " view", "time", "PSNR", "SSIM", "MS-SSIM");
}

void print_view(const Frame& frame, const run::View& v) {
  fmt::print("{:<16} {:>7.4f} {:>8.3f} {:>8.4f} {:>8.4f}\n", frame.name, frame.time, v.psnr, v.ssim,
             v.ms_ssim);
  run::flush_output();
}

void print_means(const run::Scores& s, const run::Json& figures) {
  fmt::print("{:<16} {:>7} {:>8.3f} {:>8.4f} {:>8.4f}   ({} views)\n", "mean", "", s.psnr, s.ssim, s.ms_ssim,
             s.views.size());
  fmt::print("{:<16} {:>7} {:>8.3f}   (each view times its best gain per channel)\n", "at best exposure", "",
             s.psnr_best_gain);
  if (s.psnr_inside)
    fmt::print("{:<16} {:>7} {:>8.3f} {:>17}   ({} views, {:.1f}% of their pixels)\n", "inside the masks", "",
               *s.psnr_inside, "", s.inside_views, 100 * s.inside_share);
  if (s.ignored_share > 0)
    fmt::print("{:.1f}% of all pixels are ignored, as the masks say: not in these figures\n",
               100 * s.ignored_share);
  if (!figures.contains("metrics")) return;
  for (const auto& [name, value] : figures["metrics"].items())
    fmt::print("{:<16} {:>7} {:>8.4f}   (mean over the views, by --metric)\n", name, "", value.get<double>());
}

void tell_scores(run::Json figures, const std::vector<std::string>& notes) {
  figures["notes"] = notes;
  run::write_event("result", figures);
}

}  // namespace splinevox::cli
