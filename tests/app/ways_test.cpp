// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "ball_scene.hpp"
#include "math/rotation.hpp"
#include "run/camera_ways.hpp"
#include "run/training_cameras.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "view/taken_from.hpp"

using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

namespace {

constexpr double kDegree = std::numbers::pi / 180;
const Box kBox{{-1, -1, -1}, {1, 1, 1}};

/// A camera 5 units from a point that it looks at, upright.
Camera looks_at(const Vec3d& middle, double azimuth, double elevation, double distance = 5) {
  const double a = azimuth * kDegree, e = elevation * kDegree;
  Camera c;
  c.width = 40;
  c.height = 30;
  c.fx = c.fy = 50;
  c.cx = 20;
  c.cy = 15;
  c.axes[2] = {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
  c.axes[0] = {-std::sin(a), std::cos(a), 0};
  c.axes[1] = cross(c.axes[2], c.axes[0]);
  c.position = middle + distance * c.axes[2];
  return c;
}

Dataset data_of(const std::vector<Camera>& cameras, bool timed = true) {
  Dataset data;
  data.splits.push_back({"train", {}});
  for (std::size_t i = 0; i < cameras.size(); ++i)
    data.splits[0].frames.push_back(
        {"", cameras[i], timed && cameras.size() > 1 ? double(i) / double(cameras.size() - 1) : 0, {}});
  return data;
}

/// On an arc of some degrees, in order.
std::vector<Camera> arc(int count, double degrees, double elevation = 20) {
  std::vector<Camera> out;
  for (int i = 0; i < count; ++i) out.push_back(looks_at({}, degrees * i / (count - 1), elevation));
  return out;
}

std::vector<Shot> shots_of(const std::vector<Camera>& cameras) {
  std::vector<Shot> out;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    out.push_back({cameras[i], double(i) / double(cameras.size() - 1)});
  return out;
}

/// Mean second difference of positions.
double roughness(const std::vector<Camera>& way) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < way.size(); ++i)
    sum += length(way[i - 1].position + way[i + 1].position - 2.0 * way[i].position);
  return sum / double(way.size() - 2);
}

double off_rotation(const Camera& c) {
  double worst = length(cross(c.axes[0], c.axes[1]) - c.axes[2]);
  for (const Vec3d& a : c.axes) worst = std::max(worst, std::abs(length(a) - 1));
  return worst;
}

double apart(const Camera& a, const Camera& b) {
  double worst = length(a.position - b.position);
  for (int i = 0; i < 3; ++i) worst = std::max(worst, length(a.axes[i] - b.axes[i]));
  return worst;
}

std::vector<double> evenly(int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(double(i) / (count - 1));
  return out;
}

}  // namespace

