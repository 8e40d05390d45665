// SPDX-License-Identifier: Apache-2.0
#include "train/effects/rig.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "math/median.hpp"
#include "render/specialise.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/effects/halves.hpp"
#include "train/learn_cameras.hpp"
#include "train/look.hpp"
#include "train/neutral.hpp"

namespace splinevox {
namespace {

constexpr int kRigStride = 2;         ///< pixels
constexpr int kPictures = 24;         ///< of a camera
constexpr double kDoubt = 0.1;        ///< intervals: a first look that finds less is believed
constexpr double kDoubtLevel = 0.05;  ///< of each side of each camera
constexpr double kVisible = 0.2;      ///< intervals: less is half a voxel of a walk, and seems to be there in
                                      ///< rigs whose clocks agree (docs/experiments/effects.md)
constexpr int kLonger = 3;            ///< steps of the longer fit over those of the first
constexpr double kHalf = 0.5;         ///< intervals before and after

/// Sums over the pixels of one picture: the offset that it asks for is -along / square.
struct Evidence {
  double along = 0, square = 0;
};

template <int Sh>
Evidence evidence_of(const Frame& frame, const VoxelModel& model, const CameraFits& cameras) {
  const double half = kHalf * cameras.cameras[std::size_t(frame.camera_id)].interval;
  Look<Sh> now(model, frame.time), before(model, frame.time - half), after(model, frame.time + half);
  const Vec3 gain = cameras.gain_of(frame);
  Evidence out;
  for (int y = 0; y < frame.camera.height; y += kRigStride)
    for (int x = 0; x < frame.camera.width; x += kRigStride) {
      if (frame.ignored.test(x, y)) continue;
      const Ray ray = camera_ray(frame.camera, x + 0.5, y + 0.5);
      const Vec3 behind = model.behind(ray);
      const Vec3 error = photometric_error(now.along(ray, behind),
                                           neutral_target(frame.image, x, y, behind, gain)),
                 change = float(1 / (2 * kHalf)) * (after.along(ray, behind) - before.along(ray, behind));
      out.along += double(dot(error, change));
      out.square += double(dot(change, change));
    }
  return out;
}

/// The offset that a camera's pictures ask for together, by leaving out one after the other (jackknife).
PairedGain offset_of(const std::vector<Evidence>& pictures, double level) {
  Evidence all;
  for (const Evidence& e : pictures) {
    all.along += e.along;
    all.square += e.square;
  }
  std::vector<double> values;
  const double n = double(pictures.size());
  for (const Evidence& e : pictures)
    if (all.square > e.square)
      values.push_back((n - 1) * (all.along - e.along) / (all.square - e.square) -
                       n * all.along / all.square);
  return paired_gain(values, level);
}

}  // namespace

double spread_of(const CameraFits& fits) {
  double squares = 0;
  int count = 0;
  for (const CameraFit& c : fits.cameras)
    for (int a = 0; c.trained && a < 3; ++a, ++count) squares += std::pow(c.mean_log(a), 2);
  return count > 0 ? std::sqrt(squares / count) : 0;
}

double drift_of(const CameraFits& fits) {
  double squares = 0;
  std::size_t count = 0;
  for (const CameraFit& c : fits.cameras)
    for (int a = 0; c.trained && a < 3; ++a, count += c.gains.size())
      for (const Vec3& gain : c.gains) squares += std::pow(std::log(double(gain[a])) - c.mean_log(a), 2);
  return count > 0 ? std::sqrt(squares / double(count)) : 0;
}

Image exposed(Rendered picture, const Vec3& gain, const VoxelModel& model) {
  for (std::size_t i = 0; i < picture.rgb.data.size(); ++i) {
    const int c = int(i % 3);
    // What pictures with alpha are composited over is no camera's to show.
    const float behind =
        model.background.learned() ? 0 : (1 - picture.alpha.data[i / 3]) * model.background.color[c];
    picture.rgb.data[i] = gain[c] * (picture.rgb.data[i] - behind) + behind;
  }
  return std::move(picture.rgb);
}

Image shown_by(const CameraFits& fits, const Frame& frame, const VoxelModel& model, Renderer& renderer,
               const RenderOptions& options) {
  return clamped(
      exposed(renderer.render(frame.camera, fits.time_of(frame), options), fits.gain_of(frame), model));
}

std::vector<ClockDoubt> doubt_clocks(const VoxelModel& model, const Split& views, const CameraFits& cameras,
                                     double level) {
  std::vector<const Frame*> frames;
  for (const Frame& f : views.frames) {
    if (!cameras.knows(f.camera_id)) continue;
    const double half = kHalf * cameras.cameras[std::size_t(f.camera_id)].interval;
    if (f.time - half >= 0 && f.time + half <= 1) frames.push_back(&f);
  }
  std::vector<Evidence> found(frames.size());
  parallel_for(int(frames.size()), [&](int i) {
    specialise(model.radiance.sh_order, [&]<int Sh>() {
      found[std::size_t(i)] = evidence_of<Sh>(*frames[std::size_t(i)], model, cameras);
    });
  });
  std::vector<ClockDoubt> out;
  std::vector<double> offsets;
  for (int c = 0; c < int(cameras.cameras.size()); ++c) {
    std::vector<Evidence> own;
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (frames[i]->camera_id == c) own.push_back(found[i]);
    if (own.size() < 2) continue;
    out.push_back({c, offset_of(own, level)});
    offsets.push_back(out.back().offset.mean);
  }
  if (offsets.empty()) return out;
  const double middle = median(offsets);
  for (ClockDoubt& d : out)
    for (double* bound : {&d.offset.mean, &d.offset.lo, &d.offset.hi}) *bound -= middle;
  return out;
}

EffectVerdict judge_clock(const EffectSet& all, const VoxelModel& first, const CameraFits& known,
                          Config config, const Split& train, const TimeMap& time_map, double level) {
  CameraFits rig = rig_of(train);  // with the intervals of the whole split
  const auto take_gains = [&](const CameraFits& from) {
    for (std::size_t c = 0; c < std::min(rig.cameras.size(), from.cameras.size()); ++c)
      rig.cameras[c].gains = from.cameras[c].gains;
  };
  take_gains(known);
  const Split views = some_of_each(train, int(rig.cameras.size()), kPictures);
  const auto differs = [&](const std::vector<ClockDoubt>& clocks, double least) {
    return std::any_of(clocks.begin(), clocks.end(), [&](const ClockDoubt& d) {
      return std::abs(d.offset.mean) > least && (d.offset.lo > 0 || d.offset.hi < 0);
    });
  };
  EffectVerdict out{.effect = Effect::clock, .with = all, .decision = EffectDecision::off, .gain = {}};
  out.clocks = doubt_clocks(first, views, rig, kDoubtLevel);
  if (!differs(out.clocks, kDoubt)) return out;
  config.run.max_steps = kLonger * config.run.max_steps;
  config.grid.radiance = {20, 40, 64};
  config.grid.radiance_start = {0, 0.2f, 0.5f};
  config.grid.motion = {4, 8, 16, 32};
  config.grid.motion_start = {0, 0.15f, 0.25f, 0.5f};
  Trainer trainer(config, views, time_map);
  while (!trainer.done()) trainer.step();
  take_gains(trainer.cameras());
  out.clocks = doubt_clocks(trainer.model(), views, rig, level / (2 * double(out.clocks.size())));
  if (differs(out.clocks, kVisible)) out.decision = EffectDecision::on;
  return out;
}

}  // namespace splinevox
