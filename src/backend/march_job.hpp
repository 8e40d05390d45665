// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/train_kernel.hpp"

namespace splinevox {

/// TrainKernel's arguments before its template arguments are known.
struct MarchJob {
  FieldView<float> field;
  const FrameView<float>* frames;
  const RayInput<float>* rays;
  const Vec3* targets;
  RayOutcome* outcomes;
  int ray_count, rays_per_slot, most_samples;
  RayLosses losses;
  float largest;
  GradientRows radiance;
  const GradientRows* motion;
  Vec3* behind;
};

/// Runs the rays of a job with the kernel for its harmonics. Declared here and defined per order, so that the
/// orders compile at the same time (src/backend/CMakeLists.txt).
template <class Executor, int Sh>
void run_march(Executor& run, const MarchJob& job);

template <class Executor, int Sh, bool Moving, bool Jet>
void run_march_kernel(Executor& run, const MarchJob& j) {
  using Kernel = TrainKernel<Sh, Moving, Jet>;
  const Kernel kernel{j.field,        j.frames, j.rays,    j.targets,  j.outcomes, j.rays_per_slot,
                      j.most_samples, j.losses, j.largest, j.radiance, j.motion,   j.behind};
  run.for_teams(j.ray_count, kernel, Kernel::scratch_bytes(j.most_samples));
}

}  // namespace splinevox
