// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <type_traits>

#include "core/parallel.hpp"
#include "half_rows.hpp"
#include "render/field_view.hpp"
#include "render/occupancy.hpp"
#include "render/ray_kernel.hpp"
#include "solid_preset.hpp"
#include "splinevox/data/synth.hpp"
#include "suites.hpp"
#include "timing.hpp"
#include "train/refine.hpp"
#include "trained.hpp"

namespace splinevox::cost {
namespace {

constexpr int kSh = 1;      ///< harmonic order of the models here
constexpr int kCells = 64;  ///< of the occupancy
constexpr float kEmptyAlpha = 1e-3f;

/// A model at one time before one camera, computed in Real with the radiance rows kept as Stored.
template <class Real, class Stored = Real>
class Shot {
 public:
  Shot(const VoxelModel& model, const Camera& camera, double time)
      : model_(model),
        camera_(camera),
        time_(time),
        canonical_(canonical_occupancy(model, kCells, kEmptyAlpha, model.step)) {
    const auto& raw = model.radiance.raw;
    rows_.assign(raw.values.begin(), raw.values.end());
    make_frame();
  }

  /// What a renderer does anew for every time: the motion contracted to a slice, and where there is matter
  /// then.
  void make_frame() {
    fill_slice(model_.motion, stored_weights(model_.motion, time_), contracted_);
    occupied_ = frame_occupancy(model_, contracted_, canonical_);
    if constexpr (!std::is_same_v<Real, float>)
      slice_.assign(contracted_.values.begin(), contracted_.values.end());
  }

  /// [height * width * 3] and the samples in stored bricks. @param skip  leave out cells that the occupancy
  /// calls empty.
  std::vector<double> picture(double step_scale, double stop, bool skip, double* samples = nullptr) const {
    const FieldView<Real, Stored> field = view_field(model_, rows_.data(), Real(model_.step * step_scale));
    FrameView<Real> frame;
    if constexpr (std::is_same_v<Real, float>)
      frame.slice = contracted_.values.data();
    else
      frame.slice = slice_.data();
    const OccupancyView<float> cells = occupied_.view();
    frame.occupancy.origin = cast<Real>(cells.origin);
    frame.occupancy.inv_cell = Real(cells.inv_cell);
    frame.occupancy.size = cells.size;
    frame.occupancy.bits = skip ? cells.bits : nullptr;
    std::vector<double> out(std::size_t(camera_.width) * camera_.height * 3);
    std::vector<double> counts(std::size_t(camera_.height));
    parallel_for(camera_.height, [&](int y) {
      RayKernel<Real, kSh, Stored> kernel;
      for (int x = 0; x < camera_.width; ++x) {
        const Ray ray = camera_ray(camera_, x + 0.5, y + 0.5);
        const RayInput<Real> in = clip_ray(ray, model_.box, field.step, Real(0.5), model_.background.color);
        const RayResult<Real> result = kernel.forward(in, field, frame, Real(stop));
        counts[y] += kernel.count;
        for (int c = 0; c < 3; ++c) out[(std::size_t(y) * camera_.width + x) * 3 + c] = double(result.rgb[c]);
      }
    });
    if (samples) {
      *samples = 0;
      for (const double c : counts) *samples += c / double(camera_.width) / camera_.height;
    }
    return out;
  }

