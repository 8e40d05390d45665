// SPDX-License-Identifier: Apache-2.0
#include "train/learn_surroundings.hpp"

#include <algorithm>
#include <cmath>

#include "backend/host/optimiser.hpp"
#include "core/parallel.hpp"
#include "math/logit.hpp"
#include "train/refine.hpp"

namespace splinevox {
namespace {

constexpr float kFaintest = 2e-4f;  ///< gradient behind a ray, of brightness: an error of a tenth behind an
                                    ///< alpha of 0.999

float max_abs(const Vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

Surroundings starting_surroundings(const Config& config, const Box& box, const Background& background,
                                   const PictureStats& stats, float unit) {
  Surroundings out;
  if (!learns_surroundings(config, stats)) return out;
  out.box = box;
  out.shift = float(inverse_softplus(optical_depth(config.radiance.outer_alpha)));
  float row[OuterWalk::kWidth] = {};
  for (int c = 0; c < 3; ++c) row[1 + c] = logit(std::clamp(background.color[c], 0.01f * unit, 0.99f));
  out.raw = make_channels(outer_topology(config.grid.surroundings[0]), OuterWalk::kWidth, row);
  for (int i = 0; i < kBrickRows; ++i) out.raw.row(i)[0] = kEmptyDensity;
  return out;
}

SurroundingsLearner::SurroundingsLearner(const Config& config, const Surroundings& surroundings, float unit)
    : unit_(unit) {
  begin(config, surroundings);
}

void SurroundingsLearner::begin(const Config& config, const Surroundings& surroundings) {
  learner_ = Learner(surroundings.raw);
  gradient_ = Gradient(surroundings.raw);
  learner_.rate[0] = config.optimiser.lr_density;
  learner_.tv[0] = config.loss.tv_density;
  for (std::size_t c = 1; c < 4; ++c) {
    learner_.rate[c] = config.optimiser.lr_color;
    learner_.tv[c] = config.loss.tv_color;
  }
}

void SurroundingsLearner::step(const Config& config, std::span<const Ray> rays, std::span<Vec3> behind,
                               const Background& background, const StepInput& in,
                               Surroundings& surroundings) {
  const int count = int(rays.size()), tasks = (count + kTaskRays - 1) / kTaskRays;
  const BrickView<float> view(*surroundings.raw.topology);
  const float least = config.sampling.min_weight, faintest = kFaintest * unit_;
  records_.resize(std::size_t(tasks));
  scatter_.begin(tasks, surroundings.raw.topology->brick_count() + 1);
  parallel_for(tasks, [&](int t) {
    OuterWalk walk(surroundings);
    Walked& records = records_[std::size_t(t)];
    records.clear();
    for (int i = t * kTaskRays; i < std::min(count, (t + 1) * kTaskRays); ++i) {
      if (!(max_abs(behind[i]) > faintest)) {  // next to nothing of it shows
        behind[i] = {};
        continue;
      }
      const Vec3 far = background.towards(cast<float>(rays[i].direction));
      walk.forward(rays[i], far);
      walk.backward(far, behind[i], [&](const OuterWalk::Sample& s, const EmissionAdjoint<float>& d) {
        if (s.weight < least) return;
        records.push_back({s.cell, s.fraction, {d.density, d.color[0], d.color[1], d.color[2]}, {}});
      });
      behind[i] *= walk.transmittance;
    }
    scatter_.count(t, records, view, 0);
  });
  scatter_.scan();
  parallel_for(tasks, [&](int t) { scatter_.fill(t, view); });
  parallel_for(surroundings.raw.topology->brick_count() + 1, [&](int b) {
    if (b > 0 && !scatter_.empty(b))
      scatter_.reduce(b, gradient_.values.row(std::size_t(b) * kBrickRows),
                      gradient_.touched[std::size_t(b)]);
  });
  add_total_variation(surroundings.raw, learner_.tv, in.tv_scale, in.tv_share, in.draw + 64, {}, gradient_);
  update(learned(surroundings.raw, learner_), gradient_, in.factors, in.radiance_rate);
}

void SurroundingsLearner::refine(const Config& config, double progress, Surroundings& surroundings) {
  const int due = reached(config.grid.surroundings_start, progress);
  if (due <= stage_) return;
  stage_ = due;
  // What is next to nothing stays nothing from here on.
  constexpr float kLeastAlpha = 2e-3f;  // of a sample, that keeps the bricks around it
  const float raw = raw_of_alpha(kLeastAlpha, 1, surroundings.shift, 1);
  learner_ = {};
  gradient_ = {};
  surroundings.raw = resample(surroundings.raw, outer_topology(config.grid.surroundings[std::size_t(due)]));
  const std::vector<std::int32_t> bricks = bricks_above(surroundings.raw, raw);
  surroundings.raw.topology = keep_bricks(*surroundings.raw.topology, bricks);
  keep_rows(bricks, surroundings.raw.width, surroundings.raw.values);
  surroundings.raw.values.shrink_to_fit();
  begin(config, surroundings);
}

bool SurroundingsLearner::archive(Archive& a, const Config& config, Surroundings& surroundings) {
  a(stage_, surroundings.box, surroundings.shift, surroundings.raw);
  if (a.reading()) begin(config, surroundings);
  a(learner_.m, learner_.v);
  return surroundings.raw.width == OuterWalk::kWidth && learner_.m.size() == surroundings.raw.values.size() &&
         learner_.v.size() == learner_.m.size();
}

}  // namespace splinevox
