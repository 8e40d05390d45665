// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "splinevox/core/error.hpp"
#include "splinevox/field/channels.hpp"
#include "splinevox/render/occupancy.hpp"

namespace splinevox {

/// Bytes of a training state, written and read by the same function: archive(a, b, ...) appends or fills in, in order.
class Archive {
 public:
  Archive() = default;                                             ///< writes
  explicit Archive(const std::vector<char>& bytes) : in_(&bytes) {}  ///< reads
  bool reading() const { return in_ != nullptr; }
  std::vector<char> take() { return std::move(out_); }
  bool exhausted() const { return !in_ || at_ == in_->size(); }

  template <class... T>
  void operator()(T&... values) { (item(values), ...); }

 private:
  template <class T>
  void item(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>) raw(&value, sizeof(T));
    else value.archive(*this);
  }
  template <class T, class A>
  void item(std::vector<T, A>& values) {
    std::uint64_t n = values.size();
    item(n);
    if (reading()) {
      if (n > (in_->size() - at_)) fail_short();  // every element takes at least a byte
      values.resize(n);
    }
    if constexpr (std::is_trivially_copyable_v<T>) raw(values.data(), n * sizeof(T));
    else for (T& v : values) item(v);
  }
  void item(TopologyPtr& topology) {
    Lattice lattice = topology ? topology->lattice : Lattice{};
    std::vector<Int3> bricks;
    if (topology) bricks.assign(topology->bricks.begin() + 1, topology->bricks.end());
    item(lattice), item(bricks);
    if (reading()) topology = make_topology(lattice, std::move(bricks));
  }
  void item(Channels& c) { item(c.topology), item(c.width), item(c.values); }
  void item(BitGrid& g) { item(g.origin), item(g.cell), item(g.size), item(g.bits); }

  void raw(void* data, std::size_t n) {
    if (!reading()) {
      out_.insert(out_.end(), static_cast<char*>(data), static_cast<char*>(data) + n);
      return;
    }
    if (n > in_->size() - at_) fail_short();
    std::memcpy(data, in_->data() + at_, n);
    at_ += n;
  }
  [[noreturn]] static void fail_short() {
    fail({"checkpoint", "the training state ends too early", "a state written by the same version and configuration", "fewer bytes", ""});
  }

  const std::vector<char>* in_ = nullptr;
  std::size_t at_ = 0;
  std::vector<char> out_;
};

}  // namespace splinevox
