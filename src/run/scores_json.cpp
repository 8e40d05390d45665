// SPDX-License-Identifier: Apache-2.0
#include "run/scores_json.hpp"

#include <utility>

#include "splinevox/math/metrics.hpp"

namespace splinevox::run {

Json scores_json(const Scores& s) {
  Json frames = Json::array();
  for (const ViewScore& v : s.views) {
    Json frame{{"name", v.name}, {"time", v.time},       {"psnr", capped_psnr(v.psnr)},
               {"ssim", v.ssim}, {"ms_ssim", v.ms_ssim}, {"psnr_best_gain", capped_psnr(v.psnr_best_gain)}};
    if (v.psnr_inside) frame["psnr_inside"] = capped_psnr(*v.psnr_inside);
    frames.push_back(std::move(frame));
  }
  Json j{{"psnr", s.psnr},
         {"ssim", s.ssim},
         {"ms_ssim", s.ms_ssim},
         {"psnr_best_gain", s.psnr_best_gain},
         {"split", s.split}};
  if (s.psnr_inside) {
    j["psnr_inside"] = *s.psnr_inside;
    j["inside_views"] = s.inside_views;
    j["inside_share"] = s.inside_share;
  }
  if (s.ignored_share > 0) j["ignored_share"] = s.ignored_share;
  j["frames"] = std::move(frames);
  return j;
}

}  // namespace splinevox::run
