// SPDX-License-Identifier: Apache-2.0
#include "io/splat/splat_volume.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/process.hpp"
#include "io/model/exact_text.hpp"
#include "io/splat/splat_gaussian.hpp"
#include "math/activation.hpp"
#include "math/quantile.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr std::size_t kChunk = 4096;                         ///< splats a task
constexpr double kMostVisits = double(1u << 31);             ///< of bricks by splats
constexpr double kBytesALeaf = 6 * 4 * 512 * sizeof(float);  ///< values, grids, OpenVDB's and the file's
constexpr double kMemoryShare = 0.5;
constexpr int kMostAcross = 512;  ///< voxels
constexpr std::int32_t kNowhere = INT32_MAX;

/// The layers of bricks, along x, that a splat reaches. first = kNowhere: none.
struct Layers {
  std::int32_t first = kNowhere, last = 0;
};

/// The voxels of a box.
struct Bounds {
  Int3 lo{-1'000'000'000, -1'000'000'000, -1'000'000'000}, hi{1'000'000'000, 1'000'000'000, 1'000'000'000};
};

/// A brick with matter.
struct Brick {
  Int3 at;  ///< in bricks
  LeafMask mask{};
  std::vector<float> depth, color;  ///< [512], [512 * 3]
};

class Scatter {
 public:
  Scatter(const SplatFile& file, double spacing, double min_alpha, const std::optional<SplatBox>& box)
      : file_(file), spacing_(spacing), least_(optical_depth(min_alpha)), layers_(file.size()) {
    for (int a = 0; box && a < 3; ++a) {
      bounds_.lo[a] = int(std::clamp(std::ceil(box->lo[a] / spacing), -1e9, 1e9));
      bounds_.hi[a] = int(std::clamp(std::floor(box->hi[a] / spacing), -1e9, 1e9));
    }
  }

  std::vector<Brick> run() {
    find_layers();
    std::vector<std::uint32_t> order;
    for (std::size_t i = 0; i < layers_.size(); ++i)
      if (layers_[i].first != kNowhere) order.push_back(std::uint32_t(i));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return layers_[a].first < layers_[b].first; });
    std::vector<Brick> bricks;
    std::vector<std::uint32_t> here;
    std::size_t next = 0;
    for (std::int32_t layer = 0; next < order.size() || !here.empty(); ++layer) {
      if (here.empty()) layer = layers_[order[next]].first;
      while (next < order.size() && layers_[order[next]].first <= layer) here.push_back(order[next++]);
      std::sort(here.begin(), here.end());
      add_layer(layer, here, bricks);
      std::erase_if(here, [&](std::uint32_t i) { return layers_[i].last <= layer; });
      check_room(bricks.size());
    }
    return bricks;
  }

  /// Refuses bricks so far apart that a table of the box around them would not find room: there are four.
  void check_span(Int3 lo, Int3 hi) const {
    const double slots = (double(hi.x) - lo.x + 3) * (double(hi.y) - lo.y + 3) * (double(hi.z) - lo.z + 3);
    const double room = free_memory();
    if (slots > kMostVisits || (room > 0 && 4 * sizeof(std::int32_t) * slots > kMemoryShare * room))
      refuse("bricks of 8^3 voxels in the box around all splats that fit into memory", slots);
  }

  double skipped() const { return double(skipped_); }

 private:
  bool gaussian(std::size_t i, LatticeGaussian& out) const {
    Splat splat;
    if (!file_.read(i, splat)) return false;
    out = on_lattice(splat, mean_color(splat), spacing_);
    for (int a = 0; a < 3; ++a) {
      out.lo[a] = std::max(out.lo[a], bounds_.lo[a]);
      out.hi[a] = std::min(out.hi[a], bounds_.hi[a]);
    }
    return true;
  }

  void find_layers() {
    const std::size_t tasks = (file_.size() + kChunk - 1) / kChunk;
    std::vector<double> visits(tasks, 0);
    std::vector<std::size_t> skipped(tasks, 0);
    parallel_for(int(tasks), [&](int task) {
      const auto t = std::size_t(task);
      for (std::size_t i = t * kChunk; i < std::min(file_.size(), (t + 1) * kChunk); ++i) {
        LatticeGaussian g;
        if (!gaussian(i, g)) {
          ++skipped[t];
          continue;
        }
        double bricks = 1;
        for (int a = 0; a < 3; ++a) bricks *= std::max(0, (g.hi[a] >> 3) - (g.lo[a] >> 3) + 1);
        if (g.lo.x > g.hi.x || g.lo.y > g.hi.y || g.lo.z > g.hi.z || !(g.mass > 0)) continue;
        layers_[i] = {g.lo.x >> 3, g.hi.x >> 3};
        visits[t] += bricks;
      }
    });
    double all = 0;
    for (std::size_t t = 0; t < tasks; ++t) {
      all += visits[t];
      skipped_ += skipped[t];
    }
    if (all > kMostVisits) refuse("2^31 bricks of 8^3 voxels that splats reach", all);
  }

  void check_room(std::size_t bricks) const {
    const double room = free_memory();
    if (room > 0 && double(bricks) * kBytesALeaf > kMemoryShare * (room + kept(bricks)))
      refuse("bricks of 8^3 voxels that fit into memory", double(bricks));
  }
  static double kept(std::size_t bricks) { return double(bricks) * sizeof(float) * 4 * 512; }

  [[noreturn]] void refuse(const std::string& expected, double got) const {
    fail({.where = "--voxel-size",
          .what = "is too small for where the splats are",
          .expected = "at most " + expected,
          .got = exact_text<double>({got}) + " at " + exact_text<double>({spacing_}),
          .hint = "a larger --voxel-size, or --box around what is wanted: captures often have a sky of large "
                  "splats far away"});
  }

  void add_layer(std::int32_t layer, const std::vector<std::uint32_t>& splats,
                 std::vector<Brick>& out) const {
    std::vector<LatticeGaussian> gaussians(splats.size());
    parallel_for(int((splats.size() + kChunk - 1) / kChunk), [&](int task) {
      const std::size_t begin = std::size_t(task) * kChunk;
      for (std::size_t i = begin; i < std::min(splats.size(), begin + kChunk); ++i)
        gaussian(splats[i], gaussians[i]);
    });
    struct Visit {
      std::int32_t y, z;
      std::uint32_t splat;
    };
    std::vector<Visit> visits;
    for (std::size_t i = 0; i < splats.size(); ++i)
      for (std::int32_t y = gaussians[i].lo.y >> 3; y <= gaussians[i].hi.y >> 3; ++y)
        for (std::int32_t z = gaussians[i].lo.z >> 3; z <= gaussians[i].hi.z >> 3; ++z)
          visits.push_back({y, z, std::uint32_t(i)});
    std::sort(visits.begin(), visits.end(), [](const Visit& a, const Visit& b) {
      return a.y != b.y ? a.y < b.y : a.z != b.z ? a.z < b.z : a.splat < b.splat;
    });
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < visits.size(); ++i)
      if (i == 0 || visits[i].y != visits[i - 1].y || visits[i].z != visits[i - 1].z) starts.push_back(i);
    starts.push_back(visits.size());
    std::vector<Brick> found(starts.size() - 1);
    parallel_for(int(found.size()), [&](int b) {
      const auto k = std::size_t(b);
      const Int3 at{layer, visits[starts[k]].y, visits[starts[k]].z};
      BrickSums sums;
      for (std::size_t i = starts[k]; i < starts[k + 1]; ++i)
        add_to_brick(gaussians[visits[i].splat], kBrick * at, sums);
      found[k] = brick_of(at, sums);
    });
    for (Brick& brick : found)
      if (brick.mask != LeafMask{}) out.push_back(std::move(brick));
  }

  Brick brick_of(Int3 at, const BrickSums& sums) const {
    Brick brick{at, {}, {}, {}};
    for (std::size_t v = 0; v < kBrickRows; ++v)
      if (sums.depth[v] >= least_) brick.mask[v >> 6] |= std::uint64_t(1) << (v & 63);
    if (brick.mask == LeafMask{}) return brick;
    brick.depth.resize(kBrickRows);
    brick.color.resize(3 * kBrickRows);
    for (std::size_t v = 0; v < kBrickRows; ++v) {
      if (!(brick.mask[v >> 6] >> (v & 63) & 1)) continue;
      brick.depth[v] = float(sums.depth[v] / spacing_);
      for (std::size_t c = 0; c < 3; ++c) brick.color[3 * v + c] = float(sums.color[v][c] / sums.depth[v]);
    }
    return brick;
  }

  const SplatFile& file_;
  double spacing_, least_;
  Bounds bounds_;
  std::vector<Layers> layers_;
  std::size_t skipped_ = 0;
};

}  // namespace

