// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/vdb_walk.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

namespace splinevox {
namespace {

using Word = std::uint64_t;
constexpr std::uint32_t kZip = 1, kActiveMask = 2, kBlosc = 4;  // openvdb/io/Compression.h
constexpr std::uint64_t kLeafVoxels = 512;

struct Size {
  std::string_view name;
  std::uint64_t bytes;
};

template <std::size_t N>
const Size* find_size(const Size (&sizes)[N], std::string_view name) {
  const auto at = std::find_if(sizes, sizes + N, [&](const Size& s) { return s.name == name; });
  return at == sizes + N ? nullptr : at;
}

constexpr Size kMetadata[] = {{"bool", 1},   {"int32", 4},  {"int64", 8},  {"float", 4},
                              {"double", 8}, {"vec2i", 8},  {"vec2s", 8},  {"vec2d", 16},
                              {"vec3i", 12}, {"vec3s", 12}, {"vec3d", 24}, {"vec4i", 16},
                              {"vec4s", 16}, {"vec4d", 32}, {"mat4s", 64}, {"mat4d", 128}};
constexpr Size kTransforms[] = {{"AffineMap", 128},
                                {"UnitaryMap", 128},
                                {"ScaleMap", 120},
                                {"UniformScaleMap", 120},
                                {"TranslationMap", 24},
                                {"ScaleTranslateMap", 144},
                                {"UniformScaleTranslateMap", 144}};

struct Kind {
  std::string_view name;
  std::uint64_t bytes, half;  ///< of a value, and of one stored as halves
};
constexpr Kind kKinds[] = {{"Tree_float_5_4_3", 4, 2},  {"Tree_double_5_4_3", 8, 2},
                           {"Tree_vec3s_5_4_3", 12, 6}, {"Tree_vec3d_5_4_3", 24, 6},
                           {"Tree_int32_5_4_3", 4, 4},  {"Tree_int64_5_4_3", 8, 8},
                           {"Tree_vec3i_5_4_3", 12, 12}};

/// Bits of a node, as the file has them.
class Mask {
 public:
  explicit Mask(std::string_view bytes) : bytes_(bytes) {}
  Word word(std::size_t i) const {
    Word w = 0;
    std::memcpy(&w, bytes_.data() + 8 * i, 8);
    return w;
  }
  std::size_t words() const { return bytes_.size() / 8; }
  std::uint64_t count() const { return count_without(Mask({})); }
  /// Bits that are not in the other.
  std::uint64_t count_without(const Mask& other) const {
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < words(); ++i)
      n += std::uint64_t(std::popcount(word(i) & ~(other.words() ? other.word(i) : 0)));
    return n;
  }

 private:
  std::string_view bytes_;
};

class TreeWalk {
 public:
  TreeWalk(Cursor& cursor, const Kind& kind, std::uint32_t compression, bool as_half, VdbCost& cost)
      : in_(cursor),
        bytes_(kind.bytes),
        stored_(as_half ? kind.half : kind.bytes),
        skips_empty_(as_half && kind.half < kind.bytes),
        compression_(compression),
        cost_(cost) {}

  void walk() {
    if (in_.take<std::int32_t>("a tree's number of buffers") != 1)
      in_.bad("a tree has a number of buffers that no program writes", "1");
    in_.skip(bytes_, "a background value");
    const auto tiles = in_.take<std::uint32_t>("a number of tiles"),
               children = in_.take<std::uint32_t>("a number of nodes");
    for (std::uint32_t t = 0; t < tiles; ++t) {
      in_.skip(12 + bytes_, "a tile");
      const auto active = in_.take<std::uint8_t>("a tile");
      if (active > 1) in_.bad("a tile is neither on nor off", "0 or 1", std::to_string(active));
      if (active) add_tiles(1, std::uint64_t(1) << 36);
    }
    struct Child {
      std::array<std::int32_t, 3> origin;
      std::uint64_t leaves;
    };
    std::vector<Child> order;
    for (std::uint32_t c = 0; c < children; ++c) {
      Child child{};
      for (std::int32_t& at : child.origin) {
        at = in_.take<std::int32_t>("a node's place");
        if (at % 4096 != 0)
          in_.bad("a node lies between two places", "multiples of 4096", std::to_string(at));
      }
      child.leaves = inner_node(32768, 16);
      order.push_back(child);
    }
    // OpenVDB keeps them by place, and reads their voxels in that order.
    std::sort(order.begin(), order.end(), [](const Child& a, const Child& b) { return a.origin < b.origin; });
    const auto twice = std::adjacent_find(
        order.begin(), order.end(), [](const Child& a, const Child& b) { return a.origin == b.origin; });
    if (twice != order.end()) in_.bad("two nodes have one place");
    for (const Child& child : order)
      for (std::uint64_t l = 0; l < child.leaves; ++l) {
        const Mask active(in_.skip(kLeafVoxels / 8, "a leaf's mask"));
        values(kLeafVoxels, active);
      }
  }

