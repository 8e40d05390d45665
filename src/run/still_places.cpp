// SPDX-License-Identifier: Apache-2.0
#include "run/still_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::run {
namespace {

constexpr int kSmallWidth = 160;   ///< of a small picture, at most
constexpr int kDepths = 64;        ///< tried, even in the picture: by their inverse
constexpr int kGrid = 10;          ///< pixels between patches of a small picture
constexpr int kHalf = 2;           ///< a patch has 2 kHalf + 1 samples along an edge
constexpr double kSpacing = 1.5;   ///< pixels between them
constexpr double kTexture = 0.02;  ///< least standard deviation of a patch, of white
constexpr double kAgree = 0.85;    ///< least correlation of two patches that show the same
constexpr double kAlike = 0.08;    ///< most difference of their means
constexpr double kNearest = 0.05;  ///< of the box's edge: nothing is nearer to a camera
constexpr double kInfinite = 1e4;  ///< edges of the box
constexpr int kPatchSamples = (2 * kHalf + 1) * (2 * kHalf + 1);

using Patch = std::array<float, kPatchSamples>;

/// Mean, and the root of the mean square of what is left without it.
struct Spread {
  double mean = 0, deviation = 0;
};
Spread spread_of(const Patch& patch) {
  double sum = 0, square = 0;
  for (const float v : patch) {
    sum += v;
    square += double(v) * v;
  }
  const double mean = sum / kPatchSamples;
  return {mean, std::sqrt(std::max(0.0, square / kPatchSamples - mean * mean))};
}

double correlation(const Patch& a, const Spread& of_a, const Patch& b, const Spread& of_b) {
  double sum = 0;
  for (std::size_t i = 0; i < kPatchSamples; ++i) sum += (a[i] - of_a.mean) * (b[i] - of_b.mean);
  return sum / (kPatchSamples * of_a.deviation * of_b.deviation);
}

/// Linear between pixel centres; none outside of them.
std::optional<float> value_at(const Image& grey, double u, double v) {
  const double x = u - 0.5, y = v - 0.5;
  if (!(x >= 0 && y >= 0 && x < grey.width - 1 && y < grey.height - 1)) return {};
  const int i = int(x), j = int(y);
  const float a = float(x - i), b = float(y - j);
  const float *top = grey.pixel(i, j), *bottom = grey.pixel(i, j + 1);
  return (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
}

/// The samples of a patch around a pixel's centre: values, and directions whose part along the axis is 1.
struct Source {
  Patch values;
  Spread spread;
  std::array<Vec3d, kPatchSamples> direction;
};
Source source_at(const SmallPicture& picture, double u, double v) {
  Source out;
  std::size_t i = 0;
  for (int y = -kHalf; y <= kHalf; ++y)
    for (int x = -kHalf; x <= kHalf; ++x, ++i) {
      const double pu = u + kSpacing * x, pv = v + kSpacing * y;
      out.values[i] = value_at(picture.grey, pu, pv).value_or(0);
      const Vec3d d = camera_ray(picture.camera, pu, pv).direction;
      out.direction[i] = (-1 / dot(d, picture.camera.axes[2])) * d;
    }
  out.spread = spread_of(out.values);
  return out;
}

/// How alike a patch is to what another picture shows where it would be at a depth; below kAgree: not.
double likeness(const Source& source, const Vec3d& origin, double depth, const SmallPicture& other) {
  Patch seen;
  for (std::size_t i = 0; i < kPatchSamples; ++i) {
    const Projection p = project(other.camera, origin + depth * source.direction[i]);
    if (p.depth <= 0) return 0;
    const std::optional<float> value = value_at(other.grey, p.u, p.v);
    if (!value) return 0;
    seen[i] = *value;
  }
  const Spread spread = spread_of(seen);
  if (spread.deviation < 0.5 * kTexture || std::abs(spread.mean - source.spread.mean) > kAlike) return 0;
  return correlation(source.values, source.spread, seen, spread);
}

}  // namespace

SmallPicture small_picture(const Frame& frame, const Vec3& background) {
  const ReadAll all_of(frame.image);
  const int k = std::clamp((frame.image.width + kSmallWidth - 1) / kSmallWidth, 1,
                           std::max(1, std::min(frame.image.width, frame.image.height)));
  SmallPicture out{frame.camera, frame.time, k, Image(frame.image.width / k, frame.image.height / k, 1)};
  Camera& c = out.camera;
  c.width = out.grey.width;
  c.height = out.grey.height;
  for (double* length : {&c.fx, &c.fy, &c.cx, &c.cy}) *length /= k;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      float sum = 0;
      for (int j = 0; j < k; ++j)
        for (int i = 0; i < k; ++i) {
          const Vec3 rgb = composite(frame.image, k * x + i, k * y + j, background);
          sum += 0.299f * rgb.x + 0.587f * rgb.y + 0.114f * rgb.z;
        }
      *out.grey.pixel(x, y) = sum / float(k * k);
    }
  return out;
}

