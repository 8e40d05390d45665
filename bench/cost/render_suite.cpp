// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splinevox/core/parallel.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/render/field_view.hpp"
#include "splinevox/render/occupancy.hpp"
#include "splinevox/render/ray_kernel.hpp"
#include "suites.hpp"
#include "timing.hpp"
#include "trained.hpp"

namespace splinevox::cost {
namespace {

constexpr int kSh = 1;               ///< harmonic order of the models here
constexpr int kCells = 64;           ///< of the occupancy
constexpr float kEmptyAlpha = 1e-3f;

/// A model at one time before one camera, in the precision of Real.
template <class Real>
class Shot {
 public:
  Shot(const VoxelModel& model, const Camera& camera, double time) : model_(model), camera_(camera) {
    const MotionSlice slice = make_slice(model.motion, stored_weights(model.motion, time));
    occupied_ = frame_occupancy(model, slice, OccupancyPyramid(canonical_occupancy(model, kCells, kEmptyAlpha, model.step)));
    slice_.assign(slice.values.begin(), slice.values.end());
    const auto& raw = model.radiance.raw;
    rows_.assign(raw.values.begin(), raw.values.end());
    field_.radiance = BrickView<Real>(*raw.topology);
    field_.radiance_rows = rows_.data();
    field_.density_scale = Real(model.radiance.activation.scale), field_.density_shift = Real(model.radiance.activation.shift);
    field_.moving = !model.motion.levels.empty();
    if (field_.moving) field_.motion = BrickView<Real>(*model.motion.levels.back().topology);
    field_.rigidity = model.motion.rigidity, field_.rigidity_offset = Real(model.motion.rigidity_offset);
  }

