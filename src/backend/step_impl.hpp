// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "backend/background_gradient.hpp"
#include "backend/field_mirror.hpp"
#include "backend/learned_mirror.hpp"
#include "backend/march_job.hpp"
#include "backend/ray_share.hpp"
#include "backend/step.hpp"
#include "core/rng.hpp"
#include "field/lattice/level_kernels.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

/// The sum of a step's rays, by as many threads as there are rays: in fixed point, so that their order does
/// not matter.
struct OutcomeKernel {
  static constexpr double kUnit = 0x1p32, kMost = 0x1p54;  ///< all rays together; room for 2^8 ranks
  const RayOutcome* outcomes;
  std::size_t rays;
  std::int64_t* sums;  ///< bad rays, bad rows, samples, squared error and motion loss in kUnit

  SPLINEVOX_HD std::size_t count() const { return rays; }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    const RayOutcome& o = outcomes[i];
    atomic_add(sums + 2, std::int64_t(o.samples));
    if (!o.usable) return atomic_add(sums, std::int64_t(1));
    atomic_add(sums + 3, fixed(dot(o.error, o.error)));
    atomic_add(sums + 4, fixed(o.motion_loss));
  }
  /// What is too large for a sum of as many rays counts as the largest that is not.
  SPLINEVOX_HD std::int64_t fixed(float loss) const {
    const double units = double(loss) * kUnit, most = kMost / double(rays);
    return std::int64_t(units < most ? units : most);
  }
};

/// StepBackend on any executor.
/// @tparam Peers  adds up what the ranks' executors computed: sum(executor, buffer) of numbers,
/// merge(executor, buffer) of masks, on all ranks alike.
template <class Executor, class Peers>
class Steps final : public StepBackend {
 public:
  Steps(bool deterministic, Ranks* ranks) : deterministic_(deterministic), ranks_(ranks) {
    if (ranks) peers_.emplace(*ranks);
  }

