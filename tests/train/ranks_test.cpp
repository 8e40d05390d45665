// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <barrier>
#include <cmath>
#include <exception>
#include <thread>

#include "backend/host/sum_ranks.hpp"
#include "backend/step.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"

using namespace splinevox;

namespace {

/// Ranks that are threads of this process: what one gives the others read between two barriers.
class ThreadRanks final : public Ranks {
 public:
  struct Room {
    explicit Room(int n) : given(std::size_t(n)), all_here(n) {}
    struct Given {
      const void* data;
      std::size_t size;
    };
    std::vector<Given> given;
    std::barrier<> all_here;
  };
  ThreadRanks(Room& room, int rank) : room_(room), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return int(room_.given.size()); }
  int local() const override { return rank_; }
  void merge(std::span<std::uint64_t> words) override {
    const std::vector<std::uint64_t> mine(words.begin(), words.end());
    meet(mine.data(), mine.size(), [&](int, const void* theirs) {
      for (std::size_t i = 0; i < words.size(); ++i) words[i] |= static_cast<const std::uint64_t*>(theirs)[i];
    });
  }
  std::vector<double> gather(std::span<const double> mine) override {
    std::vector<double> all;
    meet(mine.data(), mine.size(), [&](int, const void* p) {
      all.insert(all.end(), static_cast<const double*>(p), static_cast<const double*>(p) + mine.size());
    });
    return all;
  }
  void exchange(std::span<const float> mine, std::span<const std::size_t> ends,
                std::span<float> got) override {
    const std::size_t from = ends[std::size_t(rank_)], piece = ends[std::size_t(rank_) + 1] - from;
    meet(mine.data(), mine.size(), [&](int k, const void* p) {
      std::copy_n(static_cast<const float*>(p) + from, piece, got.data() + std::size_t(k) * piece);
    });
  }
  void collect(std::span<float> all, std::span<const std::size_t> ends) override {
    const std::vector<float> mine(all.begin(), all.end());
    meet(mine.data(), mine.size(), [&](int k, const void* p) {
      std::copy(static_cast<const float*>(p) + ends[std::size_t(k)],
                static_cast<const float*>(p) + ends[std::size_t(k) + 1], all.data() + ends[std::size_t(k)]);
    });
  }

 private:
  template <class Take>
  void meet(const void* data, std::size_t size, Take&& take) {
    room_.given[std::size_t(rank_)] = {data, size};
    room_.all_here.arrive_and_wait();
    for (int k = 0; k < count(); ++k) {
      if (room_.given[std::size_t(k)].size != size) std::terminate();  // the ranks have parted
      take(k, room_.given[std::size_t(k)].data);
    }
    room_.all_here.arrive_and_wait();
  }
  Room& room_;
  int rank_;
};

/// body(ranks) on as many threads as ranks.
template <class Body>
void together(int count, Body&& body) {
  ThreadRanks::Room room(count);
  std::vector<std::thread> threads;
  for (int k = 0; k < count; ++k)
    threads.emplace_back([&, k] {
      ThreadRanks ranks(room, k);
      body(ranks);
    });
  for (std::thread& t : threads) t.join();
}

/// @param opaque  before a wall, so that a background is learned
const Dataset& scene(bool opaque = false) {
  static const Dataset cut_out = make_synth("dancer", {.frames = 12, .size = 32});
  static const Dataset before_wall =
      make_synth("dancer", {.frames = 12, .size = 32, .look = {.opaque = true}});
  return opaque ? before_wall : cut_out;
}

Config rank_run(int steps) {
  Config c = test::small_run(steps);
  c.grid.radiance = {12, 20};
  c.grid.radiance_start = {0, .5f};
  c.sampling.rays = 256;
  c.sampling.occupancy_every = 15;
  return c;
}

struct RankRun {
  std::vector<double> loss;
  VoxelModel model;
};

enum class By { cpu, device };

