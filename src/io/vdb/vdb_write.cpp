// SPDX-License-Identifier: Apache-2.0
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <sstream>
#include <type_traits>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/hash.hpp"
#include "io/vdb/openvdb_grid.hpp"
#include "io/vdb/vdb_scan.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

/// Opens the writer that io::File and io::Stream share: only it can write grid offsets to a stream of ours.
class Writer : public openvdb::io::Archive {
 public:
  void write_to(std::ostream& out, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& meta) const {
    openvdb::io::Archive::write(out, grids, /*seekable=*/true, meta);
  }
};

void put(openvdb::MetaMap& map, const VdbMeta& meta) {
  for (const auto& [key, value] : meta)
    std::visit(
        [&, &name = key](const auto& v) {
          using T = std::decay_t<decltype(v)>;
          if constexpr (std::is_same_v<T, std::string>)
            map.insertMeta(name, openvdb::StringMetadata(v));
          else if constexpr (std::is_same_v<T, double>)
            map.insertMeta(name, openvdb::DoubleMetadata(v));
          else
            map.insertMeta(name, openvdb::Int64Metadata(v));
        },
        value);
}

template <class Grid>
openvdb::GridBase::Ptr make_grid(const VdbGrid& in, const typename Grid::ValueType& background) {
  using Tree = typename Grid::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Grid::ValueType;
  static_assert(sizeof(Value) % sizeof(float) == 0 && Leaf::SIZE == 512);
  constexpr std::size_t kFloats = 512 * sizeof(Value) / sizeof(float);

  auto grid = Grid::create(background);
  Tree& tree = grid->tree();
  for (std::size_t l = 0; l < in.leaves.size(); ++l) {
    const Int3 at = in.leaves[l];
    auto* leaf = new Leaf(openvdb::Coord(at.x, at.y, at.z), background, in.active.empty());
    auto* out = reinterpret_cast<float*>(leaf->buffer().data());
    std::memcpy(out, in.values.data() + l * kFloats, kFloats * sizeof(float));
    if (in.half)
      std::transform(out, out + kFloats, out,
                     [](float v) { return std::clamp(v, -kLargestHalf, kLargestHalf); });
    if (!in.active.empty()) {
      openvdb::util::NodeMask<3> mask;
      for (int w = 0; w < 8; ++w)
        mask.template getWord<std::uint64_t>(openvdb::Index(w)) = in.active[l * 8 + w];
      leaf->setValueMask(mask);
    }
    tree.addLeaf(leaf);
  }
  return grid;
}

/// A hash as the text of a (version 4, variant 1) UUID.
std::string uuid_text(std::uint64_t a, std::uint64_t b) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string digits;
  for (const std::uint64_t half : {a, b})
    for (int i = 60; i >= 0; i -= 4) digits += kHex[half >> i & 15];
  digits[12] = '4';
  digits[16] = kHex[8 | (b >> 60 & 3)];
  return digits.substr(0, 8) + "-" + digits.substr(8, 4) + "-" + digits.substr(12, 4) + "-" +
         digits.substr(16, 4) + "-" + digits.substr(20);
}

/// What readers refuse is not written. Their limit on bytes is above what so many voxels can take.
void check_voxels(const std::string& path, const VdbFile& file, const VdbLimits& limits) {
  std::uint64_t voxels = 0;
  for (const VdbGrid& grid : file.grids) voxels += std::uint64_t(kBrickRows) * grid.leaves.size();
  if (voxels <= limits.max_voxels) return;
  fail_output({.where = path,
               .what = "is not written: it would have more voxels than can be read back",
               .expected = "at most " + std::to_string(limits.max_voxels) + " in all grids together",
               .got = std::to_string(voxels),
               .hint = "larger voxels (of an export --voxel-size; of a training fewer cells in grid.radiance "
                       "and grid.motion), or fewer grids"});
}

/// Throws std::bad_alloc where there is no memory for what writing will need. Blosc does not look whether it
/// got what it asked for, so it must not be where memory ends.
void ask_for_memory(const VdbFile& file) {
  constexpr std::size_t kAside = std::size_t(16) << 20;
  std::size_t bytes = kAside;  // the values as OpenVDB's, and at most as many in the file
  for (const VdbGrid& grid : file.grids) bytes += 2 * sizeof(float) * grid.values.size();
  ::operator delete(::operator new(bytes));
}

}  // namespace

openvdb::GridBase::Ptr to_openvdb(const VdbGrid& in) {
  openvdb::GridBase::Ptr grid;
  if (in.width == 1)
    grid = make_grid<openvdb::FloatGrid>(in, in.background.x);
  else
    grid =
        make_grid<openvdb::Vec3SGrid>(in, openvdb::Vec3s(in.background.x, in.background.y, in.background.z));
  auto transform = openvdb::math::Transform::createLinearTransform(in.spacing);
  transform->postTranslate(openvdb::Vec3d(in.origin.x, in.origin.y, in.origin.z));
  grid->setTransform(transform);
  put(*grid, in.meta);
  grid->setName(in.name);
  grid->setCreator("splinevox");
  grid->setGridClass(in.grid_class == VdbClass::fog_volume ? openvdb::GRID_FOG_VOLUME
                                                           : openvdb::GRID_UNKNOWN);
  if (in.vector == VdbVector::invariant) grid->setVectorType(openvdb::VEC_INVARIANT);
  if (in.vector == VdbVector::contravariant_relative)
    grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  grid->setSaveFloatAsHalf(in.half);
  return grid;
}

FileDigest write_vdb(const std::string& path, VdbFile file, const VdbLimits& limits) {
  check_voxels(path, file, limits);
  openvdb::initialize();
  ask_for_memory(file);
  std::string bytes;
  try {
    openvdb::GridCPtrVec grids;
    std::string room;  // for all of it: a buffer that doubles is copied, and each time touched anew
    std::size_t most = 0;
    for (VdbGrid& grid : file.grids) {
      most += grid.values.size() * sizeof(float);
      grids.push_back(to_openvdb(std::exchange(grid, {})));  // of all grids together, one of the two forms
    }
    room.reserve(most);
    openvdb::MetaMap meta;
    put(meta, file.meta);
    std::ostringstream out(std::move(room), std::ios::binary);
    out.exceptions(std::ios::failbit | std::ios::badbit);
    Writer().write_to(out, grids, meta);
    bytes = std::move(out).str();
  } catch (const openvdb::Exception& e) {
    fail_output({.where = path, .what = "could not be written", .got = e.what()});
  } catch (const std::ios_base::failure&) {
    fail_output({.where = path, .what = "could not be written", .got = "not enough memory"});
  }
  // OpenVDB's id is random; a hash of the content makes equal exports equal files.
  std::fill_n(bytes.begin() + kVdbIdOffset, kVdbIdBytes, '0');
  Hash64 hash;
  hash.add(bytes);
  const std::uint64_t first = hash.value();
  hash.add("id");
  const std::string id = uuid_text(first, hash.value());
  std::copy(id.begin(), id.end(), bytes.begin() + kVdbIdOffset);
  return write_file(path, {bytes, vdb_seal(bytes.size(), hash64(bytes))});
}

}  // namespace splinevox