  /// [height * width * 3] and the samples in stored bricks. @param skip  leave out cells that the occupancy calls empty.
  std::vector<double> picture(double step_scale, double stop, bool skip, double* samples = nullptr) const {
    FieldView<Real> field = field_;
    field.step = Real(model_.step * step_scale);
    FrameView<Real> frame;
    frame.slice = slice_.data();
    const OccupancyView<float> cells = occupied_.view();
    frame.occupancy.origin = cast<Real>(cells.origin), frame.occupancy.inv_cell = Real(cells.inv_cell);
    frame.occupancy.size = cells.size, frame.occupancy.bits = skip ? cells.bits : nullptr;
    std::vector<double> out(std::size_t(camera_.width) * camera_.height * 3);
    std::vector<double> counts(std::size_t(camera_.height));
    parallel_for(camera_.height, [&](int y) {
      RayKernel<Real, kSh> kernel;
      for (int x = 0; x < camera_.width; ++x) {
        const Ray ray = camera_ray(camera_, x + 0.5, y + 0.5);
        const Interval inside = intersect(model_.box, ray.origin, ray.direction);
        RayInput<Real> in;
        in.background = cast<Real>(model_.background), in.direction = cast<Real>(ray.direction);
        const double first = inside.near + 0.5 * double(field.step);
        in.origin = cast<Real>(ray.origin + first * ray.direction);
        in.count = first > inside.far ? 0 : int((inside.far - first) / double(field.step)) + 1;
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
  BitGrid occupied_;
  AlignedVector<Real> rows_, slice_;
  FieldView<Real> field_;
};

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
  s.data = scene.empty() ? make_synth("dancer", {.frames = 40, .size = o.micro ? 64 : 200}) : load_dataset(scene, {.splits = {"train", "test"}});
  Config config = preset("fast");
  config.run.max_time = 0, config.run.max_steps = o.micro ? 300 : 1500;
  if (o.micro) config.grid.radiance = {24, 48}, config.grid.radiance_start = {0, .3f}, config.grid.motion = {4, 8}, config.grid.motion_start = {0, .2f}, config.sampling.rays = 1024;
  s.model = train_to_end(config, s.data).model;
  return s;
}

/// Richardson's extrapolation of the midpoint rule: the error of order 2 cancels.
std::vector<double> reference(const Shot<double>& shot) {
  std::vector<double> coarse = shot.picture(1.0 / 32, 0, false), fine = shot.picture(1.0 / 64, 0, false);
  for (std::size_t i = 0; i < fine.size(); ++i) fine[i] += (fine[i] - coarse[i]) / 3;
  return fine;
}

struct Variant {
  std::string knob, value;
  double order, step_scale, stop;
  bool skip, in_double, is_default, dominated;
};

std::vector<Variant> variants(bool micro) {
  std::vector<Variant> out{{"default", "step 1, stop 1e-3, skipping, float", 0, 1, 1e-3, true, false, true, false}};
  for (const double s : micro ? std::vector<double>{2, 0.5, 0.25} : std::vector<double>{2, 1.5, 0.75, 0.5, 0.25, 0.125, 0.0625})
    out.push_back({"step", fmt::format("{}", s), -s, s, 1e-3, true, false, false, false});
  for (const double t : micro ? std::vector<double>{1e-1, 1e-5} : std::vector<double>{1e-1, 1e-2, 1e-4, 1e-5, 1e-6})
    out.push_back({"stop", fmt::format("{:g}", t), -std::log10(t), 1, t, true, false, false, false});
  out.push_back({"skipping", "off", 1, 1, 1e-3, false, false, false, true});
  out.push_back({"precision", "double", 1, 1, 1e-3, true, true, false, true});
  return out;
}

}  // namespace

void render_suite(const SuiteOptions& o, const Told& told) {
  for (const std::string& scene : o.scenes.empty() ? std::vector<std::string>{""} : o.scenes) {
    const Stage stage = make_stage(o, scene);
    const Frame& frame = stage.frame();
    const Shot<float> single(stage.model, frame.camera, frame.time);
    const Shot<double> twice(stage.model, frame.camera, frame.time);
    const std::vector<double> truth = reference(twice);
    const std::vector<Variant> list = variants(o.micro);
    std::vector<Candidate> candidates;
    for (const Variant& v : list)
      candidates.push_back({v.value, [&] { v.in_double ? twice.picture(v.step_scale, v.stop, v.skip) : single.picture(v.step_scale, v.stop, v.skip); }});
    candidates.push_back({"A/A", candidates[0].run});
    const int rounds = o.micro ? 5 : o.rounds;
    const std::vector<Timed> timed = interleave(candidates, rounds);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const bool again = i == list.size();
      const Variant& v = list[again ? 0 : i];
      Record r;
      const double error = rms(v.in_double ? twice.picture(v.step_scale, v.stop, v.skip, &r.samples) : single.picture(v.step_scale, v.stop, v.skip, &r.samples), truth);
      r.suite = "render", r.scene = stage.name, r.knob = again ? "A/A" : v.knob, r.value = again ? "the default again" : v.value, r.order = v.order;
      r.error = {error, error, error}, r.seconds = timed[i].seconds, r.instructions = timed[i].instructions, r.runs = rounds;
      r.is_default = v.is_default && !again, r.expected_dominated = v.dominated, r.failed = !std::isfinite(error);
      r.note = fmt::format("{:.3f} [{:.3f}, {:.3f}] times the default's time", timed[i].ratio.value, timed[i].ratio.lo, timed[i].ratio.hi);
      told(r);
    }
  }
}

double render_order(const SuiteOptions& o) {
  const Stage stage = make_stage(o, o.scenes.empty() ? "" : o.scenes.front());
  const Shot<double> shot(stage.model, stage.frame().camera, stage.frame().time);
  const std::vector<double> truth = reference(shot);
  const double coarse = rms(shot.picture(0.25, 0, false), truth), fine = rms(shot.picture(1.0 / 16, 0, false), truth);
  return std::log2(coarse / fine) / 2;
}

}  // namespace splinevox::cost