/// @param by  who makes the steps: the CPU's own code, or the device's kernels on the host's threads, with
/// sums in fixed point
RankRun run_on(const Config& config, Ranks* ranks, const Dataset& data = scene(), By by = By::cpu) {
  Trainer trainer(config, *data.find("train"), data.time_map, 0, ranks,
                  by == By::device ? make_host_step(true, ranks) : make_step(Device::cpu, true, ranks));
  RankRun out;
  while (!trainer.done()) out.loss.push_back(trainer.step().loss);
  out.model = trainer.model();
  return out;
}

std::vector<RankRun> run_on_all(int count, const Config& config, const Dataset& data = scene(),
                                By by = By::cpu) {
  std::vector<RankRun> out(static_cast<std::size_t>(count));
  together(count,
           [&](ThreadRanks& ranks) { out[std::size_t(ranks.rank())] = run_on(config, &ranks, data, by); });
  return out;
}

bool same_bits(const RankRun& a, const RankRun& b) {
  return a.loss == b.loss && a.model.radiance.raw.values == b.model.radiance.raw.values &&
         a.model.motion.levels.size() == b.model.motion.levels.size() &&
         a.model.motion.levels[0].values == b.model.motion.levels[0].values;
}

}  // namespace

TEST_SUITE("train/ranks") {
  TEST_CASE("gradients add up in the order of the ranks, and only rows that somebody touched are sent") {
    const TopologyPtr topology = make_dense_topology(make_lattice({{0, 0, 0}, {1, 1, 1}}, 15));
    const std::vector<float> zero(8, 0.0f);
    for (const int count : {2, 3}) {
      std::vector<Gradient> gradients(std::size_t(count), Gradient(make_channels(topology, 8, zero.data())));
      // Quotients and sums: a product may be fused with a sum in one place and not in another.
      const auto value = [](int rank, int brick, int row, int c) {
        return float(1 + rank) / 1000 + float(brick * row) + float(c) / 3;
      };
      const auto touches = [](int rank, int brick, int row) {
        return brick > 0 && brick != 3 && (row + rank) % 3 == 0;
      };
      for (int k = 0; k < count; ++k)
        for (int b = 0; b <= topology->brick_count(); ++b)
          for (int i = 0; i < kBrickRows; ++i) {
            if (!touches(k, b, i)) continue;
            gradients[std::size_t(k)].touched[std::size_t(b)].set(i);
            for (int c = 0; c < 8; ++c)
              gradients[std::size_t(k)].values.row(std::size_t(b) * kBrickRows + std::size_t(i))[c] =
                  value(k, b, i, c);
          }
      std::vector<char> good(std::size_t(count), 0);
      together(count, [&](ThreadRanks& ranks) {
        good[std::size_t(ranks.rank())] = sum_over_ranks(ranks, gradients[std::size_t(ranks.rank())]);
      });
      CHECK(std::count(good.begin(), good.end(), 1) == count);
      std::int64_t wrong = 0;
      for (int k = 0; k < count; ++k)
        for (int b = 0; b <= topology->brick_count(); ++b)
          for (int i = 0; i < kBrickRows; ++i)
            for (int c = 0; c < 8; ++c) {
              float sum = 0;
              bool any = false;
              for (int r = 0; r < count; ++r)
                if (touches(r, b, i)) {
                  sum += value(r, b, i, c);
                  any = true;
                }
              const Gradient& g = gradients[std::size_t(k)];
              wrong += g.values.row(std::size_t(b) * kBrickRows + std::size_t(i))[c] != sum ||
                       g.touched[std::size_t(b)].test(i) != any;
            }
      CHECK(wrong == 0);
    }
  }

  TEST_CASE("a sum beyond what may be used is seen by every rank") {
    const TopologyPtr topology = make_dense_topology(make_lattice({{0, 0, 0}, {1, 1, 1}}, 8));
    const std::vector<float> zero(8, 0.0f);
    std::vector<Gradient> gradients(2, Gradient(make_channels(topology, 8, zero.data())));
    for (Gradient& g : gradients) {
      g.touched[1].set(5);
      g.values.row(kBrickRows + 5)[2] = 0.6f * kLargestGradient;
    }
    std::vector<char> good(2, 1);
    together(2, [&](ThreadRanks& ranks) {
      good[std::size_t(ranks.rank())] = sum_over_ranks(ranks, gradients[std::size_t(ranks.rank())]);
    });
    CHECK(good == std::vector<char>{0, 0});
  }

  TEST_CASE("ranks never part, and as many ranks give the same bits again") {
    const Config config = rank_run(40);
    const std::vector<RankRun> two = run_on_all(2, config), again = run_on_all(2, config);
    CHECK(same_bits(two[0], two[1]));
    CHECK(same_bits(two[0], again[0]));
    const std::vector<RankRun> three = run_on_all(3, config);
    CHECK(same_bits(three[0], three[1]));
    CHECK(same_bits(three[0], three[2]));
  }

  TEST_CASE("a background is learned from the rays of all ranks") {
    const Config config = rank_run(20);
    const std::vector<RankRun> two = run_on_all(2, config, scene(true));
    const Background one = run_on(config, nullptr, scene(true)).model.background,
                     &both = two[0].model.background;
    REQUIRE(one.learned());
    CHECK(both == two[1].model.background);
    for (int j = 0; j < one.count(); ++j)
      CHECK(both.raw[j].y == doctest::Approx(one.raw[j].y).epsilon(0.05).scale(0.1));
  }

  TEST_CASE("how the rays are split changes only rounding") {
    const Config config = rank_run(40);
    const RankRun one = run_on(config, nullptr);
    const std::vector<RankRun> two = run_on_all(2, config);
    // The first step's loss is a sum of doubles over the same rays; from then on parameters differ as
    // roundings of their gradients do.
    CHECK(two[0].loss[0] == doctest::Approx(one.loss[0]).epsilon(1e-12));
    for (std::size_t i = 1; i < 10; ++i) CHECK(two[0].loss[i] == doctest::Approx(one.loss[i]).epsilon(1e-2));
    CHECK(two[0].loss.back() == doctest::Approx(one.loss.back()).epsilon(0.2));
    CHECK(two[0].model.radiance.raw.topology->brick_count() ==
          one.model.radiance.raw.topology->brick_count());
  }

  TEST_CASE(
      "devices add up their gradients: no rank parts, as many give the same bits again, and against one only "
      "rounding differs") {
    const Config config = rank_run(16);
    const RankRun one = run_on(config, nullptr, scene(), By::device);
    const std::vector<RankRun> two = run_on_all(2, config, scene(), By::device),
                               again = run_on_all(2, config, scene(), By::device);
    CHECK(same_bits(two[0], two[1]));
    CHECK(same_bits(two[0], again[0]));
    CHECK(two[0].loss[0] == doctest::Approx(one.loss[0]).epsilon(1e-7));  // in units of 2^-32
    for (std::size_t i = 1; i < 10; ++i) CHECK(two[0].loss[i] == doctest::Approx(one.loss[i]).epsilon(1e-2));
    CHECK(two[0].loss.back() == doctest::Approx(one.loss.back()).epsilon(0.2));
    // Shares of unequal size.
    const std::vector<RankRun> three = run_on_all(3, rank_run(6), scene(), By::device);
    CHECK(same_bits(three[0], three[1]));
    CHECK(same_bits(three[0], three[2]));
    CHECK(three[0].loss[0] == doctest::Approx(one.loss[0]).epsilon(1e-7));
  }

  TEST_CASE("a background is learned from the rays of all devices") {
    const Config config = rank_run(10);
    const std::vector<RankRun> two = run_on_all(2, config, scene(true), By::device);
    const Background one = run_on(config, nullptr, scene(true), By::device).model.background,
                     &both = two[0].model.background;
    REQUIRE(one.learned());
    CHECK(both == two[1].model.background);
    for (int j = 0; j < one.count(); ++j)
      CHECK(both.raw[j].y == doctest::Approx(one.raw[j].y).epsilon(0.05).scale(0.1));
  }
}
