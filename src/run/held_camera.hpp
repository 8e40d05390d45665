// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "run/support.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::run {

/// How far what stands still moves in a model's pictures while the camera is held and time runs.
///
/// A film's pictures show another view at every time. A model may bend the scene as the camera goes, and show
/// all of them right: the camera's motion is learned as the scene's. Held-out pictures lie on the camera's
/// way and say nothing of it. Here each of a dozen cameras is held at its place, and the places of its
/// picture that pictures of other times prove still (still_places.hpp) are asked how far the model moves
/// them: by the difference of the displacements at the surface that the camera sees at its own time, in its
/// picture. That is what the two renders would show, without having to find one's texture in the other,
/// which fails for a scene that is torn, and finds chance in a flat one.
struct HeldCamera {
  int cameras = 0;
  std::size_t places = 0;                  ///< proved still and within the box, at one other time each
  double proved_share = 0;                 ///< of all places with texture and other times, [0, 1]
  double median = 0, p95 = 0;              ///< shift of those, pixels of the picture
  double median_share = 0, p95_share = 0;  ///< the same, shares of the picture's width
  double seconds = 0;
};

inline constexpr double kHeldCameraBad = 0.02;  ///< p95_share above which the still part moves
inline constexpr std::size_t kFewestPlaces = 50;

/// None where too little is proved still to say anything.
/// @param renderer  of the model
/// @param train     the film, with pixels
/// @param held_out  whose cameras are held; may be the film itself
std::optional<HeldCamera> held_camera_test(const VoxelModel& model, Renderer& renderer, const Split& train,
                                           const Split& held_out);

/// Whether the training pictures are those of one moving camera. Poses and times suffice.
bool is_film(const Split& train, const Box& box);

/// The key of metrics.json, and what it holds.
inline constexpr char kHeldCamera[] = "held_camera";
Json held_camera_json(const HeldCamera& test);
/// A line for people.
std::string held_camera_line(const HeldCamera& test);
/// What `train` says at its end if the still part moves too far, and what to do; empty: it does not.
std::string held_camera_warning(const HeldCamera& test);

}  // namespace splinevox::run
