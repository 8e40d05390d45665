// SPDX-License-Identifier: Apache-2.0
#include "train/home.hpp"

#include <doctest/doctest.h>

#include "core/atomic_file.hpp"
#include "field/lattice/slice.hpp"
#include "splinevox/data/synth.hpp"
#include "train/plan.hpp"

using namespace splinevox;

namespace {

/// Keeps the first radiance value to itself, adds 1 to it with every step, and counts what is asked of it.
class Adder final : public StepBackend {
 public:
  struct Calls {
    int uploads = 0, downloads = 0;
  };
  explicit Adder(Calls& calls) : calls_(calls) {}
  void upload(const StepModel& model) override {
    ++calls_.uploads;
    values_ = model.radiance.values;
    own_ = values_->values[0];
  }
  void download() override {
    ++calls_.downloads;
    values_->values[0] = own_;
  }
  StepSums run(const StepInput&) override {
    own_ += 1;
    return {};
  }
  std::vector<int> bad_rays() override { return {}; }

 private:
  Calls& calls_;
  Channels* values_ = nullptr;
  float own_ = 0;
};

struct Scene {
  Dataset data = make_synth("ball", {.frames = 8, .size = 24, .seed = 3});
  Setting setting{preset("draft"), *data.find("train")};
  Adder::Calls calls;
  Home home;

  Scene() : home(volume(), std::make_unique<Adder>(calls)) {
    home.change().lattices.model.radiance.raw.values[0] = 0;
  }

  Volume volume() {
    const SceneBounds bounds = starting_bounds(setting.config, setting.train, setting.stats);
    Volume out{Lattices(setting, {}, bounds.box), {bounds.hull, {}, {}}, {}, {}};
    const std::vector<int> frames{0};
    Plan().carry_out(setting, 0.3, false, {frames, true}, out);
    return out;
  }
  float value() const { return home.read().lattices.model.radiance.raw.values[0]; }
};

}  // namespace

TEST_SUITE("train/home") {
  TEST_CASE("what steps have made is read, and what was changed since is what the next step has") {
    Scene s;
    s.home.step({});
    CHECK(s.value() == 1);
    s.home.step({});
    s.home.step({});
    CHECK(s.value() == 3);
    s.home.change().lattices.model.radiance.raw.values[0] = 10;
    CHECK(s.value() == 10);
    s.home.step({});
    CHECK(s.value() == 11);
    CHECK(s.home.take().radiance.raw.values[0] == 11);
  }

  TEST_CASE("nothing is sent to and fro without need") {
    Scene s;
    CHECK(s.value() == 0);
    CHECK(s.calls.downloads == 0);
    for (int i = 0; i < 5; ++i) s.home.step({});
    CHECK(s.calls.uploads == 1);
    CHECK(s.calls.downloads == 0);
    CHECK(s.value() == 5);
    CHECK(s.value() == 5);
    Archive saved;
    s.home.archive(saved, s.setting);
    CHECK(total_size(saved.pieces()) > 0);
    s.home.step({});
    CHECK(s.calls.downloads == 1);
    CHECK(s.calls.uploads == 1);
  }

  TEST_CASE("the sum of the levels is that of the parameters as the steps have left them") {
    Scene s;
    std::vector<Channels>& levels = s.home.change().lattices.levels;
    REQUIRE(levels.size() > 1);
    for (Channels& level : levels)
      for (std::size_t i = std::size_t(kBrickRows) * level.width; i < level.values.size(); ++i)
        level.values[i] = float(i % 7);
    s.home.step({});
    const Lattices& l = s.home.read().lattices;
    REQUIRE(l.model.motion.levels.size() == 1);
    MotionField apart = l.model.motion;
    apart.levels = l.levels;
    CHECK(l.model.motion.levels[0].values == collapse(apart).levels[0].values);
  }
}
