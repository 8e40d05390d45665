// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include "field/edit/edit_motion.hpp"
#include "math/kmeans.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/edit.hpp"

namespace splinevox {
namespace {

constexpr int kMoments = 16;     ///< of a trajectory
constexpr int kMostCells = 72;   ///< along the longest edge
constexpr int kMostAuto = 6;     ///< clusters that are tried
constexpr double kWorth = 0.03;  ///< of silhouette that more clusters have to gain
constexpr float kLeast = 0.02f;  ///< mean opacity over the moments below which a cell holds nothing
constexpr double kAlike =
    0.7;  ///< likeness from which a cell that moves by little belongs to a part that moves
constexpr double kMuch = 0.5;  ///< share of a part's motion from which a cell moves, whichever way it goes
constexpr int kGrow = 3;  ///< cells around matter that share its cluster: what interpolation reads with it

std::size_t cell_count(const Lattice& l) { return std::size_t(l.size.x) * l.size.y * l.size.z; }

std::ptrdiff_t index_of(const Lattice& l, Vec3 p) {
  Int3 c;
  for (int a = 0; a < 3; ++a) {
    c[a] = int(std::lround((p[a] - l.origin[a]) / l.spacing));
    if (c[a] < 0 || c[a] >= l.size[a]) return -1;
  }
  return (std::ptrdiff_t(c.x) * l.size.y + c.y) * l.size.z + c.z;
}

Vec3 position_of(const Lattice& l, std::size_t i) {
  return l.position(
      {int(i / (std::size_t(l.size.y) * l.size.z)), int(i / l.size.z % l.size.y), int(i % l.size.z)});
}

/// Trajectories of the cells that hold matter.
struct Paths {
  std::vector<std::size_t> cell;
  std::vector<float> weight;  ///< [n] mean opacity over the moments
  std::vector<float> path;    ///< [n * kMoments * 3] voxels, relative to the mean
};

struct Sum {
  float weight = 0;
  Vec3 moved{};
};

/// Fills the moments without sight from those around them and takes the mean away.
void finish(const Sum* sums, float voxel, std::vector<float>& out) {
  Vec3 place[kMoments], mean{};
  for (int m = 0; m < kMoments; ++m) {
    int before = m, after = m;
    while (before >= 0 && sums[before].weight == 0) --before;
    while (after < kMoments && sums[after].weight == 0) ++after;
    const auto at = [&](int i) { return (1 / sums[i].weight) * sums[i].moved; };
    if (before < 0)
      place[m] = at(after);
    else if (after >= kMoments || before == after)
      place[m] = at(before);
    else
      place[m] = at(before) + (float(m - before) / float(after - before)) * (at(after) - at(before));
    mean += (1.0f / kMoments) * place[m];
  }
  for (const Vec3& p : place)
    for (int a = 0; a < 3; ++a) out.push_back((p[a] - mean[a]) / voxel);
}

Paths find_paths(const VoxelModel& model, const Lattice& cells) {
  struct Hit {
    std::ptrdiff_t cell;  // negative: none
    float weight;
    Vec3 moved;
  };
  std::vector<Sum> sums(cell_count(cells) * kMoments);
  for (int m = 0; m < kMoments; ++m) {
    const std::vector<Hit> hits = matter_at(model, double(m) / (kMoments - 1), [&](const MatterSample& s) {
      return Hit{index_of(cells, s.x + s.warp.displacement), s.weight, -s.warp.displacement};
    });
    for (const Hit& h : hits) {
      if (h.cell < 0) continue;
      Sum& sum = sums[std::size_t(h.cell) * kMoments + std::size_t(m)];
      sum.weight += h.weight;
      sum.moved += h.weight * h.moved;
    }
  }
  Paths out;
  const float voxel = model.radiance.raw.topology->lattice.spacing;
  for (std::size_t c = 0; c < cell_count(cells); ++c) {
    float weight = 0;
    for (int m = 0; m < kMoments; ++m) weight += sums[c * kMoments + std::size_t(m)].weight / kMoments;
    if (weight < kLeast) continue;
    out.cell.push_back(c);
    out.weight.push_back(weight);
    finish(&sums[c * kMoments], voxel, out.path);
  }
  return out;
}

/// The label that most of the matter in the cells around has; smooths what single cells get wrong.
std::vector<std::int16_t> majority(const Lattice& cells, const std::vector<std::int16_t>& label,
                                   const std::vector<float>& weight, bool fill) {
  std::vector<std::int16_t> out = label;
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (fill == (label[i] >= 0)) continue;
    const Int3 c{int(i / (std::size_t(cells.size.y) * cells.size.z)), int(i / cells.size.z % cells.size.y),
                 int(i % cells.size.z)};
    float votes[kMostClusters] = {};
    for (int x = std::max(c.x - 1, 0); x <= std::min(c.x + 1, cells.size.x - 1); ++x)
      for (int y = std::max(c.y - 1, 0); y <= std::min(c.y + 1, cells.size.y - 1); ++y)
        for (int z = std::max(c.z - 1, 0); z <= std::min(c.z + 1, cells.size.z - 1); ++z) {
          const std::size_t j = (std::size_t(x) * cells.size.y + y) * cells.size.z + z;
          if (label[j] >= 0) votes[label[j]] += std::max(weight[j], 1e-3f);
        }
    const float* best = std::max_element(votes, votes + kMostClusters);
    if (*best > 0) out[i] = std::int16_t(best - votes);
  }
  return out;
}

double rms_path(const float* path) {
  const std::vector<float> zero(kMoments * 3, 0.0f);
  return std::sqrt(trajectory_distance(path, zero.data(), kMoments));
}

/// Cosine between two trajectories, in [-1, 1].
double likeness(const float* a, const float* b) {
  double ab = 0, aa = 0, bb = 0;
  for (int i = 0; i < kMoments * 3; ++i) {
    ab += double(a[i]) * b[i];
    aa += double(a[i]) * a[i];
    bb += double(b[i]) * b[i];
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

}  // namespace

int MotionClusters::at(Vec3 canonical) const {
  const std::ptrdiff_t i = index_of(cells, canonical);
  return i < 0 ? -1 : label[std::size_t(i)];
}

MotionClusters find_clusters(const VoxelModel& model, int count) {
  if (count < 0 || count > kMostClusters)
    fail({"find_clusters", "this is no number of parts", "0 to " + std::to_string(kMostClusters),
          std::to_string(count), ""});
  MotionClusters out;
  const float voxel = model.radiance.raw.topology->lattice.spacing;
  const float spacing = std::max(2 * voxel, model.box.longest_edge() / kMostCells);
  out.cells = {model.box.lo, spacing, {}};
  for (int a = 0; a < 3; ++a) out.cells.size[a] = int(std::ceil(model.box.extent()[a] / spacing)) + 1;
  const Paths paths = find_paths(model, out.cells);
  const std::size_t n = paths.cell.size();
  const auto path = [&](std::size_t i) { return paths.path.data() + i * kMoments * 3; };

  Clustering best;
  if (!model.motion.moves()) count = 1;
  if (count > 0) best = kmeans(paths.path, paths.weight, kMoments, count);
  if (count == 0) {
    std::vector<Clustering> tried;
    double highest = -1;
    for (int k = 2; k <= kMostAuto; ++k) {
      tried.push_back(kmeans(paths.path, paths.weight, kMoments, k));
      highest = std::max(highest, tried.back().silhouette);
    }
    best = *std::find_if(tried.begin(), tried.end(),
                         [&](const Clustering& c) { return c.silhouette >= highest - kWorth; });
  }
  out.silhouette = best.silhouette;

  // Numbered by how much they move. A cell that moves by little is nearest to the static cluster. But the
  // foot of a lever belongs to the lever: it moves the same way, if not as far. So does a cell that moves as
  // far another way. A cell that drifts a little on its own stays static.
  const int k = int(best.centroid.size() / (kMoments * 3));
  const auto centroid = [&](int c) { return best.centroid.data() + std::size_t(c) * kMoments * 3; };
  std::vector<int> order(std::size_t(k), 0), number(std::size_t(k), 0);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin() + 1, order.end(),
                   [&](int a, int b) { return rms_path(centroid(a)) < rms_path(centroid(b)); });
  for (int c = 0; c < k; ++c) number[std::size_t(order[std::size_t(c)])] = c;
  out.label.assign(cell_count(out.cells), -1);
  std::vector<float> weight(out.label.size(), 0.0f);
  for (std::size_t i = 0; i < n; ++i) {
    int found = best.label[i];
    if (rms_path(path(i)) < kStillVoxels)
      found = 0;
    else if (found == 0)
      for (int c = 1; c < k; ++c) {
        const bool moves =
            rms_path(path(i)) >= kMuch * rms_path(centroid(c)) || likeness(path(i), centroid(c)) >= kAlike;
        if (moves && (found == 0 || trajectory_distance(path(i), centroid(c), kMoments) <
                                        trajectory_distance(path(i), centroid(found), kMoments)))
          found = c;
      }
    out.label[paths.cell[i]] = std::int16_t(number[std::size_t(found)]);
    weight[paths.cell[i]] = paths.weight[i];
  }
  out.label = majority(out.cells, out.label, weight, false);
  out.clusters.resize(std::size_t(k));
  double total = 0;
  std::vector<double> mass(std::size_t(k), 0.0), squares(std::size_t(k), 0.0);
  std::vector<Vec3d> place(std::size_t(k), Vec3d{});
  for (std::size_t i = 0; i < n; ++i) {
    const auto c = std::size_t(out.label[paths.cell[i]]);
    const double w = paths.weight[i], r = rms_path(path(i));
    total += w;
    mass[c] += w;
    squares[c] += w * r * r;
    place[c] += w * cast<double>(position_of(out.cells, paths.cell[i]));
  }
  for (std::size_t c = 0; c < out.clusters.size(); ++c)
    if (mass[c] > 0)
      out.clusters[c] = {mass[c] / total, std::sqrt(squares[c] / mass[c]),
                         cast<float>(place[c] * (1 / mass[c]))};
  for (int i = 0; i < kGrow; ++i) out.label = majority(out.cells, out.label, weight, true);
  return out;
}

}  // namespace splinevox
