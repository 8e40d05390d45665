// SPDX-License-Identifier: Apache-2.0
#include "train/still/still_cameras.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "math/quantile.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

constexpr int kFewestMoments = 3;
constexpr int kMostBlocks = 256;     ///< along a picture
constexpr int kMostLooks = 33;       ///< moments that make the still picture
constexpr int kChannels = 4;         ///< colour times alpha, and alpha
constexpr float kFloor = 0.03f;      ///< of brightness: smaller differences prove nothing
constexpr float kSure = 5;           ///< standard deviations of the noise
constexpr int kFewestBeside = 3;     ///< of a block's eight neighbours that differ with it
constexpr float kBlind = 0.15f;      ///< of brightness: noise beyond which a change could hide
constexpr float kQuarter = 0.3186f;  ///< of |x|, x normal of deviation 1: a quarter of all is below
constexpr double kStands = 0.03;     ///< blocks of shift, below which a camera stands still
constexpr float kSharper = 0.3f;  ///< of the range beside a block: one picture is sharper than their median
constexpr float kFlicker = 0.3f;  ///< a larger change of most of a picture is none of its exposure
constexpr float kLit = 0.1f;      ///< of brightness, to measure exposure by

constexpr double kMoved = 0.4;  ///< of the blocks: when they differ, the camera does not stand still

constexpr float kIgnored = std::numeric_limits<float>::quiet_NaN();

using Values = std::vector<float>;  ///< [channels][height][width]

/// A camera's pictures in blocks.
struct Film {
  const Split& split;
  StillCamera& camera;
  float unit;  ///< of brightness

  std::size_t blocks() const { return std::size_t(camera.width) * camera.height; }

  /// Means over blocks, colours in the unit; of large ones over four pixels of them. Not a number where a
  /// mask ignores one of them.
  Values values(int frame) const {
    const Picture& picture = split.frames[std::size_t(frame)].image;
    const PixelMask& ignored = split.frames[std::size_t(frame)].ignored;
    const ReadAll all_of(picture);
    const int step = std::max(1, camera.factor / 2), f = camera.factor;
    const float level = 1 / 65535.0f / unit;
    Values out(kChannels * blocks());
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        std::array<float, kChannels> sum{};
        int count = 0;
        for (int v = y * f; v < (y + 1) * f; v += step)
          for (int u = x * f; u < (x + 1) * f; u += step) {
            const auto p = picture.rgba(u, v);
            const float alpha = ignored.test(u, v) ? kIgnored : p[3] * (1 / 65535.0f);
            for (std::size_t c = 0; c < 3; ++c) sum[c] += alpha * p[c] * level;
            sum[3] += alpha;
            ++count;
          }
        for (std::size_t c = 0; c < kChannels; ++c)
          out[c * blocks() + std::size_t(y) * camera.width + x] = sum[c] / float(count);
      }
    return out;
  }
};

/// Brings a picture to the brightness of the still one, each channel by the median of its blocks' ratios.
/// @return the largest change, a share
float expose(const Values& still, std::size_t blocks, Values& picture) {
  float most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> ratios;
    for (std::size_t i = c * blocks; i < (c + 1) * blocks; ++i)
      if (still[i] > kLit && picture[i] > kLit / 4) ratios.push_back(picture[i] / still[i]);
    if (ratios.empty()) continue;
    const float gain = quantile(ratios, 0.5);
    most = std::max(most, std::abs(gain - 1));
    if (std::abs(gain - 1) > kFlicker) continue;
    for (std::size_t i = c * blocks; i < (c + 1) * blocks; ++i) picture[i] /= gain;
  }
  return most;
}

Values median_of(const std::vector<Values>& pictures) {
  Values out(pictures.front().size());
  parallel_for(int((out.size() + 1023) / 1024), [&](int group) {
    std::vector<float> course;
    for (std::size_t i = std::size_t(group) * 1024; i < std::min(out.size(), std::size_t(group + 1) * 1024);
         ++i) {
      course.clear();
      for (const Values& picture : pictures)
        if (!std::isnan(picture[i])) course.push_back(picture[i]);
      out[i] = course.empty() ? kIgnored : quantile(course, 0.5);
    }
  });
  return out;
}

