// SPDX-License-Identifier: Apache-2.0
// The kernels of a training step, each alone, on one thread: ./dev bench micro [FILTER]. The label says what
// the items of a line are. Bytes are those that must be read and written at least.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>

#include "backend/host/optimiser.hpp"
#include "math/photometric.hpp"
#include "render/backward.hpp"
#include "render/field_view.hpp"
#include "render/scatter.hpp"
#include "scene.hpp"
#include "train/learner.hpp"

namespace splinevox::micro {
namespace {

using benchmark::State;
using Kernel = RayKernel<float, kOrder>;
using Records = RayRecords<float, Kernel::kWidth, false>;

constexpr Vec3 kTarget{0.5f, 0.5f, 0.5f};  // colour that every ray should have
constexpr std::size_t kTaskRays = 128;     // as training cuts a batch

/// The two rates of a line. @param items, bytes  of one iteration
void rates(State& state, const char* label, double items, double bytes) {
  const double iterations = double(state.iterations());
  state.SetLabel(label);
  state.SetItemsProcessed(std::int64_t(items * iterations));
  if (bytes > 0) state.SetBytesProcessed(std::int64_t(bytes * iterations));
}

std::size_t count(std::span<const RowMask> rows) {
  std::size_t set = 0;
  for (const RowMask& mask : rows)
    for (const std::uint64_t word : mask.word) set += std::popcount(word);
  return set;
}

void ray_forward(State& state) {
  const Scene& s = scene();
  const FieldView<float> field = view_field(s.model, s.model.step);
  Kernel kernel;
  std::int64_t samples = 0;
  for (auto _ : state)
    for (std::size_t f = 0; f < s.times.size(); ++f)
      for (const RayInput<float>& ray : s.rays_of(f)) {
        benchmark::DoNotOptimize(kernel.forward(ray, field, s.frame(f), s.config.sampling.stop));
        samples += kernel.count;
      }
  const double each = double(samples) / double(state.iterations());
  rates(state, "samples", each, 0);
  state.counters["samples_per_ray"] = each / double(s.rays.size());
}

/// A task's rays, with what the backward sweep needs of each.
struct Task {
  std::vector<Kernel> kernels = std::vector<Kernel>(kTaskRays);
  std::vector<RayResult<float>> results = std::vector<RayResult<float>>(kTaskRays);
  const FieldView<float> field = view_field(scene().model, scene().model.step);

  void forward(std::size_t slot, std::span<const RayInput<float>> rays) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      results[i] = kernels[i].forward(rays[i], field, scene().frame(slot), scene().config.sampling.stop);
  }
  void backward(std::span<const RayInput<float>> rays, Records& out) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Vec3 error = photometric_error(results[i].rgb, kTarget);
      splinevox::backward(kernels[i], rays[i], results[i], field, 2.0f * error,
                          scene().config.sampling.min_weight, out);
    }
  }
};

/// Calls visit(slot, rays) for each task of a step.
template <class Visit>
void for_tasks(Visit&& visit) {
  for (std::size_t f = 0; f < scene().times.size(); ++f) {
    const std::span<const RayInput<float>> rays = scene().rays_of(f);
    for (std::size_t first = 0; first < rays.size(); first += kTaskRays)
      visit(f, rays.subspan(first, std::min(kTaskRays, rays.size() - first)));
  }
}

void ray_backward(State& state) {
  Task task;
  Records records;
  std::size_t made = 0;
  for (auto _ : state)
    for_tasks([&](std::size_t slot, std::span<const RayInput<float>> rays) {
      state.PauseTiming();
      task.forward(slot, rays);
      records.clear();
      state.ResumeTiming();
      task.backward(rays, records);
      made += records.radiance.size();
    });
  rates(state, "samples with a gradient", double(made) / double(state.iterations()), 0);
}

