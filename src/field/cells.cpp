// SPDX-License-Identifier: Apache-2.0
#include "field/cells.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox {

CellGrid::CellGrid(const Box& box, int cells_along_longest) : origin(box.lo) {
  const Vec3 extent = box.extent();
  cell = std::max({extent.x, extent.y, extent.z}) / float(cells_along_longest);
  for (int a = 0; a < 3; ++a) size[a] = std::max(1, int(std::ceil(extent[a] / cell - 1e-3f)));
}

CellValues dilate(CellValues in) {
  const Int3 size = in.grid.size;
  for (int axis = 0; axis < 3; ++axis) {
    const CellValues from = in;
    const std::size_t stride = axis == 0 ? std::size_t(size.y) * size.z : axis == 1 ? std::size_t(size.z) : 1;
    Int3 c;
    for (c.x = 0; c.x < size.x; ++c.x)
      for (c.y = 0; c.y < size.y; ++c.y)
        for (c.z = 0; c.z < size.z; ++c.z) {
          const std::size_t i = in.grid.index(c);
          if (c[axis] > 0) in.raise(i, from.values[i - stride]);
          if (c[axis] + 1 < size[axis]) in.raise(i, from.values[i + stride]);
        }
  }
  return in;
}

}  // namespace splinevox