/// The still picture, and how it changes from a block to those beside it.
struct Still {
  Values values, along_x, along_y;
  std::vector<std::uint8_t> matter;  ///< [blocks]: it shows something; noise is measured there
};

Still still_of(const Film& film, Values values) {
  const int w = film.camera.width, h = film.camera.height;
  const std::size_t n = film.blocks();
  Still out{std::move(values), Values(kChannels * n), Values(kChannels * n), std::vector<std::uint8_t>(n)};
  for (std::size_t c = 0; c < kChannels; ++c)
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const auto at = [&](int u, int v) {
          return out.values[c * n + std::size_t(std::clamp(v, 0, h - 1)) * w + std::clamp(u, 0, w - 1)];
        };
        const std::size_t i = c * n + std::size_t(y) * w + x;
        out.along_x[i] = 0.5f * (at(x + 1, y) - at(x - 1, y));
        out.along_y[i] = 0.5f * (at(x, y + 1) - at(x, y - 1));
      }
  for (std::size_t i = 0; i < n; ++i) out.matter[i] = out.values[3 * n + i] > 0.5f;
  if (std::none_of(out.matter.begin(), out.matter.end(), [](std::uint8_t m) { return m; }))
    std::fill(out.matter.begin(), out.matter.end(), 1);
  return out;
}

/// By how many blocks the whole picture has shifted: least squares, in which large differences count little
/// (Lucas and Kanade 1981). @param noise  of a value
double shift_of(const Still& still, const Values& differences, float noise) {
  const double usual = std::max(0.5f * kFloor, 3 * noise);
  double dx = 0, dy = 0;
  for (int round = 0; round < 4; ++round) {
    double xx = 1e-9, xy = 0, yy = 1e-9, xr = 0, yr = 0;
    for (std::size_t i = 0; i < differences.size(); ++i) {
      const double x = still.along_x[i], y = still.along_y[i], r = differences[i],
                   left = (r - dx * x - dy * y) / usual, weight = 1 / (1 + left * left);
      if (std::isnan(left)) continue;
      xx += weight * x * x;
      xy += weight * x * y;
      yy += weight * y * y;
      xr += weight * x * r;
      yr += weight * y * r;
    }
    const double det = xx * yy - xy * xy;
    if (det <= 1e-12) return 0;
    dx = (yy * xr - xy * yr) / det;
    dy = (xx * yr - xy * xr) / det;
  }
  return std::hypot(dx, dy);
}

/// Of a block and those within a distance of it, per channel.
struct Range {
  float lo, hi;
};

Range range(const Film& film, const Values& values, std::size_t channel, int x, int y, int reach) {
  const float* const v = values.data() + channel * film.blocks();
  const int w = film.camera.width;
  Range out{v[y * w + x], v[y * w + x]};
  for (int b = std::max(0, y - reach); b <= std::min(film.camera.height - 1, y + reach); ++b)
    for (int a = std::max(0, x - reach); a <= std::min(w - 1, x + reach); ++a) {
      out.lo = std::min(out.lo, v[b * w + a]);
      out.hi = std::max(out.hi, v[b * w + a]);
    }
  return out;
}

/// Blocks that differ together with some beside them: noise and what is left of a shift come alone.
BlockMap together(const BlockMap& differs, int w, int h) {
  BlockMap out(differs.size());
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (!differs[std::size_t(y) * w + x]) continue;
      int beside = -1;
      for (int v = std::max(0, y - 1); v <= std::min(h - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(w - 1, x + 1); ++u)
          beside += differs[std::size_t(v) * w + u];
      out[std::size_t(y) * w + x] = beside >= kFewestBeside;
    }
  return out;
}

/// What a picture shows otherwise than the still one does.
struct Difference {
  BlockMap differs, unknown;
  float flicker;
};

