// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/step.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/train/config.hpp"
#include "train/batch.hpp"

namespace splinevox {

/// Whether any frame shows tracked points.
bool has_tracks(const Split& train);
/// Whether a backend's steps would leave out tracks that are there and asked for.
bool leaves_out_tracks(const StepBackend& steps, const Config& config, const Split& train);
/// Throws Error (input) then.
void check_learns_tracks(const StepBackend& steps, const Config& config, const Split& train);

/// Rays through tracked points in the moments of a batch.
struct TrackBatch {
  std::vector<RayInput<float>> rays;
  std::vector<RayTask> tasks;
  std::vector<int> first, of_points;

  /// Good until it is drawn anew.
  TrackRays view() const { return {rays, tasks, first, of_points}; }
};

/// Draws points that move and that two moments of a batch or more show, and a ray through each there; at most
/// an eighth as many rays as the batch has. Where it is known what moves in pictures, one of them must show
/// that at the point. Points that stand still would only say how far off they are seen. A draw depends on
/// that of the batch alone.
/// @param moves  as points_that_move. @param moving  of each training frame; empty: nobody knows. @param step
/// between samples, scene units
void draw_tracks(const Split& train, const Batch& batch, const std::vector<char>& moves,
                 const std::vector<CoarseMask>& moving, const Box& box, float step, TrackBatch& out);

}  // namespace splinevox
