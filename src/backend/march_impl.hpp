// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/march_job.hpp"

namespace splinevox {

template <class Executor, int Sh>
void run_march(Executor& run, const MarchJob& job) {
  const bool jet = job.losses.motion.offset > 0 || job.losses.motion.divergence > 0;
  if (!job.field.moving) return run_march_kernel<Executor, Sh, false, false>(run, job);
  if (jet) return run_march_kernel<Executor, Sh, true, true>(run, job);
  run_march_kernel<Executor, Sh, true, false>(run, job);
}

}  // namespace splinevox
