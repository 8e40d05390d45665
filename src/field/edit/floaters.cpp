// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "field/edit/edit_motion.hpp"
#include "field/largest_presence.hpp"
#include "field/lattice/lattice_view.hpp"
#include "field/lattice/locate.hpp"
#include "math/activation.hpp"
#include "math/emission.hpp"
#include "splinevox/field/edit.hpp"

namespace splinevox {
namespace {

constexpr int kTimes = 24;       // at which what comes and goes is looked for
constexpr float kSolid = 0.05f;  // opacity of a voxel at some time from which it holds its neighbours
constexpr int kFog = 2;          // voxels around a piece whose thinner matter goes with it

/// Sets of rows that hang together (union-find); a set is known by its lowest row.
class Pieces {
 public:
  explicit Pieces(std::size_t rows) : parent_(rows) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t of(std::uint32_t row) {
    while (parent_[row] != row) row = parent_[row] = parent_[parent_[row]];
    return row;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = of(a);
    b = of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

bool within(const Topology& t, Int3 v) {
  for (int a = 0; a < 3; ++a)
    if (v[a] < 0 || v[a] >= t.lattice.size[a]) return false;
  return true;
}

/// Calls visit(row, vertex) for the stored rows up to `reach` vertices from a vertex, itself among them.
template <class Visit>
void for_each_near(const Topology& t, Int3 vertex, int reach, Visit&& visit) {
  const LatticeView view = view_of(t);
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z) {
        const Int3 v = vertex + Int3{x, y, z};
        if (const std::size_t row = view.row_of(v); row >= kBrickRows && within(t, v))
          visit(std::uint32_t(row), v);
      }
}

/// Calls visit(row, vertex) for every stored row within the lattice.
template <class Visit>
void for_each_vertex(const Topology& t, Visit&& visit) {
  const LatticeView view = view_of(t);
  for (std::size_t row = kBrickRows; row < view.rows(); ++row)
    if (const Int3 v = view.vertex(row); within(t, v)) visit(std::uint32_t(row), v);
}

/// The opacity of a voxel at each canonical row: on the mean over time, or more where some moment shows it
/// so.
std::vector<float> largest_opacity(const VoxelModel& model) {
  const Channels& raw = model.radiance.raw;
  const Topology& t = *raw.topology;
  const DensityActivation& activation = model.radiance.activation;
  const auto opacity = [&](float value) {
    return one_minus_exp_neg(density_of(value, activation.scale, activation.shift).value * t.lattice.spacing);
  };
  std::vector<float> alpha(t.rows(), 0.0f);
  for_each_vertex(t, [&](std::uint32_t row, Int3) { alpha[row] = opacity(raw.row(row)[0]); });
  if (!comes_and_goes(model.motion)) return alpha;
  const BrickView<float> view(t);
  struct LookedUp {
    Vec3 place;  // canonical
    float presence;
  };
  for (int i = 0; i < kTimes; ++i) {
    const std::vector<LookedUp> now = matter_at(model, double(i) / (kTimes - 1), [](const MatterSample& s) {
      return LookedUp{s.x + s.warp.displacement, s.warp.presence};
    });
    for (const LookedUp& at : now)
      for (const std::int32_t corner : locate(view, at.place).rows.row) {
        const auto row = std::size_t(corner);
        if (row >= kBrickRows) alpha[row] = std::max(alpha[row], opacity(raw.row(row)[0] + at.presence));
      }
  }
  return alpha;
}

}  // namespace

RemovedFloaters remove_floaters(VoxelModel& model, double least) {
  Channels& raw = model.radiance.raw;
  const Topology& t = *raw.topology;
  const std::vector<float> alpha = largest_opacity(model);
  const LargestPresence presence(model);
  Pieces pieces(t.rows());
  for_each_vertex(t, [&](std::uint32_t row, Int3 v) {
    if (alpha[row] >= kSolid)
      for_each_near(t, v, 1, [&](std::uint32_t other, Int3) {
        if (other < row && alpha[other] >= kSolid) pieces.join(row, other);
      });
  });

  std::vector<double> matter(t.rows(), 0.0);  // of a piece, at its lowest row
  double all = 0;
  for (std::uint32_t row = 0; row < t.rows(); ++row)
    if (alpha[row] >= kSolid) {
      matter[pieces.of(row)] += alpha[row];
      all += alpha[row];
    }
  const auto floats = [&](std::uint32_t row) { return matter[pieces.of(row)] < least * all; };
  RemovedFloaters out;
  for (std::uint32_t row = 0; row < t.rows(); ++row)
    if (matter[row] > 0) {
      ++(floats(row) ? out.count : out.left);
      if (floats(row)) out.share += matter[row] / all;
    }
  const auto stays = [&](std::uint32_t row) { return alpha[row] >= kSolid && !floats(row); };
  const auto beside_what_stays = [&](Int3 v) {  // interpolation draws its surface through them
    bool beside = false;
    for_each_near(t, v, 1, [&](std::uint32_t row, Int3) { beside |= stays(row); });
    return beside;
  };
  const float empty = raw.row(0)[0];
  for_each_vertex(t, [&](std::uint32_t row, Int3 v) {
    if (alpha[row] < kSolid || !floats(row)) return;
    for_each_near(t, v, kFog, [&](std::uint32_t other, Int3 w) {
      if (beside_what_stays(w)) return;
      float& density = raw.row(other)[0];  // empty at all times
      density = std::min(density, empty - presence.around(t.lattice.position(w), t.lattice.spacing));
    });
  });
  return out;
}

}  // namespace splinevox
