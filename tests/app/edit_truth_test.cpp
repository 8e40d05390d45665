// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

#include "data/truth.hpp"
#include "math/camera.hpp"
#include "program.hpp"
#include "run/correspondence.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/run/run.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

constexpr float kCell = 0.015f;   ///< of places at rest that count as one
constexpr float kSeen = 0.05f;    ///< change of a channel that counts as a change of the picture
constexpr float kBehind = 0.01f;  ///< change of depth, share of the box, from which another surface is seen

/// Surface pixels of a split: those of parts that truly move, where now another surface is seen or none; the
/// rest, and where the picture differs.
struct Changed {
  std::size_t moving = 0, moving_gone = 0, still = 0, still_changed = 0;
};

Changed changed(const run::Run& before, const run::Run& after, const Dataset& data) {
  const float edge = before.model.box.longest_edge();
  const Split& split = *data.find("test");
  const std::vector<SurfaceFrame> truth = read_truth(data.path, split, 0.03f * edge);
  const auto key = [&](const Vec3& r) {
    const auto c = [&](float v) { return int(std::floor(v / (kCell * edge))); };
    return std::tuple{c(r.x), c(r.y), c(r.z)};
  };
  std::map<std::tuple<int, int, int>, std::pair<Vec3, Vec3>>
      reach;  // lowest and highest displacement of what is in a cell at rest
  for (const SurfaceFrame& f : truth)
    for (std::size_t i = 0; i < f.rest.size(); ++i) {
      const Vec3 d = f.position[i] - f.rest[i];
      const auto at = reach.try_emplace(key(f.rest[i]), d, d).first;
      at->second = {min(at->second.first, d), max(at->second.second, d)};
    }
  Changed out;
  Renderer a(before.model), b(after.model);
  for (std::size_t f = 0; f < truth.size(); ++f) {
    const Frame& frame = split.frames[f];
    const Rendered ra = a.render(frame.camera, frame.time), rb = b.render(frame.camera, frame.time);
    const Image &x = ra.rgb, &y = rb.rgb;
    for (std::size_t i = 0; i < truth[f].rest.size(); ++i) {
      const Projection p = project(frame.camera, cast<double>(truth[f].position[i]));
      const int u = int(p.u), v = int(p.v);
      if (u < 0 || v < 0 || u >= x.width || v >= x.height) continue;
      float most = 0;
      for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(x.pixel(u, v)[c] - y.pixel(u, v)[c]));
      const auto& [lo, hi] = reach.at(key(truth[f].rest[i]));
      const bool moving = length(hi - lo) > float(run::kTrulyMoves) * edge;
      const bool gone = *rb.alpha.pixel(u, v) < 0.5f * *ra.alpha.pixel(u, v) ||
                        *rb.depth.pixel(u, v) - *ra.depth.pixel(u, v) > kBehind * edge;
      ++(moving ? out.moving : out.still);
      if (moving ? gone : most > kSeen) ++(moving ? out.moving_gone : out.still_changed);
    }
  }
  return out;
}

/// The run to edit: a finished one on truth_excavator. A run of seconds will not do: its still parts swim.
const char* finished_run() {
  const char* run = std::getenv("SPLINEVOX_EDIT_RUN");
  if (!run) MESSAGE("skipped: SPLINEVOX_EDIT_RUN names no finished run on truth_excavator");
  return run;
}

}  // namespace

TEST_SUITE("app/edit_truth") {
  TEST_CASE("hiding what moves in truth_excavator takes away its boom and bucket and little else") {
    const char* run = finished_run();
    if (!run) return;
    const TempFolder temp;
    const std::string hidden = temp.str() + "/hidden";
    const Ended edit =
        program({"edit", run, "--out", hidden, "--clusters", "auto", "--cluster", "moving", "--hide"});
    CAPTURE(edit.err);
    CAPTURE(edit.out);
    REQUIRE(edit.code == 0);
    const run::Run before = run::open_run(run), after = run::open_run(hidden);
    const char* root = std::getenv("SPLINEVOX_DATA");
    const Changed c = changed(
        before, after, run::open_split(before, root ? std::string(root) + "/truth_excavator" : "", "test"));
    const double moving = double(c.moving_gone) / double(c.moving),
                 still = double(c.still_changed) / double(c.still);
    MESSAGE("moving parts: " << 100 * moving << "% of " << c.moving
                             << " pixels show another surface or none; the rest: picture changed at "
                             << 100 * still << "% of " << c.still);
    CHECK(c.moving > 1000);
    CHECK(moving > 0.95);
    CHECK(still < 0.01);
  }
  TEST_CASE(
      "on a finished run: elevation changes a picture by less than 1e-5, half speed shows the same picture "
      "at 2t, twice back is the run") {
    const char* run = finished_run();
    if (!run) return;
    const TempFolder temp;
    const auto path = [&](const char* name) { return temp.str() + "/" + name; };
    REQUIRE(program({"edit", run, "--out", path("bezier"), "--basis", "bezier:12", "--quiet"}).code == 0);
    REQUIRE(program({"edit", path("bezier"), "--out", path("elevated"), "--elevate", "3", "--quiet"}).code ==
            0);
    REQUIRE(program({"edit", run, "--out", path("half"), "--speed", "0.5", "--quiet"}).code == 0);
    REQUIRE(program({"edit", run, "--out", path("twice"), "--reverse", "--reverse", "--quiet"}).code == 0);
    CHECK(slurp(path("twice") + "/model.vdb") == slurp(std::string(run) + "/model.vdb"));
    const run::Run original = run::open_run(run), bezier = run::open_run(path("bezier")),
                   elevated = run::open_run(path("elevated")), half = run::open_run(path("half"));
    const char* root = std::getenv("SPLINEVOX_DATA");
    const Dataset data =
        run::open_split(original, root ? std::string(root) + "/truth_excavator" : "", "test");
    Renderer a(bezier.model), b(elevated.model), c(original.model), d(half.model);
    const auto worst = [](const Image& x, const Image& y) {
      float most = 0;
      for (std::size_t i = 0; i < x.data.size(); ++i) most = std::max(most, std::abs(x.data[i] - y.data[i]));
      return double(most);
    };
    double elevation = 0, slower = 0;
    for (const int i : {1, 5, 9}) {
      const Frame& frame = data.find("test")->frames[std::size_t(i)];
      elevation = std::max(
          elevation, worst(a.render(frame.camera, frame.time).rgb, b.render(frame.camera, frame.time).rgb));
      const double t = frame.time / 2;
      slower = std::max(slower, worst(c.render(frame.camera, t).rgb, d.render(frame.camera, 2 * t).rgb));
    }
    MESSAGE("largest change of a channel: elevation " << elevation << ", half speed " << slower);
    CHECK(elevation < 1e-5);
    CHECK(slower < 1e-6);
  }
}
