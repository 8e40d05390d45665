// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/step.hpp"

namespace splinevox {

/// What training keeps beside one value array: moments, and per column a learning rate and a total variation
/// weight.
struct Learner {
  AlignedVector<float> m, v;    ///< first and second moments, same rows
  std::vector<float> rate, tv;  ///< [width]; 0 in padding
  std::vector<Shrink> shrink;   ///< groups of columns

  Learner() = default;
  explicit Learner(const Channels& values)
      : m(values.values.size(), 0.0f),
        v(values.values.size(), 0.0f),
        rate(values.width, 0.0f),
        tv(values.width, 0.0f) {}
};

/// An array and its learner as a backend takes them.
inline LearnedRows learned(Channels& values, Learner& learner) {
  return {&values, &learner.m, &learner.v, learner.rate, learner.tv, learner.shrink, {}};
}

}  // namespace splinevox
