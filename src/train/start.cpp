// SPDX-License-Identifier: Apache-2.0
#include "train/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "math/camera.hpp"
#include "math/logit.hpp"
#include "math/sh.hpp"
#include "math/view_factor.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/lattice.hpp"
#include "train/by_time.hpp"
#include "train/config/loss_terms.hpp"
#include "train/effects/effect_table.hpp"

namespace splinevox {
namespace {

constexpr float kApart = 0.25f;  ///< of a cell, at most, that floats may be apart

/// Throws where tells_places_apart does not hold.
void check_place(const Box& box, const GridConfig& grid) {
  if (tells_places_apart(box, grid)) return;
  const Vec3 c = box.center();
  const float cell = box.longest_edge() / float(grid.radiance.back());
  const auto text = [](const Vec3& v) { return fmt::format("({:.9g}, {:.9g}, {:.9g})", v.x, v.y, v.z); };
  fail({"the training cameras", "the scene lies too far from the origin for its size",
        fmt::format("a distance of at most {:.3g} for cells of {:.3g} scene units",
                    kApart * cell / std::numeric_limits<float>::epsilon(), cell),
        fmt::format("a box around {}, {:.3g} wide", text(c), box.longest_edge()),
        fmt::format("subtract {} from every position: splinevox convert DATASET --out NEW "
                    "--shift={:.9g},{:.9g},{:.9g}",
                    text(c), -c.x, -c.y, -c.z)});
}

/// Of a box whose lattices OpenVDB takes.
float least_edge(const GridConfig& grid) {
  return kLeastSpacing * float(std::max(grid.radiance.back(), grid.motion.empty() ? 0 : grid.motion.back()));
}

/// A model is stored with voxels that OpenVDB takes. Beyond the largest box the rates lose decibels (1e8
/// units: 2 dB, 1e7: none).
void check_unit(const Box& box, const GridConfig& grid) {
  constexpr float kLargest = 1e8f;
  const float edge = box.longest_edge(), least = least_edge(grid);
  if (edge >= least && edge <= kLargest) return;
  const double scale = std::pow(10, std::round(std::log10(1 / double(edge))));
  fail({"the training cameras",
        edge > 1 ? "the scene's unit is too small for it" : "the scene's unit is too large for it",
        fmt::format("a box from {:.3g} to {:.3g} wide", least, kLargest), fmt::format("{:.3g} wide", edge),
        fmt::format("multiply every position: splinevox convert DATASET --out NEW --scale={:g}", scale)});
}

SceneBounds bounds_of(const Config& config, const Split& train, const PictureStats& stats) {
  const std::vector<float>& b = config.grid.box;
  if (b.size() == 6) {
    const Box box{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
    BitGrid all(box, config.sampling.occupancy_cells);
    std::fill(all.bits.begin(), all.bits.end(), ~0u);
    return {box, all};
  }
  return find_bounds(train, stats.see_through, config.sampling.occupancy_cells, config.grid.box_margin);
}

/// Leaves out the stages of more than few_cells. What is left begins later in proportion, so that the last of
/// them has no more of the run than it needs.
void leave_out_finer(GridConfig& grid) {
  constexpr float kLastStart = 0.55f;
  const std::size_t stages = grid.radiance.size();
  while (grid.radiance.size() > 1 && grid.radiance.back() > grid.few_cells) {
    grid.radiance.pop_back();
    grid.radiance_start.pop_back();
  }
  if (grid.radiance.size() == stages || grid.radiance_start.back() <= 0) return;
  const float later = std::max(1.0f, kLastStart / grid.radiance_start.back());
  for (float& start : grid.radiance_start) start *= later;
}

}  // namespace

PictureStats picture_stats(const Split& train) {
  PictureStats out;
  std::size_t partly = 0, any = 0;
  Vec3d sum{};
  double weights = 0;
  for (const Frame* f : some_frames(train)) {
    const ReadAll all_of(f->image);
    for (std::size_t i = 0; i < f->image.pixels(); i += 16) {
      if (f->ignored.test(i)) continue;
      const auto p = f->image.rgba(i);
      const double alpha = p[3] / 65535.0;
      any += alpha > 0.02;
      partly += alpha > 0.02 && alpha < 0.98;
      sum += alpha / 65535.0 * Vec3d{double(p[0]), double(p[1]), double(p[2])};
      weights += alpha;
      out.brightest = std::max(out.brightest, float(alpha / 65535.0 * std::max({p[0], p[1], p[2]})));
    }
  }
  out.see_through =
      !std::all_of(train.frames.begin(), train.frames.end(), [](const Frame& f) { return f.image.opaque(); });
  count_places(train, out);
  out.partly = any > 0 ? float(double(partly) / double(any)) : 0;
  if (weights > 0) out.mean = cast<float>(1 / weights * sum);
  return out;
}

void count_places(const Split& train, PictureStats& stats) {
  std::set<std::array<double, 6>> places;
  std::map<int, const Camera*> first;  // of each camera that has a name or a stand
  for (const Frame& f : train.frames) {
    const Camera* seen = f.camera_id < 0 ? nullptr : first.try_emplace(f.camera_id, &f.camera).first->second;
    const Camera& at = seen && stand_alike(*seen, f.camera) ? *seen : f.camera;
    const Vec3d &p = at.position, &z = at.axes[2];
    places.insert({p.x, p.y, p.z, z.x, z.y, z.z});
  }
  stats.places = int(places.size());
  stats.pictures = int(train.frames.size());
}

bool holds_lattices(const Box& box, const GridConfig& grid) { return box.longest_edge() >= least_edge(grid); }

bool tells_places_apart(const Box& box, const GridConfig& grid) {
  const Vec3 c = box.center();
  const float edge = box.longest_edge(),
              furthest = 0.5f * edge + std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)});
  return furthest * std::numeric_limits<float>::epsilon() <= kApart * edge / float(grid.radiance.back());
}

