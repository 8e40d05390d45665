// SPDX-License-Identifier: Apache-2.0
// The random-gather limit of the machine and what finding the rows costs.
//
//   bench_gather [cells]     cells along the longest edge of the lattice, default 128
//
// A trilinear radiance sample reads four pairs of neighbouring rows, 32 bytes a row. "limit": nothing but
// reading such pairs at random bricks of a shell-like field of this size, prefetched: no renderer can fetch
// its samples faster from random places. The other lines add the voxel-to-row map: the brick table the
// renderer uses, an OpenVDB Int32 grid of row numbers, and an OpenVDB mask grid with leaf offsets. One
// thread, median of five.
#include <fmt/core.h>
#include <openvdb/tree/Tree.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/rng.hpp"
#include "core/simd.hpp"
#include "core/stopwatch.hpp"
#include "field/lattice/brick_view.hpp"
#include "splinevox/field/lattice.hpp"

using namespace splinevox;

namespace {

using Eight = Simd<float>::Eight;
constexpr int kSamples = 1 << 20, kAhead = 16;

/// Median time of a run and what it summed, which only keeps the compiler from leaving the run out.
struct Timed {
  double seconds;
  float checksum;
};

Timed median_of_five(const std::function<float()>& run) {
  float checksum = 0;
  std::vector<double> seconds;
  for (int i = 0; i < 6; ++i) {
    const Timer timer;
    checksum = run();
    if (i > 0) seconds.push_back(timer.seconds());
  }
  std::sort(seconds.begin(), seconds.end());
  return {seconds[seconds.size() / 2], checksum};
}

void report(const char* what, const Timed& timed, int bricks) {
  const nlohmann::json line{{"bench", "gather"},
                            {"rows_by", what},
                            {"bricks", bricks},
                            {"megabytes", bricks * 512 * 32 / 1e6},
                            {"samples_per_second", kSamples / timed.seconds},
                            {"checksum", timed.checksum}};
  fmt::print("{}\n", line.dump());
}

}  // namespace

int main(int argc, char** argv) {
  const int cells = argc > 1 ? std::atoi(argv[1]) : 128;
  const Lattice lattice = make_lattice({{-1, -1, -1}, {1, 1, 1}}, cells);
  // Bricks that a spherical shell passes through: about as many as a reconstructed object has.
  std::vector<Int3> shell;
  const int n = (lattice.size.x + 7) / 8;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const float r = length(lattice.position({x * 8 + 4, y * 8 + 4, z * 8 + 4}));
        if (std::abs(r - 0.8f) < 8 * lattice.spacing) shell.push_back({x, y, z});
      }
  const TopologyPtr topology = make_topology(lattice, shell);
  const int bricks = topology->brick_count();
  const std::vector<float> row(8, 1.0f);
  const Channels values = make_channels(topology, 8, row.data());
  const BrickView<float> view(*topology);

  // Random vertices of stored bricks, in ring coordinates; interior ones, so that all maps do the same reads.
  std::vector<Int3> at(kSamples);
  const Rng rng(1, 1);
  for (int i = 0; i < kSamples; ++i) {
    const Int3 b = topology->bricks[1 + rng.below(4 * i, bricks)];
    at[i] = {8 * b.x + int(rng.below(4 * i + 1, 7)), 8 * b.y + int(rng.below(4 * i + 2, 7)),
             8 * b.z + int(rng.below(4 * i + 3, 7))};
  }
  const auto gather = [&](auto&& base_row) {
    std::vector<std::int32_t> base(kSamples + kAhead, kBrickRows);
    Eight sum{};
    for (int i = -kAhead; i < kSamples; ++i) {
      if (i + kAhead < kSamples) {
        base[i + kAhead] = base_row(i + kAhead);
        for (const int c : {0, 8, 64, 72}) __builtin_prefetch(values.row(base[i + kAhead] + c));
      }
      if (i < 0) continue;
      for (const int c : {0, 1, 8, 9, 64, 65, 72, 73}) sum += load<Eight>(values.row(base[i] + c));
    }
    return sum8(sum);
  };

  std::vector<std::int32_t> known(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const Cell cell = view.cell(at[i].x + 8, at[i].y + 8, at[i].z + 8);
    known[i] = view.table[cell.slot] * kBrickRows + cell.local;
  }
  report("limit", median_of_five([&] { return gather([&](int i) { return known[i]; }); }), bricks);
  report("brick table", median_of_five([&] {
           return gather(
               [&](int i) { return view.rows(view.cell(at[i].x + 8, at[i].y + 8, at[i].z + 8)).row[0]; });
         }),
         bricks);

  openvdb::tree::Tree4<std::int32_t, 5, 4, 3>::Type rows(0);
  openvdb::tree::Tree4<openvdb::ValueMask, 5, 4, 3>::Type mask(false);
  openvdb::tree::ValueAccessor row_writer(rows);
  for (int b = 1; b <= bricks; ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const openvdb::Coord v(topology->bricks[b].x * 8 + (i >> 6), topology->bricks[b].y * 8 + (i >> 3 & 7),
                             topology->bricks[b].z * 8 + (i & 7));
      row_writer.setValue(v, b * kBrickRows + i);
      mask.setValueOn(v);
    }
  report("Int32 grid", median_of_five([&] {
           const openvdb::tree::ValueAccessor reader(std::as_const(rows));
           return gather([&](int i) { return reader.getValue(openvdb::Coord(at[i].x, at[i].y, at[i].z)); });
         }),
         bricks);
  std::unordered_map<const void*, std::int32_t> offset;
  for (auto leaf = mask.cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord o = leaf->origin();
    offset[leaf.getLeaf()] = topology->brick_at({o.x() / 8, o.y() / 8, o.z() / 8}) * kBrickRows;
  }
  report("mask grid", median_of_five([&] {
           const openvdb::tree::ValueAccessor reader(std::as_const(mask));
           return gather([&](int i) {
             const openvdb::Coord v(at[i].x, at[i].y, at[i].z);
             const auto* leaf = reader.probeConstLeaf(v);
             return offset.find(leaf)->second + std::int32_t(leaf->coordToOffset(v));
           });
         }),
         bricks);
}
