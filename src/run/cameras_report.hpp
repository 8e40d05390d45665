// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "run/support.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/train/cameras.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox::run {

/// What a run has learned of its cameras, as `cameras` of metrics.json holds it (docs/formats.md): an array,
/// empty if nothing was. Of each its gains, if those are learned, and its clock, if that is.
Json cameras_json(const Dataset& data, const CamerasConfig& learned, const CameraFits& fits);

/// The same in a line per camera: "cam05: gain 0.89 0.90 0.85, 0.50 frames late".
std::string camera_line(const Json& camera);

/// A table of them as HTML; empty if there are none.
std::string cameras_table(const Json& cameras);

}  // namespace splinevox::run
