// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "field/lattice/slice.hpp"
#include "field/warp_velocity.hpp"
#include "io/check_option.hpp"
#include "io/export/leaf_grid.hpp"
#include "io/export/velocity_band.hpp"
#include "math/activation.hpp"
#include "math/srgb.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

/// Density on the voxels of at least min_density, found among the candidate leaves.
LeafValues bake_density(const FrameSampler& sampler, const Lattice& lattice,
                        const std::vector<Int3>& candidates, float min_density) {
  std::vector<float> blocks(candidates.size() * kBrickRows, 0.0f);
  std::vector<LeafMask> masks(candidates.size(), LeafMask{});
  parallel_for(int(candidates.size()), [&](int leaf) {
    const auto l = std::size_t(leaf);
    for (int i = 0; i < kBrickRows; ++i) {
      const Int3 v = kBrick * candidates[l] + Int3{i >> 6, i >> 3 & 7, i & 7};
      if (v.x >= lattice.size.x || v.y >= lattice.size.y || v.z >= lattice.size.z) continue;
      const float density = sampler.density(lattice.position(v));
      if (!(density >= min_density)) continue;
      blocks[l * kBrickRows + std::size_t(i)] = density;
      add_voxel(masks[l], i);
    }
  });
  Int3 dims{};
  for (int a = 0; a < 3; ++a) dims[a] = (lattice.size[a] + kBrick - 1) / kBrick;
  LeafSet set({}, dims);
  std::vector<std::size_t> kept;
  for (std::size_t l = 0; l < candidates.size(); ++l)
    if (masks[l] != LeafMask{}) {
      set.add(candidates[l], masks[l]);
      kept.push_back(l);
    }
  LeafValues out(std::move(set), 1);
  for (std::size_t k = 0; k < kept.size(); ++k)
    std::copy_n(blocks.data() + kept[k] * kBrickRows, kBrickRows, out.at(k, 0));
  return out;
}

/// The density split by the cluster of the matter in a voxel; matter of none goes with the static cluster.
std::vector<LeafValues> split(LeafValues& density, const FrameSampler& sampler, const Lattice& lattice,
                              const MotionClusters& clusters) {
  const LeafSet& dense = density.set();
  const std::size_t count = clusters.clusters.size();
  std::vector<std::vector<LeafMask>> masks(count, std::vector<LeafMask>(dense.size(), LeafMask{}));
  for_each_voxel(
      dense.leaves(), [&](std::size_t l) -> const LeafMask& { return dense.masks()[l]; },
      [&](std::size_t l, int i, Int3 v) {
        const int label = std::max(0, clusters.at(sampler.canonical(lattice.position(v))));
        add_voxel(masks[std::size_t(label)][l], i);
      });
  Int3 dims{};
  for (int a = 0; a < 3; ++a) dims[a] = (lattice.size[a] + kBrick - 1) / kBrick;
  std::vector<LeafValues> parts;
  for (std::size_t c = 0; c < count; ++c) {
    LeafSet set({}, dims);
    for (std::size_t l = 0; l < dense.size(); ++l)
      if (masks[c][l] != LeafMask{}) set.add(dense.leaves()[l], masks[c][l]);
    LeafValues part(std::move(set), 1);
    for_each_voxel(
        part.set().leaves(), [&](std::size_t l) -> const LeafMask& { return part.set().masks()[l]; },
        [&](std::size_t l, int i, Int3 v) { *part.at(l, i) = *density.find(v); });
    parts.push_back(std::move(part));
  }
  return parts;
}

struct BakedColor {
  LeafValues color;
  std::vector<LeafValues> sh;  ///< three coefficients each
};

