// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "splinevox/data/scene.hpp"
#include "splinevox/train/config.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox {

/// The middle of the scene that a configuration begins with. Makes a hull, so it is worth keeping.
Vec3 starting_middle(const Config& config, const Split& train);

/// How well the time of a picture tells its viewing direction (effects/film.hpp), in windows as long as a
/// piece of the configuration's curves. @param middle  of the scene
double view_told_by_time(const Config& config, const Split& train, const Vec3& middle);

/// What moves, where something but fits says it: masks (Frame::moving), of pictures of any kind; pictures of
/// which all may move say nothing. Else a still world says it of a film (look_at_film). None: neither does.
/// @param told  view_told_by_time. @param moving  what moves in each frame, of a film. @param on_film  called
/// once a film was looked at; may be empty
std::optional<FilmEvidence> motion_told(const Config& config, const Split& train, const TimeMap& time_map,
                                        double told, std::vector<CoarseMask>& moving,
                                        const std::function<void(const FilmEvidence&)>& on_film);

/// What a world in which nothing changes cannot show of a film.
///
/// One camera on its way sees every moment from another place. So motion explains whatever a coarse lattice
/// cannot show of a static scene, bent into place as the camera passes, and the scene goes wrong off the
/// camera's way. So it is asked first what nothing but motion explains: a still world is fitted to all
/// pictures for a few hundred steps. What it does not show, not even beside a pixel (unexplained.hpp), moves,
/// or is a highlight sharper than its harmonics. Places that few pictures have in them say nothing: there the
/// world itself is not known.
/// @param config  as prepared. @param moving  what moves, of each frame
FilmEvidence look_at_film(const Config& config, const Split& train, const TimeMap& time_map,
                          std::vector<CoarseMask>& moving);

}  // namespace splinevox
