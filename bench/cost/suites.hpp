// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "record.hpp"

namespace splinevox::cost {

struct SuiteOptions {
  bool micro = false;               ///< small enough for a minute in all, on built-in data
  std::vector<std::string> scenes;  ///< data sets; none: the built-in dancer
  int steps = 3000, seeds = 3;      ///< of the training suite
  std::vector<std::string> knobs;   ///< of the training suite: only these; empty: all
  int rounds = 15;                  ///< of the timed suites
  std::vector<int> versus_steps{10, 25, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12800};
  std::string where;  ///< machine, threads, compiler and commit
};

/// Called after every finished record.
using OnRecord = std::function<void(Record)>;

/// Evaluating a curve of K points: error in units of float rounding of the largest coordinate against long
/// double, nanoseconds per 3-vector. Methods: De Casteljau, Bernstein weights per curve, weights shared by
/// all curves of one time, Horner, forward differences along equally spaced times.
void spline_suite(const SuiteOptions& o, const OnRecord& on_record);

/// Rendering a trained model: root mean square colour error against a double-precision reference, seconds a
/// frame. The reference is Richardson's extrapolation of the midpoint rule at 1/32 and 1/64 of a march step.
/// @return  of the first scene, the order of convergence in double precision between steps of 1/4 and 1/16: 2
/// for the midpoint rule.
double render_suite(const SuiteOptions& o, const OnRecord& on_record);

/// Training with one number of the preset changed at a time: root mean square colour error of the test views,
/// processor seconds of training. The other presets run with as many steps. Every seed is a run; all settings
/// of one seed run before the next seed does.
/// @param runs  file with a line for every finished run; those it has are not made again.
void train_suite(const SuiteOptions& o, const std::string& runs, const OnRecord& on_record);

/// Voxels beside perceptrons on the same scenes: root mean square colour error of the test views against
/// processor seconds, summed over cores. The voxels run once for each of versus_steps, each a run of its own
/// with its schedule laid out over its steps; reading the pictures, trying out effects and making the model
/// are in their seconds, while those of the perceptrons are of training alone. All are measured at the pixels
/// of the test views that the perceptrons were; o.seeds runs of each number of steps.
/// @param runs  finished splinevox-mlp runs with --cpu-time and --test-at; every scene of theirs must be
/// among o.scenes.
void versus_suite(const SuiteOptions& o, const std::vector<std::string>& runs, const OnRecord& on_record);

}  // namespace splinevox::cost
