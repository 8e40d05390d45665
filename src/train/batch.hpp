// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "backend/step.hpp"
#include "render/views.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/train/cameras.hpp"
#include "splinevox/train/config.hpp"
#include "train/changing_blocks.hpp"
#include "train/error_map.hpp"
#include "train/learn_depth.hpp"
#include "train/silhouette_blocks.hpp"

namespace splinevox {

/// A pixel of a picture.
struct PixelIndex {
  int x, y;
};
/// The pixel of ray k, 0 to 3, of a block of 2 x 2: the first from k on, in turn, that is not ignored; none
/// if all four are.
std::optional<PixelIndex> usable_pixel(const Frame& frame, std::uint32_t block, int k);

/// What a ray's camera shows of it.
struct CameraRay {
  Vec3 colour;  ///< times alpha, in display values
  int camera;   ///< of CameraFits
  double time;  ///< of its picture
};

/// Rays of a few frames and the colours they should have.
struct Batch {
  std::vector<int> frames;            ///< a training frame of each slot
  std::vector<double> times;          ///< of the slots, model time in [0, 1]
  std::vector<RayInput<float>> rays;  ///< grouped by slot, equally many each
  std::vector<Ray> lines;             ///< the same before they were clipped, if there are surroundings
  std::vector<Vec3> targets;  ///< [rays] neutral, composited over the ray's background; some are bounds
                              ///< (math/photometric.hpp)
  std::vector<DepthTarget<float>> depths;  ///< [rays]; empty where no depth is asked for
  std::vector<CameraRay> shown;            ///< [rays]; empty where nothing is learned of cameras
  std::vector<Patch> patches;              ///< of four rays each
  std::vector<RayTask> tasks;              ///< fixed cut of the rays into pieces of work, none across slots
  std::vector<int> grids;                  ///< of the slots: which of Occupancy::grids
  std::uint64_t draw = 0;                  ///< seed of the step's other draws

  int slot_of(int ray) const { return int(std::size_t(ray) / (rays.size() / frames.size())); }
};

/// Draws batches. A draw depends on (seed, step) alone.
///
/// Moments come from a shuffled deck, and so do the cameras of a moment, so every frame is used equally
/// often. A slot is a moment: what a step makes for a moment serves all its cameras. With a window the deck
/// holds only frames around the middle one in time at first and grows to all of them: what is fitted to
/// moments close together needs little motion, so every part gets one canonical place before fast motion
/// tempts it into several (docs/experiments.md). Rays come in patches of 2 x 2 pixels, whose samples share
/// cache lines; most are taken where the picture shows something or nearly does, the rest anywhere, so that
/// matter where there should be none is found as well.
///
/// Once it is known where pictures are fitted worst (ErrorMap), most patches of a frame are drawn there.
/// Weights of the loss undo a part of that: what is left of it makes the fit better where it is worst.
///
/// Where it is known what moves in a picture, a share of the rays is drawn there: before opaque surroundings
/// nothing else says where the moving subject is, and most of a picture is soon learned. All other rays of it
/// ask what they show to be at rest.
///
/// Some rays carve: a camera of a neighbouring time looks past its silhouette, further away than things move
/// in between, and there must be nothing *now* either. With one camera per time, matter can hide behind the
/// body from the only view of its time; other views of about that time see it beside the body. Needs pictures
/// with alpha; frames without any are never carved with.
///
/// Ignored pixels (Frame::ignored) are never drawn. A patch that holds some and others repeats the others;
/// one of ignored pixels alone is not drawn. Nothing is carved near them. @pre no frame ignores all its
/// pixels
class BatchSampler {
 public:
  /// @param brightest  largest value of a random background
  BatchSampler(const Split& train, const Box& box, const SamplingConfig& config, std::uint64_t seed,
               float brightest = 1);
  void set_box(const Box& box) { box_ = box; }
  /// Share of the configuration's rays that steps have, in (0, 1].
  void set_share(double share) { share_ = share; }
  /// What moves, of each frame; none: nothing is known.
  /// @param rest  weight of rest_vjp of rays before which nothing does, for a voxel of length 1
  void set_moving(const std::vector<CoarseMask>& moving, float rest);
  /// @param progress    of the run, 0..1: how many rays are drawn and from which frames. @param step  march
  /// step, scene units.
  /// @param background  of every ray, if it is learned or the configuration asks for a fixed one; otherwise
  /// they are random. @param around  before it
  /// @param cameras  what is known of them by now. @param depths  the same of depth maps; empty: no depth is
  /// asked for. @param errors  of the pictures; null: patches are drawn evenly
  void draw(std::int64_t index, double progress, float step, const Background& background,
            const Surroundings& around, Batch& out, const CameraFits& cameras = {},
            const DepthFits& depths = {}, const ErrorMap* errors = nullptr) const;
  /// The frames that may be drawn, in order of time.
  std::span<const int> window(double progress) const;
  /// Whether that is all of them.
  bool whole(double progress) const { return config_.window >= 1 || progress >= config_.window_full; }

 private:
  /// Share of a frame's patches that are drawn where something moves.
  float changing_share(int frame) const;
  /// The chance that a patch of a frame is drawn. @param by_error  of the frame; null: drawn evenly
  float chance(const Patch& patch, const ErrorDraw* by_error) const;
  /// The patch of one number of a step. @param by_error  of the frame; null: drawn evenly
  Patch draw_patch(std::uint64_t step, std::uint64_t number, int frame, const ErrorDraw* by_error) const;
  /// The patches of a slot, in order, and the weights of their rays, 1 on the mean.
  /// @param first  number of the first in the step. @param views  of the moment, in turn
  void draw_patches(std::uint64_t step, std::uint64_t first, const std::vector<int>& views,
                    const ErrorMap* errors, std::span<Patch> out, std::span<float> weights) const;
  /// Where slots' moments begin in by_time_, by what is known of the cameras.
  const std::vector<std::size_t>& moments(const CameraFits& cameras) const;
  /// The cameras from which the patches of a slot are drawn in turn. @param first  and @param end  of its
  /// moment in by_time_
  std::vector<int> frames_of_moment(std::size_t first, std::size_t end, std::int64_t visit, int most) const;

  const Split& train_;
  Box box_;
  SamplingConfig config_;
  double share_ = 1;
  float brightest_;  ///< random background
  std::uint64_t seed_;
  std::vector<int> by_time_, rank_;  ///< frames in order of time, and each frame's place in that order
  std::vector<std::size_t> moments_, each_;  ///< where each moment, and each frame, begins in by_time_
  std::vector<SilhouetteBlocks> shown_;      ///< per frame
  std::vector<ChangingBlocks> changing_;     ///< per frame; none: nothing is known
  float rest_ = 0;                           ///< of set_moving
};

}  // namespace splinevox
