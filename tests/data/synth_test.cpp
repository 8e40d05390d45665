// SPDX-License-Identifier: Apache-2.0
#include "splinevox/data/synth.hpp"

#include <doctest/doctest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "data/pictures/exr.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("splinevox_synth_" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

constexpr SynthOptions kSmall{.frames = 10, .size = 40, .seed = 3};

/// Scenes of solid things that stay in the pictures.
std::vector<std::string> solid_scenes() {
  std::vector<std::string> names = synth_scenes();
  std::erase_if(names, [](const std::string& name) {
    return name == "smoke" || name == "fire" || name == "enters" || name == "leaves";
  });
  return names;
}

/// What every second pixel of a view shows, background left out.
struct PixelHit {
  int x, y;
  SynthHit hit;
};
std::vector<PixelHit> look(const SynthMoment& moment, const Camera& camera) {
  std::vector<PixelHit> seen;
  for (int y = 0; y < camera.height; y += 2)
    for (int x = 0; x < camera.width; x += 2)
      if (const auto hit = moment.trace(camera_ray(camera, x + 0.5, y + 0.5))) seen.push_back({x, y, *hit});
  return seen;
}

/// A camera of the test path, 80 pixels wide.
Camera camera_of(int i) {
  static const Dataset data = make_synth("ball", {.frames = 40, .size = 8, .seed = 1});
  Camera camera = data.find("test")->frames[std::size_t(i)].camera;
  for (double* v : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *v *= 10;
  camera.width = camera.height = 80;
  return camera;
}

Error caught(auto&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  return Error({.where = "no error", .what = {}, .expected = {}, .got = {}, .hint = {}}, Fault::numeric);
}

TEST_SUITE("data/synth") {
  TEST_CASE("dancer is the default; an unknown scene lists all and names the nearest") {
    CHECK(synth_scenes() == std::vector<std::string>{"dancer", "ball", "snake", "toy", "garden", "static",
                                                     "smoke", "fire", "enters", "leaves"});
    const Error error = caught([] { SynthScene::open("dencer"); });
    CHECK(error.fault == Fault::input);
    CHECK(std::string(error.what()) ==
          "synth: there is no built-in scene of that name\n"
          "  expected: dancer, ball, snake, toy, garden, static, smoke, fire, enters, leaves\n"
          "  got:      'dencer'\n"
          "  try:      splinevox synth dancer");
  }

  TEST_CASE("hits lie on their pixel's ray and on the surface; rest and position are one material point") {
    for (const std::string& name : solid_scenes()) {
      const SynthScene scene = SynthScene::open(name);
      for (const double t : {0.0, 0.31, 0.77, 1.0}) {
        CAPTURE(name);
        CAPTURE(t);
        const Camera camera = camera_of(int(7 * t));
        const SynthMoment moment = scene.at(t);
        const std::vector<PixelHit> seen = look(moment, camera);
        CHECK(seen.size() > 40);
        double off_pixel = 0, off_surface = 0, off_material = 0, off_unit = 0;
        for (const auto& [x, y, hit] : seen) {
          const Projection p = project(camera, hit.position);
          off_pixel = std::max({off_pixel, std::abs(p.u - x - 0.5), std::abs(p.v - y - 0.5)});
          off_surface = std::max(off_surface, std::abs(moment.distance(hit.body, hit.position)));
          off_material =
              std::max(off_material, length(moment.world_from_rest(hit.body, hit.rest) - hit.position));
          off_unit = std::max(off_unit, std::abs(length(hit.normal) - 1));
        }
        CHECK(off_pixel < 1e-9);
        CHECK(off_surface < 1e-7);
        CHECK(off_material < 1e-9);
        CHECK(off_unit < 1e-12);
      }
    }
  }

  TEST_CASE("at time 0 every point is at rest; later its place at rest is on the same body's surface") {
    for (const std::string& name : solid_scenes()) {
      CAPTURE(name);
      const SynthScene scene = SynthScene::open(name);
      const SynthMoment rest = scene.at(0);
      double moved = 0, off = 0;
      for (const PixelHit& s : look(rest, camera_of(1)))
        moved = std::max(moved, length(s.hit.rest - s.hit.position));
      for (const PixelHit& s : look(scene.at(0.6), camera_of(4)))
        off = std::max(off, std::abs(rest.distance(s.hit.body, s.hit.rest)));
      CHECK(moved < 1e-12);
      CHECK(off < 1e-6);
    }
  }

  TEST_CASE("a surface point seen at one time is seen at its predicted place at another, in the same paint") {
    const SynthScene scene = SynthScene::open("dancer");
    const SynthMoment then = scene.at(0.3), now = scene.at(0.4);
    const Camera camera = camera_of(2);
    int visible = 0, same = 0;
    for (const PixelHit& s : look(then, camera)) {
      const Vec3d p = now.world_from_rest(s.hit.body, s.hit.rest);
      const auto hit = now.trace({camera.position, normalize(p - camera.position)});
      if (!hit || hit->body != s.hit.body || length(hit->position - p) > 1e-6) continue;
      ++visible;
      same += length(hit->rest - s.hit.rest) < 1e-6;
    }
    CHECK(visible > 200);
    CHECK(same == visible);
  }

  TEST_CASE("of the toy's scene the ball alone moves, and of the garden's the plant too") {
    const auto moving = [](const char* name) {
      const SynthScene scene = SynthScene::open(name);
      const SynthMoment first = scene.at(0), later = scene.at(0.3);
      std::vector<int> out;
      for (int body = 0; body < first.bodies(); ++body)
        if (length(later.world_from_rest(body, {0.1, 0, 0.2}) - first.world_from_rest(body, {0.1, 0, 0.2})) >
            1e-9)
          out.push_back(body);
      return out;
    };
    const int bodies = SynthScene::open("toy").at(0).bodies();
    CHECK(SynthScene::open("garden").at(0).bodies() == bodies);
    CHECK(SynthScene::open("dancer").at(0).bodies() == bodies);
    CHECK(moving("toy") == std::vector<int>{bodies - 1});
    const std::vector<int> garden = moving("garden");
    CHECK(garden.size() == 5);  // two stalks, two blossoms and the ball; not the pot
    CHECK(garden.back() == bodies - 1);
    CHECK(moving("static").empty());
    CHECK(moving("dancer").size() > garden.size());
  }
  TEST_CASE("nothing moves in the static scene") {
    const SynthScene scene = SynthScene::open("static");
    const SynthMoment a = scene.at(0), b = scene.at(0.63);
    const Camera camera = camera_of(3);
    const auto before = look(a, camera), after = look(b, camera);
    REQUIRE(before.size() == after.size());
    int differences = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
      differences += !(before[i].hit.position == after[i].hit.position &&
                       length(after[i].hit.rest - after[i].hit.position) < 1e-12 &&
                       before[i].hit.colour == after[i].hit.colour);
    CHECK(differences == 0);
  }

  TEST_CASE("the ball moves by one vector, in proportion to time") {
    const SynthScene scene = SynthScene::open("ball");
    for (const double t : {0.25, 0.5, 1.0})
      for (const PixelHit& s : look(scene.at(t), camera_of(2)))
        REQUIRE(length(s.hit.position - s.hit.rest - t * Vec3d{0.8, 0.3, 0.4}) < 1e-12);
  }

  TEST_CASE("a repeated motion goes there and back without a jump or a jerk") {
    const SynthScene scene = SynthScene::open("ball", {.repeats = 5});
    const Vec3d rest{0, 0, 0.4}, way{0.8, 0.3, 0.4};
    const auto place = [&](double t) { return scene.at(t).world_from_rest(0, rest) - rest; };
    CHECK(length(place(0)) < 1e-12);
    CHECK(length(place(0.2) - way) < 1e-12);
    CHECK(length(place(0.4)) < 1e-12);
    CHECK(length(place(1) - way) < 1e-12);
    CHECK(length(place(0.2 + 1e-4) - place(0.2 - 1e-4)) < 1e-6);
  }

  TEST_CASE("the dancer holds all kinds of movers: rigid, non-rigid and none") {
    const SynthScene scene = SynthScene::open("dancer");
    const SynthMoment rest = scene.at(0), now = scene.at(0.25);
    std::map<int, std::vector<Vec3d>> points;
    for (int view = 0; view < 8; ++view)
      for (const PixelHit& s : look(rest, camera_of(view))) points[s.hit.body].push_back(s.hit.rest);
    int fixed = 0, rigid = 0, bending = 0;
    for (const auto& [body, at_rest] : points) {
      double moved = 0, stretched = 0;
      for (const Vec3d& p : at_rest) {
        const Vec3d q = now.world_from_rest(body, p), q0 = now.world_from_rest(body, at_rest[0]);
        moved = std::max(moved, length(q - p));
        stretched = std::max(stretched, std::abs(length(q - q0) - length(p - at_rest[0])));
      }
      (moved < 1e-12 ? fixed : stretched < 1e-9 ? rigid : bending) += 1;
    }
    CHECK(fixed >= 3);    // plinth, pot, the foot that bears the weight
    CHECK(rigid >= 12);   // limbs
    CHECK(bending >= 4);  // ball, stalks, plait
  }

  TEST_CASE("every solid scene stays within the unit cube and in every picture") {
    for (const std::string& name : solid_scenes()) {
      CAPTURE(name);
      const Dataset data = make_synth(name, kSmall);
      int touched = 0, soft = 0;
      for (const Split& split : data.splits)
        for (const Frame& f : split.frames) {
          CHECK(length(f.camera.position) == doctest::Approx(4));
          const int w = f.image.width;
          int solid = 0;
          for (int y = 0; y < w; ++y)
            for (int x = 0; x < w; ++x) {
              const int alpha = f.image.pixel(x, y)[3];
              solid += alpha == 65535;
              soft += alpha > 0 && alpha < 65535;
              touched += alpha > 0 && (x == 0 || y == 0 || x == w - 1 || y == w - 1);
            }
          CHECK(solid > 20);
        }
      CHECK(touched == 0);
      CHECK(soft > 100);
      double reach = 0;
      for (const double t : {0.0, 0.2, 0.4, 0.6, 0.8})
        for (const PixelHit& s : look(SynthScene::open(name).at(t), camera_of(int(9 * t))))
          reach = std::max(
              {reach, std::abs(s.hit.position.x), std::abs(s.hit.position.y), std::abs(s.hit.position.z)});
      CHECK(reach <= 1.0);
    }
  }

  TEST_CASE("the folder loads back as the data set in memory, and its truth is the scene's") {
    const Folder folder;
    const std::string path = (folder.path / "new" / "set").string();
    int calls = 0, last = 0;
    write_synth("dancer", path, kSmall, [&](int done, int total) {
      CHECK(total == 14);
      CHECK(done == ++calls);
      last = done;
    });
    CHECK(last == 14);
    const Dataset loaded = load_dataset(path), made = make_synth("dancer", kSmall);
    CHECK(loaded.notes.empty());
    CHECK(loaded.has_alpha == made.has_alpha);
    CHECK(loaded.time_map == made.time_map);
    REQUIRE(loaded.splits.size() == made.splits.size());
    for (std::size_t s = 0; s < made.splits.size(); ++s) {
      REQUIRE(loaded.splits[s].name == made.splits[s].name);
      REQUIRE(loaded.splits[s].frames.size() == made.splits[s].frames.size());
      for (std::size_t i = 0; i < made.splits[s].frames.size(); ++i) {
        const Frame &a = loaded.splits[s].frames[i], &b = made.splits[s].frames[i];
        CHECK(a.name == b.name);
        CHECK(a.time == b.time);
        CHECK(a.image == b.image);
        CHECK(a.camera.fx == b.camera.fx);
        CHECK(length(a.camera.position - b.camera.position) == 0);
        for (std::size_t k = 0; k < 3; ++k) CHECK(length(a.camera.axes[k] - b.camera.axes[k]) < 1e-12);
      }
    }
    const SynthScene scene = SynthScene::open("dancer");
    for (const Frame& f : made.find("test")->frames) {
      const std::string file = path + "/truth/" + f.name + "_0000.exr";
      const auto layers = read_exr_layers(file);
      CHECK(layers.size() == 3);
      const Image& position = find_exr_layer(layers, "position", file).image;
      const Image& rest = find_exr_layer(layers, "rest", file).image;
      const Image& depth = find_exr_layer(layers, "depth", file).image;
      CHECK(find_exr_layer(layers, "position", file).channels == std::vector<std::string>{"X", "Y", "Z"});
      CHECK(find_exr_layer(layers, "rest", file).channels == std::vector<std::string>{"R", "G", "B"});
      const SynthMoment moment = scene.at(f.time);
      double worst = 0;
      int hits = 0, lit_background = 0;
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
          const auto hit = moment.trace(camera_ray(f.camera, x + 0.5, y + 0.5));
          const float *p = position.pixel(x, y), *r = rest.pixel(x, y), z = *depth.pixel(x, y);
          if (!hit) {
            lit_background +=
                p[0] != 0 || p[1] != 0 || p[2] != 0 || r[0] != 0 || r[1] != 0 || r[2] != 0 || z != 0;
            continue;
          }
          ++hits;
          const Vec3d stored{p[0], p[1], p[2]};
          worst = std::max(worst, length(moment.world_from_rest(hit->body, {r[0], r[1], r[2]}) - stored));
          worst = std::max(worst, std::abs(project(f.camera, stored).depth - z));
        }
      CHECK(hits > 100);
      CHECK(worst < 1e-5);
      CHECK(lit_background == 0);
    }
  }

  TEST_CASE(
      "the same seed gives the same bits on any number of threads; another seed other training cameras") {
    const Dataset a = make_synth("dancer", kSmall);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Dataset b = make_synth("dancer", kSmall);
    CHECK(a.fingerprint == b.fingerprint);
    bool same = true;
    for (std::size_t s = 0; s < a.splits.size(); ++s)
      for (std::size_t i = 0; i < a.splits[s].frames.size(); ++i)
        same &= a.splits[s].frames[i].image == b.splits[s].frames[i].image;
    CHECK(same);
    const Dataset c = make_synth("ball", {.frames = 10, .size = 8, .seed = 4});
    const Dataset d = make_synth("ball", {.frames = 10, .size = 8, .seed = 3});
    CHECK(c.splits[0].frames[0].camera.position != d.splits[0].frames[0].camera.position);
    CHECK(c.splits[2].frames[1].camera.position == d.splits[2].frames[1].camera.position);
    CHECK(c.fingerprint != d.fingerprint);
  }

  TEST_CASE("splits have the sizes and times of the options") {
    const Dataset data = make_synth("ball", {.frames = 41, .size = 8, .seed = 1});
    CHECK(data.find("train")->frames.size() == 41);
    CHECK(data.find("val")->frames.size() == 4);
    CHECK(data.find("test")->frames.size() == 8);
    CHECK(data.find("train")->frames[10].time == 0.25);
    CHECK(data.find("train")->frames[7].name == "r_007");
    CHECK(make_synth("ball", {.frames = 2, .size = 8, .seed = 1}).find("val")->frames.size() == 2);
  }

  TEST_CASE("an orbit is one camera that goes around evenly, from a place of the seed's") {
    const auto azimuths = [](std::uint64_t seed, double orbit) {
      std::vector<double> out;
      for (const Frame& f :
           make_synth("ball", {.frames = 9, .size = 8, .seed = seed, .orbit = orbit}).find("train")->frames)
        out.push_back(std::atan2(f.camera.position.y, f.camera.position.x));
      return out;
    };
    const std::vector<double> a = azimuths(1, 0.5), b = azimuths(2, 0.5), back = azimuths(1, -1);
    for (std::size_t i = 1; i < a.size(); ++i) {
      CHECK(std::remainder(a[i] - a[i - 1] - M_PI / 8, 2 * M_PI) == doctest::Approx(0).epsilon(1e-9));
      CHECK(std::remainder(back[i] - back[i - 1] + M_PI / 4, 2 * M_PI) == doctest::Approx(0).epsilon(1e-9));
    }
    CHECK(std::abs(a[0] - b[0]) > 0.01);
    CHECK(a[0] == back[0]);
    CHECK(caught([] { make_synth("ball", {.orbit = 101}); }).fault == Fault::input);
    CHECK(caught([] { make_synth("ball", {.orbit = std::nan("")}); }).fault == Fault::input);
  }

  TEST_CASE("options out of range and a folder that cannot be made are told apart") {
    CHECK(std::string(caught([] { make_synth("ball", {.frames = 1, .size = 8, .seed = 1}); }).what()) ==
          "synth, frames: out of range\n  expected: 2 to 10000\n  got:      1");
    CHECK(caught([] { make_synth("ball", {.frames = 2, .size = 7, .seed = 1}); }).fault == Fault::input);
    const Folder folder;
    const std::string file = (folder.path / "taken").string();
    std::ofstream(file) << "a file";
    const Error error = caught([&] { write_synth("ball", file, kSmall); });
    CHECK(error.fault == Fault::output);
    CHECK(std::string(error.what()).find("taken") != std::string::npos);
  }
}

}  // namespace
}  // namespace splinevox