  void upload(const StepModel& model) override {
    model_ = model;
    fresh_ = true;
    const VoxelModel& m = *model.model;
    most_samples_ = most_samples(m.box, m.step);
    if (most_samples_ > MarchList::kMostSamples)
      fail({"sampling.step", "a ray would have too many samples for the device",
            "at most " + std::to_string(MarchList::kMostSamples), std::to_string(most_samples_),
            "a larger sampling.step, or --device cpu"});
    radiance_.upload(run_, model.radiance);
    if (deterministic_) clear(radiance_fixed_, radiance_.values.size());
    levels_.resize(model.levels.size());
    sums_.resize(model.levels.size());
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      levels_[l].upload(run_, model.levels[l]);
      clear(sums_[l], l == 0 && levels_.size() > 1 ? 0 : levels_[l].values.size());
    }
    run_.resize(slices_, 0);  // those of other lattices: made anew with the next step
    const Contraction by(m.motion);
    run_.upload(mean_, by.mean.data(), !levels_.empty() && m.motion.presence ? by.count : 0);
    if (!levels_.empty())
      run_.upload(active_, model.active->rows[0].word, model.active->rows.size() * kBrick);
    std::size_t words = 0;
    for (const BitGrid& grid : model.occupancy) words += grid.bits.size();
    std::vector<std::uint32_t> all;
    all.reserve(words);
    for (const BitGrid& grid : model.occupancy) all.insert(all.end(), grid.bits.begin(), grid.bits.end());
    run_.upload(bits_, all.data(), all.size());
    run_.wait();
  }

  void download() override {
    radiance_.download(run_, model_.radiance);
    for (std::size_t l = 0; l < levels_.size(); ++l) levels_[l].download(run_, model_.levels[l]);
  }

  StepSums run(const StepInput& in) override {
    if (!in.depths.empty())
      fail({"loss.depth", "depth is not learned on a device", "--device cpu, or --set loss.depth=0",
            "rays with depth", ""});
    if (!in.tracks.rays.empty())
      fail({"loss.tracks", "tracks are not learned on a device", "--device cpu, or --set loss.tracks=0",
            "rays of tracks", ""});
    const int slots = int(in.times.size());
    share_.take(in, ranks_);
    prepare(in, slots);
    if (std::exchange(fresh_, false) || peers_)
      queue(in, slots);
    else
      run_.together([&] { queue(in, slots); });

    std::int64_t t[5];
    run_.download(totals_, t);
    StepSums out;
    out.squared_error = double(t[3]) / OutcomeKernel::kUnit;
    out.motion_loss = double(t[4]) / OutcomeKernel::kUnit;
    out.samples = t[2];
    out.usable = t[0] + t[1] == 0;
    out.bad_rows = t[1];
    if (in.errors) out.errors = errors(in.rays.size());
    if (in.slopes) out.slopes = slopes(std::size_t(slots));
    if (ranks_) sum_over_ranks(*ranks_, out);
    if (wants_behind(in) && out.usable) {
      std::vector<Vec3> behind(behind_.size());
      run_.download(behind_, behind.data());
      if (in.behind.empty()) {
        out.background = background_gradient(*in.background, share_.rays(), share_.tasks(), behind, ranks_);
      } else {
        std::fill(in.behind.begin(), in.behind.end(), Vec3{});
        for (std::size_t i = 0; i < behind.size(); ++i)
          in.behind[std::size_t(share_.in_batch(int(i)))] = behind[i];
      }
    }
    return out;
  }

  std::vector<int> bad_rays() override {
    std::vector<RayOutcome> all(outcomes_.size());
    run_.download(outcomes_, all.data());
    std::vector<int> bad;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!all[i].usable) bad.push_back(share_.in_batch(int(i)));
    return bad;
  }

 private:
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;

  static bool wants_behind(const StepInput& in) { return in.background->learned() || !in.behind.empty(); }
  template <class T>
  void clear(Buffer<T>& buffer, std::size_t n) {
    run_.resize(buffer, n);
    run_.zero(buffer);
  }
  /// Photometric errors of the batch's rays, 0 of those that others compute.
  std::vector<Vec3> errors(std::size_t rays) {
    std::vector<RayOutcome> own(outcomes_.size());
    run_.download(outcomes_, own.data());
    std::vector<Vec3> out(rays);
    for (std::size_t i = 0; i < own.size(); ++i) out[std::size_t(share_.in_batch(int(i)))] = own[i].error;
    return out;
  }
  std::vector<double> slopes(std::size_t slots) {
    std::vector<double> parts(slope_parts_.size()), out(slots);
    run_.download(slope_parts_, parts.data());
    for (std::size_t i = 0; i < parts.size(); ++i) out[i % slots] += parts[i];
    return out;
  }
  /// All kernels of a step.
  void queue(const StepInput& in, int slots) {
    if (!levels_.empty()) make_slices(slots);
    march(in);
    if (peers_) {
      peers_->sum(run_, totals_);
      add_up(radiance_);
      if (!model_.radiance.visible.empty()) peers_->merge(run_, radiance_.marks);
    }
    if (!levels_.empty()) spread(in, slots);
    radiance_.regularise(run_, in.tv_share, in.draw);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      levels_[l].regularise(run_, in.tv_share, in.draw + 1 + l);
      levels_[l].hold_curves(run_, model_.model->motion, model_.curves, in.tv_share, in.draw + 1 + l);
    }
    radiance_.check(run_, totals_.data() + 1, kLargestGradient);
    for (auto& level : levels_) level.check(run_, totals_.data() + 1, kLargestGradient);
    radiance_.update(run_, totals_.data(), in.factors, in.radiance_rate);
    for (auto& level : levels_) level.update(run_, totals_.data(), in.factors, in.motion_rate);
  }
  /// The gradient of all ranks' rays in place of ours. Whole arrays: untouched rows are zero, and picking out
  /// the others would cost more than their bytes do between devices.
  void add_up(LearnedMirror<Executor>& rows) {
    peers_->sum(run_, rows.gradient);
    peers_->merge(run_, rows.touched);
  }
  const float* mean() const { return mean_.size() > 0 ? mean_.data() : nullptr; }
  const LearnedMirror<Executor>& finest() const { return levels_.back(); }
  /// The sum of all levels on the finest lattice: with one level, that level.
  const float* collapsed() const { return levels_.size() > 1 ? sums_.back().data() : finest().values.data(); }

  /// Everything that comes from the host, while the stream is idle: a copy from pageable memory behind a
  /// kernel would wait for it.
  void prepare(const StepInput& in, int slots) {
    run_.upload(rays_, share_.rays().data(), share_.rays().size());
    run_.upload(targets_, share_.targets().data(), share_.targets().size());
    run_.resize(outcomes_, share_.rays().size());
    run_.resize(behind_, wants_behind(in) ? share_.rays().size() : 0);
    run_.resize(totals_, 5);
    radiance_.prepare(run_, in.tv_scale, in.tv_share);
    for (auto& level : levels_) level.prepare(run_, in.tv_scale, in.tv_share);
    const MotionField& motion = model_.model->motion;
    std::size_t slice = 0;  // floats
    run_.resize(slope_parts_, in.slopes && !levels_.empty()
                                  ? SlopeKernel::shares(finest().rows()) * std::size_t(slots)
                                  : 0);
    std::vector<SlotWeights> weights, weights_dt;
    if (!levels_.empty()) {
      for (const double t : in.times) {
        weights.push_back(slot_weights(stored_weights(motion, t), motion.stored_points()));
        if (in.slopes)
          weights_dt.push_back(slot_weights(stored_weights_dt(motion, t), motion.stored_points()));
      }
      run_.upload(weights_, weights.data(), weights.size());
      run_.upload(weights_dt_, weights_dt.data(), weights_dt.size());
      slice = finest().rows() * kSliceWidth;
      if (slices_.size() != slots * slice) {
        clear(slices_, slots * slice);
        clear(slice_gradients_, slots * slice);
        if (deterministic_) clear(slice_fixed_, slots * slice);
        clear(motion_touched_, finest().rows() / 64);
      }
    }
    std::vector<FrameView<float>> frames;
    std::vector<GradientRows> rows;
    const BitGrid& grid = model_.occupancy[0];
    for (int s = 0; s < slots; ++s) {
      FrameView<float> frame{slices_.data() + s * slice, grid.view()};
      frame.occupancy.bits = bits_.data() + grid.bits.size() * std::size_t(in.occupancy[s]);
      frames.push_back(frame);
      rows.push_back({slice_gradients_.data() + s * slice,
                      deterministic_ ? slice_fixed_.data() + s * slice : nullptr, motion_touched_.data(),
                      kSliceWidth});
    }
    run_.upload(frames_, frames.data(), frames.size());
    run_.upload(motion_rows_, rows.data(), rows.size());
    run_.zero(totals_);
    run_.wait();
  }

  /// Levels -> their sum -> a slice per slot.
  void make_slices(int slots) {
    const int width = finest().width;
    for (std::size_t l = 1; l < levels_.size(); ++l) {
      const bool last = l + 1 == levels_.size();
      run_.for_each(CollapseKernel{
          levels_[l].values.data(), l > 1 ? sums_[l - 1].data() : levels_[0].values.data(), sums_[l].data(),
          levels_[l].lattice.view(), levels_[l - 1].lattice.view(), last ? active_.data() : nullptr, width});
    }
    run_.for_each(ContractKernel{MotionLayout(model_.model->motion), collapsed(), active_.data(),
                                 weights_.data(), mean(), model_.model->motion.stored_points(), slots,
                                 finest().rows(), slices_.data()});
  }

  void march(const StepInput& in) {
    const VoxelModel& m = *model_.model;
    MarchJob job;
    job.field = view_field(m, radiance_.values.data(), m.step);
    job.field.radiance = radiance_.lattice.brick_view();
    job.field.moving = !levels_.empty();
    if (job.field.moving) job.field.motion = finest().lattice.brick_view();
    job.frames = frames_.data();
    job.rays = rays_.data();
    job.targets = targets_.data();
    job.outcomes = outcomes_.data();
    job.ray_count = int(share_.rays().size());
    job.rays_per_slot = share_.per_slot();
    job.most_samples = most_samples_;
    job.losses = in.losses;
    if (ranks_)  // a device counts its own rays from 0
      job.losses.probe_seed = hash64(in.losses.probe_seed + std::uint64_t(ranks_->rank()));
    job.largest = deterministic_ ? std::min(kLargestGradient, GradientRows::kLargest) : kLargestGradient;
    job.radiance = {radiance_.gradient.data(), deterministic_ ? radiance_fixed_.data() : nullptr,
                    radiance_.touched.data(), radiance_.width,
                    model_.radiance.visible.empty() ? nullptr : radiance_.marks.data()};
    job.motion = motion_rows_.data();
    job.behind = wants_behind(in) ? behind_.data() : nullptr;
    switch (m.radiance.sh_order) {
      case -1:
        run_march<Executor, -1>(run_, job);
        break;
      case 0:
        run_march<Executor, 0>(run_, job);
        break;
      case 1:
        run_march<Executor, 1>(run_, job);
        break;
      case 2:
        run_march<Executor, 2>(run_, job);
        break;
      default:
        run_march<Executor, 3>(run_, job);
    }
    run_.for_each(OutcomeKernel{outcomes_.data(), outcomes_.size(), totals_.data()});
    if (deterministic_)
      run_.for_each(DecodeKernel{radiance_fixed_.data(), radiance_.gradient.data(), radiance_.touched.data(),
                                 radiance_.rows(), radiance_.width, 1 / GradientRows::kUnit});
  }

  /// Gradients of the slices -> of the finest level -> of the coarser ones.
  void spread(const StepInput& in, int slots) {
    const std::size_t rows = finest().rows();
    if (deterministic_)
      for (int s = 0; s < slots; ++s) {
        const std::size_t offset = s * rows * kSliceWidth;
        run_.for_each(DecodeKernel{slice_fixed_.data() + offset, slice_gradients_.data() + offset,
                                   motion_touched_.data(), rows, kSliceWidth, 1 / GradientRows::kUnit});
      }
    if (in.slopes)
      run_.for_each(SlopeKernel{MotionLayout(model_.model->motion), collapsed(), motion_touched_.data(),
                                active_.data(), weights_dt_.data(), slots, rows, slice_gradients_.data(),
                                slope_parts_.data()});
    run_.for_each(ExpandKernel{MotionLayout(model_.model->motion), motion_touched_.data(), active_.data(),
                               weights_.data(), mean(), model_.model->motion.stored_points(), slots, rows,
                               slice_gradients_.data(), levels_.back().gradient.data()});
    run_.for_each(
        MergeMaskKernel{motion_touched_.data(), levels_.back().touched.data(), active_.data(), rows / 64});
    if (peers_) add_up(levels_.back());
    levels_.back().hold_curves(run_, model_.model->motion, model_.static_prior, in.tv_share,
                               in.draw + levels_.size(), collapsed(), active_.data());
    for (std::size_t l = levels_.size() - 1; l > 0; --l)
      run_.for_each(RestrictKernel{levels_[l].gradient.data(), levels_[l].touched.data(),
                                   levels_[l - 1].gradient.data(), levels_[l - 1].touched.data(),
                                   levels_[l].lattice.view(), levels_[l - 1].lattice.view(), finest().width});
  }

  const bool deterministic_;
  Ranks* const ranks_;
  StepModel model_{};
  RayShare share_;
  int most_samples_ = 0;
  bool fresh_ = true;  ///< the next step is the first since an upload: kernels are loaded when they first
                       ///< start, which a recording could not do
  Executor run_;
  std::optional<Peers> peers_;  ///< after run_: parted from before it goes
  LearnedMirror<Executor> radiance_;
  std::vector<LearnedMirror<Executor>> levels_;
  std::vector<Buffer<float>> sums_;  ///< of the levels up to each but the first
  Buffer<std::uint64_t> active_, motion_touched_;
  Buffer<std::uint32_t> bits_;  ///< occupancy grids, one after the other
  Buffer<SlotWeights> weights_, weights_dt_;
  Buffer<float> mean_;  ///< of presence
  Buffer<double> slope_parts_;
  Buffer<float> slices_, slice_gradients_;
  Buffer<std::int64_t> radiance_fixed_, slice_fixed_;
  Buffer<RayInput<float>> rays_;
  Buffer<Vec3> targets_, behind_;
  Buffer<RayOutcome> outcomes_;
  Buffer<FrameView<float>> frames_;
  Buffer<GradientRows> motion_rows_;
  Buffer<std::int64_t> totals_;  ///< bad rays, bad rows, samples, squared error, motion loss
};

}  // namespace splinevox
