// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/model_vdb.hpp"

#include <doctest/doctest.h>

#include <cstring>
#include <set>

#include "core/atomic_file.hpp"
#include "data/expect_error.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "math/time_curve.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::FileSizeLimit, test::noisy_model, test::Scratch, test::slurp, test::refusal;

namespace {

bool same_bits(const Channels& a, const Channels& b) {
  return a.width == b.width && a.topology->lattice == b.topology->lattice &&
         a.topology->dims == b.topology->dims && a.topology->table == b.topology->table &&
         a.topology->bricks == b.topology->bricks && a.values.size() == b.values.size() &&
         std::memcmp(a.values.data(), b.values.data(), a.values.size() * 4) == 0;
}

std::string refused_model(const std::string& path) {
  return refusal([&] { load_model(path); });
}

std::set<std::string> grid_names(const std::string& path) {
  std::set<std::string> names;
  for (const GridInfo& grid : inspect_vdb(path).grids) names.insert(grid.name);
  return names;
}

}  // namespace

TEST_SUITE("io/model_vdb") {
  TEST_CASE("a march step or a lattice beyond reason is refused, however few bytes ask for it") {
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    save_model(path, blob_model(8));
    const VdbFile good = read_vdb(path);
    const auto with = [&](const char* key, const char* text, bool in_grids) {
      VdbFile file = good;
      if (!in_grids) file.meta[key] = std::string(text);
      for (VdbGrid& grid : file.grids)
        if (in_grids) grid.meta[key] = std::string(text);
      write_vdb(path, file);
      return refused_model(path);
    };
    CHECK(with("march_step", "1e-9", false).find("2^20 steps through the box") != std::string::npos);
    CHECK(with("march_step", "1e-44", false).find("march_step") != std::string::npos);
    CHECK(with("march_step", "nan", false).find("march_step") != std::string::npos);
    CHECK(with("march_step", "0.01", false).empty());
    CHECK(with("lattice", "0 0 0 0.1 8192 8192 8192", true).find("2^25 bricks") != std::string::npos);
    CHECK(with("lattice", "0 0 0 0.1 1e9 8 8", true).find("lattice") != std::string::npos);
  }

  TEST_CASE(
      "a model whose light changes and nothing moves has no control points in its file, and comes back the "
      "same") {
    VoxelModel model = noisy_model(3, 6, FirstPoint::free, BasisKind::bspline, 1, false, true);
    MotionField& m = model.motion;
    m.displaces = false;
    Channels light = make_channels(m.levels[0].topology, m.width(),
                                   std::vector<float>(std::size_t(m.width()), 0.0f).data());
    for (std::size_t r = kBrickRows; r < light.topology->rows(); ++r)
      for (int k = 0; k < 6; ++k) light.row(r)[k] = float(r % 17) - float(k);
    m.levels[0] = light;
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    save_model(path, model);
    for (const std::string& name : grid_names(path)) CHECK_FALSE(name.starts_with("control_"));
    CHECK(grid_names(path).count("light_0"));
    CHECK_FALSE(grid_names(path).count("rigidity"));
    const VoxelModel back = load_model(path);
    CHECK_FALSE(back.motion.displaces);
    CHECK_FALSE(back.motion.moves());
    REQUIRE(back.motion.levels.size() == 1);
    CHECK(same_bits(back.motion.levels[0], light));
  }
  TEST_CASE("a saved model is the model in memory, bit for bit") {
    struct Row {
      int points;
      FirstPoint first;
      BasisKind basis;
      int sh_order;
      bool rigidity, light = false;
    };
    for (const Row& row : {Row{5, FirstPoint::zero, BasisKind::bezier, 1, true},
                           Row{7, FirstPoint::free, BasisKind::bspline, -1, true, true},
                           Row{20, FirstPoint::free, BasisKind::bspline, 1, false, true},
                           Row{2, FirstPoint::zero, BasisKind::bezier, 0, false},
                           Row{12, FirstPoint::free, BasisKind::bezier, 3, false}}) {
      CAPTURE(row.points);
      const Scratch scratch;
      const std::string path = scratch.path("model.vdb");
      VoxelModel model =
          noisy_model(3, row.points, row.first, row.basis, row.sh_order, row.rigidity, row.light);
      model.box.lo.x = std::nextafter(model.box.lo.x, 0.0f);
      model.time_map = {0.1, 1.0 / 3};
      model.background.order = row.sh_order;  // any of -1 to 3
      for (int j = 0; j < model.background.count(); ++j)
        model.background.raw[j] = {0.1f * float(j), 1 / 3.0f, -float(j)};
      save_model(path, model, {{"dataset", "lego"}, {"odd", std::string("\0\xff\n", 3)}});
      ModelNotes notes;
      const VoxelModel back = load_model(path, &notes);
      CHECK(notes == ModelNotes{{"dataset", "lego"}, {"odd", std::string("\0\xff\n", 3)}});
      CHECK(back.box == model.box);
      CHECK(back.background == model.background);
      CHECK(inspect_vdb(path).meta.at("splinevox_model") == (row.sh_order < 0 ? "2" : "4"));
      CHECK(back.step == model.step);
      CHECK(back.time_map == model.time_map);
      CHECK(back.radiance.activation == model.radiance.activation);
      CHECK(back.radiance.sh_order == model.radiance.sh_order);
      CHECK(same_bits(back.radiance.raw, model.radiance.raw));
      CHECK(back.motion.basis == model.motion.basis);
      CHECK(back.motion.points == model.motion.points);
      CHECK(back.motion.first_point == model.motion.first_point);
      CHECK(back.motion.rigidity == model.motion.rigidity);
      CHECK(back.motion.light == model.motion.light);
      CHECK(back.motion.rigidity_offset == model.motion.rigidity_offset);
      REQUIRE(back.motion.levels.size() == 1);
      CHECK(same_bits(back.motion.levels[0], model.motion.levels[0]));

      std::mt19937 random(1);
      std::uniform_real_distribution<float> u(-1.2f, 1.2f);
      for (const double t : {0.0, 0.37, 1.0}) {
        const FrameSampler a(model, t), b(back, t);
        for (int i = 0; i < 200; ++i) {
          const Vec3 x{u(random), u(random), u(random)};
          CHECK(a.canonical(x) == b.canonical(x));
          CHECK(a.warp(x).light == b.warp(x).light);
          CHECK(a.radiance(x).density == b.radiance(x).density);
          CHECK(a.radiance(x).color == b.radiance(x).color);
        }
      }
      CHECK(save_model(scratch.path("again.vdb"), back, notes) == digest_file(path));
    }
  }

  TEST_CASE(
      "a time curve and the bases of edited models come back; files without have the older format number") {
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    for (const auto& [basis, points] : {std::pair{BasisKind::poly_bezier, 10},
                                        std::pair{BasisKind::hermite, 8}, std::pair{BasisKind::bspline, 8}}) {
      VoxelModel model = noisy_model(3, points, FirstPoint::free, basis, 1, true, true);
      model.motion.time_curve = loop_time(3, false);
      save_model(path, model);
      const VoxelModel back = load_model(path);
      CHECK(back.motion.basis == basis);
      CHECK(back.motion.time_curve == model.motion.time_curve);
      for (const double t : {0.0, 0.21, 0.9})
        CHECK(FrameSampler(back, t).canonical({0.1f, 0.2f, 0.3f}) ==
              FrameSampler(model, t).canonical({0.1f, 0.2f, 0.3f}));
      CHECK(inspect_vdb(path).meta.at("splinevox_model") == "3");
    }
    save_model(path, noisy_model(3, 8, FirstPoint::free, BasisKind::bspline, 1, true));
    CHECK(inspect_vdb(path).meta.at("splinevox_model") == "2");
    CHECK(load_model(path).motion.time_curve.identity());
    VdbFile file = read_vdb(path);
    for (const char* curve :
         {"0 0 0.5 1", "0 0 0.6 1 0.5 1 1 1", "0 0 1 1.5", "0 0 1", "0 0 1 nan", "0.1 0 1 1", ""}) {
      for (VdbGrid& grid : file.grids)
        if (grid.name == "control_0") grid.meta["time_curve"] = std::string(curve);
      write_vdb(path, file);
      CAPTURE(curve);
      CHECK(refused_model(path).find("metadata 'time_curve'") != std::string::npos);
    }
  }

  TEST_CASE("what a model lacks is absent from the file") {
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    save_model(path, blob_model(16, {.moves = false}, -1));
    CHECK(grid_names(path) == std::set<std::string>{"density", "rgb"});
    CHECK(load_model(path).motion.levels.empty());
    save_model(path, blob_model(16, {.points = 3, .rigidity = true}, 1));
    CHECK(grid_names(path) == std::set<std::string>{"density", "rgb", "sh0", "sh1", "sh2", "sh3", "control_1",
                                                    "control_2", "rigidity"});
    save_model(path, noisy_model(1, 2, FirstPoint::free, BasisKind::bspline, 0, false));
    CHECK(grid_names(path) == std::set<std::string>{"density", "rgb", "sh0", "control_0", "control_1"});
  }

  TEST_CASE("an empty model has empty grids") {
    const Scratch scratch;
    VoxelModel model = blob_model(16, {.moves = false}, -1);
    const std::vector<float> background(8, -9.0f);
    model.radiance.raw =
        make_channels(make_topology(model.radiance.raw.topology->lattice, {}), 8, background.data());
    save_model(scratch.path("model.vdb"), model);
    const VoxelModel back = load_model(scratch.path("model.vdb"));
    CHECK(back.radiance.raw.topology->brick_count() == 0);
    CHECK(back.radiance.raw.row(5)[0] == -9.0f);
  }

  TEST_CASE("other programs see types, places and what the numbers mean") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.points = 4, .rigidity = true});
    save_model(scratch.path("model.vdb"), model, {}, true);
    const VdbInfo info = inspect_vdb(scratch.path("model.vdb"));
    CHECK(info.meta.at("splinevox_model") == "2");
    CHECK(info.meta.at("time_map") == "0.25 1.5");
    for (const GridInfo& grid : info.grids) {
      CAPTURE(grid.name);
      const bool motion = grid.name == "rigidity" || grid.name.starts_with("control");
      const Channels& channels = motion ? model.motion.levels[0] : model.radiance.raw;
      CHECK(grid.active_voxels == std::uint64_t(channels.topology->brick_count()) * 512);
      CHECK(grid.voxel_size.x == doctest::Approx(channels.topology->lattice.spacing));
      CHECK(length(grid.origin - cast<double>(channels.topology->lattice.origin)) < 1e-12);
      CHECK(grid.half);
      const std::string activation = grid.name == "density"                          ? "softplus"
                                     : grid.name == "rgb" || grid.name == "rigidity" ? "sigmoid"
                                                                                     : "linear";
      CHECK(grid.meta.at("activation") == activation);
      CHECK(grid.meta.count("basis") == std::size_t(motion));
      if (motion) CHECK(grid.meta.at("basis") == "bezier");
      CHECK(grid.meta.count("role") == 1);
    }
    const VoxelModel half = load_model(scratch.path("model.vdb"));
    float worst = 0;
    for (std::size_t i = 0; i < half.radiance.raw.values.size(); ++i)
      worst = std::max(worst, std::abs(half.radiance.raw.values[i] - model.radiance.raw.values[i]) /
                                  std::max(1e-3f, std::abs(model.radiance.raw.values[i])));
    CHECK(worst < 5e-4f);
    CHECK(worst > 0);
  }

  TEST_CASE("files that are not models are refused, naming grid and entry") {
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    const VoxelModel model = blob_model(16, {.points = 3});
    save_model(path, model);
    const VdbFile good = read_vdb(path);
    const auto expect = [&](const VdbFile& file, const std::string& says) {
      write_vdb(path, file);
      const std::string message = refused_model(path);
      CAPTURE(message);
      CHECK(message.find(path) == 0);
      CHECK(message.find(says) != std::string::npos);
    };
    VdbFile file = good;
    file.meta.erase("splinevox_model");
    expect(file, "is a VDB file, but not a model of splinevox");
    file = good;
    file.meta["splinevox_model"] = std::int64_t(9);
    expect(file, "newer version");
    file = good;
    file.meta["box"] = std::string("0 0 0 1 1");
    expect(file, "metadata 'box'");
    file = good;
    file.meta["box"] = std::string("0 0 0 1 -1 1");
    expect(file, "lo.xyz below hi.xyz");
    file = good;
    file.meta["time_map"] = 3.0;
    expect(file, "metadata 'time_map'");
    file = good;
    file.meta["background_order"] = std::int64_t(9);
    expect(file, "an integer from 0 to 3");
    file = good;
    file.meta["background_order"] = std::int64_t(1);
    file.meta["background_harmonics"] = std::string("1 2 3");
    expect(file, "12 finite numbers");
    const auto grid = [&](const std::string& name) -> VdbGrid& {
      for (VdbGrid& g : file.grids)
        if (g.name == name) return g;
      throw std::runtime_error("no grid " + name);
    };
    file = good;
    grid("density").name = "dense";
    expect(file, "has no grid 'density'");
    file = good;
    grid("sh2").name = "other";
    expect(file, "has no grid 'sh2'");
    file = good;
    grid("control_1").meta["basis"] = std::string("nurbs");
    expect(file, "one of: bezier, bspline, poly_bezier, hermite");
    file = good;
    grid("control_1").meta["basis"] = std::string("hermite");
    expect(file, "4, 6, 8, ... points");
    file = good;
    grid("control_1").meta["points"] = std::int64_t(99);
    expect(file, "2 to 20 points");
    file = good;
    grid("control_1").meta["points"] = std::int64_t(257);
    expect(file, "an integer from 2 to 256");
    file = good;
    grid("control_1").meta["basis"] = std::string("bspline");
    expect(file, "free for bspline");
    file = good;
    grid("control_1").meta["row_width"] = std::int64_t(12);
    expect(file, "a multiple of 8");
    file = good;
    grid("density").meta["lattice"] = std::string("0 0 0 -1 9 9 9");
    expect(file, "metadata 'lattice'");
    file = good;
    grid("density").meta["lattice"] = std::string("0 0 0 1 9e9 9e9 9e9");
    expect(file, "metadata 'lattice'");
    file = good;
    grid("rgb").leaves[0] = {800, 0, 0};
    expect(file, "outside its lattice");
    file = good;
    grid("density").values[100] = NAN;
    expect(file, "not finite");
  }

  TEST_CASE("grids that another program pruned or added do no harm") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.moves = false});
    save_model(scratch.path("model.vdb"), model);
    VdbFile file = read_vdb(scratch.path("model.vdb"));
    file.grids[0].leaves.pop_back();  // density of one brick: back to the background
    file.grids[0].values.resize(file.grids[0].leaves.size() * 512);
    file.grids[0].active.resize(file.grids[0].leaves.size() * 8);
    file.grids.push_back({});
    file.grids.back().name = "note";
    write_vdb(scratch.path("model.vdb"), file);
    const VoxelModel back = load_model(scratch.path("model.vdb"));
    CHECK(back.radiance.raw.topology->bricks == model.radiance.raw.topology->bricks);
    int different = 0;
    for (std::size_t r = 0; r < model.radiance.raw.topology->rows(); ++r) {
      if (model.radiance.raw.row(r)[0] != back.radiance.raw.row(r)[0]) ++different;
      CHECK(std::memcmp(model.radiance.raw.row(r) + 1, back.radiance.raw.row(r) + 1, 12) == 0);
    }
    CHECK(different <= kBrickRows);
  }

  TEST_CASE("a full disk leaves the old model") {
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    save_model(path, blob_model(16));
    const std::string good = slurp(path);
    {
      const FileSizeLimit limit(good.size() / 2);
      CHECK_THROWS_AS(save_model(path, blob_model(24)), Error);
    }
    CHECK(slurp(path) == good);
    CHECK(scratch.count() == 1);
  }
}
