// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <map>
#include <random>
#include <regex>
#include <tuple>

#include "field/columns.hpp"
#include "math/activation.hpp"
#include "math/emission.hpp"
#include "math/time_curve.hpp"
#include "run/camera_ways.hpp"
#include "run/html.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"
#include "support/empty_model.hpp"
#include "support/tiny_dataset.hpp"
#include "view/codec.hpp"
#include "view/pack.hpp"
#include "view/page.hpp"
#include "view/reduce.hpp"

using namespace splinevox;
using namespace splinevox::run;

namespace {

std::vector<std::uint16_t> plane_of(const PackedScene& scene, const Json& plane) {
  return read_plane(std::span(scene.bytes).subspan(plane["offset"].get<std::size_t>()),
                    plane["count"].get<std::size_t>(), plane["bits"].get<int>());
}

/// Number of each packed brick by its place in the ring.
std::map<std::tuple<int, int, int>, std::size_t> bricks_of(const PackedScene& scene, const Json& field) {
  const std::vector<std::uint16_t> places = plane_of(scene, field["places"]);
  const std::size_t n = field["bricks"].get<std::size_t>();
  std::map<std::tuple<int, int, int>, std::size_t> bricks;
  for (std::size_t i = 0; i < n; ++i) bricks[{places[i], places[n + i], places[2 * n + i]}] = i;
  return bricks;
}

/// The keys of a table `const NAME = {key: value, ...}` of a script.
std::vector<std::string> keys_of(std::string_view script, const std::string& name) {
  const std::size_t from = script.find("const " + name + " = {");
  REQUIRE(from != script.npos);
  const std::string table(script.substr(from, script.find('}', from) - from));
  const std::regex key("(\\w+):");
  std::vector<std::string> keys;
  for (std::sregex_iterator at(table.begin(), table.end(), key), end; at != end; ++at)
    keys.push_back((*at)[1]);
  return keys;
}

/// A ball of smoke, radius 0.3 in the canonical volume, that is there a fifth of the time. Its mean over time
/// shows nothing. @param moves  everything, along x
VoxelModel brief_smoke(bool moves) {
  VoxelModel m = test::empty_model(32, {32, -4}, -1);
  const Topology& t = *m.radiance.raw.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i)
      if (length(t.position(b, i)) < 0.3f) m.radiance.raw.row(std::size_t(b) * kBrickRows + i)[0] = -9;
  m.motion.basis = BasisKind::bspline;
  m.motion.first_point = FirstPoint::free;
  m.motion.points = 12;
  m.motion.displaces = moves;
  m.motion.rigidity = false;
  m.motion.presence = true;
  const int stride = m.motion.stride();
  Channels& level = test::add_level(m, 8);
  const Vec3 way{0.36f, 0, 0};
  const Vec3 seen = moves ? (-5.0f / 9) * way : Vec3{};  // where it is when point 6 counts most
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      float* row = level.row(std::size_t(b) * kBrickRows + i);
      if (length(level.topology->position(b, i) - seen) < 0.29f) row[stride * 6 + stride - 1] = 18;
      for (int k = 0; moves && k < 12; ++k)  // evenly over time
        for (int a = 0; a < 3; ++a) row[stride * k + a] = float(k - 1) / 9 * way[a];
    }
  return m;
}

}  // namespace

