// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "core/parallel.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

constexpr int kRing = 2;  ///< pixels around what is not ground

Vec3 colour_at(const Picture& image, int x, int y) {
  const auto p = image.rgba(x, y);
  return {p[0] / 65535.0f, p[1] / 65535.0f, p[2] / 65535.0f};
}

bool is_ground(const Vec3& pixel, const Vec3& colour) {
  for (int a = 0; a < 3; ++a)
    if (std::abs(pixel[a] - colour[a]) > kGroundTolerance) return false;
  return true;
}

/// Calls visit(x, y) for the pixels along a picture's border that are not ignored.
template <class Visit>
void visit_border(const Frame& frame, const Visit& of) {
  const Picture& image = frame.image;
  const auto visit = [&](int x, int y) {
    if (!frame.ignored.test(x, y)) of(x, y);
  };
  for (int x = 0; x < image.width; ++x) {
    visit(x, 0);
    if (image.height > 1) visit(x, image.height - 1);
  }
  for (int y = 1; y + 1 < image.height; ++y) {
    visit(0, y);
    if (image.width > 1) visit(image.width - 1, y);
  }
}

/// The most frequent colour along all borders, to a 32nd, and the median of what lies near it.
Vec3 border_mode(const std::vector<const Frame*>& frames) {
  constexpr float kBins = 32;
  std::map<int, std::pair<std::size_t, Vec3d>> bins;
  for (const Frame* f : frames) {
    const ReadAll all_of(f->image);
    visit_border(*f, [&](int x, int y) {
      const Vec3 c = colour_at(f->image, x, y);
      int key = 0;
      for (int a = 0; a < 3; ++a) key = key * int(kBins) + int(std::min(c[a] * kBins, kBins - 1));
      auto& [count, sum] = bins[key];
      ++count;
      sum += cast<double>(c);
    });
  }
  if (bins.empty()) return {};
  const auto most = std::max_element(
      bins.begin(), bins.end(), [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
  const Vec3 centre = cast<float>(1 / double(most->second.first) * most->second.second);
  // The median of what lies near: the mean of a black ground with noise would be grey everywhere.
  constexpr int kLevels = 4096;
  std::array<std::vector<std::size_t>, 3> levels;
  for (auto& l : levels) l.resize(kLevels + 1);
  std::size_t near = 0;
  for (const Frame* f : frames) {
    const ReadAll all_of(f->image);
    visit_border(*f, [&](int x, int y) {
      const Vec3 c = colour_at(f->image, x, y);
      if (!is_ground(c, centre)) return;
      for (int k = 0; k < 3; ++k)
        ++levels[std::size_t(k)][std::size_t(std::min(c[k], 1.0f) * kLevels + 0.5f)];
      ++near;
    });
  }
  if (near == 0) return centre;
  Vec3 median;
  for (int k = 0; k < 3; ++k) {
    std::size_t below = 0, level = 0;
    while ((below += levels[std::size_t(k)][level]) * 2 < near) ++level;
    median[k] = float(level) / kLevels;
  }
  return median;
}

/// Whether each pixel is ground that hangs together with the border. Ignored pixels may be: they are not what
/// stands before it.
std::vector<char> connected_ground(const Frame& frame, const Vec3& colour) {
  const Picture& image = frame.image;
  const int w = image.width, h = image.height;
  std::vector<char> ground(std::size_t(w) * h, 0);
  std::vector<int> open;
  const auto reach = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= w || y >= h) return;
    const std::size_t i = std::size_t(y) * w + x;
    if (ground[i] || !(frame.ignored.test(i) || is_ground(colour_at(image, x, y), colour))) return;
    ground[i] = 1;
    open.push_back(int(i));
  };
  visit_border(frame, reach);
  while (!open.empty()) {
    const int i = open.back(), x = i % w, y = i / w;
    open.pop_back();
    reach(x - 1, y);
    reach(x + 1, y);
    reach(x, y - 1);
    reach(x, y + 1);
  }
  return ground;
}

/// Without what lies within kRing pixels of anything else, along rows and then along columns.
std::vector<char> shrunk(const std::vector<char>& ground, int w, int h) {
  const auto pass = [&](const std::vector<char>& in, int dx, int dy) {
    std::vector<char> out = in;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        for (int k = -kRing; k <= kRing; ++k) {
          const int u = x + k * dx, v = y + k * dy;
          if (u >= 0 && v >= 0 && u < w && v < h && !in[std::size_t(v) * w + u])
            out[std::size_t(y) * w + x] = 0;
        }
    return out;
  };
  return pass(pass(ground, 1, 0), 0, 1);
}

}  // namespace

std::optional<Vec3> find_ground(const Split& train) {
  constexpr double kPlainBorder = 0.75, kPlainPictures = 0.75;
  if (train.frames.empty()) return {};
  const std::vector<const Frame*> frames = some_frames(train);
  const Vec3 colour = border_mode(frames);
  std::size_t plain = 0;
  for (const Frame* f : frames) {
    const ReadAll all_of(f->image);
    std::size_t like = 0, all = 0;
    visit_border(*f, [&](int x, int y) {
      like += is_ground(colour_at(f->image, x, y), colour) ? 1 : 0;
      ++all;
    });
    plain += all > 0 && double(like) >= kPlainBorder * double(all) ? 1 : 0;
  }
  if (double(plain) < kPlainPictures * double(frames.size())) return {};
  return colour;
}

double cut_ground(Split& train, const Vec3& colour) {
  std::vector<double> cut(train.frames.size()), all(train.frames.size());
  parallel_for(int(train.frames.size()), [&](int f) {
    Picture& image = train.frames[f].image;
    const ReadAll all_of(image);
    const std::vector<char> ground =
        shrunk(connected_ground(train.frames[f], colour), image.width, image.height);
    cut[f] = double(std::count(ground.begin(), ground.end(), char(1)));
    all[f] = double(image.pixels());
    image.cut(std::vector<bool>(ground.begin(), ground.end()));
  });
  return std::accumulate(cut.begin(), cut.end(), 0.0) / std::accumulate(all.begin(), all.end(), 1e-9);
}

void undo_cut(Split& train) {
  for (Frame& f : train.frames) f.image.cut({});
}

}  // namespace splinevox
