// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

#include "app/correspondence.hpp"
#include "app/evaluate.hpp"
#include "program.hpp"
#include "splinevox/data/truth.hpp"
#include "splinevox/math/camera.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

constexpr float kCell = 0.015f;   ///< of places at rest that count as one
constexpr float kSeen = 0.05f;    ///< change of a channel that counts as a change of the picture
constexpr float kBehind = 0.01f;  ///< change of depth, share of the box, from which another surface is seen

/// Surface pixels of a split: those of parts that truly move, where now another surface is seen or none; the rest, and where the
/// picture differs.
struct Changed {
  std::size_t moving = 0, moving_gone = 0, still = 0, still_changed = 0;
};

Changed changed(const app::Run& before, const app::Run& after, const Dataset& data) {
  const float edge = before.model.box.longest_edge();
  const Split& split = *data.find("test");
  const std::vector<SurfaceFrame> truth = read_truth(data.path, split, 0.03f * edge);
  const auto key = [&](const Vec3& r) {
    const auto c = [&](float v) { return int(std::floor(v / (kCell * edge))); };
    return std::tuple{c(r.x), c(r.y), c(r.z)};
  };
  std::map<std::tuple<int, int, int>, std::pair<Vec3, Vec3>> reach;  // lowest and highest displacement of what is in a cell at rest
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
      const bool moving = length(hi - lo) > float(app::kTrulyMoves) * edge;
      const bool gone = *rb.alpha.pixel(u, v) < 0.5f * *ra.alpha.pixel(u, v) || *rb.depth.pixel(u, v) - *ra.depth.pixel(u, v) > kBehind * edge;
      ++(moving ? out.moving : out.still);
      if (moving ? gone : most > kSeen) ++(moving ? out.moving_gone : out.still_changed);
    }
  }
  return out;
}

}  // namespace

TEST_SUITE("app/edit_truth") {
  TEST_CASE("hiding what moves in truth_excavator takes away its boom and bucket and little else") {
    const char* root = std::getenv("SPLINEVOX_DATA");
    const std::string data = root ? std::string(root) + "/truth_excavator" : "";
    if (!root || !std::filesystem::exists(data + "/truth")) {
      MESSAGE("skipped: SPLINEVOX_DATA names no folder with truth_excavator");
      return;
    }
    // A run that is there already can be measured instead of one trained for a moment.
    const char* finished = std::getenv("SPLINEVOX_EDIT_RUN");
    const TempFolder temp;
    const std::string run = finished ? finished : temp.str() + "/run", hidden = temp.str() + "/hidden";
    if (!finished) REQUIRE(program({"train", data, "--out", run, "--preset", "draft", "--downscale", "2", "--effects", "motion,light", "--max-steps", "600", "--quiet"}).code == 0);
    const Ended edit = program({"edit", run, "--out", hidden, "--clusters", "auto", "--cluster", "moving", "--hide"});
    CAPTURE(edit.err);
    CAPTURE(edit.out);
    REQUIRE(edit.code == 0);
    const app::Run before = app::open_run(run), after = app::open_run(hidden);
    LoadOptions full;
    full.splits = {"test"}, full.time_map = before.record.time_map;
    const Changed c = changed(before, after, load_dataset(data, full));
    const double moving = double(c.moving_gone) / double(c.moving), still = double(c.still_changed) / double(c.still);
    MESSAGE(edit.out << "moving parts: " << 100 * moving << "% of " << c.moving << " pixels show another surface or none; the rest: picture changed at " << 100 * still << "% of " << c.still);
    CHECK(c.moving > 1000);
    CHECK(moving > (finished ? 0.9 : 0.6));
    CHECK(still < (finished ? 0.01 : 0.05));
  }
}