 private:
  void add(std::uint64_t voxels, std::uint64_t bytes) { add_cost(in_, cost_, voxels, bytes); }
  void add_tiles(std::uint64_t count, std::uint64_t voxels) {
    cost_.tile_voxels += count * voxels;
    add(count * voxels, count * voxels * (bytes_ + 1));
  }

  /// A node of `slots` places; those within have 16 or 8 voxels along each axis. @return leaves below it
  std::uint64_t inner_node(std::uint64_t slots, int side) {
    const Mask children(in_.skip(slots / 8, "a node's masks")), active(in_.skip(slots / 8, "a node's masks"));
    add(0, slots * std::max<std::uint64_t>(8, bytes_ + 4) + slots / 4 + 64);
    const std::uint64_t edge = side == 16 ? 128 : 8;
    if (const std::uint64_t tiles = active.count_without(children)) add_tiles(tiles, edge * edge * edge);
    values(slots, active);
    const std::uint64_t below = children.count();
    if (side == 16) {
      std::uint64_t leaves = 0;
      for (std::uint64_t c = 0; c < below; ++c) leaves += inner_node(4096, 8);
      return leaves;
    }
    for (std::uint64_t l = 0; l < below; ++l) {
      in_.skip(kLeafVoxels / 8, "a leaf's mask");
      add(kLeafVoxels, kLeafVoxels * bytes_ + 160);
    }
    return below;
  }

  /// readCompressedValues of openvdb/io/Compression.h.
  void values(std::uint64_t count, const Mask& active) {
    enum { kMaskAndNone = 3, kMaskAndOne = 4, kMaskAndTwo = 5, kAll = 6, kOne = 2 };
    const auto how = in_.take<std::uint8_t>("a node's way of storing");
    if (how > kAll) in_.bad("a node has a way of storing that is not known", "0 to 6", std::to_string(how));
    if (how == kOne || how == kMaskAndOne || how == kMaskAndTwo) in_.skip(bytes_, "an inactive value");
    if (how == kMaskAndTwo) in_.skip(bytes_, "an inactive value");
    if (how >= kMaskAndNone && how <= kMaskAndTwo) in_.skip(count / 8, "a mask of inactive values");
    if ((compression_ & kActiveMask) && how != kAll) count = active.count();
    if (skips_empty_ && count == 0) return;
    block(count * stored_);
  }

  /// `bytes` of values, as they are or compressed.
  void block(std::uint64_t bytes) {
    if (!(compression_ & (kBlosc | kZip))) {
      in_.skip(bytes, "values");
      return;
    }
    const auto length = in_.take<std::int64_t>("a block's length");
    if (length <= 0) {  // minus the length of what could not be made smaller
      if (length != -std::int64_t(bytes))
        in_.bad("a block of values is not as long as its node needs", std::to_string(bytes) + " bytes",
                std::to_string(length));
      in_.skip(bytes, "values");
      return;
    }
    constexpr std::uint64_t kOverhead = 64;  // of a compressor that gained nothing
    if (std::uint64_t(length) > bytes + bytes / 64 + kOverhead)
      in_.bad("a block of values is longer than what is in it", "at most " + std::to_string(bytes) + " bytes",
              std::to_string(length));
    const std::string_view packed = in_.skip(std::uint64_t(length), "compressed values");
    if (compression_ & kBlosc) check_blosc(packed, bytes);
  }

