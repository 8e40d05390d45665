// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

#include "io/houdini_options.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "math/sh.hpp"
#include "math/view_factor.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::BlobMotion, test::Scratch, test::houdini_options;

namespace {

using Key = std::tuple<int, int, int>;
using Voxels = std::map<Key, Vec3>;  // active voxels and their values

Voxels voxels_of(const VdbGrid& grid) {
  Voxels out;
  for (std::size_t l = 0; l < grid.leaves.size(); ++l)
    for (int i = 0; i < 512; ++i) {
      const float* p = &grid.values[(l * 512 + std::size_t(i)) * std::size_t(grid.width)];
      const bool active = grid.active[l * 8 + std::size_t(i >> 6)] >> (i & 63) & 1;
      const Int3 v = grid.leaves[l] + Int3{i >> 6, i >> 3 & 7, i & 7};
      const Vec3 value = grid.width == 3 ? Vec3{p[0], p[1], p[2]} : Vec3{p[0], 0, 0};
      if (active)
        out[{v.x, v.y, v.z}] = value;
      else if (value != Vec3{})
        throw std::runtime_error("an inactive voxel is not 0");
    }
  return out;
}

const VdbGrid& find(const VdbFile& file, const std::string& name) {
  for (const VdbGrid& grid : file.grids)
    if (grid.name == name) return grid;
  throw std::runtime_error("no grid " + name);
}

Vec3 position(const VdbGrid& grid, const Key& k) {
  const Lattice lattice{cast<float>(grid.origin), float(grid.spacing), {}};
  return lattice.position({std::get<0>(k), std::get<1>(k), std::get<2>(k)});
}

}  // namespace