PatchEvidence::PatchEvidence(const Split& train, const Box& box, const Vec3& background,
                             std::vector<double> times)
    : box_(box), times_(std::move(times)), pictures_(times_.size()) {
  parallel_for(int(times_.size()), [&](int t) {
    const double time = times_[std::size_t(t)];
    const auto nearest = std::min_element(
        train.frames.begin(), train.frames.end(),
        [&](const Frame& a, const Frame& b) { return std::abs(a.time - time) < std::abs(b.time - time); });
    pictures_[std::size_t(t)] = small_picture(*nearest, background);
  });
}

std::vector<double> PatchEvidence::depths_of(const Camera& camera) const {
  const double edge = box_.longest_edge();
  double near = HUGE_VAL;
  for (int corner = 0; corner < 8; ++corner)
    near = std::min(near,
                    project(camera, {corner & 1 ? box_.hi.x : box_.lo.x, corner & 2 ? box_.hi.y : box_.lo.y,
                                     corner & 4 ? box_.hi.z : box_.lo.z})
                        .depth);
  near = std::max(near, kNearest * edge);
  std::vector<double> out{kInfinite * edge};
  for (int i = 1; i < kDepths; ++i) out.push_back(near * (kDepths - 1) / i);
  return out;
}

std::vector<PatchEvidence::Proof> PatchEvidence::proofs(const SmallPicture& picture, const PixelMask& ignored,
                                                        std::size_t& asked) const {
  const Camera& camera = picture.camera;
  const std::vector<double> depths = depths_of(camera);
  std::vector<int> others;
  for (std::size_t t = 0; t < times_.size(); ++t)
    if (std::abs(times_[t] - picture.time) >= kOtherTime) others.push_back(int(t));
  constexpr int kMargin = int(kHalf * kSpacing) + 1;
  std::vector<std::pair<int, int>> corners;
  for (int y = kMargin; y < camera.height - kMargin; y += kGrid)
    for (int x = kMargin; x < camera.width - kMargin; x += kGrid)
      if (!ignored.test(picture.factor * x, picture.factor * y)) corners.emplace_back(x, y);

  const auto proved = [&](double u, double v, const Source& source) {
    Proof best{{0, u, v, {}}, {}};
    int most = 0;
    double best_sum = 0;
    for (const double depth : depths) {
      std::vector<bool> still(times_.size());
      int count = 0;
      double sum = 0;
      for (const int t : others) {
        const double like = likeness(source, camera.position, depth, pictures_[std::size_t(t)]);
        if (like < kAgree) continue;
        still[std::size_t(t)] = true;
        ++count;
        sum += like;
      }
      if (count < kFewestTimes || count < most || (count == most && sum <= best_sum)) continue;
      best.place.still = std::move(still);
      best.at = camera.position + depth * source.direction[kPatchSamples / 2];
      most = count;
      best_sum = sum;
    }
    return best;
  };
  std::vector<std::optional<Proof>> found(corners.size());
  parallel_for(int(corners.size()), [&](int i) {
    const double u = corners[std::size_t(i)].first + 0.5, v = corners[std::size_t(i)].second + 0.5;
    const Source source = source_at(picture, u, v);
    if (source.spread.deviation >= kTexture) found[std::size_t(i)] = proved(u, v, source);
  });
  std::vector<Proof> out;
  for (std::optional<Proof>& proof : found) {
    if (!proof) continue;
    asked += others.size();
    if (!proof->place.still.empty()) out.push_back(std::move(*proof));
  }
  return out;
}

StillPlaces PatchEvidence::places(const std::vector<SmallPicture>& pictures,
                                  const std::vector<PixelMask>& ignored) const {
  StillPlaces out;
  const double cell = box_.longest_edge() / kStillCells;
  std::map<std::array<double, 3>, std::vector<bool>> known;
  std::vector<Proof> all;
  const auto key = [&](const Vec3d& p) {
    return std::array<double, 3>{std::floor(p.x / cell), std::floor(p.y / cell), std::floor(p.z / cell)};
  };
  for (std::size_t k = 0; k < pictures.size(); ++k)
    for (Proof& proof : proofs(pictures[k], ignored[k], out.asked)) {
      proof.place.picture = k;
      std::vector<bool>& there = known[key(proof.at)];
      there.resize(times_.size());
      for (std::size_t t = 0; t < times_.size(); ++t)
        if (proof.place.still[t] || std::abs(times_[t] - pictures[k].time) < kOtherTime) there[t] = true;
      all.push_back(std::move(proof));
    }
  for (Proof& proof : all) {
    StillPlace& place = proof.place;
    place.still = known[key(proof.at)];
    for (std::size_t t = 0; t < times_.size(); ++t)
      if (std::abs(times_[t] - pictures[place.picture].time) < kOtherTime) place.still[t] = false;
    out.places.push_back(std::move(place));
  }
  return out;
}

}  // namespace splinevox::run
