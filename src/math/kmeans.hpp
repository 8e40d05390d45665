// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/rng.hpp"

namespace splinevox {

/// Squared distance of two trajectories: mean over their moments of the squared distance of the places, so
/// that its unit is that of a place squared, whatever the number of moments.
/// @param a, b  [moments * 3]
inline double trajectory_distance(const float* a, const float* b, int moments) {
  double sum = 0;
  for (int i = 0; i < 3 * moments; ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
  return sum / moments;
}

/// Clusters of weighted trajectories.
struct Clustering {
  std::vector<int> label;       ///< [n] in [0, k)
  std::vector<float> centroid;  ///< [k * moments * 3]
  double silhouette =
      0;  ///< in [-1, 1]: how much nearer trajectories are to their own centroid than to the next
};

/// k-means (Lloyd) from k-means++ seeds (Arthur, Vassilvitskii 2007); the draws are functions of `seed`
/// alone. Cluster 0 is fixed: it is static, its centroid is zero.
///
/// The silhouette is the simplified one (Hruschka et al. 2004): the weighted mean of (b - a) / max(a, b), a
/// the distance to the own centroid and b to the nearest other.
/// @param k  >= 1, cluster 0 included. Fewer come out where there are fewer different trajectories: the
/// others have no member.
inline Clustering kmeans(const std::vector<float>& trajectories, const std::vector<float>& weights,
                         int moments, int k, std::uint64_t seed = 1) {
  constexpr int kRounds = 50;
  const std::size_t n = weights.size(), dim = std::size_t(moments) * 3;
  Clustering out;
  out.label.assign(n, 0);
  out.centroid.assign(dim, 0.0f);
  const auto row = [&](std::size_t i) { return trajectories.data() + i * dim; };
  std::vector<double> nearest(n);
  for (std::size_t i = 0; i < n; ++i) nearest[i] = trajectory_distance(row(i), out.centroid.data(), moments);
  const Rng rng(seed, 0);
  for (int c = 1; c < k; ++c) {
    double total = 0;
    for (std::size_t i = 0; i < n; ++i) total += weights[i] * nearest[i];
    if (!(total > 0)) break;
    double left = rng.uniform(std::uint64_t(c)) * total;
    std::size_t chosen = n;
    for (std::size_t i = 0; i < n; ++i) {
      if (!(weights[i] * nearest[i] > 0)) continue;
      chosen = i;
      if ((left -= weights[i] * nearest[i]) < 0) break;
    }
    out.centroid.insert(out.centroid.end(), row(chosen), row(chosen) + dim);
    for (std::size_t i = 0; i < n; ++i)
      nearest[i] = std::min(nearest[i], trajectory_distance(row(i), row(chosen), moments));
  }
  const int found = int(out.centroid.size() / dim);
  const auto centroid = [&](int c) { return out.centroid.data() + std::size_t(c) * dim; };
  for (int round = 0; round < kRounds; ++round) {
    bool changed = round == 0;
    double score = 0, total = 0;
    std::vector<double> sum(out.centroid.size(), 0.0), mass(std::size_t(found), 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      double a = std::numeric_limits<double>::infinity(), b = a;
      int best = 0;
      for (int c = 0; c < found; ++c) {
        const double d = trajectory_distance(row(i), centroid(c), moments);
        if (d < a) {
          b = a;
          a = d;
          best = c;
        } else if (d < b)
          b = d;
      }
      changed |= best != out.label[i];
      out.label[i] = best;
      mass[std::size_t(best)] += weights[i];
      for (std::size_t j = 0; j < dim; ++j)
        sum[std::size_t(best) * dim + j] += double(weights[i]) * row(i)[j];
      if (found > 1 && b > 0) score += weights[i] * (1 - std::sqrt(a / b));
      total += weights[i];
    }
    out.silhouette = total > 0 ? score / total : 0;
    if (!changed) break;
    for (int c = 1; c < found; ++c)
      for (std::size_t j = 0; j < dim && mass[std::size_t(c)] > 0; ++j)
        centroid(c)[j] = float(sum[std::size_t(c) * dim + j] / mass[std::size_t(c)]);
  }
  return out;
}

}  // namespace splinevox
