// SPDX-License-Identifier: Apache-2.0
// Steps whose loss or gradients could not be used.
#include <limits>
#include <string>

#include "math/photometric.hpp"
#include "splinevox/core/error.hpp"
#include "train/state.hpp"

namespace splinevox {
namespace {

std::string description(const StepReport& report, bool among_ranks) {
  const std::string rows = std::to_string(report.bad_rows) + " rows of the gradient";
  if (!report.bad_rays.empty())
    return rows + ", from ray " + std::to_string(report.bad_rays[0].index) + " of training view " +
           std::to_string(report.bad_rays[0].frame) + " first";
  return rows + (among_ranks ? ", from no ray of this process" : ", from no ray: from a regulariser");
}

}  // namespace

StepReport Trainer::State::discard(const StepSums& sums, StepReport report) {
  // After the throw below they are still there to be read; who goes on all the same begins to count anew.
  if (int(discarded.size()) == kMostDiscarded) discarded.clear();
  report.discarded = true;
  report.bad_rows = sums.bad_rows;
  report.loss = report.psnr = std::numeric_limits<double>::quiet_NaN();
  for (const int i : home.bad_rays()) {
    if (report.bad_rays.size() == kBadRaysKept) break;
    const RayInput<float>& ray = batch.rays[i];
    const int slot = batch.slot_of(i);
    report.bad_rays.push_back({batch.patches[std::size_t(i) / 4].frame, i, ray.origin, ray.direction,
                               colour_of(batch.targets[i]), batch.times[slot]});
  }
  discarded.push_back(report);
  if (int(discarded.size()) < kMostDiscarded) return report;
  clock.step -= kMostDiscarded;
  throw Error(
      {"step " + std::to_string(clock.step + 1),
       std::to_string(kMostDiscarded) + " steps in a row were not finite; the model is as it was before them",
       "finite losses and gradients", description(report, ranks != nullptr),
       "smaller weights of losses and smaller learning rates (--set loss... and optimiser...)"},
      Fault::numeric);
}

}  // namespace splinevox
