// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/vdb_pack.hpp"

#include <stdexcept>

#include "splinevox/field/lattice.hpp"

namespace splinevox::vdb_pack {
namespace {

constexpr std::uint64_t kMostEntries = 1 << 20, kLeafVoxels = 512, kLeafWords = 8;

void put(const Sink& sink, const Int3& v) { sink(&v, sizeof v); }
void put(const Sink& sink, const Vec3d& v) { sink(&v, sizeof v); }
void put(const Sink& sink, const std::map<std::string, std::string>& texts) {
  vdb_pack::put(sink, std::uint64_t(texts.size()));
  for (const auto& [key, value] : texts) {
    vdb_pack::put(sink, key);
    vdb_pack::put(sink, value);
  }
}

}  // namespace

void put(const Sink& sink, std::uint64_t number) { sink(&number, sizeof number); }
void put(const Sink& sink, double number) { sink(&number, sizeof number); }
void put(const Sink& sink, const std::string& text) {
  put(sink, std::uint64_t(text.size()));
  sink(text.data(), text.size());
}

void put(const Sink& sink, const VdbMeta& meta) {
  put(sink, std::uint64_t(meta.size()));
  for (const auto& [key, value] : meta) {
    put(sink, key);
    put(sink, std::uint64_t(value.index()));
    if (const auto* text = std::get_if<std::string>(&value)) put(sink, *text);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) put(sink, std::uint64_t(*whole));
    if (const auto* real = std::get_if<double>(&value)) put(sink, *real);
  }
}

void put(const Sink& sink, const VdbInfo& info) {
  put(sink, info.version);
  put(sink, info.meta);
  put(sink, std::uint64_t(info.grids.size()));
  for (const GridInfo& g : info.grids) {
    for (const std::string* text : {&g.name, &g.type, &g.grid_class}) put(sink, *text);
    for (const std::uint64_t n :
         {g.active_voxels, g.leaves, g.memory_bytes, std::uint64_t(g.half), std::uint64_t(g.linear)})
      put(sink, n);
    for (const Vec3d& v : {g.voxel_size, g.origin}) put(sink, v);
    for (const Int3& v : {g.lo, g.hi}) put(sink, v);
    put(sink, g.meta);
  }
}

void put_head(const Sink& sink, const VdbGrid& grid, std::uint64_t leaves) {
  put(sink, grid.name);
  put(sink, std::uint64_t(grid.width));
  put(sink, grid.origin);
  put(sink, grid.spacing);
  sink(&grid.background, sizeof grid.background);
  for (const std::uint64_t n :
       {std::uint64_t(grid.grid_class), std::uint64_t(grid.vector), std::uint64_t(grid.half)})
    put(sink, n);
  put(sink, grid.meta);
  put(sink, leaves);
}

void put_leaf(const Sink& sink, Int3 at, const std::uint64_t* active, const float* values, int width) {
  put(sink, at);
  sink(active, kLeafWords * sizeof *active);
  sink(values, kLeafVoxels * std::size_t(width) * sizeof *values);
}

std::uint64_t Reader::number(std::uint64_t most) {
  std::uint64_t n = 0;
  source_(&n, sizeof n);
  if (n > most) throw std::length_error("a number out of range");
  return n;
}

double Reader::real() {
  double n = 0;
  source_(&n, sizeof n);
  return n;
}

std::string Reader::text() {
  std::string out(number(4 * std::uint64_t(limits_.max_text)), '\0');  // numbers are longer when printed
  source_(out.data(), out.size());
  return out;
}

Int3 Reader::int3() {
  Int3 v{};
  source_(&v, sizeof v);
  return v;
}
Vec3d Reader::vec3d() {
  Vec3d v{};
  source_(&v, sizeof v);
  return v;
}

VdbMeta Reader::meta() {
  VdbMeta out;
  for (std::uint64_t n = number(kMostEntries); n > 0; --n) {
    const std::string key = text();
    const std::uint64_t type = number(2);
    if (type == 0) out[key] = text();
    if (type == 1) out[key] = std::int64_t(number(~std::uint64_t(0)));
    if (type == 2) out[key] = real();
  }
  return out;
}

std::map<std::string, std::string> Reader::texts() {
  std::map<std::string, std::string> out;
  for (std::uint64_t n = number(kMostEntries); n > 0; --n) {
    const std::string key = text();
    out[key] = text();
  }
  return out;
}

VdbGrid Reader::grid() {
  VdbGrid out;
  out.name = text();
  out.width = int(number(3));
  if (out.width != 1 && out.width != 3) throw std::length_error("a grid's width");
  out.origin = vec3d();
  out.spacing = real();
  source_(&out.background, sizeof out.background);
  out.grid_class = VdbClass(number(std::uint64_t(VdbClass::fog_volume)));
  out.vector = VdbVector(number(std::uint64_t(VdbVector::contravariant_relative)));
  out.half = number(1) != 0;
  out.meta = meta();
  const std::uint64_t leaves = number((limits_.max_voxels - voxels_) / kLeafVoxels);
  voxels_ += leaves * kLeafVoxels;
  const std::size_t floats = kLeafVoxels * std::size_t(out.width);
  out.leaves.resize(leaves);
  out.active.resize(leaves * kLeafWords);
  out.values.resize(leaves * floats);
  for (std::size_t l = 0; l < leaves; ++l) {
    Int3& at = out.leaves[l];
    at = int3();
    if (((at.x | at.y | at.z) & (kBrick - 1)) != 0) throw std::length_error("a leaf's place");
    source_(out.active.data() + l * kLeafWords, kLeafWords * sizeof(std::uint64_t));
    source_(out.values.data() + l * floats, floats * sizeof(float));
  }
  return out;
}

VdbInfo Reader::info() {
  VdbInfo out;
  out.version = text();
  out.meta = texts();
  for (std::uint64_t n = number(std::uint64_t(limits_.max_grids)); n > 0; --n) {
    GridInfo g;
    for (std::string* to : {&g.name, &g.type, &g.grid_class}) *to = text();
    for (std::uint64_t* to : {&g.active_voxels, &g.leaves, &g.memory_bytes}) *to = number(~std::uint64_t(0));
    g.half = number(1) != 0;
    g.linear = number(1) != 0;
    for (Vec3d* to : {&g.voxel_size, &g.origin}) *to = vec3d();
    for (Int3* to : {&g.lo, &g.hi}) *to = int3();
    g.meta = texts();
    out.grids.push_back(std::move(g));
  }
  return out;
}

}  // namespace splinevox::vdb_pack
