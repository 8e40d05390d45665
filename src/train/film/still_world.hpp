// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "splinevox/data/scene.hpp"
#include "splinevox/train/config.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox {

/// How well the time of a picture tells its viewing direction (effects/film.hpp), of the scene that a
/// configuration begins with and in windows as long as a piece of its curves.
double view_told_by_time(const Config& config, const Split& train);
/// Whether that makes a film of it: of one camera on its way.
bool is_film(double view_told_by_time);

/// What masks say that moves (Frame::moving): with them no still world is asked. Pictures of which all may
/// move say nothing. None: no masks are for that.
std::optional<FilmEvidence> given_motion(const Split& train);

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
