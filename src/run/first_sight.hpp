// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "run/training_cameras.hpp"
#include "run/true_shots.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/run/cameras.hpp"

namespace splinevox::run {

/// What a page opens on.
struct FirstSight {
  int view = -1;  ///< which of its true pictures is from there; -1: none
  Shot shot;
  std::vector<char> poster = {};  ///< PNG file of it
};

/// Chooses a camera and a moment at which much of the scene is seen.
///
/// | training cameras | what it chooses from |
/// | --- | --- |
/// | surround the scene, or are not known | cameras and times of `shots`; without any, the first camera of an
/// orbit at twelve times | | a film of one camera, or many places on one side | the camera next to the mean
/// of all, at its time | | few places on one side, or one | that camera, at twelve times |
///
/// Of these it takes the one nearest to the middle of time whose silhouette is at most a twentieth smaller
/// than the largest. A silhouette is the share of the picture that matter covers, less that of its edge: what
/// the edge cuts off does not count.
/// @param train  null: not known
/// @param size  longest side of the poster at most, pixels
FirstSight first_sight(const VoxelModel& model, const std::vector<TrueShot>& shots,
                       const TrainingCameras* train, int size);

/// Without looking at the model: the camera next to the mean, or the first of the shots. None: neither is
/// there.
std::optional<FirstSight> plain_sight(const std::vector<TrueShot>& shots, const TrainingCameras* train);

}  // namespace splinevox::run
