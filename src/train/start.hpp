// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/train/config.hpp"
#include "train/bounds/hull.hpp"

namespace splinevox {

/// Statistics of the training pictures. Colours are weighted by alpha, from every 16th pixel of some_frames.
struct PictureStats {
  Vec3 mean{0.5f, 0.5f, 0.5f};
  float brightest = 0;       ///< of any channel
  bool see_through = false;  ///< some pixel of them all is transparent
  float partly = 0;          ///< share of partly transparent pixels among all that are not empty
  int places = 0;  ///< that pictures were taken from; several of a camera that stands still are of one
  int pictures = 0;
  /// Whether cameras stand still: what is seen from few places leaves much open, however many pictures say
  /// so.
  bool rig() const { return 2 * places <= pictures; }
  /// Whether matter is thin everywhere, as smoke is: of solid bodies only the rims are partly transparent.
  bool thin() const { return partly > 0.5f; }
  bool dark() const { return (mean.x + mean.y + mean.z) / 3 < 0.03f; }
};
PictureStats picture_stats(const Split& train);
/// Of these `places` and `pictures` alone, which cameras tell before any picture is read.
void count_places(const Split& train, PictureStats& stats);

/// Where the scene may be, before anything is known of it: the box of the configuration, or what cameras and
/// silhouettes say. Throws Error (Fault::input) if it lies so far from the origin that floats cannot tell its
/// cells apart.
SceneBounds starting_bounds(const Config& config, const Split& train, const PictureStats& stats);

/// Whether a box is large enough for the finest lattices, in scene units (kLeastSpacing).
bool holds_lattices(const Box& box, const GridConfig& grid);
/// Positions in the scene's space are floats. Whether they tell apart places within a cell of the finest
/// lattice: up to a seventh of one costs nothing, from one cell on decibels (numerics H14).
bool tells_places_apart(const Box& box, const GridConfig& grid);

/// The unit of brightness that a scene is trained in: 1, or for pictures darker than 0.03 on average
/// the brightest value in them or of a fixed background. Random backgrounds go no higher: against 0 to 1
/// the silhouettes of a scene of 0.01 would be 10^4 times as loud as all that its colours say (numerics
/// H30).
float brightness(const Config& config, const PictureStats& stats);

/// The weights of the regularisers and Adam's epsilon times the square of the unit, as the loss and its
/// gradients are.
Config in_units_of(float brightness, Config config);

/// With no finer radiance lattice than grid.few_cells where cameras stand still at fewer places than
/// loss.tv_places: what few cameras see is fitted worse by finer cells (docs/experiments.md). And behind
/// opaque pictures with the weight of density's total variation, and the share of bricks that it visits, as
/// few places ask for: in proportion to loss.tv_places / places, and to its root. Matter that few cameras see
/// has room to hide, and to have holes, that other views show; silhouettes leave it less
/// (docs/experiments/matter.md).
Config for_places(const PictureStats& stats, Config config);

/// Rays are asked to end on something or to pass where silhouettes say which. Opaque pictures do not: there
/// the prior makes what hides something else thick, whatever it is. Rays through thin matter do neither.
Config for_silhouettes(const PictureStats& stats, Config config);

/// Of thin matter that comes and goes hardly any sample is worth nothing: skipped and left alone is a tenth
/// of what solid bodies can do without, and the box cuts off a hundredth. Its colours vary little.
Config for_thin(const PictureStats& stats, Config config);

/// Whether surroundings are learned behind these pictures: the configuration wants them and they are opaque.
bool learns_surroundings(const Config& config, const PictureStats& stats);

/// Alpha of one step of the first lattice before training. Behind opaque pictures matter is everywhere and is
/// taken away: what begins thin stays full of holes. With
/// surroundings these are behind the holes, and what begins thick stands in for them.
float initial_alpha(const Config& config, const PictureStats& stats);

/// Raw colour before training: 0, half way up. A scene darker than 0.03 on average begins at its mean: from
/// half way the rates would need hundreds of steps down, and what they do not reach lights up its
/// surroundings through interpolation, fifty times as bright as the scene (numerics H30).
Vec3 starting_color(const RadianceConfig& config, const PictureStats& stats);

/// Whether this configuration's motion is frozen where nothing moves.
bool freezes(const Config& config);

/// Whether cameras that stand still say anything about a run with this configuration: where motion is frozen,
/// or where more rays are drawn.
bool asks_still_cameras(const Config& config);

}  // namespace splinevox
