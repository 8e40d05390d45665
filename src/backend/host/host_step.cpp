// SPDX-License-Identifier: Apache-2.0
#include "backend/host/host_step.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "backend/background_gradient.hpp"
#include "backend/host/optimiser.hpp"
#include "backend/host/sum_ranks.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"

namespace splinevox {
namespace {

/// Room for the gradient of an array; all zero between steps, so that of the same rows can stay.
void fit(Gradient& gradient, const Channels& of) {
  if (gradient.values.topology == of.topology && gradient.values.width == of.width) return;
  gradient = {};  // not both the old lattice's and the new one's
  gradient = Gradient(of);
}

}  // namespace

void HostStep::upload(const StepModel& model) {
  model_ = model;
  marks_.assign(model.radiance.visible.size(), {});
  fit(radiance_, *model.radiance.values);
  levels_.resize(model.levels.size());
  for (std::size_t l = 0; l < levels_.size(); ++l) fit(levels_[l], *model.levels[l].values);
}

StepSums HostStep::run(const StepInput& in) {
  StepSums out;
  Stopwatch watch;
  choose_engine(in.losses);
  if (moving()) {
    std::vector<const Channels*> levels;
    for (const LearnedRows& level : model_.levels) levels.push_back(level.values);
    sums_.make(levels, model_.active->rows);
  }
  out.slice_seconds += watch.lap();

  // The finest level takes the gradient of the sum of all levels as it is.
  const std::vector<RayTask> tasks = own(in.tasks), tracks = own(in.tracks.tasks);
  behind_.assign(in.background->learned() || !in.behind.empty() ? in.rays.size() : 0, Vec3{});
  if (in.errors) out.errors.resize(in.rays.size());
  if (in.slopes) out.slopes.resize(in.times.size());
  PassResult pass =
      engine_->run(model_, moving() ? &sums_.sum() : nullptr, in, {tasks, tracks}, radiance_,
                   moving() ? &levels_.back() : nullptr, {behind_, out.errors, out.slopes, marks_});
  watch.lap();
  out.slice_seconds += pass.slice_seconds;
  out.scatter_seconds += pass.scatter_seconds;
  if (ranks_) {
    sum_ranks(pass);
    sum_over_ranks(*ranks_, out);
  }
  out.scatter_seconds += watch.lap();

  if (moving()) {
    add_curve_prior(sums_.sum(), model_.model->motion, model_.static_prior, in.tv_share,
                    in.draw + levels_.size(), model_.active->rows, levels_.back());
    spread_motion_gradient();
  }
  out.slice_seconds += watch.lap();
  regularise(in);
  out.regularise_seconds = watch.lap();

  out.squared_error = pass.squared_error;
  out.motion_loss = pass.motion_loss;
  out.depth_loss = pass.depth_loss;
  out.track_loss = pass.track_loss;
  out.samples = pass.samples;
  // What the losses of Eq. 9 add is no larger than their weights, so only very large ones need another look.
  out.usable = pass.usable && !(model_.may_spoil && unusable_rows() > 0);
  if (!out.usable) {
    out.bad_rows = unusable_rows();
    discard();
    return out;
  }
  update(in);
  if (in.background->learned() && in.behind.empty())
    out.background = background_gradient(*in.background, in.rays, tasks, behind_, ranks_);
  std::copy_n(behind_.begin(), in.behind.size(), in.behind.begin());
  out.update_seconds = watch.lap();
  return out;
}

void HostStep::choose_engine(const RayLosses& losses) {
  const int order = model_.model->radiance.sh_order;
  const bool asks = losses.motion.offset > 0 || losses.motion.divergence > 0;
  if (engine_ && engine_order_ == order && engine_moves_ == moving() && engine_losses_ == asks) return;
  engine_order_ = order;
  engine_moves_ = moving();
  engine_losses_ = asks;
  engine_ = make_engine(order, moving(), asks);
}

/// Every count-th piece of work.
std::vector<RayTask> HostStep::own(std::span<const RayTask> tasks) const {
  if (!ranks_) return {tasks.begin(), tasks.end()};
  std::vector<RayTask> out;
  for (std::size_t t = std::size_t(ranks_->rank()); t < tasks.size(); t += std::size_t(ranks_->count()))
    out.push_back(tasks[t]);
  return out;
}

void HostStep::sum_ranks(PassResult& pass) {
  pass = sum_over_ranks(*ranks_, pass);
  if (!marks_.empty()) ranks_->merge({marks_.data()->word, marks_.size() * kBrick});
  if (!sum_over_ranks(*ranks_, radiance_)) pass.usable = false;
  if (moving() && !sum_over_ranks(*ranks_, levels_.back())) pass.usable = false;
}

/// From the finest level to each coarser one: the transpose of its prolongation.
void HostStep::spread_motion_gradient() {
  for (std::size_t l = levels_.size() - 1; l > 0; --l) {
    const Gradient& fine = levels_[l];
    Gradient& coarse = levels_[l - 1];
    parallel_for(coarse.values.topology->brick_count(), [&](int index) {
      restrict_brick(fine.values, fine.touched, coarse.values, index + 1, coarse.touched[index + 1]);
    });
  }
}

void HostStep::regularise(const StepInput& in) {
  add_total_variation(*model_.radiance.values, model_.radiance.tv, in.tv_scale, in.tv_share, in.draw,
                      model_.radiance.visible, radiance_);
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const LearnedRows& level = model_.levels[l];
    add_total_variation(*level.values, level.tv, in.tv_scale, in.tv_share, in.draw + 1 + l, level.visible,
                        levels_[l]);
    add_curve_prior(*level.values, model_.model->motion, model_.curves, in.tv_share, in.draw + 1 + l, {},
                    levels_[l]);
  }
}

std::int64_t HostStep::unusable_rows() const {
  std::int64_t rows = splinevox::unusable_rows(radiance_);
  for (const Gradient& level : levels_) rows += splinevox::unusable_rows(level);
  return rows;
}

void HostStep::discard() {
  splinevox::discard(radiance_);
  std::fill(marks_.begin(), marks_.end(), RowMask{});
  for (Gradient& level : levels_) splinevox::discard(level);
}

void HostStep::update(const StepInput& in) {
  splinevox::update(model_.radiance, radiance_, in.factors, in.radiance_rate);
  for (std::size_t b = 0; b < marks_.size(); ++b) model_.radiance.visible[b] |= std::exchange(marks_[b], {});
  for (std::size_t l = 0; l < levels_.size(); ++l)
    splinevox::update(model_.levels[l], levels_[l], in.factors, in.motion_rate);
}

}  // namespace splinevox
