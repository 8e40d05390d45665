// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.hpp"
#include "field/largest_presence.hpp"
#include "math/logit.hpp"
#include "splinevox/field/edit.hpp"

namespace splinevox {
namespace {

/// Calls visit(row, place) for every radiance row whose place belongs to a chosen cluster, or to none if
/// `others`.
template <class Visit>
void for_each_row(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                  bool others, Visit&& visit) {
  Channels& raw = model.radiance.raw;
  parallel_for(raw.topology->brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 place = raw.topology->position(index + 1, i);
      const int label = clusters.at(place);
      const bool member = label >= 0 && chosen[std::size_t(label)];
      if (member != others) visit(raw.row(std::size_t(index + 1) * kBrickRows + std::size_t(i)), place);
    }
  });
}

/// Empty at all times: what comes and goes must not bring them back.
void empty_rows(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                bool others) {
  const LargestPresence presence(model);
  const float empty = model.radiance.raw.row(0)[0], reach = model.radiance.raw.topology->lattice.spacing;
  for_each_row(model, clusters, chosen, others, [&](float* row, const Vec3& place) {
    row[0] = std::min(row[0], empty - presence.around(place, reach));
  });
}

/// The view factor 1 - sigmoid(0) / 2 of no harmonics is 3/4 everywhere.
float flat_factor(const VoxelModel& model) { return model.radiance.sh_order >= 0 ? 0.75f : 1.0f; }

}  // namespace

void hide_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen) {
  empty_rows(model, clusters, chosen, false);
}

void keep_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen) {
  empty_rows(model, clusters, chosen, true);
}

Vec3 paintable(const VoxelModel& model, Vec3 color) {
  const float factor = flat_factor(model);
  for (int a = 0; a < 3; ++a) color[a] = factor * std::clamp(color[a] / factor, 0.01f, 0.99f);
  return color;
}

void paint_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                    Vec3 color) {
  const Vec3 possible = paintable(model, color);
  float raw[3];
  for (int a = 0; a < 3; ++a) raw[a] = logit(possible[a] / flat_factor(model));
  for_each_row(model, clusters, chosen, false, [&](float* row, const Vec3&) {
    for (int a = 0; a < 3; ++a) row[1 + a] = raw[a];
    std::fill_n(row + 4, model.radiance.sh_count(), 0.0f);
  });
}

RigidMotion rotation(const Vec3d& axis, double degrees, const Vec3d& pivot) {
  // Rodrigues' formula.
  const Vec3d u = normalize(axis);
  const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  RigidMotion g;
  g.pivot = pivot;
  const Vec3d unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int j = 0; j < 3; ++j) {
    const Vec3d column = c * unit[j] + s * cross(u, unit[j]) + ((1 - c) * u[j]) * u;
    for (int i = 0; i < 3; ++i) g.turn[i][j] = column[i];
  }
  return g;
}

}  // namespace splinevox