TEST_SUITE("app/view_pack") {
  TEST_CASE("the page knows every basis, by the name that it has everywhere") {
    CHECK(keys_of(view_asset("basis.js"), "kBases") == basis_names());
  }

  TEST_CASE("base64 is that of RFC 4648") {
    const auto coded = [](const std::string& text) {
      return base64(std::vector<char>(text.begin(), text.end()));
    };
    CHECK(coded("") == "");
    CHECK(coded("f") == "Zg==");
    CHECK(coded("fo") == "Zm8=");
    CHECK(coded("foobar") == "Zm9vYmFy");
  }

  TEST_CASE("a plane comes back as it was, of 8 bits and of 16, negative numbers too") {
    std::mt19937 random(3);
    for (const int bits : {1, 8, 9, 16}) {
      CAPTURE(bits);
      std::vector<std::uint16_t> values;
      for (int i = 0; i < 1000; ++i) values.push_back(std::uint16_t(random() & ((1u << bits) - 1)));
      std::vector<std::uint8_t> bytes{7};
      append_plane(bytes, values, bits);
      CHECK(bytes.size() == 1 + values.size() * (bits > 8 ? 2 : 1));
      CHECK(read_plane(std::span(bytes).subspan(1), values.size(), bits) == values);
    }
  }

  TEST_CASE("a quantised number is within half a step, or at the end it lies beyond") {
    const Quantiser q{-2, 6, 5};
    for (float v = -2; v <= 6; v += 0.01f) CHECK(std::abs(q.value(q(v)) - v) <= 0.5f * 8 / 31 + 1e-5f);
    CHECK(q(-9) == 0);
    CHECK(q(99) == 31);
    CHECK(q(std::numeric_limits<float>::quiet_NaN()) == 0);
    const Quantiser constant{3, 3, 8};
    CHECK(constant.value(constant(3)) == 3);
  }

  TEST_CASE("every vertex that can be seen is in the page, within half a step of its value") {
    for (const ViewQuality& quality : {view_qualities()[0], view_qualities()[1]}) {
      const VoxelModel model = test::blob_model(40, {}, 1);
      const PackedScene scene = pack_scene(model, quality);
      const Json& field = scene.header["radiance"];
      const auto bricks = bricks_of(scene, field);
      REQUIRE(field["columns"].size() == 8);
      std::vector<std::vector<std::uint16_t>> columns;
      for (const Json& c : field["columns"]) columns.push_back(plane_of(scene, c["plane"]));
      const Topology& t = *model.radiance.raw.topology;
      std::size_t seen = 0, missing = 0, wrong = 0;
      for (int b = 1; b <= t.brick_count(); ++b)
        for (int i = 0; i < kBrickRows; ++i) {
          const float* row = model.radiance.raw.row(std::size_t(b) * kBrickRows + i);
          const float depth = model.radiance.activation.scale *
                              softplus(row[0] + model.radiance.activation.shift).value * model.step;
          if (one_minus_exp_neg(depth) < 2e-4f) continue;
          ++seen;
          const Int3 place = t.bricks[b] + Int3{1, 1, 1};
          const auto found = bricks.find({place.x, place.y, place.z});
          if (found == bricks.end()) {
            ++missing;
            continue;
          }
          for (int c = 0; c < 8; ++c) {
            const Json& column = field["columns"][c];
            const Quantiser q{column["lo"].get<float>(), column["hi"].get<float>(),
                              column["plane"]["bits"].get<int>()};
            const float value = q.value(columns[c][found->second * kBrickRows + i]),
                        step = (q.hi - q.lo) / float((1 << q.bits) - 1);
            wrong += !(std::abs(value - std::clamp(row[c], q.lo, q.hi)) <= 0.501f * step);
          }
        }
      CHECK(seen > 1000);
      CHECK(missing == 0);
      CHECK(wrong == 0);
      CHECK(bricks.size() < std::size_t(t.brick_count()));
    }
  }

  TEST_CASE("what can be seen part of the time is in the page, and what never can is not seen there") {
    for (const bool moves : {false, true}) {
      CAPTURE(moves);
      VoxelModel model = brief_smoke(moves);
      const Topology& t = *model.radiance.raw.topology;
      model.radiance.raw.row(std::size_t(t.brick_at({1, 1, 1})) * kBrickRows)[0] = -20;  // beside the smoke
      const PackedScene scene = pack_scene(model, view_qualities()[0]);
      const Json& field = scene.header["radiance"];
      const Json& column = field["columns"][0];
      const auto bricks = bricks_of(scene, field);
      const std::vector<std::uint16_t> values = plane_of(scene, column["plane"]);
      const Quantiser q{column["lo"].get<float>(), column["hi"].get<float>(),
                        column["plane"]["bits"].get<int>()};
      const float step = (q.hi - q.lo) / float((1 << q.bits) - 1);
      const DensityActivation& activation = model.radiance.activation;
      const auto shows_as = [&](float raw) {
        const float density = density_of(raw, activation.scale, activation.shift).value;
        return one_minus_exp_neg(density * model.step) > 2.1e-4f;
      };
      std::vector<FrameSampler> times;
      for (int k = 0; k <= 36; ++k) times.emplace_back(model, k / 36.0);
      std::size_t seen = 0, missing = 0, wrong = 0, shown = 0;
      float most_present = 0;
      for (int b = 1; b <= t.brick_count(); ++b)
        for (int i = 0; i < kBrickRows; ++i) {
          const float raw = model.radiance.raw.row(std::size_t(b) * kBrickRows + i)[0];
          float most = 0;
          for (const FrameSampler& s : times)  // all is displaced alike
            most = std::max(most, s.density(t.position(b, i) - s.warp({}).displacement));
          const bool shows = one_minus_exp_neg(most * model.step) > 2.1e-4f;
          const float presence =
              float(raw_of_depth(std::max(most, 1e-30f), activation.scale, activation.shift)) - raw;
          most_present = std::max(most_present, presence);
          seen += shows;
          const Int3 place = t.bricks[b] + Int3{1, 1, 1};
          const auto found = bricks.find({place.x, place.y, place.z});
          if (found == bricks.end()) {
            missing += shows;
            continue;
          }
          const float value = q.value(values[found->second * kBrickRows + i]);
          wrong += shows && !(std::abs(value - raw) <= 0.501f * step);
          shown += !shows && shows_as(value + presence);
        }
      CHECK(seen > 60);
      CHECK(missing == 0);
      CHECK(wrong == 0);
      CHECK(shown == 0);
      CHECK(most_present > 1);
      CHECK_FALSE(shows_as(column["background"].get<float>() + most_present));
      CHECK(bricks.size() < std::size_t(t.brick_count()));
    }
  }

  TEST_CASE(
      "the cells that hold matter at some time are the same in whatever time an edit shows the motion") {
    const VoxelModel model = test::blob_model(40, {}, -1);
    const auto ever = [](const VoxelModel& of) {
      const PackedScene scene = pack_scene(of, view_qualities()[0]);
      return plane_of(scene, scene.header["occupancy"]["ever"]);
    };
    const std::vector<std::uint16_t> plain = ever(model);
    for (const int times : {4, 64}) {
      CAPTURE(times);
      VoxelModel looped = model;
      retime(looped.motion, loop_time(times, false));
      CHECK(ever(looped) == plain);
    }
  }

  TEST_CASE("control points, light and rigidity are within half a step; zero stays zero") {
    const VoxelModel model = test::noisy_model(5, 4, FirstPoint::free, BasisKind::bspline, 0, true, true);
    const PackedScene scene = pack_scene(model, view_qualities()[0]);
    const Json& field = scene.header["motion"];
    const auto bricks = bricks_of(scene, field);
    const Channels& level = model.motion.levels[0];
    const Topology& t = *level.topology;
    REQUIRE(field["control_points"].size() == 4);
    REQUIRE(field["light_points"].size() == 4);
    std::size_t wrong = 0;
    const auto compare = [&](const Json& entry, int first) {
      for (std::size_t lane = 0; lane < entry["planes"].size(); ++lane) {
        const auto values = plane_of(scene, entry["planes"][lane]);
        for (int b = 1; b <= t.brick_count(); ++b)
          for (int i = 0; i < kBrickRows; ++i) {
            const Int3 v = t.vertex(b, i), place = t.bricks[b] + Int3{1, 1, 1}, size = t.lattice.size;
            if (v.x >= size.x || v.y >= size.y || v.z >= size.z) continue;
            const float was = level.row(std::size_t(b) * kBrickRows + i)[first + int(lane)];
            const auto q = std::int16_t(values[bricks.at({place.x, place.y, place.z}) * kBrickRows + i]);
            const float scale = entry["scale"].get<float>();
            wrong += !(std::abs(scale * float(q) - was) <= 0.501f * scale) || (was == 0 && q != 0);
          }
      }
    };
    for (int k = 0; k < 4; ++k) {
      compare(field["control_points"][k], 4 * k);
      compare(field["light_points"][k], 4 * k + 3);
    }
    compare(field["rigidity_values"], 16);
    CHECK(wrong == 0);
  }

  TEST_CASE("every column of a model is in the page, by the name that its grids have") {
    const VoxelModel model =
        test::noisy_model(5, 4, FirstPoint::free, BasisKind::bspline, 1, true, true, true);
    const PackedScene scene = pack_scene(model, view_qualities()[0]);
    std::size_t radiance = 0;
    for (const ColumnFacts& facts : kColumns) {
      CAPTURE(facts.name);
      const std::vector<Column> columns = columns_of(model, facts.kind);
      REQUIRE_FALSE(columns.empty());
      const Json& motion = scene.header["motion"];
      const std::string name = facts.name;
      if (!facts.of_motion())
        radiance += columns.size() * std::size_t(facts.width);
      else if (facts.repeat == Repeat::point)
        CHECK(motion[name + "_points"].size() == columns.size());
      else
        CHECK(motion[name + "_values"]["planes"].size() == std::size_t(facts.width));
    }
    CHECK(scene.header["radiance"]["columns"].size() == radiance);
  }

  TEST_CASE("each quality is smaller than the one before; without view dependence there are four columns") {
    const VoxelModel model = test::blob_model(48, {}, 2);
    std::size_t last = std::size_t(-1);
    for (const ViewQuality& quality : view_qualities()) {
      if (quality.halvings != 0) continue;
      const PackedScene scene = pack_scene(model, quality);
      const std::size_t size = deflated(scene.bytes).size();
      CHECK(size < last);
      last = size;
      CHECK(scene.header["radiance"]["columns"].size() == (quality.sh_bits ? 13 : 4));
    }
    CHECK(deflated(pack_scene(model, view_qualities().back()).bytes).size() < last);
  }

  TEST_CASE("without the view rescale a colour is the mean over the directions") {
    VoxelModel model = test::blob_model(16, {}, 1);
    for (std::size_t r = kBrickRows; r < model.radiance.raw.topology->rows(); ++r) {
      float* row = model.radiance.raw.row(r);
      row[1] = 2;
      row[4] = 0;
      row[5] = 3;
      row[6] = -2;
      row[7] = 1;  // odd in the direction: the mean of the factor is that of no harmonics
    }
    const RadianceField matt = without_view(model.radiance);
    CHECK(matt.sh_order == -1);
    CHECK(sigmoid(matt.raw.row(kBrickRows)[1]).value ==
          doctest::Approx(0.75f * sigmoid(2.0f).value).epsilon(1e-5));
  }

  TEST_CASE("halving keeps what is linear, and adds nothing beyond what was there") {
    VoxelModel model = test::blob_model(24, {}, -1);
    model.radiance.raw = make_channels(make_dense_topology(model.radiance.raw.topology->lattice),
                                       model.radiance.raw.width, std::vector<float>(8, -3.0f).data());
    const Topology& t = *model.radiance.raw.topology;
    const auto linear = [](Vec3 x) { return 1 + 2 * x.x - 3 * x.y + 0.5f * x.z; };
    for (int b = 1; b <= t.brick_count(); ++b)
      for (int i = 0; i < kBrickRows; ++i)
        model.radiance.raw.row(std::size_t(b) * kBrickRows + i)[0] = linear(t.position(b, i));
    const RadianceField coarse = halved(model.radiance);
    const Topology& c = *coarse.raw.topology;
    CHECK(c.lattice.spacing == 2 * t.lattice.spacing);
    int compared = 0;
    for (int b = 1; b <= c.brick_count(); ++b)
      for (int i = 0; i < kBrickRows; ++i) {
        const Int3 v = c.vertex(b, i);
        const float value = coarse.raw.row(std::size_t(b) * kBrickRows + i)[0];
        const bool inside = v.x > 0 && v.y > 0 && v.z > 0 && v.x < 11 && v.y < 9 && v.z < 8;
        if (inside) {
          CHECK(value == doctest::Approx(linear(c.position(b, i))).epsilon(1e-5));
          ++compared;
        }
        if (v.x >= 20) CHECK(value == -3.0f);
      }
    CHECK(compared > 300);
  }

  TEST_CASE("a page opens where most is seen, without what an edge cuts off; then the middle of time") {
    const VoxelModel model = test::blob_model(16, {.moves = false});
    const Camera near = orbit(model.box, 20, 64, 1).front();
    Camera far = near, cut = near;
    far.fx = far.fy = near.fx / 2;
    cut.fx = cut.fy = 20 * near.fx;
    const auto shot = [](const Camera& camera, double time) { return TrueShot{"r", camera, time, {}, true}; };
    const std::vector<TrueShot> shots{shot(cut, 0.5), shot(far, 0.5), shot(near, 0.1), shot(near, 0.6)};
    const FirstSight first = first_sight(model, shots, nullptr, 32);
    CHECK(first.view == 3);
    CHECK(first.shot.time == 0.6);
    const test::TempFolder temp;
    test::write_bytes(temp.path() / "poster.png", {first.poster.begin(), first.poster.end()});
    const Picture poster = read_png((temp.path() / "poster.png").string());
    CHECK(poster.width == 32);
    CHECK(poster.pixel(0)[3] == 0);
    CHECK(poster.pixel(32 * 16 + 16)[3] > 60000);
    CHECK(first_sight(model, {}, nullptr, 32).view == -1);
    TrainingCameras train;
    train.stand = Stand::film;
    train.places = {{far, 0.2}};
    CHECK(first_sight(model, shots, &train, 32).shot.time == 0.2);
    train.stand = Stand::one;
    CHECK(std::abs(first_sight(model, shots, &train, 32).shot.time - 0.5) < 0.05);
    CHECK(plain_sight(shots, &train)->view == -1);
    CHECK_FALSE(plain_sight({}, nullptr));
  }
}
