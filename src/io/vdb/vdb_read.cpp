// SPDX-License-Identifier: Apache-2.0
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <istream>
#include <new>
#include <stdexcept>
#include <streambuf>

#include "core/atomic_file.hpp"
#include "core/process.hpp"
#include "io/vdb/child.hpp"
#include "io/vdb/openvdb_grid.hpp"
#include "io/vdb/vdb_pack.hpp"
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

/// OpenVDB's messages may quote the file's own bytes: printable, and no longer than a line or two.
std::string clean(const char* message) {
  std::string text(message, strnlen(message, 300));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

/// What the child throws: only its text comes out.
[[noreturn]] void refuse(const std::string& text) { throw std::runtime_error(text); }

struct Parsed {
  openvdb::GridPtrVecPtr grids;
  openvdb::MetaMap::Ptr meta;
  std::string version;
};

/// In the child.
Parsed parse_payload(std::string_view payload) {
  MemoryBuffer buffer(payload);
  std::istream in(&buffer);
  in.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  Parsed out;
  try {
    openvdb::io::Stream stream(in, /*delayLoad=*/false);
    out.grids = stream.getGrids();
    out.meta = stream.getMetadata();
    out.version = stream.version();
    if (std::uint64_t(in.tellg()) != payload.size()) refuse("bytes after the last grid");
  } catch (const std::ios_base::failure&) {
    refuse("the data ends too early");
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {  // openvdb::Exception and what its parsers let through
    refuse(clean(e.what()));
  }
  if (!out.grids) out.grids = std::make_shared<openvdb::GridPtrVec>();
  if (!out.meta) out.meta = std::make_shared<openvdb::MetaMap>();
  return out;
}

[[noreturn]] void fail_damaged(const std::string& path, const std::string& got) {
  fail({.where = path,
        .what = "is damaged or not complete: OpenVDB cannot read it",
        .got = got,
        .hint = "copy or export the file again"});
}

[[noreturn]] void fail_no_memory(const std::string& path, const std::string& need) {
  fail_memory({.where = path,
               .what = "not enough memory to read it",
               .expected = need,
               .got = "less",
               .hint = "end other programs, raise the limit (ulimit -v, the container's), or use a larger "
                       "machine"});
}

std::string megabytes(std::uint64_t bytes) { return "about " + std::to_string((bytes >> 20) + 1) + " MiB"; }

/// To open a pipe may take for ever, and to read a device as well. A file is read as a whole.
void check_file(const std::string& path) {
  std::error_code unknown;
  const std::filesystem::file_status status = std::filesystem::status(path, unknown);
  if (std::filesystem::exists(status) && std::filesystem::is_other(status))
    fail({.where = path, .what = "is no file", .expected = "a regular file", .got = "a pipe or a device"});
  const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
  if (const double room = free_memory(); !unknown && room > 0 && double(bytes) > room)
    fail_no_memory(path, megabytes(bytes));
}

/// The child is not trusted: it may send as many voxels as were counted. Where a grid could not be looked at
/// its own are not among them.
VdbLimits sent_at_most(const VdbCost& cost, VdbLimits limits) {
  constexpr std::uint64_t kUncounted = std::uint64_t(1) << 30;
  limits.max_voxels = std::min(limits.max_voxels, cost.voxels + (cost.known ? 0 : kUncounted));
  return limits;
}

struct Opened {
  std::uint64_t bytes = 0;
  bool sealed = false;
};

/// Parses a file in a child process, since OpenVDB 10 can crash, hang or ask for any amount of memory, and
/// nobody vouches for a file: the seal has no key. The child gives what `send` makes of it, and `take` has
/// it.
Opened parse(const std::string& path, const VdbLimits& limits,
             const std::function<void(const Parsed&, const Sink&)>& send,
             const std::function<void(vdb_pack::Reader&)>& take) {
  constexpr std::uint64_t kAside = std::uint64_t(256) << 20, kUnknown = std::uint64_t(1) << 30;
  openvdb::initialize();
  check_file(path);
  const std::string bytes = read_file(path, limits.max_bytes, Named::by_user);
  const VdbScan scan = scan_vdb(path, bytes, limits);
  const VdbCost& cost = scan.cost;
  const std::string need = megabytes(2 * cost.bytes);
  const VdbLimits sent = sent_at_most(cost, limits);
  if (const double room = free_memory(); room > 0 && 2 * double(cost.bytes) > room)
    fail_no_memory(path, need);
  ChildReport report;
  try {
    report = run_in_child(
        [&](const Sink& sink) {
          tbb::task_arena alone(
              1);  // OpenVDB counts and frees in parallel, and the child may have no threads
          alone.execute([&] { send(*new Parsed(parse_payload(scan.payload)), sink); });  // freed by its end
        },
        [&](const Source& source) {
          vdb_pack::Reader reader(source, sent);
          take(reader);
        },
        {unsigned(20 + bytes.size() / 10'000'000),
         cost.bytes + cost.bytes / 2 + kAside + (cost.known ? 0 : 40 * bytes.size() + kUnknown)});
  } catch (const std::bad_alloc&) {
    fail_no_memory(path, need);
  } catch (const std::length_error&) {
    fail_damaged(path, "what comes out of it is beyond its limits");
  }
  // What the file says has been looked at: if memory is short then, that is not the file's fault. A library
  // that does not check what it was given uses address zero; damage is not the reason where the seal is
  // right.
  if (cost.known && (report.end == ChildEnd::no_memory || (report.end == ChildEnd::null && scan.sealed)))
    fail_no_memory(path, need);
  if (report.end == ChildEnd::no_memory) report.text = "sizes beyond reason";
  if (report.end != ChildEnd::done) fail_damaged(path, report.text);
  return {bytes.size(), scan.sealed};
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
void send_leaves(Grid& grid, const VdbGrid& head, const Sink& sink) {
  grid.tree().voxelizeActiveTiles(/*threaded=*/false);
  vdb_pack::put_head(sink, head, grid.tree().leafCount());
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord at = leaf->origin();
    std::uint64_t active[8];
    for (openvdb::Index w = 0; w < 8; ++w) active[w] = leaf->valueMask().template getWord<std::uint64_t>(w);
    vdb_pack::put_leaf(sink, {at.x(), at.y(), at.z()}, active,
                       reinterpret_cast<const float*>(leaf->buffer().data()), head.width);
  }
}

/// In the child.
void send_grid(openvdb::GridBase& grid, const Sink& sink) {
  VdbGrid out;
  out.name = grid.getName();
  const openvdb::math::Transform& transform = grid.transform();
  const Vec3d size = to_vec(transform.voxelSize());
  const Vec3d along = to_vec(transform.indexToWorld(openvdb::Vec3d(1, 1, 1)) -
                             transform.indexToWorld(openvdb::Vec3d(0, 0, 0)));
  const double slack = 1e-9 * size.x;
  for (int a = 0; a < 3; ++a)
    if (!transform.isLinear() || !(std::abs(along[a] - size.x) <= slack))
      refuse(
          "grid '" + clean(out.name.c_str()) +
          "' has a rotation, a frustum or uneven voxels, and this program takes cubic voxels along the axes");
  out.spacing = size.x;
  out.origin = to_vec(transform.indexToWorld(openvdb::Vec3d(0, 0, 0)));
  out.half = grid.saveFloatAsHalf();
  out.grid_class = grid.getGridClass() == openvdb::GRID_FOG_VOLUME ? VdbClass::fog_volume : VdbClass::unknown;
  out.meta = to_meta(grid);
  if (auto* scalar = dynamic_cast<openvdb::FloatGrid*>(&grid)) {
    out.background.x = scalar->background();
    send_leaves(*scalar, out, sink);
  } else {
    auto& vector = dynamic_cast<openvdb::Vec3SGrid&>(grid);
    const openvdb::Vec3s b = vector.background();
    out.width = 3;
    out.background = {b.x(), b.y(), b.z()};
    const openvdb::VecType type = grid.getVectorType();
    out.vector = type == openvdb::VEC_CONTRAVARIANT_RELATIVE ? VdbVector::contravariant_relative
                                                             : VdbVector::invariant;
    send_leaves(vector, out, sink);
  }
}

bool is_ours(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::Vec3SGrid>();
}

/// In the child.
void send_file(const Parsed& parsed, const Sink& sink) {
  vdb_pack::put(sink, to_meta(*parsed.meta));
  vdb_pack::put(sink, std::uint64_t(parsed.grids->size()));
  for (const openvdb::GridBase::Ptr& grid : *parsed.grids) {
    vdb_pack::put(sink, std::uint64_t(is_ours(*grid)));
    if (is_ours(*grid))
      send_grid(*grid, sink);
    else
      vdb_pack::put(sink, grid->getName());
  }
}

GridInfo info_of(const openvdb::GridBase& grid) {
  GridInfo g;
  g.name = grid.getName();
  g.type = grid.valueType();
  g.grid_class = openvdb::GridBase::gridClassToString(grid.getGridClass());
  g.active_voxels = grid.activeVoxelCount();
  g.leaves = grid.constBaseTree().leafCount();
  g.memory_bytes = grid.memUsage();
  g.half = grid.saveFloatAsHalf();
  g.linear = grid.transform().isLinear();
  g.voxel_size = to_vec(grid.transform().voxelSize());
  g.origin = to_vec(grid.transform().indexToWorld(openvdb::Vec3d(0, 0, 0)));
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  g.lo = {box.min().x(), box.min().y(), box.min().z()};
  g.hi = {box.max().x(), box.max().y(), box.max().z()};
  g.meta = to_text(grid);
  return g;
}

/// In the child.
void send_info(const Parsed& parsed, const Sink& sink) {
  VdbInfo info;
  info.version = parsed.version;
  info.meta = to_text(*parsed.meta);
  for (const openvdb::GridBase::Ptr& grid : *parsed.grids) info.grids.push_back(info_of(*grid));
  vdb_pack::put(sink, info);
}

}  // namespace

VdbFile read_vdb(const std::string& path, const VdbLimits& limits) {
  VdbFile out;
  parse(path, limits, send_file, [&](vdb_pack::Reader& in) {
    out.meta = in.meta();
    for (std::uint64_t n = in.number(std::uint64_t(limits.max_grids)); n > 0; --n)
      if (in.number(1) == 1)
        out.grids.push_back(in.grid());
      else
        out.skipped.push_back(in.text());
  });
  return out;
}

VdbInfo inspect_vdb(const std::string& path, const VdbLimits& limits) {
  VdbInfo info;
  const Opened opened = parse(path, limits, send_info, [&](vdb_pack::Reader& in) { info = in.info(); });
  info.file_bytes = opened.bytes;
  info.sealed = opened.sealed;
  return info;
}

}  // namespace splinevox
