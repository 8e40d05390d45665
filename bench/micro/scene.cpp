// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/rng.hpp"
#include "math/activation.hpp"
#include "render/active_rows.hpp"
#include "render/field_view.hpp"
#include "splinevox/core/error.hpp"
#include "train/refine.hpp"

namespace splinevox::micro {
namespace {

constexpr float kRadius = 0.8f;       // of the ball, in a box of edge 2
constexpr float kEmpty = -10;         // raw density of nothing
constexpr float kSurface = 8;         // raw density in the middle of the shell
constexpr float kSway = 0.05f;        // scene units
constexpr double kDistance = 4;       // of the cameras from the ball's centre
constexpr double kPixel = 1 / 200.0;  // width of a pixel at the ball

enum Stream : std::uint64_t { kColours, kCurves, kRays };

/// The bricks of the ball's shell, and those around them that training keeps.
RadianceField make_radiance(const Config& config, const Box& box, float step) {
  RadianceField out;
  out.sh_order = kOrder;
  out.activation.scale = 1 / step;
  out.activation.shift = float(inverse_softplus(optical_depth(config.radiance.initial_alpha)));
  const Lattice lattice = make_lattice(box, config.grid.radiance.back());
  const float half = 0.5f * kBrick * lattice.spacing;
  std::vector<Int3> bricks;
  for (int x = 0; x * kBrick < lattice.size.x; ++x)
    for (int y = 0; y * kBrick < lattice.size.y; ++y)
      for (int z = 0; z * kBrick < lattice.size.z; ++z) {
        const Vec3 centre = lattice.position({x * kBrick, y * kBrick, z * kBrick}) + Vec3{half, half, half};
        if (std::abs(length(centre) - kRadius) < 1.5f * half) bricks.push_back({x, y, z});
      }
  std::vector<float> row(radiance_width(kOrder), 0.0f);
  row[0] = kEmpty;
  out.raw = make_channels(make_topology(lattice, std::move(bricks)), int(row.size()), row.data());
  const Topology& topology = *out.raw.topology;
  const Rng draw(1, kColours);
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const std::size_t r = std::size_t(b) * kBrickRows + i;
      const float voxels = std::abs(length(topology.position(b, i)) - kRadius) / lattice.spacing;
      out.raw.row(r)[0] = std::max(kEmpty, kSurface * (2 - voxels));
      for (int c = 1; c < 4 + out.sh_count(); ++c)
        out.raw.row(r)[c] = 2 * draw.uniform(r * out.raw.width + c) - 1;
    }
  return out;
}

MotionField make_motion(const Config& config, const Box& box, const BitGrid& matter) {
  MotionField out;
  out.basis = config.motion.basis;
  out.first_point = config.motion.first_point;
  out.rigidity = config.motion.rigidity;
  out.light = config.motion.light;
  out.points = config.motion.points;
  for (std::size_t i = 0; i < config.motion.halve_start.size(); ++i)
    out.points = basis_of(out.basis).refinement.refined(out.points);
  const std::vector<float> zero(out.width(), 0.0f);
  out.levels.push_back(make_channels(bricks_near(make_lattice(box, config.grid.motion.back()), matter),
                                     int(zero.size()), zero.data()));
  Channels& level = out.levels[0];
  const Rng draw(1, kCurves);
  for (std::size_t r = kBrickRows; r < level.topology->rows(); ++r)
    for (int c = 0; c <= out.rigidity_column(); ++c)
      level.row(r)[c] = kSway * (2 * draw.uniform(r * level.width + c) - 1);
  return out;
}

/// Patches of 2 x 2 pixels, nearly all of which show the ball; every slot is a picture of its own.
std::vector<RayInput<float>> make_rays(const Config& config, const VoxelModel& model) {
  const SamplingConfig& sampling = config.sampling;
  const int patches = int(float(sampling.rays) * sampling.growth) / sampling.frames / 4;
  std::vector<RayInput<float>> rays;
  for (int slot = 0; slot < sampling.frames; ++slot) {
    const Rng draw(1, kRays + slot);
    std::uint64_t drawn = 0;
    const auto number = [&] { return double(draw.uniform(drawn++)); };
    const double up = 2 * number() - 1, around = 2 * M_PI * number(), level = std::sqrt(1 - up * up);
    const Vec3d back{level * std::cos(around), level * std::sin(around), up};
    const Vec3d right{-std::sin(around), std::cos(around), 0}, above = cross(back, right);
    const Vec3d eye = kDistance * back;
    for (int p = 0; p < patches; ++p) {
      const double far = 1.1 * kRadius * std::sqrt(number()), turn = 2 * M_PI * number();
      for (int i = 0; i < 4; ++i) {
        const double u = far * std::cos(turn) + (i & 1) * kPixel,
                     v = far * std::sin(turn) + (i >> 1) * kPixel;
        const Ray ray{eye, normalize(u * right + v * above - eye)};
        rays.push_back(clip_ray<float>(ray, model.box, model.step, float(number()), {1, 1, 1}));
      }
    }
  }
  return rays;
}

}  // namespace

Scene::Scene() : config(preset("fast")) {
  if (config.radiance.sh_order != kOrder)
    fail({"bench/micro/scene.hpp", "the preset fast has other harmonics than kernels are compiled for",
          std::to_string(kOrder), std::to_string(config.radiance.sh_order), "set kOrder"});
  model.box = {{-1, -1, -1}, {1, 1, 1}};
  model.step = config.sampling.step * make_lattice(model.box, config.grid.radiance.back()).spacing;
  model.radiance = make_radiance(config, model.box, model.step);
  const SamplingConfig& sampling = config.sampling;
  const BitGrid matter =
      canonical_occupancy(model, sampling.occupancy_cells, sampling.occupancy_alpha, model.step);
  model.motion = make_motion(config, model.box, dilate(matter));
  const OccupancyPyramid canonical(matter);
  BitGrid ever(model.box, sampling.occupancy_cells);
  for (int f = 0; f < sampling.frames; ++f) {
    times.push_back((f + 0.5) / sampling.frames);
    weights.push_back(stored_weights(model.motion, times.back()));
    slices.push_back(make_slice(model.motion, weights.back()));
    occupancy.push_back(frame_occupancy(model, slices.back(), canonical));
    ever |= occupancy.back();
  }
  const Topology& topology = *model.motion.levels[0].topology;
  active = rows_near(topology, ever, reach_of_vertex(topology.lattice));
  rays = make_rays(config, model);
}

const Scene& scene() {
  static const Scene one;
  return one;
}

}  // namespace splinevox::micro
