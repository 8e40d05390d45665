// SPDX-License-Identifier: Apache-2.0
#include "train/engine.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "core/atomic.hpp"
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "field/lattice/slice.hpp"
#include "math/photometric.hpp"
#include "render/field_view.hpp"
#include "render/scatter.hpp"
#include "render/specialise.hpp"

namespace splinevox {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point& last) {
  const auto now = Clock::now();
  const double s = std::chrono::duration<double>(now - last).count();
  last = now;
  return s;
}

template <int Sh, bool Moving, bool Jet>
class RayEngine final : public Engine {
  using Kernel = RayKernel<float, Sh, float, Moving>;
  static constexpr int kWidth = Kernel::kWidth;

  struct Worker {
    Kernel kernel;
    RayRecords<float, kWidth, Jet> records;
    double squared_error, motion_loss;
    std::int64_t samples, visited;
    /// Where a ray's records end, and what it lost.
    struct Ray {
      std::size_t radiance, motion;
      double loss;
    };
    std::vector<Ray> rays;
    int first;  ///< ray of the batch
  };

  template <class Rec>
  static bool all_usable(const std::vector<Rec>& records, std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      for (const float g : records[i].g)
        if (!usable(g)) return false;
      for (const auto& row : records[i].h)
        for (const float h : row)
          if (!usable(h)) return false;
    }
    return true;
  }

 public:
  PassResult run(const VoxelModel& model, const ActiveRows& active, float step, const Batch& batch,
                 const std::vector<double>& times, const std::vector<const BitGrid*>& occupancy,
                 const RayLosses& losses, Gradient& radiance, Gradient& motion,
                 std::span<Vec3> behind) override {
    PassResult result;
    auto clock = Clock::now();
    FieldView<float> field = view_field(model, step);
    if constexpr (!Jet)
      field.reach = active.reach.cells() > 0
                        ? active.reach.bits.data()
                        : nullptr;  // losses of motion are asked of every sample, moving or not
    if constexpr (Moving) make_slices(model, active.rows, times);
    result.slice_seconds = seconds_since(clock);

    const int tasks = int(batch.tasks.size());
    workers_.resize(tasks);
    radiance_scatter_.begin(tasks, model.radiance.raw.topology->brick_count() + 1);
    const int motion_bricks = Moving ? model.motion.levels[0].topology->brick_count() + 1 : 0;
    if constexpr (Moving) motion_scatter_.begin(tasks, motion_bricks, int(times.size()));
    std::uint64_t* const seen = radiance.seen.empty() ? nullptr : radiance.seen.data()->word;
    parallel_for(tasks, [&](int t) {
      march(field, seen, batch, batch.tasks[t], *occupancy[batch.tasks[t].frame], losses, workers_[t],
            behind);
      radiance_scatter_.count(t, workers_[t].records.radiance, field.radiance, 0);
      if constexpr (Moving)
        motion_scatter_.count(t, workers_[t].records.motion, field.motion, batch.tasks[t].frame);
    });
    for (const Worker& w : workers_) {
      result.squared_error += w.squared_error, result.motion_loss += w.motion_loss;
      result.samples += w.samples, result.visited += w.visited;
    }
    result.ray_seconds = seconds_since(clock);

    radiance_scatter_.scan();
    if constexpr (Moving) motion_scatter_.scan();
    parallel_for(tasks, [&](int t) {
      radiance_scatter_.fill(t, field.radiance);
      if constexpr (Moving) motion_scatter_.fill(t, field.motion);
    });
    usable_ = std::isfinite(result.squared_error) && std::isfinite(result.motion_loss);
    parallel_for(model.radiance.raw.topology->brick_count() + 1, [&](int b) {
      if (radiance_scatter_.empty(b)) return;
      radiance_scatter_.reduce(b, radiance.values.row(std::size_t(b) * kBrickRows), radiance.touched[b]);
      if (!usable(radiance, b)) usable_ = false;  // here, where the rows are in the cache
    });
    if constexpr (Moving) expand_motion(model, active.rows, times, motion_bricks, motion);
    result.usable = usable_;
    result.scatter_seconds = seconds_since(clock);
    return result;
  }

  std::vector<int> bad_rays() const override {
    std::vector<int> bad;
    for (const Worker& w : workers_) {
      typename Worker::Ray before{0, 0, 0};
      for (std::size_t i = 0; i < w.rays.size(); ++i) {
        const typename Worker::Ray& ray = w.rays[i];
        if (!std::isfinite(ray.loss) || !all_usable(w.records.radiance, before.radiance, ray.radiance) ||
            !all_usable(w.records.motion, before.motion, ray.motion))
          bad.push_back(w.first + int(i));
        before = ray;
      }
    }
    return bad;
  }

 private:
  void make_slices(const VoxelModel& model, const std::vector<RowMask>& active,
                   const std::vector<double>& times) {
    const Channels& level = model.motion.levels[0];
    const int frames = int(times.size()), bricks = level.topology->brick_count() + 1;
    slices_.resize(frames), slice_gradients_.resize(frames), weights_.resize(frames);
    for (int f = 0; f < frames; ++f) {
      weights_[f] = stored_weights(model.motion, times[f]);
      slices_[f].resize(level.topology->rows() * kSliceWidth);
      slice_gradients_[f].resize(
          slices_[f].size());  // all zero between steps: expand_brick clears what it reads
    }
    if (active != contracted_) {  // rows that were active may be no more
      contracted_ = active;
      for (auto& slice : slices_) std::fill(slice.begin(), slice.end(), 0.0f);
    }
    std::vector<float*> slices(frames);
    for (int f = 0; f < frames; ++f) slices[f] = slices_[f].data();
    parallel_for(bricks, [&](int b) { contract_brick(model.motion, level, weights_, b, active[b], slices); });
  }

  void march(const FieldView<float>& field, std::uint64_t* seen, const Batch& batch, const Batch::Task& task,
             const BitGrid& occupancy, const RayLosses& losses, Worker& w, std::span<Vec3> behind) {
    w.records.clear();
    w.squared_error = w.motion_loss = 0, w.samples = w.visited = 0;
    w.rays.clear(), w.first = task.first;
    const FrameView<float> frame{Moving ? slices_[task.frame].data() : nullptr, occupancy.view()};
    for (int i = task.first; i < task.last; ++i) {
      const RayInput<float>& ray = batch.rays[i];
      const RayResult<float> result = w.kernel.forward(ray, field, frame, losses.stop);
      const Vec3 error = photometric_error(result.rgb, batch.targets[i]);
      if (seen && has_matter(batch.targets[i], ray.background, losses.faintest))
        show(field, w.kernel, losses, seen);
      const double squared = dot(error, error);
      if (!behind.empty()) behind[i] = (2 * result.transmittance) * error;
      double motion = 0;
      w.squared_error += squared;
      w.samples += w.kernel.count, w.visited += w.kernel.visited;
      [[maybe_unused]] const std::size_t first = w.records.motion.size();
      backward(w.kernel, ray, result, field, 2.0f * error, losses.min_weight, w.records);
      if constexpr (Jet)
        motion = motion_losses(w.kernel, field, frame, losses.motion, draw_probe(losses.probe_seed, i),
                               losses.min_weight, first, w.records);
      w.motion_loss += motion;
      w.rays.push_back({w.records.radiance.size(), w.records.motion.size(), squared + motion});
    }
  }

  /// Marks what a ray showed (Gradient::seen). Tasks may mark the same words: the order does not matter.
  static void show(const FieldView<float>& field, const Kernel& ray, const RayLosses& losses,
                   std::uint64_t* seen) {
    float most = 0;
    for (int k = 0; k < ray.count; ++k) most = std::max(most, ray.weight[k]);
    const float enough = std::max(losses.seen_share * most, losses.min_weight);
    for (int k = 0; k < ray.count; ++k) {
      if (ray.weight[k] < enough || ray.weight[k] <= 0) continue;
      const CellRows rows = field.radiance.rows(ray.samples[k].radiance_cell);
      for (const std::int32_t row : rows.row) atomic_set(seen + (row >> 6), std::uint64_t(1) << (row & 63));
    }
  }

  void expand_motion(const VoxelModel& model, const std::vector<RowMask>& active,
                     const std::vector<double>& times, int bricks, Gradient& motion) {
    parallel_for(bricks, [&](int b) {
      if (b == 0) return;
      for (std::size_t f = 0; f < times.size(); ++f) {
        const int bin = int(f) * bricks + b;
        if (motion_scatter_.empty(bin)) continue;
        float* rows = slice_gradients_[f].data() + std::size_t(b) * kBrickRows * kSliceWidth;
        RowMask hit;
        motion_scatter_.reduce(bin, rows, hit);
        RowMask at_rest = hit;
        (at_rest &= ~active[b]).for_each([&](int i) {
          std::fill_n(rows + std::size_t(i) * kSliceWidth, kSliceWidth, 0.0f);
        });
        hit &= active[b];
        expand_brick(model.motion, weights_[f], hit, rows, b, motion.values);
        motion.touched[b] |= hit;
      }
      if (!usable(motion, b)) usable_ = false;
    });
  }

  std::vector<AlignedVector<float>> slices_, slice_gradients_;
  std::vector<RowMask> contracted_;  ///< rows of slices_ that are made anew every step; the others are zero
  std::vector<BasisWeights<float>> weights_;
  std::vector<Worker> workers_;
  std::atomic<bool> usable_ = true;
  Scatter<float, kWidth, false> radiance_scatter_;
  Scatter<float, kSliceWidth, Jet> motion_scatter_;
};

}  // namespace

std::unique_ptr<Engine> make_engine(int sh_order, bool moving, bool motion_losses) {
  return specialise(sh_order, moving, [&]<int Sh, bool Moving>() -> std::unique_ptr<Engine> {
    if constexpr (Moving)
      if (motion_losses) return std::make_unique<RayEngine<Sh, Moving, true>>();
    return std::make_unique<RayEngine<Sh, Moving, false>>();
  });
}

}  // namespace splinevox
