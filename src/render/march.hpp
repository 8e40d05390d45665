// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>

#include "core/team.hpp"
#include "render/shade.hpp"

namespace splinevox {

/// Number of set bits.
SPLINEVOX_HD inline int count_bits(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return std::popcount(bits);
#endif
}

/// What a team keeps of its ray between forward and backward, in its scratch: which samples it shaded and,
/// per kLanes of them, the transmittance before.
struct MarchList {
  static constexpr int kMostSamples = 65535;  ///< of one ray, what an index of 16 bits can tell
  float* before;                              ///< [chunks]
  std::uint16_t* index;                       ///< [samples]

  SPLINEVOX_HD static constexpr int chunks(int samples) { return (samples + kLanes - 1) / kLanes; }
  static constexpr std::size_t bytes(int samples) {
    return std::size_t(chunks(samples)) * (sizeof(float) + kLanes * sizeof(std::uint16_t));
  }
  /// @param memory  bytes(samples) of it
  SPLINEVOX_HD MarchList(char* memory, int samples)
      : before(reinterpret_cast<float*>(memory)),
        index(reinterpret_cast<std::uint16_t*>(memory + chunks(samples) * sizeof(float))) {}
};

/// Where a march ended.
struct Marched {
  Vec3 rgb{};  ///< without background
  float transmittance = 1;
  int shaded =
      0;  ///< samples in occupied cells, up to the one that made the ray opaque and the rest of its chunk
  int live = 0;    ///< those of them before the ray became opaque, that one included
  int stored = 0;  ///< those of them in stored bricks
};

/// Front to back along one ray, kLanes samples at once, skipping cells that are not occupied:
/// RayKernel::forward for a team. visit(lane, sample, weight, index) sees every live sample that is stored.
/// @param sample  afterwards the lanes' samples of the last chunk: most rays have no other.
template <int Sh, bool Moving, class Team, class Visit>
SPLINEVOX_HD Marched march(const Team& team, const RayInput<float>& ray, const FieldView<float>& field,
                           const FrameView<float>& frame, const RowHarmonics<Sh>& harmonics, float stop,
                           const MarchList& list, typename Team::template Lanes<Shaded<Sh, Moving>>& sample,
                           Visit&& visit) {
  using Three = typename Team::template Lanes<Vec3>;
  Marched out;
  int found = 0, next = 0;
  Three rgb;
  typename Team::template Lanes<int> stored;
  team.each([&](int lane) {
    rgb[lane] = {};
    stored[lane] = 0;
  });
  const OccupancyView<float>& grid = frame.occupancy;
  const Vec3 o = (ray.origin - grid.origin) * grid.inv_cell, d = ray.direction * (field.step * grid.inv_cell);
  while (!ray_ends(out.transmittance, stop)) {
    while (found - out.shaded < kLanes && next < ray.count) {
      typename Team::template Lanes<bool> hit;
      team.each([&](int lane) {
        const int i = next + lane;
        hit[lane] = i < ray.count &&
                    grid.occupied_at({o.x + float(i) * d.x, o.y + float(i) * d.y, o.z + float(i) * d.z});
      });
      const std::uint32_t mask = team.ballot(hit);
      team.each([&](int lane) {
        if (hit[lane]) list.index[found + count_bits(mask & ((1u << lane) - 1))] = std::uint16_t(next + lane);
      });
      found += count_bits(mask);
      next += kLanes;
    }
    const int n = found - out.shaded < kLanes ? found - out.shaded : kLanes;
    if (n == 0) break;
    team.sync();
    typename Team::template Lanes<float> before;
    team.each([&](int lane) {
      if (lane < n) {
        sample[lane] = shade_sample<Sh, Moving>(ray, list.index[out.shaded + lane], field, frame, harmonics);
      } else {
        sample[lane].stored = false;
        sample[lane].passed = 1;
      }
      before[lane] = sample[lane].passed;
      if (lane == 0) list.before[out.shaded / kLanes] = out.transmittance;
    });
    const float first = out.transmittance;
    team.product_before(before);
    typename Team::template Lanes<bool> alive;
    team.each([&](int lane) {
      const float t = first * before[lane];
      alive[lane] = lane < n && !ray_ends(t, stop);
      if (!alive[lane] || !sample[lane].stored) return;
      const float w = composite_sample(sample[lane].emission, sample[lane].alpha, t, rgb[lane]);
      ++stored[lane];
      visit(lane, sample[lane], w, int(list.index[out.shaded + lane]));
    });
    const int live = count_bits(team.ballot(alive));  // transmittance only falls, so they are the first ones
    typename Team::template Lanes<float> after;
    team.each([&](int lane) { after[lane] = first * before[lane] * sample[lane].passed; });
    out.transmittance = team.at(after, live - 1);
    out.shaded += n;
    out.live += live;
    if (live < n) break;
  }
  out.rgb = team.sum(rgb);
  out.stored = team.sum(stored);
  return out;
}

}  // namespace splinevox