/// What the rays of a step leave behind, task by task.
struct Tasks {
  std::vector<int> slots;
  std::vector<Records> records;
};
const Tasks& tasks() {
  static const Tasks all = [] {
    Tasks out;
    Task task;
    for_tasks([&](std::size_t slot, std::span<const RayInput<float>> rays) {
      task.forward(slot, rays);
      task.backward(rays, out.records.emplace_back());
      out.slots.push_back(int(slot));
    });
    return out;
  }();
  return all;
}

/// The records of one kind, summed into rows; every slot has rows of its own.
template <int Width>
struct Sums {
  using Kind = std::vector<Record<float, Width>> Records::*;
  Kind kind;
  BrickView<float> view;
  int bricks, slots;
  std::vector<AlignedVector<float>> rows;  ///< [slots] of [rows * Width]
  std::vector<RowMask> touched;            ///< [slots * bricks]
  Scatter<float, Width, false> scatter;

  Sums(Kind k, const Topology& topology, int slot_count)
      : kind(k), view(topology), bricks(topology.brick_count() + 1), slots(slot_count) {
    rows.assign(slots, AlignedVector<float>(topology.rows() * Width, 0.0f));
    touched.resize(std::size_t(slots) * bricks);
  }
  std::size_t records() const {
    std::size_t all = 0;
    for (const Records& task : tasks().records) all += (task.*kind).size();
    return all;
  }
  void add() {
    const int count = int(tasks().records.size());
    scatter.begin(count, bricks, slots);
    for (int t = 0; t < count; ++t)
      scatter.count(t, tasks().records[t].*kind, view, slots > 1 ? tasks().slots[t] : 0);
    scatter.scan();
    for (int t = 0; t < count; ++t) scatter.fill(t, view);
    for (int bin = 0; bin < slots * bricks; ++bin) {
      if (scatter.empty(bin)) continue;
      float* const to = rows[bin / bricks].data() + std::size_t(bin % bricks) * kBrickRows * Width;
      scatter.reduce(bin, to, touched[bin]);
    }
  }
};
using RadianceSums = Sums<Kernel::kWidth>;
using MotionSums = Sums<kSliceWidth>;

RadianceSums radiance_sums() { return {&Records::radiance, *scene().model.radiance.raw.topology, 1}; }
MotionSums motion_sums() {
  const Scene& s = scene();
  return {&Records::motion, *s.model.motion.levels[0].topology, int(s.times.size())};
}

template <int Width>
void scatter(State& state, Sums<Width> sums) {
  const double records = double(sums.records());
  for (auto _ : state) sums.add();
  rates(state, "records", records, records * sizeof(Record<float, Width>));
}

void contract(State& state) {
  const Scene& s = scene();
  const Channels& level = s.model.motion.levels[0];
  std::vector<MotionSlice> slices = s.slices;
  std::vector<float*> out;
  for (MotionSlice& slice : slices) out.push_back(slice.values.data());
  for (auto _ : state)
    for (int b = 0; b <= level.topology->brick_count(); ++b)
      contract_brick(s.model.motion, level, s.weights, b, s.active[b], out);
  const double rows = double(count(s.active)), slots = double(slices.size());
  rates(state, "rows and times", rows * slots, rows * sizeof(float) * (level.width + slots * kSliceWidth));
}

/// Adds the gradient of every slot's slice to that of the control points. Clears the slices' gradients.
void expand_all(MotionSums& slices, Gradient& out) {
  const Scene& s = scene();
  for (int b = 1; b < slices.bricks; ++b)
    for (int f = 0; f < slices.slots; ++f) {
      RowMask hit = slices.touched[std::size_t(f) * slices.bricks + b];
      hit &= s.active[b];
      float* const rows = slices.rows[f].data() + std::size_t(b) * kBrickRows * kSliceWidth;
      expand_brick(s.model.motion, s.weights[f], hit, rows, b, out.values);
      out.touched[b] |= hit;
    }
}

