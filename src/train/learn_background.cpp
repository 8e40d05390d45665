// SPDX-License-Identifier: Apache-2.0
#include "train/learn_background.hpp"

#include <algorithm>

#include "field/learn_kernels.hpp"
#include "math/background_color.hpp"
#include "math/logit.hpp"
#include "math/sh.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

/// Colour at the raw values of band 0, all others left out.
Vec3 mean_color(const Background& b) {
  return background_color(0, b.raw, Vec3{}).value;
}  // band 0 is the same everywhere

Vec3 border_color(const Split& train) {
  Vec3d sum{};
  double count = 0;
  for (const Frame* f : some_frames(train)) {
    const Picture& image = f->image;
    const ReadAll all_of(image);
    for (int y = 0; y < image.height; ++y) {
      const bool whole = y == 0 || y == image.height - 1;
      for (int x = 0; x < image.width; x += whole ? 1 : std::max(1, image.width - 1)) {
        if (f->ignored.test(x, y)) continue;
        const auto p = image.rgba(x, y);
        sum += 1 / 65535.0 * Vec3d{double(p[0]), double(p[1]), double(p[2])};
        ++count;
      }
    }
  }
  return cast<float>(1 / std::max(1.0, count) * sum);
}

}  // namespace

bool learns_background(const Config& config, const PictureStats& stats) {
  return config.run.background_order >= 0 && !stats.see_through;
}

Background starting_background(const Config& config, const Split& train, const PictureStats& stats,
                               float unit) {
  const std::vector<float>& c = config.run.background;
  Background out{.color = {c[0], c[1], c[2]}};
  if (!learns_background(config, stats)) return out;
  constexpr float kEnd =
      1 / 512.0f;  // half a step of 8 bits: neither black nor white is in reach of a sigmoid
  out.order = config.run.background_order;
  float band0;
  sh_basis(0, Vec3{}, &band0);
  const Vec3 start = border_color(train);
  for (int a = 0; a < 3; ++a) out.raw[0][a] = logit(std::clamp(start[a], kEnd * unit, 1 - kEnd)) / band0;
  out.color = mean_color(out);
  return out;
}

void update(Background& background, BackgroundLearner& learner, const BackgroundGradient& gradient,
            const MomentFactors& factors, float rate) {
  for (int j = 0; j < background.count(); ++j)
    for (int a = 0; a < 3; ++a)
      adam_step(factors, rate, float(gradient[j][a]), learner.m[j][a], learner.v[j][a], background.raw[j][a],
                PlainRoot{}, PlainFlush{});
  background.color = mean_color(background);
}

}  // namespace splinevox