Difference difference(const Film& film, const Still& still, Values picture) {
  const std::size_t n = film.blocks();
  const int w = film.camera.width, h = film.camera.height;
  Difference out{BlockMap(n), BlockMap(n), expose(still.values, n, picture)};
  Values differences = picture;
  std::vector<float> sizes;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    differences[i] -= still.values[i];
    if (i < 3 * n && still.matter[i % n] && !std::isnan(differences[i]))
      sizes.push_back(std::abs(differences[i]));
  }
  const float noise = quantile(sizes, 0.25) / kQuarter;
  const double shift = shift_of(still, differences, noise);
  const int reach = shift < kStands ? 0 : 1 + std::min(2, int(shift));
  const float least = std::max(kFloor, kSure * noise);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::size_t i = std::size_t(y) * w + x;
      float hidden = least;
      for (std::size_t c = 0; c < kChannels; ++c) {
        const Range r = range(film, still.values, c, x, y, reach);
        const float beyond = least + kSharper * (r.hi - r.lo), value = picture[c * n + i];
        out.differs[i] |= value < r.lo - beyond || value > r.hi + beyond;
        hidden = std::max(hidden, beyond + r.hi - r.lo);
      }
      out.unknown[i] = hidden > kBlind || std::isnan(differences[i]);
    }
  out.differs = together(out.differs, w, h);
  return out;
}

void look(const Split& split, StillCamera& camera, float unit) {
  const Frame& first = split.frames[std::size_t(camera.frames.front())];
  const int longest = std::max(first.image.width, first.image.height);
  camera.factor = std::max(1, (longest + kMostBlocks - 1) / kMostBlocks);
  camera.width = first.image.width / camera.factor;
  camera.height = first.image.height / camera.factor;
  const Film film{split, camera, unit};
  const std::size_t n = film.blocks();
  const int count = int(camera.frames.size()), looks = std::min(count, kMostLooks);
  std::vector<Values> pictures{std::size_t(looks)};
  parallel_for(looks, [&](int i) {
    pictures[std::size_t(i)] =
        film.values(camera.frames[std::size_t(i) * std::size_t(count - 1) / std::size_t(looks - 1)]);
  });
  const Values rough = median_of(pictures);
  for (Values& picture : pictures) expose(rough, n, picture);
  const Still still = still_of(film, median_of(pictures));
  pictures.clear();

  camera.now.resize(std::size_t(count));
  camera.ever.assign(n, 0);
  camera.unknown.assign(n, 0);
  std::vector<Difference> found{std::size_t(count)};
  parallel_for(count, [&](int i) {
    found[std::size_t(i)] = difference(film, still, film.values(camera.frames[std::size_t(i)]));
  });
  for (std::size_t f = 0; f < found.size(); ++f) {
    for (std::size_t i = 0; i < n; ++i) {
      camera.ever[i] |= found[f].differs[i];
      camera.unknown[i] |= found[f].unknown[i];
    }
    camera.most = std::max(camera.most, share_of(found[f].differs));
    camera.flicker = std::max(camera.flicker, double(found[f].flicker));
    camera.now[f].assign(found[f].differs.begin(), found[f].differs.end());
  }
  camera.share = share_of(camera.ever);
}

}  // namespace

CoarseMask StillCamera::changing(std::size_t moment) const {
  CoarseMask out{PixelMask(width, height), factor};
  for (std::size_t i = 0; i < now[moment].size(); ++i)
    if (now[moment][i]) out.squares.set(i);
  return out;
}

double share_of(const BlockMap& map) {
  return double(std::count(map.begin(), map.end(), 1)) / double(map.size());
}

std::vector<StillCamera> still_cameras(const Split& split, float unit) {
  std::map<int, StillCamera> by_id;
  for (const int f : frames_by_time(split))
    if (const int id = split.frames[std::size_t(f)].camera_id; id >= 0) by_id[id].frames.push_back(f);
  std::vector<StillCamera> out;
  for (auto& [id, camera] : by_id) {
    const auto frame = [&](int f) -> const Frame& { return split.frames[std::size_t(f)]; };
    int moments = 1;
    bool still = true;
    for (std::size_t i = 1; i < camera.frames.size(); ++i) {
      const Frame &before = frame(camera.frames[i - 1]), &now = frame(camera.frames[i]);
      moments += now.time != before.time;
      still &= stand_alike(now.camera, frame(camera.frames[0]).camera) &&
               now.image.width == before.image.width && now.image.height == before.image.height;
    }
    if (!still || moments < kFewestMoments) continue;
    look(split, camera, unit);
    if (camera.most < kMoved) out.push_back(std::move(camera));
  }
  return out;
}

}  // namespace splinevox