SceneBounds starting_bounds(const Config& config, const Split& train, const PictureStats& stats) {
  const SceneBounds bounds = bounds_of(config, train, stats);
  check_place(bounds.box, config.grid);
  check_unit(bounds.box, config.grid);
  return bounds;
}

float brightness(const Config& config, const PictureStats& stats) {
  constexpr float kLeast = 1e-3f;  // a black scene has no brightness of its own
  if (!stats.dark()) return 1;
  const std::vector<float>& b = config.run.background;
  const float behind =
      config.sampling.background != BackgroundKind::random ? *std::max_element(b.begin(), b.end()) : 0;
  return std::max({stats.brightest, behind, kLeast});
}

Config in_units_of(float brightness, Config config) {
  config.loss = in_unit_of_brightness(config.loss, brightness);
  config.optimiser.epsilon *= brightness * brightness;
  return config;
}

Config for_places(const PictureStats& stats, Config config) {
  constexpr float kMost = 16;
  if (!stats.rig()) return config;
  if (config.grid.few_cells > 0 && stats.places < config.loss.tv_places) leave_out_finer(config.grid);
  if (stats.see_through) return config;
  const float factor = std::clamp(float(config.loss.tv_places) / float(stats.places), 1.0f, kMost);
  config.loss.tv_density *= factor;
  config.loss.tv_share = std::min(1.0f, config.loss.tv_share * std::sqrt(factor));
  return config;
}

Config for_silhouettes(const PictureStats& stats, Config config) {
  if (!stats.see_through || stats.thin()) config.loss.transmittance = 0;
  return config;
}

Config for_thin(const PictureStats& stats, Config config) {
  if (!config.motion.presence || !stats.thin()) return config;
  SamplingConfig& sampling = config.sampling;
  config.grid.box_alpha *= 0.01f;
  sampling.occupancy_alpha *= 0.1f;
  sampling.min_weight *= 0.1f;
  config.loss.tv_color *= 30;
  return config;
}

bool learns_surroundings(const Config& config, const PictureStats& stats) {
  return config.run.surroundings && !config.grid.surroundings.empty() && config.run.background_order >= 0 &&
         !stats.see_through;
}

float initial_alpha(const Config& config, const PictureStats& stats) {
  return stats.see_through || learns_surroundings(config, stats)
             ? config.radiance.initial_alpha
             : std::max(config.radiance.initial_alpha, config.radiance.opaque_alpha);
}

Vec3 starting_color(const RadianceConfig& config, const PictureStats& stats) {
  constexpr float kDarkest = 1e-5f;
  if (!stats.dark()) return {};
  const float view = config.sh_order >= 0 ? view_factor(float(kSh0) * config.initial_sh).value : 1;
  Vec3 raw;
  for (int c = 0; c < 3; ++c) {
    const float share = std::clamp(stats.mean[c] / view, kDarkest, 0.5f);
    raw[c] = logit(share);
  }
  return raw;
}

bool asks_still_cameras(const Config& config) {
  return freezes(config) || (config.sampling.changing > 0 && changes(effects_of(config)));
}

bool freezes(const Config& config) { return config.motion.enabled && config.motion.rest > 0; }

}  // namespace splinevox