SplatVolume splat_volume(const SplatFile& file, double spacing, double min_alpha,
                         const std::optional<SplatBox>& box) {
  Scatter scatter(file, spacing, min_alpha, box);
  const std::vector<Brick> bricks = scatter.run();
  Int3 lo{}, hi{-1, -1, -1};
  for (const Brick& brick : bricks)
    for (int a = 0; a < 3; ++a) {
      lo[a] = &brick == bricks.data() ? brick.at[a] : std::min(lo[a], brick.at[a]);
      hi[a] = &brick == bricks.data() ? brick.at[a] : std::max(hi[a], brick.at[a]);
    }
  scatter.check_span(lo, hi);
  LeafSet set(lo, hi - lo + Int3{1, 1, 1});
  for (const Brick& brick : bricks) set.add(brick.at, brick.mask);
  SplatVolume out{LeafValues(set, 1), LeafValues(set.grown(1), 3), {}};
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    std::copy_n(bricks[b].depth.data(), kBrickRows, out.density.at(b, 0));
    const std::int32_t leaf = out.color.set().find(bricks[b].at);
    std::copy_n(bricks[b].color.data(), 3 * kBrickRows, out.color.at(std::size_t(leaf), 0));
  }
  const LeafSet& grown = out.color.set();
  for_each_voxel(
      grown.leaves(), [&](std::size_t l) -> const LeafMask& { return grown.masks()[l]; },
      [&](std::size_t l, int i, Int3 v) {
        if (set.active(v)) return;
        const Vec3 mean = neighbour_mean(out.color, set, v);
        for (int a = 0; a < 3; ++a) out.color.at(l, i)[a] = mean[a];
      });
  out.figures["splats"] = double(file.size());
  if (scatter.skipped() > 0) out.figures["splats_skipped"] = scatter.skipped();
  return out;
}

double splat_spacing(const SplatFile& file) {
  constexpr std::size_t kSample = 100'000;
  std::vector<double> sizes, places[3];
  const std::size_t step = file.size() / kSample + 1;
  for (std::size_t i = 0; i < file.size(); i += step) {
    Splat splat;
    if (!file.read(i, splat)) continue;
    const Vec3d& size = splat.size;
    sizes.push_back(std::max(std::min(size.x, size.y), std::min(std::max(size.x, size.y), size.z)));
    for (int a = 0; a < 3; ++a) places[a].push_back(splat.place[a]);
  }
  if (sizes.empty()) return 0;
  double across = 0;
  for (auto& v : places) across = std::max(across, quantile(v, 0.99) - quantile(v, 0.01));
  return std::max(quantile(sizes, 0.5), across / kMostAcross);
}

}  // namespace splinevox
