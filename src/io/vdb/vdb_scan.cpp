// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/vdb_scan.hpp"

#include <map>
#include <vector>

#include "core/hash.hpp"
#include "io/vdb/vdb_cursor.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr std::string_view kSealMagic = "SPVXSEAL";
constexpr std::int64_t kVdbMagic = 0x56444220;
constexpr std::uint32_t kOldestVersion = 222, kNewestVersion = 224;  // the layouts that this scan knows

/// A grid without a tree of its own: it has that of another. Names are as the file has them.
struct Instance {
  std::string_view name, of;
};

/// Trees by the names of their grids: voxels, and bytes in memory.
using Trees = std::map<std::string_view, VdbCost>;

/// A grid that shares a tree is handed over as one of its own, so a few bytes stand for all its voxels.
void add_instances(const Cursor& cursor, const std::vector<Instance>& instances, Trees& trees,
                   VdbCost& cost) {
  for (const Instance& instance : instances) {
    const VdbCost shared = trees[instance.of];
    cost.tile_voxels += shared.tile_voxels;
    trees[instance.name].tile_voxels += shared.tile_voxels;
    add_cost(cursor, cost, shared.voxels, shared.bytes);
    add_cost(cursor, trees[instance.name], shared.voxels, shared.bytes);
  }
}

void scan_grids(Cursor& cursor, std::uint64_t size, bool offsets, VdbCost& cost) {
  Trees trees;
  std::vector<Instance> instances;
  const auto grids = cursor.take<std::int32_t>("the number of grids");
  const int most = cursor.limits().max_grids;
  if (grids < 0 || grids > most)
    cursor.bad("the number of grids is out of range", "0 to " + std::to_string(most), std::to_string(grids));
  for (int g = 0; g < grids; ++g) {
    const std::string_view name = cursor.text("a grid's name"), type = cursor.text("a grid's type"),
                           parent = cursor.text("a grid's instance parent");
    const VdbCost before = cost;
    const auto start = cursor.take<std::int64_t>("a grid's offset");
    cursor.skip(8, "a grid's offset");
    const auto end = cursor.take<std::int64_t>("a grid's offset");
    if (offsets && (start != std::int64_t(cursor.at()) || end < start || std::uint64_t(end) > size))
      cursor.bad("a grid's offsets are out of order",
                 "begin " + std::to_string(cursor.at()) + ", end within " + std::to_string(size),
                 std::to_string(start) + " and " + std::to_string(end));
    if (!walk_grid(cursor, type, parent.empty(), cost)) {
      cost.known = false;
      if (!offsets) return;  // where the next one begins is known only to who can parse this one
      cursor.move_to(std::uint64_t(end));
    }
    if (offsets && cursor.at() != std::uint64_t(end))
      cursor.bad("a grid does not end where the file says", std::to_string(end), std::to_string(cursor.at()));
    trees[name].tile_voxels += cost.tile_voxels - before.tile_voxels;
    add_cost(cursor, trees[name], cost.voxels - before.voxels, cost.bytes - before.bytes);
    if (!parent.empty()) instances.push_back({name, parent});
  }
  add_instances(cursor, instances, trees, cost);
  if (cursor.at() != size)
    cursor.bad("there are bytes after the last grid", "a file of " + std::to_string(cursor.at()) + " bytes",
               std::to_string(size));
}

}  // namespace

std::string vdb_seal(std::uint64_t bytes_before, std::uint64_t hash_before) {
  std::string seal(kSealMagic);
  seal.append(reinterpret_cast<const char*>(&bytes_before), 8);
  seal.append(reinterpret_cast<const char*>(&hash_before), 8);
  return seal;
}

VdbScan scan_vdb(const std::string& path, std::string_view bytes, const VdbLimits& limits) {
  VdbScan scan{bytes, false, {}};
  if (bytes.size() > kVdbSealBytes &&
      bytes.substr(bytes.size() - kVdbSealBytes, kSealMagic.size()) == kSealMagic) {
    scan.payload = bytes.substr(0, bytes.size() - kVdbSealBytes);
    scan.sealed = true;
    if (bytes.substr(scan.payload.size()) != vdb_seal(scan.payload.size(), hash64(scan.payload)))
      fail({.where = path,
            .what = "the checksum does not fit the content",
            .got = "damaged bytes",
            .hint = "copy or export the file again"});
  }
  Cursor cursor(path, scan.payload, limits);
  if (cursor.take<std::int64_t>("the header") != kVdbMagic)
    fail({.where = path,
          .what = "is not a VDB file",
          .expected = "the magic number of OpenVDB at the beginning"});
  const auto version = cursor.take<std::uint32_t>("the header");
  if (version < kOldestVersion || version > kNewestVersion)
    fail({.where = path,
          .what = "this version of the VDB format is not supported",
          .expected = std::to_string(kOldestVersion) + " to " + std::to_string(kNewestVersion),
          .got = std::to_string(version),
          .hint = "save the file again with a current VDB program"});
  cursor.skip(8, "the header");
  const auto offsets = cursor.take<char>("the header");
  cursor.skip(kVdbIdBytes, "the header");
  walk_metadata(cursor);
  scan_grids(cursor, scan.payload.size(), offsets != 0, scan.cost);
  return scan;
}

}  // namespace splinevox
