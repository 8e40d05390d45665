// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "run/support.hpp"
#include "run/truth_volumes.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox::run {

/// A model's density beside the true one. Sums are over all voxels of the truth's lattice, continued to hold
/// the model's box (at most by the truth's own size on every side). t is the truth, m the model's density
/// there: the mean over the voxel where the model is finer, 0 where its voxel hides less than 0.1%, as in an
/// export. One factor for all moments, `scale` = sum m t / sum m m, brings m to t.
struct VolumeFigures {
  double l1 = 0;           ///< sum |scale m - t| / sum t; 0 is perfect, of an empty model 1
  double l1_unscaled = 0;  ///< the same with factor 1
  double correlation = 0;  ///< Pearson's, over the voxels where at some moment either has matter
  double iou = 0;          ///< sum min(scale m, t) / sum max(scale m, t)
  double outside = 0;      ///< share of the model's mass outside of the truth's own box
};
struct VolumeMoment : VolumeFigures {  ///< NaN where a figure divides by nothing
  double time = 0;                     ///< of the model
  double mass_truth = 0, mass = 0;     ///< integrals of density, the model's without the factor
};
struct VolumeScore : VolumeFigures {  ///< over all moments together
  double scale = 0;
  double voxel = 0;                   ///< of the truth, scene units
  int samples = 1;                    ///< of the model, along an edge of a voxel
  double correlation_per_moment = 0;  ///< mean; moments with less than 2% of the largest true mass left out
  double mass_curve = 0;  ///< mean |m(t) / mean m - t(t) / mean t| of the masses: the error of their course
  double mass_unscaled = 0;  ///< mean |m(t) - t(t)| / mean t of the masses
  std::vector<VolumeMoment> moments;
};

/// Throws Error (Fault::input): the truth lies beside the model's box, has no matter, or cannot be read.
VolumeScore score_volumes(const VoxelModel& model, const TruthVolumes& truth);

/// As metrics.json has it under `truth_volume`.
Json volume_json(const VolumeScore& score);
/// As `eval` prints it, a line for every moment and then one for each figure.
void print_volumes(const VolumeScore& score);

}  // namespace splinevox::run
