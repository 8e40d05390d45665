// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "render/occupancy.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// Bytes of a training state, written and read by the same function: archive(a, b, ...) appends or fills in,
/// in order. A state is a row of sections: kSectionName bytes of name, padded with zeros; the number of bytes
/// that follow, 64 bit; those bytes.
class Archive {
 public:
  static constexpr std::size_t kSectionName = 16;

  Archive() = default;  ///< writes
  /// Reads.
  explicit Archive(const std::vector<char>& bytes) : in_(&bytes), end_(bytes.size()) {}
  bool reading() const { return in_ != nullptr; }
  /// What `fill` archives, as a section. Throws Error (input) where another one comes next, or it holds more
  /// or less than `fill` reads.
  template <class Fill>
  void section(std::string_view name, Fill&& fill) {
    char label[kSectionName] = {};
    std::copy_n(name.data(), std::min(name.size(), kSectionName), label);
    char found[kSectionName];
    std::copy_n(label, kSectionName, found);
    raw(found, kSectionName);
    std::uint64_t size = 0;
    const std::size_t at = out_.size();
    item(size);
    if (!reading()) {
      const std::size_t before = written();
      fill();
      size = written() - before;
      std::copy_n(reinterpret_cast<const char*>(&size), sizeof size, out_.data() + at);
      return;
    }
    if (!std::equal(label, label + kSectionName, found)) fail_at(name, "is not where it should be");
    if (size > end_ - at_) fail_short();
    const std::size_t all = std::exchange(end_, at_ + size);
    fill();
    if (at_ != end_) fail_at(name, "goes on after its end");
    end_ = all;
  }
  /// All that was written, in order. Parameters and moments, which are most of it, are where they were: they
  /// must stay there, unchanged, as long as the pieces are used.
  std::vector<std::string_view> pieces() const {
    std::vector<std::string_view> out;
    std::size_t at = 0;
    for (const auto& [before, bytes] : large_) {
      out.push_back(std::string_view(out_.data(), out_.size()).substr(at, before - at));
      out.push_back(bytes);
      at = before;
    }
    out.push_back(std::string_view(out_.data(), out_.size()).substr(at));
    return out;
  }
  /// Nothing is left of what is read, or of its present section.
  bool exhausted() const { return !in_ || at_ == end_; }

  template <class... T>
  void operator()(T&... values) {
    (item(values), ...);
  }

 private:
  template <class T>
  void item(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>)
      raw(&value, sizeof(T));
    else
      value.archive(*this);
  }
  template <class T, class A>
  void item(std::vector<T, A>& values) {
    std::uint64_t n = values.size();
    item(n);
    if (reading()) {
      const std::uint64_t each =
          std::is_trivially_copyable_v<T> ? sizeof(T) : 1;  // bytes of an element, at least
      if (n > (end_ - at_) / each) fail_short();
      values.resize(n);
    }
    if constexpr (std::is_same_v<A, AlignedAllocator<T>> && std::is_trivially_copyable_v<T>) {
      if (!reading()) {
        large_.emplace_back(out_.size(),
                            std::string_view(reinterpret_cast<const char*>(values.data()), n * sizeof(T)));
        return;
      }
    }
    if constexpr (std::is_trivially_copyable_v<T>)
      raw(values.data(), n * sizeof(T));
    else
      for (T& v : values) item(v);
  }
  void item(TopologyPtr& topology) {
    Lattice lattice = topology ? topology->lattice : Lattice{};
    std::vector<Int3> bricks;
    if (topology) bricks.assign(topology->bricks.begin() + 1, topology->bricks.end());
    item(lattice);
    item(bricks);
    if (!reading()) return;
    check(lattice.spacing > 0 && volume(lattice.size) <= kMostCells, "a lattice");
    std::vector<Int3> sorted = bricks;
    const auto before = [](const Int3& a, const Int3& b) {
      return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    };
    std::sort(sorted.begin(), sorted.end(), before);
    bool good = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
    for (const Int3& b : bricks)
      for (int a = 0; a < 3; ++a) good = good && b[a] >= 0 && b[a] < (lattice.size[a] + kBrick - 1) / kBrick;
    check(good, "the bricks of a lattice");
    topology = make_topology(lattice, std::move(bricks));
  }
  void item(Channels& c) {
    item(c.topology);
    item(c.width);
    item(c.values);
    if (reading())
      check(c.width > 0 && c.values.size() == c.topology->rows() * std::size_t(c.width),
            "an array of parameters");
  }
  void item(BitGrid& g) {
    item(g.origin);
    item(g.cell);
    item(g.size);
    item(g.bits);
    const bool none = g.size == Int3{} && g.bits.empty();
    if (reading() && !none)
      check(volume(g.size) <= kMostCells && g.bits.size() == (std::size_t(volume(g.size)) + 31) / 32,
            "an occupancy");
  }

  static constexpr double kMostCells = 1u << 31;
  static constexpr int kLongestSide = 1 << 16;
  /// Cells of a grid; infinite if there is no such grid.
  static double volume(const Int3& size) {
    bool good = true;
    for (int a = 0; a < 3; ++a) good = good && size[a] > 0 && size[a] <= kLongestSide;
    return good ? double(size.x) * size.y * size.z : std::numeric_limits<double>::infinity();
  }
  static void check(bool good, const char* what) {
    if (!good)
      fail({"checkpoint", std::string("the training state holds ") + what + " that cannot be",
            "a state written by the same version and configuration", "other numbers", ""});
  }

  void raw(void* data, std::size_t n) {
    if (!reading()) {
      out_.insert(out_.end(), static_cast<char*>(data), static_cast<char*>(data) + n);
      return;
    }
    if (n > end_ - at_) fail_short();
    std::copy_n(in_->data() + at_, n, static_cast<char*>(data));
    at_ += n;
  }
  /// Bytes so far.
  std::size_t written() const {
    std::size_t bytes = out_.size();
    for (const auto& [before, large] : large_) bytes += large.size();
    return bytes;
  }
  [[noreturn]] static void fail_at(std::string_view section, const char* what) {
    fail({"checkpoint", "the part '" + std::string(section) + "' of the training state " + what,
          "a state written by the same version and configuration", "other bytes", ""});
  }
  [[noreturn]] static void fail_short() {
    fail({"checkpoint", "the training state ends too early",
          "a state written by the same version and configuration", "fewer bytes", ""});
  }

  const std::vector<char>* in_ = nullptr;
  std::size_t at_ = 0, end_ = 0;  ///< of what is read, or of its section
  std::vector<char> out_;         ///< written, but for what is large
  std::vector<std::pair<std::size_t, std::string_view>>
      large_;  ///< arrays of parameters, and how much of out_ is before each
};

}  // namespace splinevox
