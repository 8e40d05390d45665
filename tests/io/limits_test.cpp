// SPDX-License-Identifier: Apache-2.0
// What a configuration may say, the reader of a model can read: at the extremes of every key.
#include <doctest/doctest.h>

#include <limits>
#include <type_traits>

#include "field/columns.hpp"
#include "io/scratch.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/train/config_keys.hpp"
#include "train/config/config_value.hpp"

using namespace splinevox;
using test::Scratch;

namespace {

/// The model that training with a configuration ends with, by its shape; of its matter a brick is there.
VoxelModel model_of(const Config& c) {
  VoxelModel m;
  m.box = {{-1, -1, -1}, {1, 1, 1}};
  m.background.order = c.run.background_order;
  const auto channels = [&](int cells, int width) {
    const std::vector<float> background(std::size_t(width), 0.25f);
    return make_channels(make_topology(make_lattice(m.box, cells), {{0, 0, 0}}), width, background.data());
  };
  m.radiance.activation = {40, -4};
  m.radiance.sh_order = c.radiance.sh_order;
  m.radiance.raw = channels(c.grid.radiance.back(), radiance_width(c.radiance.sh_order));
  m.step = c.sampling.step * m.radiance.raw.topology->lattice.spacing;
  MotionField& motion = m.motion;
  motion.basis = c.motion.basis;
  motion.points = points_at_end(c.motion);
  motion.first_point = c.motion.first_point;
  motion.displaces = c.motion.enabled;
  motion.rigidity = c.motion.enabled && c.motion.rigidity;
  motion.light = c.motion.light;
  motion.presence = c.motion.presence && c.motion.first_point == FirstPoint::free;
  if (motion.displaces || motion.light || motion.presence)
    motion.levels = {channels(c.grid.motion.back(), motion.width())};
  if (!c.run.surroundings) return m;
  constexpr int kWidth = radiance_width(-1);  // density and colour
  const std::vector<float> empty(std::size_t(kWidth), 0.25f);
  const Lattice around = outer_lattice(c.grid.surroundings.back());
  m.surroundings.box = m.box;
  m.surroundings.raw = make_channels(make_topology(around, {{0, 0, 0}}), kWidth, empty.data());
  return m;
}

/// The largest number that a key may have.
int most_of(const std::string& key) {
  Config c;
  double most = 0;
  visit_config(c, [&](const char* name, const auto&, const char*, double, double hi) {
    if (key == name) most = hi;
  });
  return int(most);
}

/// Voxels of a grid on a cube that is full.
double full(const Lattice& lattice) {
  double voxels = kBrickRows;
  for (int a = 0; a < 3; ++a) voxels *= (lattice.size[a] + kBrick - 1) / kBrick;
  return voxels;
}

bool is_valid(const Config& c) {
  try {
    validate(c);
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Saves and reads back, if a configuration is valid. @return whether it is
bool check_round_trip(const Config& c, const Scratch& scratch) {
  if (!is_valid(c)) return false;
  const VoxelModel model = model_of(c);
  save_model(scratch.path("model.vdb"), model);
  const VoxelModel back = load_model(scratch.path("model.vdb"));
  CHECK(back.motion.points == (model.motion.levels.empty() ? back.motion.points : model.motion.points));
  CHECK(back.motion.levels.size() == model.motion.levels.size());
  CHECK(back.motion.presence == model.motion.presence);
  CHECK(back.surroundings.any() == model.surroundings.any());
  CHECK(back.radiance.raw.topology->lattice == model.radiance.raw.topology->lattice);
  return true;
}

}  // namespace

TEST_SUITE("io/limits") {
  TEST_CASE("at both ends of every key, what validates is saved and read back") {
    const Scratch scratch;
    int tried = 0;
    for (const char* base : {"fast", "paper"}) {
      std::vector<std::string> keys;
      const Config start = preset(base);
      visit_config(start, [&](const char* name, const auto&, const char*, double, double) {
        keys.emplace_back(name);
      });
      for (const std::string& key : keys)
        for (const bool high : {false, true}) {
          Config c = start;
          visit_config(c, [&](const char* name, auto& member, const char*, double lo, double hi) {
            using T = std::decay_t<decltype(member)>;
            if (key != name) return;
            if constexpr (std::is_enum_v<T>)
              member = high ? choices<T>().back().value : choices<T>().front().value;
            else if constexpr (config_value::IsList<T>::value)
              for (auto& v : member) v = static_cast<std::decay_t<decltype(v)>>(high ? hi : lo);
            else
              member = static_cast<T>(high ? hi : lo);
          });
          CAPTURE(key);
          CAPTURE(high);
          tried += check_round_trip(c, scratch);
        }
    }
    CHECK(tried > 150);
  }

  TEST_CASE(
      "control points of every basis, with and without motion, light, rigidity and presence, up to the "
      "most") {
    const Scratch scratch;
    int good = 0, refused = 0;
    for (const Choice<BasisKind>& basis : choices<BasisKind>())
      for (const int points : {2, 3, 4, 7, 61, 119, 120, 121, 122, 127, 128, 237, 238, 239, 253, 256})
        for (const bool light : {false, true})
          for (const bool moves : {false, true}) {
            if (!light && !moves) continue;
            Config c = preset("fast");
            c.motion.presence = points % 2 == 1;
            c.radiance.sh_order = 3;
            c.motion.halve_start.clear();
            c.motion.elevate_points.clear();
            c.motion.elevate_start.clear();
            c.motion.first_point = FirstPoint::free;
            c.motion.rigidity = moves;
            c.motion.basis = basis.value;
            c.motion.points = points;
            c.motion.light = light;
            c.motion.enabled = moves;
            CAPTURE(basis.name);
            CAPTURE(points);
            CAPTURE(light);
            check_round_trip(c, scratch) ? ++good : ++refused;
          }
    CHECK(good > 20);
    CHECK(refused > 4);
    Config c = preset("fast");
    c.motion.light = true;
    c.motion.basis = BasisKind::bspline;
    c.motion.points = 61;
    c.motion.halve_start = {0.3f, 0.6f};
    CHECK_THROWS_WITH_AS(validate(c), doctest::Contains("'motion.points' leads to more grids"), Error);
    CHECK_THROWS_AS(save_model(scratch.path("model.vdb"), model_of(c)), Error);
  }

  TEST_CASE("full lattices of the most cells and the most grids are written and read: no training is lost") {
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    RadianceField radiance;
    radiance.sh_order = most_of("radiance.sh_order");
    const std::size_t finest = radiance_columns(radiance).size();
    const double voxels =
        double(finest) * full(make_lattice(box, most_of("grid.radiance"))) +
        double(kMostGrids - finest) * full(make_lattice(box, most_of("grid.motion"))) +
        double(VdbLimits().max_grids - kMostGrids) * full(outer_lattice(most_of("grid.surroundings")));
    CHECK(voxels > 5e10);
    CHECK(voxels <= double(VdbLimits().max_voxels));
    // Vectors that do not become smaller, with two masks and the lengths of a block for each leaf.
    const double leaf = kBrickRows * 3.0 * sizeof(float) + 256;
    CHECK(double(VdbLimits().max_voxels) / kBrickRows * leaf <= double(VdbLimits().max_bytes));
  }

  TEST_CASE("a model with values that are not finite is not saved, and the old file stays") {
    const Scratch scratch;
    const std::string path = scratch.path("model.vdb");
    const VoxelModel good = model_of(preset("fast"));
    save_model(path, good);
    const std::string before = test::slurp(path);
    for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity()})
      for (const bool motion : {false, true})
        for (const bool absent : {false, true}) {
          VoxelModel bad = good;
          Channels& c = motion ? bad.motion.levels[0] : bad.radiance.raw;
          c.row(absent ? 0 : kBrickRows + 5)[1] = value;
          try {
            save_model(path, bad);
            FAIL("it was saved");
          } catch (const Error& e) {
            CHECK(e.fault == Fault::numeric);
            CHECK(std::string(e.what()).find("not finite") != std::string::npos);
          }
          CHECK(test::slurp(path) == before);
        }
  }
}