/// From the second time on it adds zeros, which takes as long.
void expand(State& state) {
  MotionSums slices = motion_sums();
  slices.add();
  Gradient out(scene().model.motion.levels[0]);
  for (auto _ : state) expand_all(slices, out);
  rates(state, "rows and times", double(count(slices.touched)), 0);
}

Gradient radiance_gradient() {
  RadianceSums sums = radiance_sums();
  sums.add();
  Gradient out(scene().model.radiance.raw);
  out.values.values = sums.rows[0];
  out.touched = sums.touched;
  return out;
}
Gradient motion_gradient() {
  MotionSums slices = motion_sums();
  slices.add();
  Gradient out(scene().model.motion.levels[0]);
  expand_all(slices, out);
  return out;
}

void adam(State& state, Channels values, const Gradient& gradient, bool shrinks) {
  Learner learner(values);
  learner.rate.assign(values.width, 1e-4f);
  if (shrinks) learner.shrink = {{std::vector<float>(values.width, 1.0f), 1e-5f}};
  const MomentFactors factors = moment_factors(0.9, 0.99, 1e-8, 1000);
  Gradient present;
  for (auto _ : state) {
    state.PauseTiming();
    present = gradient;
    state.ResumeTiming();
    update(learned(values, learner), present, factors, 1);
  }
  // Parameters, gradients and two moments, each read and written.
  const double rows = double(count(gradient.touched));
  rates(state, "rows", rows, rows * values.width * sizeof(float) * 8);
}

void total_variation(State& state, const Channels& values) {
  const std::vector<float> weights(values.width, 1e-4f);
  Gradient gradient(values);
  for (auto _ : state) add_total_variation(values, weights, 1, 1, 0, {}, gradient);
  const double bricks = values.topology->brick_count();
  // Values are read, gradients read and written.
  rates(state, "bricks", bricks, bricks * kBrickRows * values.width * sizeof(float) * 3);
}

void refresh_occupancy(State& state) {
  const Scene& s = scene();
  const SamplingConfig& c = s.config.sampling;
  MotionSlice slice;
  for (auto _ : state) {
    const OccupancyPyramid canonical(
        canonical_occupancy(s.model, c.occupancy_cells, c.occupancy_alpha, s.model.step));
    for (const BasisWeights<float>& weights : s.weights) {
      fill_slice(s.model.motion, weights, slice);
      benchmark::DoNotOptimize(frame_occupancy(s.model, slice, canonical));
    }
  }
  rates(state, "cells and times", double(s.occupancy[0].cells() * s.times.size()), 0);
}

void list_benchmarks() {
  using benchmark::RegisterBenchmark;
  const auto radiance = []() -> const Channels& { return scene().model.radiance.raw; };
  const auto motion = []() -> const Channels& { return scene().model.motion.levels[0]; };
  RegisterBenchmark("ray_forward", ray_forward);
  RegisterBenchmark("ray_backward", ray_backward);
  RegisterBenchmark("scatter/radiance", [](State& s) { scatter(s, radiance_sums()); });
  RegisterBenchmark("scatter/motion", [](State& s) { scatter(s, motion_sums()); });
  RegisterBenchmark("slice_contract", contract);
  RegisterBenchmark("slice_expand", expand);
  RegisterBenchmark("update/radiance", [=](State& s) { adam(s, radiance(), radiance_gradient(), false); });
  RegisterBenchmark("update/motion", [=](State& s) { adam(s, motion(), motion_gradient(), true); });
  RegisterBenchmark("total_variation/radiance", [=](State& s) { total_variation(s, radiance()); });
  RegisterBenchmark("total_variation/motion", [=](State& s) { total_variation(s, motion()); });
  RegisterBenchmark("occupancy_refresh", refresh_occupancy);
}

}  // namespace
}  // namespace splinevox::micro

int main(int argc, char** argv) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  splinevox::micro::list_benchmarks();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::SetDefaultTimeUnit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