/// Colour on the density's voxels and one further: a renderer interpolates colour as well, towards 0 where
/// there is none. @param sh_count  coefficients that are wanted beside it
BakedColor bake_color(const FrameSampler& sampler, const Lattice& lattice, const LeafSet& dense,
                      const ViewBake& view, bool linear, int sh_count) {
  LeafValues out(dense.grown(1), 3);
  const LeafSet& set = out.set();
  std::vector<LeafValues> sh(std::size_t(sh_count + 2) / 3, LeafValues(set, 3));
  const auto masks = [&](std::size_t l) -> const LeafMask& { return set.masks()[l]; };
  std::vector<LeafMask> missing(set.size(), LeafMask{});
  for_each_voxel(set.leaves(), masks, [&](std::size_t l, int i, Int3 v) {
    const Vec3 x = lattice.position(v);
    const FrameSampler::Warp warp = sampler.warp(x);
    const auto radiance = sampler.radiance(x + warp.displacement, warp.presence);
    if (radiance.density == 0) {  // nothing is stored there
      add_voxel(missing[l], i);
      return;
    }
    const Vec3 color = (warp.light * view.factor(radiance.sh)) * radiance.color;
    for (int a = 0; a < 3; ++a) out.at(l, i)[a] = linear ? srgb_to_linear(color[a]) : color[a];
    for (int j = 0; j < sh_count; ++j) sh[std::size_t(j / 3)].at(l, i)[j % 3] = radiance.sh[j];
  });
  for_each_voxel(
      set.leaves(), [&](std::size_t l) -> const LeafMask& { return missing[l]; },
      [&](std::size_t l, int i, Int3 v) {
        const auto fill = [&](LeafValues& values) {
          const Vec3 mean = neighbour_mean(values, dense, v);
          for (int a = 0; a < 3; ++a) values.at(l, i)[a] = mean[a];
        };
        fill(out);
        for (LeafValues& values : sh) fill(values);
      });
  return {std::move(out), std::move(sh)};
}

/// Brightness that a voxel gives off per unit of length: the luminance of its colour (weights of Rec. 709)
/// times its density. @pre `color` holds every voxel of `density`
LeafValues bake_flame(LeafValues& density, LeafValues& color) {
  constexpr Vec3 kLuminance{0.2126f, 0.7152f, 0.0722f};
  LeafValues out(density.set(), 1);
  for_each_voxel(
      out.set().leaves(), [&](std::size_t l) -> const LeafMask& { return out.set().masks()[l]; },
      [&](std::size_t l, int i, Int3 v) {
        const float* c = color.find(v);
        *out.at(l, i) = *density.find(v) * dot(kLuminance, Vec3{c[0], c[1], c[2]});
      });
  return out;
}

struct BakedVelocity {
  VelocityBand band;
  double max_speed = 0, folded = 0;  ///< scene units per second; share of the density's voxels
};

BakedVelocity bake_velocity(const FrameSampler& sampler, const Lattice& lattice, const LeafSet& dense,
                            double per_second, double half_shutter) {
  LeafValues core(dense, 3);
  std::vector<double> fastest(dense.size(), 0);
  std::vector<std::uint64_t> folds(dense.size(), 0);
  const auto dense_masks = [&](std::size_t l) -> const LeafMask& { return dense.masks()[l]; };
  for_each_voxel(dense.leaves(), dense_masks, [&](std::size_t l, int i, Int3 v) {
    const FrameSampler::Warp warp = sampler.warp(lattice.position(v));
    const auto moving = material_velocity(warp);
    const Vec3d velocity = per_second * moving.velocity;
    for (int a = 0; a < 3; ++a) core.at(l, i)[a] = float(velocity[a]);
    fastest[l] = std::max(fastest[l], length(velocity));
    folds[l] += moving.folded;
  });
  double max_speed = 0, folded = 0;
  for (const double s : fastest) max_speed = std::max(max_speed, s);
  for (const std::uint64_t n : folds) folded += double(n);
  const std::uint64_t voxels = dense.count();
  return {spread_velocity(std::move(core), half_shutter / lattice.spacing), max_speed,
          voxels ? folded / double(voxels) : 0};
}

/// The density that makes one voxel this opaque.
float density_of(double alpha, const Lattice& lattice) {
  return float(optical_depth(alpha) / lattice.spacing);
}

/// @param counts  voxels along the axes: as doubles, since they may be beyond any integer
void check_counts(const Vec3d& counts, const Lattice& own) {
  constexpr double kMost = double(std::int64_t(1) << 33), kMostAlong = double(1 << 30);
  const double along = std::max({counts.x, counts.y, counts.z}), voxels = counts.x * counts.y * counts.z;
  if (voxels <= kMost && along <= kMostAlong) return;
  fail({.where = "--voxel-size",
        .what = "is too small for the model's box",
        .expected = "at most 2^33 voxels in the box, and 2^30 along an axis",
        .got = option_text(voxels) + " voxels",
        .hint = "the model's own voxel size is " + exact_text<float>({own.spacing})});
}

}  // namespace

