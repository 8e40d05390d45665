// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox {

/// How far the gains of cameras are apart: the standard deviation of their logarithms, whose mean is 0.
double spread_of(const CameraFits& fits);

/// How far the gains of one camera are apart at different times: the standard deviation of their logarithms
/// from the mean of each camera, over all cameras.
double drift_of(const CameraFits& fits);

/// What a camera of that gain shows of a picture of the model; not clamped.
Image exposed(Rendered picture, const Vec3& gain, const VoxelModel& model);
/// What a frame's camera shows of a model: its picture, as it is clamped.
Image shown_by(const CameraFits& fits, const Frame& frame, const VoxelModel& model, Renderer& renderer,
               const RenderOptions& options = {});

/// Of each camera of a rig, by one step of Gauss and Newton: the colour errors of its pictures along what the
/// model changes there in half an interval before and after. A model takes late pictures for true ones as
/// well, so it finds less of an offset than there is.
/// @param views  pictures within half an interval of the ends of time are left out
/// @param level  of the bounds, each
std::vector<ClockDoubt> doubt_clocks(const VoxelModel& model, const Split& views, const CameraFits& cameras,
                                     double level);

/// Whether a clock has an offset that can be told. A first look is at the fit without clocks. Where it leaves
/// a doubt, a longer and finer fit decides: what is a tenth of an interval in one voxel of the first is
/// noise. It is on if some camera's offset is sure not to be 0, and large enough to be visible.
/// @param first     the fit without clocks, and its cameras
/// @param config    of that fit
/// @param level     of the decision, all cameras together
EffectVerdict judge_clock(const EffectSet& all, const VoxelModel& first, const CameraFits& known,
                          Config config, const Split& train, const TimeMap& time_map, double level);

}  // namespace splinevox