 private:
  const VoxelModel& model_;
  Camera camera_;
  double time_;
  OccupancyPyramid canonical_;
  MotionSlice contracted_;
  BitGrid occupied_;
  AlignedVector<Stored> rows_;
  AlignedVector<Real> slice_;  ///< contracted_ in Real, where that is not float
};

/// The model with its radiance on a lattice of a share of the cells, its march step longer by as much: a
/// level of detail.
VoxelModel coarser(const VoxelModel& model, int factor) {
  VoxelModel out = model;
  const Lattice& fine = model.radiance.raw.topology->lattice;
  const int cells = std::max({fine.size.x, fine.size.y, fine.size.z}) - 1;
  const BitGrid matter = canonical_occupancy(model, kCells, kEmptyAlpha, model.step);
  out.radiance.raw =
      resample(model.radiance.raw, bricks_near(make_lattice(model.box, std::max(1, cells / factor)), matter));
  out.step = model.step * float(factor);
  return out;
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / double(a.size()));
}

/// A model that moves, seen from a test view.
struct Stage {
  std::string name;
  Dataset data;
  VoxelModel model;
  const Frame& frame() const { return data.find("test")->frames[data.find("test")->frames.size() / 2]; }
};

Stage make_stage(const SuiteOptions& o, const std::string& scene) {
  Stage s;
  s.name = scene.empty() ? "dancer" : std::filesystem::path(scene).filename().string();
  s.data = scene.empty() ? make_synth("dancer", {.frames = 40, .size = o.micro ? 64 : 200})
                         : load_dataset(scene, {.splits = {"train", "test"}});
  Config config = solid_preset("fast");
  config.run.max_time = 0;
  config.run.max_steps = o.micro ? 300 : 1500;
  config.radiance.sh_order = kSh;
  if (o.micro) {
    config.grid.radiance = {24, 48};
    config.grid.radiance_start = {0, .3f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0, .2f};
    config.sampling.rays = 1024;
    // In 300 steps a window of time leaves fog at the sides of the box, where rays then end in a jump: no
    // model to measure an order on.
    config.sampling.window = 1;
    config.motion.presence = true;  // without it, too, 300 steps leave something there: the order is 1.2
  }
  s.model = train_to_end(config, s.data).model;
  return s;
}

/// Richardson's extrapolation of the midpoint rule: the error of order 2 cancels.
std::vector<double> reference(const Shot<double>& shot) {
  std::vector<double> coarse = shot.picture(1.0 / 32, 0, false), fine = shot.picture(1.0 / 64, 0, false);
  for (std::size_t i = 0; i < fine.size(); ++i) fine[i] += (fine[i] - coarse[i]) / 3;
  return fine;
}

/// The order of convergence between steps of 1/4 and 1/16.
double convergence(const Shot<double>& shot, const std::vector<double>& truth) {
  const double coarse = rms(shot.picture(0.25, 0, false), truth),
               fine = rms(shot.picture(1.0 / 16, 0, false), truth);
  return std::log2(coarse / fine) / 2;
}

/// A way to make the picture: settings, and what makes it with them.
struct Variant {
  std::string knob, value;
  double order = 0, step_scale = 1, stop = 1e-3;
  bool skip = true, dominated = false;
  std::function<std::vector<double>(double*)>
      work{};  ///< [height * width * 3]; fills in the samples a ray where asked to
};

std::vector<Variant> variants(bool micro) {
  std::vector<Variant> out{{"default", "step 1, stop 1e-3, skipping, float"}};
  for (const double s : micro ? std::vector<double>{2, 0.5, 0.25}
                              : std::vector<double>{2, 1.5, 0.75, 0.5, 0.25, 0.125, 0.0625})
    out.push_back({.knob = "step", .value = fmt::format("{}", s), .order = -s, .step_scale = s});
  for (const double t :
       micro ? std::vector<double>{1e-1, 1e-5} : std::vector<double>{1e-1, 1e-2, 1e-4, 1e-5, 1e-6})
    out.push_back({.knob = "stop", .value = fmt::format("{:g}", t), .order = -std::log10(t), .stop = t});
  // As accurate as the step alone allows: an early stop and skipped cells have errors of their own.
  for (const double s : micro ? std::vector<double>{0.5} : std::vector<double>{1, 0.5, 0.25, 0.125, 0.0625})
    out.push_back({.knob = "step, nothing left out",
                   .value = fmt::format("{}", s),
                   .order = -s,
                   .step_scale = s,
                   .stop = 1e-6,
                   .skip = false});
  out.push_back({.knob = "skipping", .value = "off", .order = 1, .skip = false, .dominated = true});
  return out;
}

}  // namespace

double render_suite(const SuiteOptions& o, const OnRecord& on_record) {
  std::optional<double> order;
  for (const std::string& scene : o.scenes.empty() ? std::vector<std::string>{""} : o.scenes) {
    const Stage stage = make_stage(o, scene);
    const Frame& frame = stage.frame();
    const VoxelModel half_lattice = coarser(stage.model, 2), quarter_lattice = coarser(stage.model, 4);
    Shot<float> single(stage.model, frame.camera, frame.time);
    const Shot<float, Half> half(stage.model, frame.camera, frame.time);
    const Shot<double> twice(stage.model, frame.camera, frame.time);
    const Shot<float> half_detail(half_lattice, frame.camera, frame.time),
        quarter_detail(quarter_lattice, frame.camera, frame.time);
    const std::vector<double> truth = reference(twice);
    if (!order) order = convergence(twice, truth);

    std::vector<Variant> list = variants(o.micro);
    const Variant base = list.front();
    const auto plain = [](const auto& shot, const Variant& v) {
      return [&shot, v](double* samples) { return shot.picture(v.step_scale, v.stop, v.skip, samples); };
    };
    for (Variant& v : list) v.work = plain(single, v);
    list.push_back(
        {.knob = "precision", .value = "double", .order = 1, .dominated = true, .work = plain(twice, base)});
    list.push_back({.knob = "precision",
                    .value = "radiance rows in half floats",
                    .order = -1,
                    .work = plain(half, base)});
    list.push_back({.knob = "detail",
                    .value = "half the cells, twice the step",
                    .order = -1,
                    .work = plain(half_detail, base)});
    list.push_back({.knob = "detail",
                    .value = "a quarter of the cells, four times the step",
                    .order = -2,
                    .work = plain(quarter_detail, base)});
    list.push_back({.knob = "slice",
                    .value = "made for this picture",
                    .order = 1,
                    .work = [&, again = plain(single, base)](double* samples) {
                      single.make_frame();
                      return again(samples);
                    }});
    list.push_back({.knob = "A/A", .value = "the default again", .work = plain(single, base)});

    std::vector<Candidate> candidates;
    for (const Variant& v : list) candidates.push_back({v.value, [&v] { v.work(nullptr); }});
    const int rounds = o.micro ? 5 : o.rounds;
    const std::vector<Timed> timed = interleave(candidates, rounds);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Variant& v = list[i];
      Record r;
      const double error = rms(v.work(&r.samples), truth);
      r.suite = "render";
      r.scene = stage.name;
      r.knob = v.knob;
      r.value = v.value;
      r.order = v.order;
      r.error = {error, error, error};
      r.seconds = timed[i].seconds;
      r.instructions = timed[i].instructions;
      r.runs = rounds;
      r.is_default = i == 0;
      r.expected_dominated = v.dominated;
      r.failed = !std::isfinite(error);
      r.note = fmt::format("{:.3f} [{:.3f}, {:.3f}] times the default's time", timed[i].ratio.value,
                           timed[i].ratio.lo, timed[i].ratio.hi);
      on_record(r);
    }
  }
  return *order;
}

}  // namespace splinevox::cost