TEST_SUITE("io/export") {
  TEST_CASE("density is the model's at every voxel of the lattice, and nothing of it is missing") {
    struct Row {
      BlobMotion motion;
      double voxel_size;
    };
    for (const Row& row : {Row{{.shift = {-0.5f, 0.1f, 0.2f}, .twist = 0.9f, .rigidity = true}, 0},
                           Row{{.twist = -0.5f}, 0.0371}, Row{{.moves = false}, 0}}) {
      const Scratch scratch;
      const VoxelModel model = blob_model(40, row.motion);
      const ExportOptions options = houdini_options(3, row.voxel_size);
      const ExportResult result = export_vdb(model, scratch.folder(), options);
      REQUIRE(result.frames.size() == 3);
      CHECK(result.finished);
      for (const ExportedFrame& frame : result.frames) {
        CAPTURE(frame.time);
        const VdbFile file = read_vdb(scratch.path(frame.file.name));
        const VdbGrid& grid = find(file, "density");
        const Voxels voxels = voxels_of(grid);
        CHECK(double(voxels.size()) == frame.file.figures.at("density_voxels"));
        CHECK(voxels.size() > 500);
        const FrameSampler sampler(model, frame.time);
        const Lattice lattice{cast<float>(grid.origin), float(grid.spacing), {}};
        const float least = float(-std::log1p(-options.min_alpha) / grid.spacing);
        const Vec3 extent = model.box.extent();
        int wrong = 0;
        for (int x = 0; x <= int(extent.x / lattice.spacing); ++x)
          for (int y = 0; y <= int(extent.y / lattice.spacing); ++y)
            for (int z = 0; z <= int(extent.z / lattice.spacing); ++z) {
              const float expected = sampler.radiance(sampler.canonical(lattice.position({x, y, z}))).density;
              const auto at = voxels.find({x, y, z});
              wrong += (at == voxels.end() ? 0 : at->second.x) != (expected >= least ? expected : 0);
            }
        CHECK(wrong == 0);
      }
    }
  }

  TEST_CASE(
      "colour is the sigmoid times the light and the mean view factor, and reaches one voxel beyond the "
      "density") {
    const Scratch scratch;
    const VoxelModel model = blob_model(32, {.twist = 0.4f, .light = 0.8f}, 3);
    export_vdb(model, scratch.folder(), houdini_options(2));
    const VdbFile file = read_vdb(scratch.path("frame_0002.vdb"));
    const Voxels density = voxels_of(find(file, "density")), color = voxels_of(find(file, "Cd"));
    const FrameSampler sampler(model, 1);
    // The mean by brute force: 4000 directions spread evenly over the sphere.
    std::vector<std::array<float, 16>> basis(4000);
    for (int i = 0; i < 4000; ++i) {
      const double z = 1 - (2 * i + 1) / 4000.0, r = std::sqrt(1 - z * z), a = 2.399963229728653 * i;
      sh_basis(3, Vec3{float(r * std::cos(a)), float(r * std::sin(a)), float(z)},
               basis[std::size_t(i)].data());
    }
    int checked = 0;
    for (const auto& [key, value] : density) {
      REQUIRE(color.count(key) == 1);
      for (int i = 0; i < 27; ++i)
        CHECK(color.count({std::get<0>(key) + i / 9 - 1, std::get<1>(key) + i / 3 % 3 - 1,
                           std::get<2>(key) + i % 3 - 1}) == 1);
      if (++checked % 50 != 0) continue;
      const FrameSampler::Warp warp = sampler.warp(position(find(file, "Cd"), key));
      const auto radiance = sampler.radiance(position(find(file, "Cd"), key) + warp.displacement);
      CHECK(warp.light != 1);
      double mean = 0;
      for (const auto& y : basis) {
        float q = 0;
        for (int j = 0; j < 16; ++j) q += y[std::size_t(j)] * radiance.sh[j];
        mean += view_factor(q).value / 4000.0;
      }
      const Vec3 expected = (warp.light * float(mean)) * radiance.color;
      CHECK(length(color.at(key) - expected) < 2e-3f);
    }
    CHECK(checked > 500);
    for (const auto& [key, value] : color) {  // beyond the stored bricks too: continued, not black
      CHECK(value.x + value.y + value.z > 0.02f);
      CHECK(std::max({value.x, value.y, value.z}) <= 1);
    }
  }

  TEST_CASE("other ways to bake the view, and linear colour") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.moves = false}, 1);
    const FrameSampler sampler(model, 0);
    const auto color_of = [&](ExportOptions options) {
      options.resume = false;
      export_vdb(model, scratch.folder(), options);
      return read_vdb(scratch.path("frame_0001.vdb"));
    };
    ExportOptions options = houdini_options(1);
    for (const char* spec : {"none", "dir=0,0,-2", "linear"}) {
      CAPTURE(spec);
      options.bake_view = spec == std::string("linear") ? "none" : spec;
      options.colorspace = spec == std::string("linear") ? "linear" : "display";
      const VdbFile file = color_of(options);
      const VdbGrid& grid = find(file, "Cd");
      const Voxels density = voxels_of(find(file, "density"));
      for (const auto& [key, value] : voxels_of(grid)) {
        if (!density.count(key)) continue;
        const auto radiance = sampler.radiance(position(grid, key));
        float y[4];
        sh_basis(1, Vec3{0, 0, -1}, y);
        const float q =
            y[0] * radiance.sh[0] + y[1] * radiance.sh[1] + y[2] * radiance.sh[2] + y[3] * radiance.sh[3];
        const float factor = options.bake_view == "none" ? 1 : view_factor(q).value;
        for (int a = 0; a < 3; ++a) {
          const float c = factor * radiance.color[a];
          CHECK(value[a] ==
                doctest::Approx(options.colorspace == "display" ? c : std::pow((c + 0.055) / 1.055, 2.4))
                    .epsilon(c < 0.05f ? 0.05 : 1e-4));
        }
      }
    }
  }

  TEST_CASE("a blob that moves at u has velocity u per second, and beyond its surface too") {
    for (const double seconds : {0.0, 0.25}) {
      CAPTURE(seconds);
      const Scratch scratch;
      const Vec3 shift{-0.6f, 0.1f, 0.2f};
      const VoxelModel model = blob_model(32, {.points = 4, .shift = shift});
      ExportOptions options = houdini_options(5);
      options.seconds = seconds;
      options.shutter = 2;
      const ExportResult result = export_vdb(model, scratch.folder(), options);
      const double length_s = seconds > 0 ? seconds : 4 / 24.0;
      const ManifestFile& frame = result.frames[2].file;
      CHECK(frame.figures.at("time") == doctest::Approx(2 / 24.0 / length_s));
      CHECK(frame.figures.at("folded_share") == 0);
      const double speed = length(shift) / length_s;
      CHECK(frame.figures.at("max_speed") == doctest::Approx(speed).epsilon(1e-4));
      const VdbFile file = read_vdb(scratch.path(frame.name));
      const VdbGrid& grid = find(file, "v");
      CHECK(grid.vector == VdbVector::contravariant_relative);
      const Voxels velocity = voxels_of(grid), density = voxels_of(find(file, "density"));
      const Vec3 expected = shift * float(-1 / length_s);
      for (const auto& [key, value] : velocity) CHECK(length(value - expected) < 1e-3f * length(expected));
      const int reach = int(std::ceil(speed * 2 / 24 / 2 / grid.spacing)) + 1;
      CHECK(frame.figures.at("velocity_padding") == reach);
      int count = 0;
      for (const auto& [key, value] : density) {
        if (++count % 37 != 0) continue;
        const auto [x, y, z] = key;
        for (const int s : {-reach, reach}) {
          CHECK(velocity.count({x + s, y, z}) == 1);
          CHECK(velocity.count({x, y + s, z}) == 1);
          CHECK(velocity.count({x + s, y - s, z + s}) == 1);
        }
      }
    }
  }

  TEST_CASE("velocity of a warp that is no translation: what tracked particles do") {
    const Scratch scratch;
    const VoxelModel model =
        blob_model(40, {.points = 5, .shift = {0.3f, 0.2f, -0.1f}, .twist = 0.8f, .rigidity = true});
    ExportOptions options = houdini_options(3);
    options.seconds = 2.0 / 24;  // frame 2 is model time 0.5
    export_vdb(model, scratch.folder(), options);
    const VdbFile file = read_vdb(scratch.path("frame_0002.vdb"));
    const VdbGrid& grid = find(file, "v");
    const Voxels density = voxels_of(find(file, "density")), velocity = voxels_of(grid);
    const double h = 0.01;
    const FrameSampler now(model, 0.5), before(model, 0.5 - h), after(model, 0.5 + h);
    // Where the particle of canonical position X is: x + Delta(x, t) = X by fixed-point iteration.
    const auto locate = [](const FrameSampler& at, Vec3 canonical, Vec3 x) {
      for (int i = 0; i < 200; ++i) x = x + 0.5f * (canonical - at.canonical(x));
      return x;
    };
    int count = 0;
    double worst = 0, fastest = 0;
    for (const auto& [key, value] : density) {
      if (++count % 29 != 0) continue;
      const Vec3 x = position(grid, key), canonical = now.canonical(x);
      const Vec3d moved = cast<double>(locate(after, canonical, x) - locate(before, canonical, x)) *
                          (1 / (2 * h) / options.seconds);
      worst = std::max(worst, length(moved - cast<double>(velocity.at(key))));
      fastest = std::max(fastest, length(moved));
    }
    CHECK(count > 1000);
    CHECK(fastest > 3);
    CHECK(worst < 0.02 * fastest);
  }
}
