// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/lattice/lattice_view.hpp"
#include "render/field_view.hpp"

namespace splinevox {

/// A topology in an executor's memory.
template <class Executor>
struct LatticeMirror {
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;
  TopologyPtr topology;
  Buffer<std::int32_t> table;
  Buffer<Int3> bricks;

  void upload(Executor& run, const TopologyPtr& t) {
    topology = t;
    run.upload(table, t->table.data(), t->table.size());
    run.upload(bricks, t->bricks.data(), t->bricks.size());
  }
  LatticeView view() const { return {table.data(), bricks.data(), topology->dims, topology->brick_count()}; }
  BrickView<float> brick_view() const {
    BrickView<float> v(*topology);
    v.table = table.data();
    return v;
  }
};

/// The most samples a ray through a box can have.
inline int most_samples(const Box& box, float step) {
  const Vec3 e = box.extent();
  return int(length(e) / step) + 2;
}

}  // namespace splinevox