Lattice export_lattice(const VoxelModel& model, double voxel_size) {
  const Lattice& own = model.radiance.raw.topology->lattice;
  Lattice lattice = own;
  Vec3d counts = cast<double>(own.size);
  if (voxel_size > 0) {
    lattice.origin = model.box.lo;
    lattice.spacing = float(voxel_size);
    const Vec3d extent = cast<double>(model.box.extent());
    for (int a = 0; a < 3; ++a) counts[a] = std::max(2.0, std::ceil(extent[a] / voxel_size - 1e-3) + 1);
  }
  check_counts(counts, own);
  lattice.size = cast<int>(counts);
  return lattice;
}

FrameBaker::FrameBaker(const VoxelModel& model, const ExportOptions& options, const MotionClusters* clusters)
    : model_(model),
      options_(options),
      clusters_(clusters),
      profile_(find_profile(options.profile)),
      lattice_(export_lattice(model, options.voxel_size)),
      min_density_(density_of(options.min_alpha, lattice_)),
      reach_(model, min_density_),
      view_(options.sh ? "none" : options.bake_view, model.radiance.sh_order),
      mesh_view_(options.bake_view, model.radiance.sh_order) {}

std::vector<BakedPart> FrameBaker::bake(double time, double per_second, bool mesh) const {
  const FrameSampler sampler(model_, time);
  LeafValues density = bake_density(
      sampler, lattice_, reach_.candidates(lattice_, stored_weights(model_.motion, time)), min_density_);
  std::vector<BakedPart> parts;
  if (!clusters_)
    parts.push_back(bake_part(sampler, std::move(density), per_second, mesh));
  else
    for (LeafValues& part : split(density, sampler, lattice_, *clusters_))
      parts.push_back(bake_part(sampler, std::move(part), per_second, mesh));
  return parts;
}

BakedPart FrameBaker::bake_part(const FrameSampler& sampler, LeafValues density, double per_second,
                                bool mesh) const {
  const LeafSet dense = density.set();
  BakedColor baked = bake_color(sampler, lattice_, dense, view_, options_.colorspace == "linear",
                                options_.sh ? model_.radiance.sh_count() : 0);

  BakedPart out;
  out.figures["density_voxels"] = double(dense.count());
  out.figures["color_voxels"] = double(baked.color.set().count());
  add_box(out.figures, dense, cast<double>(lattice_.origin), double(lattice_.spacing));
  std::optional<LeafValues> flame;
  if (options_.flame) flame = bake_flame(density, baked.color);
  auto& grids = out.file.grids;
  grids.push_back(to_grid(density, 1, profile_.density));
  grids.push_back(to_grid(baked.color, 3, profile_.color));
  grids.back().vector = VdbVector::invariant;
  for (std::size_t k = 0; k < baked.sh.size(); ++k) {
    grids.push_back(to_grid(baked.sh[k], 3, "sh" + std::to_string(k)));
    grids.back().vector = VdbVector::invariant;
  }
  if (flame) grids.push_back(to_grid(*flame, 1, profile_.flame));
  if (profile_.velocity && model_.motion.moves()) {
    BakedVelocity velocity =
        bake_velocity(sampler, lattice_, dense, per_second, options_.shutter / options_.fps / 2);
    VelocityBand& band = velocity.band;
    out.figures["velocity_voxels"] = double(band.values.set().count());
    out.figures["velocity_padding"] = band.padding;
    if (band.missing > 0) out.figures["velocity_padding_short"] = band.missing;
    out.figures["max_speed"] = velocity.max_speed;
    out.figures["folded_share"] = velocity.folded;
    grids.push_back(to_grid(band.values, 3, profile_.velocity));
    grids.back().vector = VdbVector::contravariant_relative;
  }
  place_grids(grids, cast<double>(lattice_.origin), double(lattice_.spacing), options_.half, profile_,
              out.figures);
  if (mesh) {
    const bool linear = options_.colorspace == "linear";
    VdbGrid shown;
    if (options_.sh) {
      BakedColor seen = bake_color(sampler, lattice_, dense, mesh_view_, linear, 0);
      shown = to_grid(seen.color, 3, profile_.color);
      shown.origin = grids[1].origin;
      shown.spacing = grids[1].spacing;
    }
    out.mesh = make_mesh(grids[0], options_.sh ? shown : grids[1], density_of(options_.mesh_alpha, lattice_),
                         linear);
  }
  shift_grids(grids, profile_);
  return out;
}

}  // namespace splinevox