TEST_SUITE("app/ways") {
  TEST_CASE("a rotation comes back from its quaternion, whichever part of that is the largest") {
    for (int azimuth = 0; azimuth < 360; azimuth += 20)
      for (int elevation = -80; elevation <= 80; elevation += 20) {
        const Camera c = looks_at({}, azimuth, elevation);
        const std::array<Vec3d, 3> back = axes_of(quaternion_of(c.axes));
        for (int i = 0; i < 3; ++i) CHECK(length(back[i] - c.axes[i]) < 1e-12);
      }
  }

  TEST_CASE("how cameras stand is measured: around, a film, few places, many, one") {
    const auto stand = [](const Dataset& data) { return survey(data, kBox, 20).stand; };
    CHECK(stand(data_of(arc(12, 330))) == Stand::around);
    CHECK(stand(make_synth("ball", {.frames = 40, .size = 8})) == Stand::around);
    CHECK(stand(data_of(arc(30, 120))) == Stand::film);
    CHECK(stand(data_of(arc(30, 120), false)) == Stand::film);
    CHECK(stand(data_of(arc(5, 120))) == Stand::few);
    CHECK(stand(data_of(std::vector<Camera>(9, looks_at({}, 0, 20)))) == Stand::one);
    std::vector<Camera> mixed = arc(40, 120);
    for (std::size_t i = 0; i < 40; ++i) mixed[i] = arc(40, 120)[i * 17 % 40];
    CHECK(stand(data_of(mixed)) == Stand::many);
    // cameras that look away from the box, and those above it, do not surround it
    std::vector<Camera> outwards = arc(12, 330);
    for (Camera& c : outwards) c.axes = {-c.axes[0], c.axes[1], -c.axes[2]};
    CHECK(stand(data_of(outwards)) != Stand::around);
    std::vector<Camera> above;
    for (int i = 0; i < 12; ++i) above.push_back(looks_at({}, 30 * i, 75));
    CHECK(survey(data_of(above), kBox, 50).stand != Stand::around);
  }

  TEST_CASE("cameras meet where they look, also where their axes are nearly parallel") {
    CHECK(length(survey(data_of(arc(8, 100)), kBox, 20).middle) < 0.05);
    std::vector<Camera> parallel;
    for (int i = 0; i < 6; ++i) {
      parallel.push_back(looks_at({}, 0, 0));
      parallel.back().position.y = 0.1 * (i - 2.5);
    }
    CHECK(length(survey(data_of(parallel), kBox, 20).middle) < 0.05);
  }

  TEST_CASE("a stabilised film loses its shake and keeps its way and its ends") {
    const std::vector<Camera> still = arc(60, 80);
    std::vector<Camera> shaken = still;
    for (std::size_t i = 0; i < shaken.size(); ++i) {
      shaken[i] = looks_at({0.05 * std::sin(2.3 * double(i)), 0, 0.05 * std::cos(3.1 * double(i))},
                           80.0 * double(i) / 59, 20);
      if (i % 2) shaken[i].fx *= 1.02;
    }
    const std::vector<Camera> way = stabilised(shots_of(shaken), 0.2, evenly(60));
    CHECK(roughness(way) < 0.1 * roughness(shaken));
    for (std::size_t i = 0; i < way.size(); ++i) {
      CHECK(length(way[i].position - still[i].position) < 0.06);
      CHECK(off_rotation(way[i]) < 1e-9);
      CHECK(way[i].fx == doctest::Approx(50.5).epsilon(0.02));
    }
    // a straight way stays as it is, ends included
    std::vector<Camera> straight(20, looks_at({}, 0, 20));
    for (std::size_t i = 0; i < straight.size(); ++i) straight[i].position.y = 0.1 * double(i);
    const std::vector<Camera> same = stabilised(shots_of(straight), 0.3, evenly(20));
    for (std::size_t i = 0; i < same.size(); ++i) CHECK(apart(same[i], straight[i]) < 1e-9);
  }

  TEST_CASE("an interpolated way goes through its cameras, on the arc between, and closes") {
    const std::vector<Camera> cameras = round_trip(arc(5, 120), 24);
    REQUIRE(cameras.size() == 5);
    const std::vector<Camera> way = interpolated(cameras, {}, true, evenly(2001));
    CHECK(apart(way.front(), way.back()) < 1e-9);
    for (const Camera& c : cameras) {
      double least = 1;
      for (const Camera& w : way) least = std::min(least, apart(w, c));
      CHECK(least < 0.02);
    }
    for (const Camera& w : way) {
      CHECK(length(w.position) == doctest::Approx(5).epsilon(1e-6));
      CHECK(off_rotation(w) < 1e-9);
    }
    CHECK(round_trip(arc(60, 120), 24).size() == 24);
    const std::vector<Camera> open = interpolated(arc(4, 90), {}, false, {0, 1});
    CHECK(apart(open[0], arc(4, 90).front()) < 1e-9);
    CHECK(apart(open[1], arc(4, 90).back()) < 1e-9);
  }

  TEST_CASE("a way along a wide arc looks at the scene all the time, and goes there and back") {
    for (const auto& [count, degrees] : {std::pair{8, 180.0}, std::pair{12, 150.0}, std::pair{5, 120.0}}) {
      CAPTURE(degrees);
      std::vector<Camera> trip = round_trip(arc(count, degrees), 24);
      REQUIRE(open_at_wide_leg(trip, {}));
      for (const Camera& c : interpolated(trip, {}, false, evenly(501)))
        CHECK(angle_between(c.axes[2], c.position) < 0.05);
    }
    std::vector<Camera> narrow = round_trip(arc(5, 50), 24);
    CHECK_FALSE(open_at_wide_leg(narrow, {}));
    const std::vector<Camera> facing{looks_at({}, 0, 0), looks_at({}, 180, 0)};
    for (const Camera& c : interpolated(facing, {}, false, {0, 0.5, 1}))
      CHECK(length(c.position) == doctest::Approx(5));
  }

  TEST_CASE("a round trip of a ring goes round it") {
    std::vector<Camera> ring;
    for (int i = 0; i < 11; ++i) ring.push_back(looks_at({}, 360.0 * (i * 4 % 11) / 11, 0));
    const std::vector<Camera> trip = round_trip(ring, 24);
    const double step = 2 * 5 * std::sin(std::numbers::pi / 11);
    for (std::size_t i = 0; i < 11; ++i)
      CHECK(length(trip[i].position - trip[(i + 1) % 11].position) == doctest::Approx(step));
  }

  TEST_CASE("a spiral stays among its cameras and looks at the middle") {
    const std::vector<Camera> cameras = arc(9, 60);
    for (const Camera& c : spiral(cameras, {}, evenly(50))) {
      CHECK(off_rotation(c) < 1e-9);
      double least = 10;
      for (const Camera& o : cameras) least = std::min(least, length(c.position - o.position));
      CHECK(least < 1);
      CHECK(length(cross(c.axes[2], normalize(c.position))) < 0.2);
    }
  }

  TEST_CASE("the page keeps near the cameras of one side, and is free where they surround the scene") {
    CHECK_FALSE(taken_from(survey(data_of(arc(12, 330)), kBox, 20)));
    const auto seen = taken_from(survey(data_of(arc(5, 120)), kBox, 20));
    REQUIRE(seen);
    CHECK(seen->directions.size() == 5);
    CHECK(seen->near == doctest::Approx(5).epsilon(0.02));
    CHECK(seen->far == doctest::Approx(5).epsilon(0.02));
    CHECK(seen->spacing ==
          doctest::Approx(angle_between(arc(5, 120)[0].axes[2], arc(5, 120)[1].axes[2])).epsilon(0.05));
  }

  TEST_CASE("render says what way it took and why; the data's own way, and names that there are not") {
    TempFolder temp;
    const auto path = [&](const std::string& name) { return temp.str() + "/" + name; };
    REQUIRE(
        program({"synth", "ball", "--out", path("scene"), "--size", "24", "--frames", "16", "--orbit", "0.2"})
            .code == 0);
    REQUIRE(program({"train", path("scene"), "--out", path("run"), "--preset", "draft", "--max-steps", "20",
                     "--quiet", "--set", "grid.radiance=16,24,32", "--set", "grid.motion=4,8", "--set",
                     "grid.motion_start=0,0.2", "--set", "sampling.rays=256"})
                .code == 0);
    const auto render = [&](const std::vector<std::string>& more) {
      std::vector<std::string> words{"render", path("run"), "--out", path("pictures")};
      words.insert(words.end(), more.begin(), more.end());
      return program(words);
    };
    Ended e = render({});
    CAPTURE(e.err);
    CHECK(e.code == 0);
    CHECK(contains(e.out, "--camera stabilised: 16 pictures are a film of one camera"));
    CHECK(contains(e.out, "fitted to 20% of the film"));
    CHECK(contains(e.out, "16 pictures of 24x24"));
    for (const char* name : {"stabilised", "interpolate", "spiral", "held", "orbit"}) {
      e = render({"--path", name, "--times", "0:1:3", "--size", "16"});
      CAPTURE(e.err);
      CHECK(contains(e.out, "3 pictures of 16x16"));
    }
    CHECK(contains(render({"--camera", "data"}).err, "transforms_render.json"));
    std::filesystem::copy_file(path("scene") + "/transforms_test.json",
                               path("scene") + "/transforms_render.json");
    CHECK(render({"--camera", "data"}).code == 0);
    CHECK(contains(render({"--camera", "stabilized"}).err, "--camera stabilised"));
    // A file of one's own: what it says and is not understood, times that are no times of the run.
    const auto file = [&](const std::vector<std::string>& extras) {
      std::string frames;
      for (const std::string& extra : extras)
        frames += std::string(frames.empty() ? "" : ",") +
                  "{\"transform_matrix\":[[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]" + extra + "}";
      write_text(path("own.json"), "{\"camera_angle_x\":0.6,\"w\":8,\"h\":8,\"frames\":[" + frames + "]}");
      return render({"--camera", path("own.json")});
    };
    e = file({",\"time\":0.2", "", ",\"time\":0.8"});
    CHECK(e.code == 2);
    CHECK(contains(e.err, "2 of 3 frames with 'time'"));
    e = file({",\"time\":0", ",\"time\":1.5", ",\"time\":3"});
    CHECK(e.code == 0);
    CHECK(contains(e.out, "2 of 3 cameras have times outside the run's"));
    CHECK(contains(file({",\"timestamp\":0.4", ",\"timestamp\":0.5"}).out, "timestamp"));
    std::filesystem::rename(path("scene"), path("moved"));
    e = render({"--times", "0:1:2", "--size", "16"});
    CHECK(e.code == 0);
    CHECK(contains(e.out, "--camera orbit, for want of the training cameras"));
    CHECK(render({"--camera", "spiral"}).code == 2);
    CHECK(contains(render({"--data", path("moved"), "--times", "0.5"}).out, "--camera stabilised"));
  }

  TEST_CASE("cameras of a data set need the pixels of three pictures at most: another one is damaged") {
    const SmallRun small;
    const std::string picture = small.data + "/train/r_1.png";
    std::string bytes = slurp(picture);
    bytes[bytes.size() / 2] ^= 1;
    write_text(picture, bytes);
    CHECK(program({"eval", small.run, "--split", "train"}).code == 2);
    const Ended e = program({"render", small.run, "--out", small.path("cameras"), "--format", "cameras",
                             "--camera", "dataset:train"});
    CAPTURE(e.err);
    CHECK(e.code == 0);
    CHECK(contains(e.out, "6 cameras"));
    const Run opened = open_run(small.run);
    CameraRequest one{"dataset:train:1", "", ""};
    const Camera own = plan_shots(opened, one).at(0).camera;
    one.size = 2 * own.width;
    const Camera twice = plan_shots(opened, one).at(0).camera;
    CHECK(twice.width == 2 * own.width);
    CHECK(twice.fx == doctest::Approx(2 * own.fx));
    CHECK_THROWS_AS(open_split(opened, "", "train"), Error);
    const Dataset data = open_split(opened, "", "train", {}, Pixels::left_out);
    CHECK(data.find("train")->frames.size() == 6);
    CHECK(data.find("train")->frames[1].image.pixels() == 0);
  }
}
