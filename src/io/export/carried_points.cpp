// SPDX-License-Identifier: Apache-2.0
#include "io/export/carried_points.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "field/warp_velocity.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {

FrameTimes frame_times(const FrameRange& range, const std::vector<int>& frames) {
  FrameTimes out;
  for (const int f : frames) {
    out.times.push_back(range.time_at(f));
    out.rates.push_back(range.rate_at(f));
  }
  return out;
}

std::vector<Vec3> velocities_at(const VoxelModel& model, double time, double rate,
                                std::span<const Vec3> places) {
  std::vector<Vec3> out(places.size(), Vec3{});
  if (rate == 0 || !model.motion.moves()) return out;
  const FrameSampler sampler(model, time);
  for (std::size_t i = 0; i < places.size(); ++i)
    out[i] = cast<float>(rate * material_velocity(sampler.warp(places[i])).velocity);
  return out;
}

CarriedPoints carry_points(const VoxelModel& model, const ExportPoints& points, const FrameTimes& frames,
                           const ViewBake& view) {
  const auto tracks = track(model, points.position, points.time, frames.times);
  const std::size_t count = points.position.size();
  CarriedPoints out;
  out.ids = points.id;
  out.places.assign(tracks.size(), std::vector<Vec3>(count));
  out.lost.assign(tracks.size(), std::vector<bool>(count));
  out.velocities.resize(tracks.size());
  parallel_for(int(tracks.size()), [&](int frame) {
    const auto f = std::size_t(frame);
    for (std::size_t i = 0; i < count; ++i) {
      out.places[f][i] = tracks[f][i].position;
      out.lost[f][i] = tracks[f][i].folded;
    }
    out.velocities[f] = velocities_at(model, frames.times[f], frames.rates[f], out.places[f]);
  });
  for (const auto& row : out.lost)
    for (const bool lost : row) out.untracked += double(lost) / double(tracks.size() * count);
  const FrameSampler first(model, frames.times.front());
  for (const Vec3& x : out.places[0]) {
    const FrameSampler::Warp warp = first.warp(x);
    const auto radiance = first.radiance(x + warp.displacement, warp.presence);
    const Vec3 color = (warp.light * view.factor(radiance.sh)) * radiance.color;
    out.colors.push_back({std::min(color.x, 1.0f), std::min(color.y, 1.0f), std::min(color.z, 1.0f)});
  }
  return out;
}

}  // namespace splinevox
