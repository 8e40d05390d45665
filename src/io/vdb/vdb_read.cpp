// SPDX-License-Identifier: Apache-2.0
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstring>
#include <istream>
#include <new>
#include <stdexcept>
#include <streambuf>

#include "core/atomic_file.hpp"
#include "io/vdb/child.hpp"
#include "io/vdb/openvdb_grid.hpp"
#include "io/vdb/vdb_scan.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

namespace splinevox {
namespace {

/// Bytes in memory as a stream that can seek.
class MemoryBuffer : public std::streambuf {
 public:
  explicit MemoryBuffer(std::string_view bytes) {
    char* p = const_cast<char*>(bytes.data());  // only read: no put area
    setg(p, p, p + bytes.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir dir, std::ios_base::openmode) override {
    const char* base = dir == std::ios_base::beg ? eback() : dir == std::ios_base::cur ? gptr() : egptr();
    if (offset < eback() - base || offset > egptr() - base) return pos_type(off_type(-1));
    setg(eback(), const_cast<char*>(base) + offset, egptr());
    return gptr() - eback();
  }
  pos_type seekpos(pos_type at, std::ios_base::openmode mode) override {
    return seekoff(at, std::ios_base::beg, mode);
  }
};

struct Parsed {
  openvdb::GridPtrVecPtr grids;
  openvdb::MetaMap::Ptr meta;
  std::string version;
  bool sealed = false;
  std::uint64_t bytes = 0;
};

/// OpenVDB's messages may quote the file's own bytes: printable, and no longer than a line or two.
std::string clean(const char* message) {
  std::string text(message, strnlen(message, 300));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

[[noreturn]] void fail_damaged(const std::string& path, const std::string& got) {
  fail({.where = path,
        .what = "is damaged or not complete: OpenVDB cannot read it",
        .got = got,
        .hint = "copy or export the file again"});
}

Parsed parse_payload(const std::string& path, const VdbScan& scan) {
  MemoryBuffer buffer(scan.payload);
  std::istream in(&buffer);
  in.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  Parsed out;
  out.sealed = scan.sealed;
  try {
    openvdb::io::Stream stream(in, /*delayLoad=*/false);
    out.grids = stream.getGrids();
    out.meta = stream.getMetadata();
    out.version = stream.version();
    if (std::uint64_t(in.tellg()) != scan.payload.size()) fail_damaged(path, "bytes after the last grid");
  } catch (const std::ios_base::failure&) {
    fail_damaged(path, "the data ends too early");
  } catch (const std::bad_alloc&) {
    fail_damaged(path, "sizes beyond this machine's memory");
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {  // openvdb::Exception and what its parsers let through
    fail_damaged(path, clean(e.what()));
  }
  if (!out.grids) out.grids = std::make_shared<openvdb::GridPtrVec>();
  if (!out.meta) out.meta = std::make_shared<openvdb::MetaMap>();
  return out;
}

Parsed parse(const std::string& path, const VdbLimits& limits) {
  openvdb::initialize();
  const std::string bytes = read_file(path, limits.max_bytes, Named::by_user);
  const VdbScan scan = scan_vdb(path, bytes, limits);
  if (!scan.sealed) {
    // Nobody vouches for these bytes, and OpenVDB 10 can crash, hang or ask for any amount of memory on
    // damaged ones (docs/reliability.md): a child process goes first.
    const std::string trouble = run_in_child(
        [&] {
          try {
            parse_payload(path, scan);
          } catch (const Error& e) {
            throw std::runtime_error(e.problem.got);
          }
        },
        unsigned(20 + bytes.size() / 10'000'000), 40 * bytes.size() + (std::uint64_t(1) << 30));
    if (!trouble.empty()) fail_damaged(path, trouble);
  }
  Parsed out = parse_payload(path, scan);
  out.bytes = bytes.size();
  return out;
}

VdbMeta to_meta(const openvdb::MetaMap& map) {
  VdbMeta meta;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
    const openvdb::Metadata& m = *it->second;
    if (m.typeName() == openvdb::Int64Metadata::staticTypeName())
      meta[it->first] = static_cast<const openvdb::Int64Metadata&>(m).value();
    else if (m.typeName() == openvdb::Int32Metadata::staticTypeName())
      meta[it->first] = std::int64_t(static_cast<const openvdb::Int32Metadata&>(m).value());
    else if (m.typeName() == openvdb::DoubleMetadata::staticTypeName())
      meta[it->first] = static_cast<const openvdb::DoubleMetadata&>(m).value();
    else if (m.typeName() == openvdb::FloatMetadata::staticTypeName())
      meta[it->first] = double(static_cast<const openvdb::FloatMetadata&>(m).value());
    else
      meta[it->first] = m.str();
  }
  return meta;
}

std::map<std::string, std::string> to_text(const openvdb::MetaMap& map) {
  std::map<std::string, std::string> text;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) text[it->first] = it->second->str();
  return text;
}

Vec3d to_vec(const openvdb::Vec3d& v) { return {v.x(), v.y(), v.z()}; }

template <class Grid>
void copy_leaves(Grid& grid, VdbGrid& out) {
  grid.tree().voxelizeActiveTiles(/*threaded=*/false);
  constexpr std::size_t kFloats = 512 * sizeof(typename Grid::ValueType) / sizeof(float);
  const std::size_t leaves = grid.tree().leafCount();
  out.leaves.reserve(leaves);
  out.active.reserve(leaves * 8);
  out.values.resize(leaves * kFloats);
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord at = leaf->origin();
    std::memcpy(out.values.data() + out.leaves.size() * kFloats, leaf->buffer().data(),
                kFloats * sizeof(float));
    out.leaves.push_back({at.x(), at.y(), at.z()});
    for (openvdb::Index w = 0; w < 8; ++w)
      out.active.push_back(leaf->valueMask().template getWord<std::uint64_t>(w));
  }
}

VdbGrid from_openvdb(const std::string& path, openvdb::GridBase& grid, const VdbLimits& limits) {
  VdbGrid out;
  out.name = grid.getName();
  const auto bad = [&](const char* what, std::string expected, std::string got) {
    fail({.where = path + ", grid '" + clean(out.name.c_str()) + "'",
          .what = what,
          .expected = std::move(expected),
          .got = std::move(got)});
  };
  if (grid.activeVoxelCount() > limits.max_voxels)
    bad("has too many active voxels", "at most " + std::to_string(limits.max_voxels),
        std::to_string(grid.activeVoxelCount()));
  const openvdb::math::Transform& transform = grid.transform();
  const Vec3d size = to_vec(transform.voxelSize());
  const Vec3d along = to_vec(transform.indexToWorld(openvdb::Vec3d(1, 1, 1)) -
                             transform.indexToWorld(openvdb::Vec3d(0, 0, 0)));
  const double slack = 1e-9 * size.x;
  for (int a = 0; a < 3; ++a)
    if (!transform.isLinear() || !(std::abs(along[a] - size.x) <= slack))
      bad("has a transform that this program cannot use", "cubic voxels along the axes",
          "a rotation, a frustum or uneven voxels");
  out.spacing = size.x;
  out.origin = to_vec(transform.indexToWorld(openvdb::Vec3d(0, 0, 0)));
  out.half = grid.saveFloatAsHalf();
  out.grid_class = grid.getGridClass() == openvdb::GRID_FOG_VOLUME ? VdbClass::fog_volume : VdbClass::unknown;
  out.meta = to_meta(grid);
  if (auto* scalar = dynamic_cast<openvdb::FloatGrid*>(&grid)) {
    out.background.x = scalar->background();
    copy_leaves(*scalar, out);
  } else {
    auto& vector = dynamic_cast<openvdb::Vec3SGrid&>(grid);
    const openvdb::Vec3s b = vector.background();
    out.width = 3;
    out.background = {b.x(), b.y(), b.z()};
    const openvdb::VecType type = grid.getVectorType();
    out.vector = type == openvdb::VEC_CONTRAVARIANT_RELATIVE ? VdbVector::contravariant_relative
                                                             : VdbVector::invariant;
    copy_leaves(vector, out);
  }
  return out;
}

}  // namespace

VdbFile read_vdb(const std::string& path, const VdbLimits& limits) {
  const Parsed parsed = parse(path, limits);
  VdbFile out;
  out.meta = to_meta(*parsed.meta);
  for (const openvdb::GridBase::Ptr& grid : *parsed.grids)
    if (grid->isType<openvdb::FloatGrid>() || grid->isType<openvdb::Vec3SGrid>())
      out.grids.push_back(from_openvdb(path, *grid, limits));
    else
      out.skipped.push_back(grid->getName());
  return out;
}

VdbInfo inspect_vdb(const std::string& path, const VdbLimits& limits) {
  const Parsed parsed = parse(path, limits);
  VdbInfo info{parsed.bytes, parsed.version, parsed.sealed, to_text(*parsed.meta), {}};
  for (const openvdb::GridBase::Ptr& grid : *parsed.grids) {
    GridInfo g;
    g.name = grid->getName();
    g.type = grid->valueType();
    g.grid_class = openvdb::GridBase::gridClassToString(grid->getGridClass());
    g.active_voxels = grid->activeVoxelCount();
    g.leaves = grid->constBaseTree().leafCount();
    g.memory_bytes = grid->memUsage();
    g.half = grid->saveFloatAsHalf();
    g.linear = grid->transform().isLinear();
    g.voxel_size = to_vec(grid->transform().voxelSize());
    g.origin = to_vec(grid->transform().indexToWorld(openvdb::Vec3d(0, 0, 0)));
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    g.lo = {box.min().x(), box.min().y(), box.min().z()};
    g.hi = {box.max().x(), box.max().y(), box.max().z()};
    g.meta = to_text(*grid);
    info.grids.push_back(std::move(g));
  }
  return info;
}

}  // namespace splinevox
