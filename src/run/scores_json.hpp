// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "run/support.hpp"
#include "splinevox/run/evaluate.hpp"

namespace splinevox::run {

/// The figures of a split as metrics.json and Python have them: psnr, ssim, ms_ssim, psnr_best_gain, split,
/// those inside the masks where there are any, frames.
Json scores_json(const Scores& scores);

}  // namespace splinevox::run
