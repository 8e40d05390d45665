// SPDX-License-Identifier: Apache-2.0
#include "train/config/loss_terms.hpp"

#include <algorithm>

namespace splinevox {
namespace {

float power(float base, int exponent) {
  float out = 1;
  for (int i = 0; i < exponent; ++i) out *= base;
  return out;
}

}  // namespace

LossConfig in_unit_of_brightness(LossConfig loss, float unit) {
  for (const LossTerm& term : kLossTerms) loss.*term.weight *= power(unit, term.brightness);
  return loss;
}

LossConfig in_scene_units(LossConfig loss, float edge) {
  for (const LossTerm& term : kLossTerms) loss.*term.weight /= power(edge, term.edges);
  return loss;
}

LossConfig for_trials(LossConfig loss) {
  for (const LossTerm& term : kLossTerms)
    if (!term.in_trials) loss.*term.weight = 0;
  return loss;
}

bool can_spoil_gradients(const LossConfig& loss) {
  constexpr float kLargest = 1e12f;  // far from where a float has no square, far above what anybody asks for
  float most = 0;
  for (const LossTerm& term : kLossTerms)
    if (term.guarded) most = std::max(most, loss.*term.weight);
  return !(most / loss.tv_share < kLargest);
}

}  // namespace splinevox
