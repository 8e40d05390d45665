// SPDX-License-Identifier: Apache-2.0
#include "backend/host/engine.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/atomic.hpp"
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "core/stopwatch.hpp"
#include "field/lattice/slice.hpp"
#include "math/photometric.hpp"
#include "render/backward.hpp"
#include "render/field_view.hpp"
#include "render/scatter.hpp"
#include "render/specialise.hpp"
#include "render/track_sight.hpp"

namespace splinevox {
namespace {

template <int Sh, bool Moving, bool Jet>
class RayEngine final : public Engine {
  using Kernel = RayKernel<float, Sh, float, Moving>;
  static constexpr int kWidth = Kernel::kWidth;

  struct Worker {
    Kernel kernel;
    RayRecords<float, kWidth, Jet> records;
    double squared_error, motion_loss, depth_loss, track_loss;
    std::int64_t samples;
    /// Where a ray's records end, and what it lost.
    struct Ray {
      std::size_t radiance, motion;
      double loss;
    };
    std::vector<Ray> rays;
    int first;  ///< ray of the batch

    void begin(const RayTask& task) {
      records.clear();
      squared_error = motion_loss = depth_loss = track_loss = 0;
      samples = 0;
      rays.clear();
      first = task.first;
    }
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
  PassResult run(const StepModel& model, const Channels* motion, const StepInput& in, const OwnTasks& own,
                 Gradient& d_radiance, Gradient* d_motion, const PassOutput& out) override {
    PassResult result;
    Stopwatch watch;
    const Channels& radiance = *model.radiance.values;
    const MotionField& columns = model.model->motion;
    [[maybe_unused]] const Contraction by(columns);
    FieldView<float> field = view_field(*model.model, radiance.values.data(), model.model->step);
    field.moving = Moving;
    if constexpr (Moving) field.motion = BrickView<float>(*motion->topology);
    if constexpr (!Jet)
      field.reach = model.active->reach.cells() > 0
                        ? model.active->reach.bits.data()
                        : nullptr;  // losses of motion are asked of every sample, moving or not
    if constexpr (Moving)
      make_slices(columns, by, *motion, model.active->rows, in.times, !out.slopes.empty());
    result.slice_seconds = watch.lap();

    const std::span<const RayTask> batch = own.rays;
    const int ray_tasks = int(batch.size()), tasks = ray_tasks + (Moving ? int(own.tracks.size()) : 0);
    workers_.resize(tasks);
    radiance_scatter_.begin(tasks, radiance.topology->brick_count() + 1);
    const int motion_bricks = Moving ? motion->topology->brick_count() + 1 : 0;
    if constexpr (Moving) motion_scatter_.begin(tasks, motion_bricks, int(in.times.size()));
    colours_.resize(in.colour_gradient ? in.rays.size() : 0);
    given_.clear();
    if (in.colour_gradient) {  // a loss may look at all rays together: their colours first
      parallel_for(ray_tasks,
                   [&](int t) { march(field, model, in, batch[t], workers_[t], out, colours_.data()); });
      given_.assign(in.rays.size(), Vec3{});
      (*in.colour_gradient)(colours_, given_);
    }
    // A ray that leaves no record would tell the background alone of what is no gradient.
    const bool good = std::all_of(given_.begin(), given_.end(),
                                  [](const Vec3& g) { return usable(g.x) && usable(g.y) && usable(g.z); });
    if constexpr (Moving) see_tracks(field, model, in);
    parallel_for(tasks, [&](int t) {
      const RayTask& task = t < ray_tasks ? batch[t] : own.tracks[t - ray_tasks];
      if (t < ray_tasks)
        march(field, model, in, task, workers_[t], out, nullptr);
      else if constexpr (Moving)
        follow(field, model, in, task, workers_[t]);
      radiance_scatter_.count(t, workers_[t].records.radiance, field.radiance, 0);
      if constexpr (Moving) motion_scatter_.count(t, workers_[t].records.motion, field.motion, task.slot);
    });
    for (const Worker& w : workers_) {
      result.squared_error += w.squared_error;
      result.motion_loss += w.motion_loss;
      result.depth_loss += w.depth_loss;
      result.track_loss += w.track_loss;
      result.samples += w.samples;
    }
    watch.lap();

    radiance_scatter_.scan();
    if constexpr (Moving) motion_scatter_.scan();
    parallel_for(tasks, [&](int t) {
      radiance_scatter_.fill(t, field.radiance);
      if constexpr (Moving) motion_scatter_.fill(t, field.motion);
    });
    usable_ = good && std::isfinite(result.squared_error) && std::isfinite(result.motion_loss) &&
              std::isfinite(result.depth_loss) && std::isfinite(result.track_loss);
    parallel_for(radiance.topology->brick_count() + 1, [&](int b) {
      if (radiance_scatter_.empty(b)) return;
      radiance_scatter_.reduce(b, d_radiance.values.row(std::size_t(b) * kBrickRows), d_radiance.touched[b]);
      if (!usable(d_radiance, b)) usable_ = false;  // here, where the rows are in the cache
    });
    std::fill(out.slopes.begin(), out.slopes.end(), 0.0);  // nothing changes over time
    if constexpr (Moving)
      expand_motion(by, *motion, model.active->rows, motion_bricks, *d_motion, out.slopes);
    result.usable = usable_;
    result.scatter_seconds = watch.lap();
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
  void make_slices(const MotionField& motion, const Contraction& by, const Channels& level,
                   const std::vector<RowMask>& active, std::span<const double> times, bool slopes) {
    const int frames = int(times.size()), bricks = level.topology->brick_count() + 1;
    slices_.resize(frames);
    slice_gradients_.resize(frames);
    weights_.resize(frames);
    weights_dt_.resize(slopes ? frames : 0);
    for (int f = 0; f < frames; ++f) {
      weights_[f] = stored_weights(motion, times[f]);
      if (slopes) weights_dt_[f] = stored_weights_dt(motion, times[f]);
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
    parallel_for(bricks, [&](int b) { contract_brick(by, level, weights_, b, active[b], slices); });
  }

  /// @param colours  [rays] gets what each shows, and nothing else is done; null: forward and backward
  void march(const FieldView<float>& field, const StepModel& model, const StepInput& in, const RayTask& task,
             Worker& w, const PassOutput& out, Vec3* colours) {
    const RayLosses& losses = in.losses;
    w.begin(task);
    const FrameView<float> frame = frame_of(model, in, task.slot);
    for (int i = task.first; i < task.last; ++i) {
      const RayInput<float>& ray = in.rays[i];
      const RayResult<float> result = w.kernel.forward(ray, field, frame, losses.stop);
      if (colours) {
        colours[i] = result.rgb;
        continue;
      }
      const Vec3 error = photometric_error(result.rgb, in.targets[i]);
      if (!out.marks.empty() && has_matter(in.targets[i], ray.background, losses.faintest))
        mark_visible(field, w.kernel, losses, out.marks.data()->word);
      const double squared = dot(error, error);
      const Vec3 d_rgb =
          in.colour_gradient ? given_[std::size_t(i)] : photometric_gradient(error, ray.weight);
      if (!out.behind.empty()) out.behind[i] = result.transmittance * d_rgb;
      if (!out.errors.empty()) out.errors[i] = error;
      double motion = 0, depth = 0;
      w.squared_error += squared;
      w.samples += w.kernel.count;
      [[maybe_unused]] const std::size_t first = w.records.motion.size();
      if (in.depths.empty() || in.depths[i].scale == 0) {
        backward(w.kernel, ray, result, field, d_rgb, losses.min_weight, w.records, losses.transmittance);
      } else {
        const Activated<float> off =
            depth_error(expected_distance(w.kernel, ray, result, field.step), in.depths[i]);
        depth = losses.depth * off.value;
        w.depth_loss += depth;
        backward<true>(w.kernel, ray, result, field, d_rgb, losses.min_weight, w.records,
                       losses.transmittance, losses.depth * off.slope);
      }
      if constexpr (Jet)
        motion = motion_losses(w.kernel, field, frame, losses.motion, draw_probe(losses.probe_seed, i),
                               losses.min_weight, first, w.records);
      w.motion_loss += motion;
      w.rays.push_back({w.records.radiance.size(), w.records.motion.size(), squared + motion + depth});
    }
  }

  FrameView<float> frame_of(const StepModel& model, const StepInput& in, int slot) const {
    return {Moving ? slices_[slot].data() : nullptr, model.occupancy[in.occupancy[slot]].view()};
  }

  /// Where the rays of tracks see their points, and what their places are asked: of each ray the mean over
  /// the others of its point.
  void see_tracks(const FieldView<float>& field, const StepModel& model, const StepInput& in) {
    const TrackRays& tracks = in.tracks;
    if (tracks.rays.empty()) return;
    sightings_.resize(tracks.rays.size());
    asked_.resize(tracks.rays.size());
    lookers_.resize(tracks.tasks.size());
    parallel_for(int(tracks.tasks.size()), [&](int t) {
      const RayTask& task = tracks.tasks[t];
      const FrameView<float> frame = frame_of(model, in, task.slot);
      for (int i = task.first; i < task.last; ++i) {
        lookers_[t].forward(tracks.rays[i], field, frame, in.losses.stop);
        sightings_[i] = sighting_of(lookers_[t], tracks.rays[i], field.step);
      }
    });
    parallel_for(int(tracks.first.size()) - 1, [&](int p) {
      const std::span rays = tracks.of_points.subspan(tracks.first[p], tracks.first[p + 1] - tracks.first[p]);
      const float share = in.losses.tracks / float(rays.size() - 1);
      for (const int i : rays) {
        asked_[i] = {};
        for (const int j : rays) {
          if (i == j) continue;
          const TrackError<float> e = track_error(sightings_[i], sightings_[j], in.losses.track_scale);
          asked_[i].value += share * e.value;
          asked_[i].slope += (2 * share) * e.slope;  // from both ends
        }
      }
    });
  }

  /// Forward and backward of rays of tracks.
  void follow(const FieldView<float>& field, const StepModel& model, const StepInput& in, const RayTask& task,
              Worker& w) {
    w.begin(task);
    const FrameView<float> frame = frame_of(model, in, task.slot);
    for (int i = task.first; i < task.last; ++i) {
      w.track_loss += asked_[i].value;
      w.kernel.forward(in.tracks.rays[i], field, frame, in.losses.stop);
      sighting_vjp(w.kernel, sightings_[i], asked_[i].slope, in.losses.min_weight, w.records);
    }
  }

  /// Marks the rows that a ray makes visible (LearnedRows::visible). Tasks may mark the same words: the order
  /// does not matter.
  static void mark_visible(const FieldView<float>& field, const Kernel& ray, const RayLosses& losses,
                           std::uint64_t* marks) {
    float most = 0;
    for (int k = 0; k < ray.count; ++k) most = std::max(most, ray.weight[k]);
    const float enough = std::max(losses.visible_share * most, losses.min_weight);
    for (int k = 0; k < ray.count; ++k) {
      if (ray.weight[k] < enough || ray.weight[k] <= 0) continue;
      const CellRows rows = field.radiance.rows(ray.samples[k].radiance_cell);
      for (const std::int32_t row : rows.row)
        if (row >= kBrickRows) atomic_set(marks + (row >> 6), std::uint64_t(1) << (row & 63));
    }
  }

  void expand_motion(const Contraction& by, const Channels& level, const std::vector<RowMask>& active,
                     int bricks, Gradient& motion, std::span<double> slopes) {
    const std::size_t slots = weights_.size();
    std::vector<double> parts(std::size_t(bricks) * slopes.size());
    parallel_for(bricks, [&](int b) {
      if (b == 0) return;
      RowMask expanded;
      for (std::size_t f = 0; f < slots; ++f) {
        const int bin = int(f) * bricks + b;
        if (motion_scatter_.empty(bin)) continue;
        float* rows = slice_gradients_[f].data() + std::size_t(b) * kBrickRows * kSliceWidth;
        RowMask hit;
        motion_scatter_.reduce(bin, rows, hit);
        RowMask frozen = hit;
        (frozen &= ~active[b]).for_each([&](int i) {
          std::fill_n(rows + std::size_t(i) * kSliceWidth, kSliceWidth, 0.0f);
        });
        hit &= active[b];
        if (!slopes.empty())
          parts[std::size_t(b) * slots + f] = slope_brick(by, level, weights_dt_[f], hit, rows, b);
        expand_brick(by, weights_[f], hit, rows, b, motion.values);
        expanded |= hit;
      }
      centre_brick(by, expanded, b, motion.values);
      motion.touched[b] |= expanded;
      if (!usable(motion, b)) usable_ = false;
    });
    for (std::size_t i = 0; i < parts.size(); ++i) slopes[i % slots] += parts[i];
  }

  std::vector<AlignedVector<float>> slices_, slice_gradients_;
  std::vector<RowMask> contracted_;  ///< rows of slices_ that are made anew every step; the others are zero
  std::vector<BasisWeights<float>> weights_, weights_dt_;  ///< of the slots; the latter where it is wanted
  std::vector<Worker> workers_;                            ///< of the rays' tasks, then of the tracks'
  std::vector<Kernel> lookers_;                            ///< of all tasks of tracks
  std::vector<Sighting<float>> sightings_;                 ///< of all rays of tracks
  std::vector<TrackError<float>> asked_;                   ///< of the same
  std::vector<Vec3> colours_, given_;  ///< of all rays, and their gradients, for StepInput::colour_gradient
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
