// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/camera_bodies.hpp"
#include "render/field_view.hpp"
#include "render/march.hpp"
#include "render/pixel_sums.hpp"

namespace splinevox {

/// One pixel of Rendered, all its layers, and nothing behind it yet.
struct Pixel {
  Vec3 rgb, flow;
  float transmittance, depth, rigidity;
};

/// Forward along the ray of one pixel by a team; pixels come in small tiles, so that teams beside each other
/// share cache lines.
template <int Sh, bool Moving>
struct PictureKernel {
  static constexpr int kTile = 8;

  FieldView<float> field;
  FrameView<float> frame;
  Camera camera;
  Box box;
  float stop;
  int most_samples;
  Pixel* pixels;  ///< [height * width]

  static std::size_t scratch_bytes(int most_samples) { return MarchList::bytes(most_samples); }
  static int tiles(int pixels) { return (pixels + kTile - 1) / kTile; }
  /// Teams it takes.
  int count() const { return tiles(camera.width) * tiles(camera.height) * kTile * kTile; }

  template <class Team>
  SPLINEVOX_HD void operator()(int index, const Team& team) const {
    const int tile = index / (kTile * kTile), within = index % (kTile * kTile),
              across = (camera.width + kTile - 1) / kTile;
    const int x = tile % across * kTile + within % kTile, y = tile / across * kTile + within / kTile;
    if (x >= camera.width || y >= camera.height) return;
    const Ray ray = bodies::camera_ray(camera, x + 0.5, y + 0.5);
    RayInput<float> input = clip_ray(ray, box, field.step, 0.5f, {});
    if (input.count > most_samples) input.count = most_samples;  // what the list has room for
    const RowHarmonics<Sh> harmonics(input.direction);
    typename Team::template Lanes<PixelSums> sums;
    team.each([&](int lane) { sums[lane] = {}; });
    const PixelDepth depth(camera, ray, input);
    const MarchList list(team.scratch(), most_samples);
    typename Team::template Lanes<Shaded<Sh, Moving>> last;
    const Marched m = march<Sh, Moving>(team, input, field, frame, harmonics, stop, list, last,
                                        [&](int lane, const Shaded<Sh, Moving>& s, float w, int i) {
                                          sums[lane].add(w, depth.distance(float(i), field.step));
                                          if constexpr (Moving) sums[lane].add_motion(w, s.r, s.motion);
                                        });
    Pixel out;
    out.rgb = m.rgb;
    out.transmittance = m.transmittance;
    const PixelSums all = team.sum(sums);
    out.flow = all.flow;
    out.rigidity = all.rigidity;
    out.depth = depth.mean(all);
    team.each([&](int lane) {
      if (lane == 0) pixels[std::size_t(y) * camera.width + x] = out;
    });
  }
};

}  // namespace splinevox