  /// The 16 bytes that begin a block of Blosc: its lengths are those of the block and of what comes out.
  void check_blosc(std::string_view packed, std::uint64_t bytes) {
    std::array<std::uint32_t, 3> lengths{};  // of the values, of a part of them, of the block
    if (packed.size() >= 16) std::memcpy(lengths.data(), packed.data() + 4, sizeof lengths);
    const auto [all, part, block] = lengths;
    const bool parts = bytes == 0 || (part > 0 && part <= all);
    if (all != bytes || block != packed.size() || !parts || packed[3] == 0)
      in_.bad("the lengths of a compressed block do not fit together", std::to_string(bytes) + " bytes",
              std::to_string(all));
  }

  Cursor& in_;
  std::uint64_t bytes_, stored_;
  bool skips_empty_;
  std::uint32_t compression_;
  VdbCost& cost_;
};

/// A table that lets other programs read leaves later: their number, a byte for each, eight for each. Both
/// lists may be compressed, and OpenVDB makes room for what their lengths say. Each leaf takes its mask in
/// the file at least.
void check_leaf_table(const Cursor& cursor, std::string_view value) {
  constexpr std::uint32_t kNone = ~std::uint32_t(0);
  std::uint64_t at = 0;
  const auto take = [&] {
    std::uint32_t n = 0;
    if (value.size() < at + sizeof n) cursor.bad("a table of leaves ends early");
    std::memcpy(&n, value.data() + at, sizeof n);
    at += sizeof n;
    return n;
  };
  if (value.empty()) return;
  const std::uint64_t leaves = take(), most = (cursor.at() + cursor.left()) / (kLeafVoxels / 8);
  bool fits = leaves <= most;
  for (const std::uint64_t each : {1, 8}) {
    if (!fits) break;
    const std::uint32_t packed = take();
    if (packed != kNone) at += packed > 0 ? packed : each * leaves;
    fits = at <= value.size();
  }
  if (!fits)
    cursor.bad("a table of leaves is longer than the file", "at most " + std::to_string(most) + " leaves",
               std::to_string(leaves));
}

}  // namespace

void add_cost(const Cursor& cursor, VdbCost& cost, std::uint64_t voxels, std::uint64_t bytes) {
  cost.voxels += voxels;
  cost.bytes += bytes;
  const VdbLimits& limits = cursor.limits();
  if (cost.voxels > limits.max_voxels)
    cursor.bad("there are too many active voxels in the file's grids together",
               "at most " + std::to_string(limits.max_voxels), "more");
  if (cost.tile_voxels > limits.max_tile_voxels)
    cursor.bad("there are too many active voxels in tiles, in the file's grids together",
               "at most " + std::to_string(limits.max_tile_voxels), std::to_string(cost.tile_voxels));
}

bool walk_metadata(Cursor& cursor) {
  int halves = -1;
  const auto n = cursor.take<std::uint32_t>("the metadata count");
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::string_view name = cursor.text("a metadata name"), type = cursor.text("a metadata type"),
                           value = cursor.text("a metadata value");
    if (const Size* size = find_size(kMetadata, type); size && size->bytes != value.size())
      cursor.bad("a metadata value is not as long as its type", std::to_string(size->bytes) + " bytes",
                 std::to_string(value.size()));
    if (type == "__delayedload") check_leaf_table(cursor, value);
    if (name != "is_saved_as_half_float") continue;
    if (halves >= 0 || type != "bool") cursor.bad("it is not clear how floats are stored");
    halves = value[0] != 0;
  }
  return halves == 1;
}

bool walk_grid(Cursor& cursor, std::string_view type, bool tree, VdbCost& cost) {
  constexpr std::string_view kHalf = "_HalfFloat";
  const bool named_half = type.ends_with(kHalf);
  if (named_half) type.remove_suffix(kHalf.size());
  const auto compression = cursor.take<std::uint32_t>("a grid's compression flags");
  if (compression > (kZip | kActiveMask | kBlosc))
    cursor.bad("a grid's compression is not known", "flags of 1, 2 and 4", std::to_string(compression));
  const bool half = walk_metadata(cursor);
  const Size* transform = find_size(kTransforms, cursor.text("a transform's type"));
  const Kind* kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.name == type; });
  if (!transform || (tree && kind == std::end(kKinds))) return false;
  cursor.skip(transform->bytes, "a transform");
  if (!tree) return true;
  if (half != named_half) cursor.bad("it is not clear how floats are stored");
  TreeWalk(cursor, *kind, compression, half, cost).walk();
  return true;
}

}  // namespace splinevox
