// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::run {

/// A small grey picture and its camera.
struct SmallPicture {
  Camera camera;
  double time = 0;
  int factor = 1;  ///< pixels of the picture along an edge of one of these
  Image grey;      ///< 1 channel
};
/// Means of blocks, at most 160 of them a row.
SmallPicture small_picture(const Frame& frame, const Vec3& background);

/// A place of a picture that pictures of other times show as it is.
struct StillPlace {
  std::size_t picture = 0;  ///< of those asked for
  double u = 0, v = 0;      ///< in the small picture, pixels
  std::vector<bool> still;  ///< [times] whether it is proved still at each, its own not among them
};
struct StillPlaces {
  std::vector<StillPlace> places;
  std::size_t asked = 0;  ///< patches with texture times other times
};

/// What of a film's pictures a still world explains, from the pictures and their cameras alone. No model is
/// asked: one that took the camera's motion for the scene's would call everything moving.
///
/// A patch of a picture is carried to pictures of other times, at one depth after the other. It is proved
/// still at a time if a picture of about that time shows the same there, at the depth at which most times
/// agree, and at least kFewestTimes do. Something that moves shows the same at one depth only if its way
/// looks like that of a still thing; then no film tells the difference. Patches without texture are not
/// asked: they agree with anything.
///
/// Far along its way a camera sees a place so askew that patches no longer compare. But what stands at one
/// place of the world between two pictures, and between two others, stands still in all: what pictures prove
/// of places within one cell of the box, kStillCells along its longest edge, is put together.
class PatchEvidence {
 public:
  /// @param times  model times that are asked, ascending
  PatchEvidence(const Split& train, const Box& box, const Vec3& background, std::vector<double> times);
  /// Of pictures of the film's cameras, or of some beside them. @param ignored  of each picture, as it was
  StillPlaces places(const std::vector<SmallPicture>& pictures, const std::vector<PixelMask>& ignored) const;
  const std::vector<double>& times() const { return times_; }

 private:
  /// What is proved of one patch by itself.
  struct Proof {
    StillPlace place;
    Vec3d at;  ///< scene units
  };
  std::vector<Proof> proofs(const SmallPicture& picture, const PixelMask& ignored, std::size_t& asked) const;
  std::vector<double> depths_of(const Camera& camera) const;
  Box box_;
  std::vector<double> times_;
  std::vector<SmallPicture> pictures_;  ///< [time] the nearest to it
};

inline constexpr double kOtherTime = 0.1;  ///< least model time between a picture's own time and another one
inline constexpr int kFewestTimes = 3;     ///< that must agree
inline constexpr int kStillCells = 32;

}  // namespace splinevox::run
