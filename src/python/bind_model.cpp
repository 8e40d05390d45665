// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "core/atomic_file.hpp"
#include "field/columns.hpp"
#include "python/convert.hpp"
#include "run/scores_json.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/run/evaluate.hpp"

namespace splinevox::python {
namespace {

/// A renderer that keeps its model, for one thread at a time.
struct Looker {
  explicit Looker(ModelPtr m) : model(std::move(m)) {
    released([&] { renderer.emplace(*model); });
  }
  Rendered look(const Camera& camera, double time, double step_scale, double stop,
                std::optional<int> across) {
    constexpr double kLeastScale = 0.01, kMostScale = 100;
    if (!(step_scale >= kLeastScale && step_scale <= kMostScale && stop >= 0 && stop < 1))
      fail({"render", "there is no such march", "step_scale in 0.01 to 100 and stop in [0, 1)",
            std::to_string(step_scale) + ", " + std::to_string(stop), ""});
    if (!std::isfinite(time))
      fail({"render", "there is no such time", "model time in [0, 1]; beyond it the nearest moment is shown",
            std::to_string(time), ""});
    if (across && !(*across >= 1 && *across <= kMostAcross))
      fail({"render", "there are no such rays", "across in 1 to " + std::to_string(kMostAcross) + ", or None",
            std::to_string(*across), ""});
    Rendered out;
    released([&] {
      const std::lock_guard lock(mutex);
      out = renderer->render(camera, time, {float(stop), float(step_scale), across.value_or(0)});
    });
    return out;
  }
  ModelPtr model;
  std::optional<Renderer> renderer;
  std::mutex mutex;
};

/// The layers of a picture as arrays.
struct Pictures {
  py::array_t<float> rgb, alpha, depth, flow, rigidity;
  explicit Pictures(Rendered&& r)
      : rgb(array_of(std::move(r.rgb))),
        alpha(array_of(std::move(r.alpha))),
        depth(array_of(std::move(r.depth))),
        flow(array_of(std::move(r.flow))),
        rigidity(array_of(std::move(r.rigidity))) {}
};

VoxelModel& model_of(const py::object& self) { return *self.cast<ModelPtr>(); }

/// A kind of column in every row, as it lies in memory; None where the model has none.
py::object view_of_column(const ColumnFacts& facts, const py::object& self) {
  VoxelModel& model = model_of(self);
  const std::vector<Column> columns = columns_of(model, facts.kind);
  if (columns.empty()) return py::none();
  Channels& rows = facts.of_motion() ? model.motion.levels[0] : model.radiance.raw;
  std::vector<py::ssize_t> shape{py::ssize_t(rows.values.size()) / rows.width}, strides{rows.width * 4};
  if (facts.repeat != Repeat::once) {
    shape.push_back(py::ssize_t(columns.size()));
    strides.push_back(columns.size() > 1 ? (columns[1].first - columns[0].first) * 4 : 4);
  }
  if (facts.width > 1) {
    shape.push_back(facts.width);
    strides.push_back(4);
  }
  return view_of(rows.values.data() + columns[0].first, shape, strides, self);
}

/// "float32 (rows, stored points, 3), scene units; ...".
std::string about(const ColumnFacts& facts) {
  constexpr const char* kRepeated[] = {"", " coefficients", " stored points"};
  std::string shape = std::string("(rows,") + kRepeated[int(facts.repeat)];
  if (facts.width > 1) shape += (facts.repeat == Repeat::once ? " " : ", ") + std::to_string(facts.width);
  return "float32 " + shape + ")" + facts.about;
}

py::array_t<float> positions(const Topology& t) {
  py::array_t<float> out({py::ssize_t(t.rows()), py::ssize_t(3)});
  float* p = out.mutable_data();
  std::fill_n(p, 3 * kBrickRows, std::numeric_limits<float>::quiet_NaN());
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(b, i);
      std::copy_n(&x.x, 3, p + 3 * (std::size_t(b) * kBrickRows + std::size_t(i)));
    }
  return out;
}

/// [times][points] as arrays (times, n, 3) and (times, n).
py::tuple tracked(const std::vector<std::vector<TrackedPoint>>& found, std::size_t points) {
  py::array_t<float> place({py::ssize_t(found.size()), py::ssize_t(points), py::ssize_t(3)});
  py::array_t<bool> folded({py::ssize_t(found.size()), py::ssize_t(points)});
  float* p = place.mutable_data();
  bool* f = folded.mutable_data();
  for (const auto& row : found)
    for (const TrackedPoint& t : row) {
      *p++ = t.position.x;
      *p++ = t.position.y;
      *p++ = t.position.z;
      *f++ = t.folded;
    }
  return py::make_tuple(place, folded);
}

void check_time(double t) {
  if (!(t >= 0 && t <= 1))
    fail({"time", "there is no such time in the model", "a number in [0, 1]", std::to_string(t), ""});
}

py::tuple track_points(const ModelPtr& model, const Floats& array, double from, std::vector<double> to) {
  const std::vector<Vec3> points = points_of(array);
  check_time(from);
  for (const double t : to) check_time(t);
  std::vector<std::vector<TrackedPoint>> found;
  released([&] { found = track(*model, points, from, to); });
  return tracked(found, points.size());
}

py::tuple warp_points(const ModelPtr& model, const Floats& array, double time) {
  const std::vector<Vec3> points = points_of(array);
  check_time(time);
  std::vector<std::vector<TrackedPoint>> found(1);
  released([&] { found[0] = to_canonical(*model, points, time); });
  const py::tuple both = tracked(found, points.size());
  const py::object places = py::object(both[0])[py::int_(0)], folded = py::object(both[1])[py::int_(0)];
  return py::make_tuple(places, folded);
}

ModelPtr model_of_file(const std::string& path) {
  auto model = std::make_shared<VoxelModel>();
  released([&] { *model = load_model(path); });
  return model;
}

/// A file that is gone with the object.
struct PassingFile {
  PassingFile()
      : folder(py::module_::import("tempfile").attr("TemporaryDirectory")()),
        path(folder.attr("name").cast<std::string>() + "/model.vdb") {}
  ~PassingFile() { folder.attr("cleanup")(); }
  const py::object folder;
  const std::string path;
};

/// A model's file: what is empty in it has no rows.
py::bytes model_bytes(const ModelPtr& model) {
  const PassingFile file;
  released([&] { save_model(file.path, *model, {}, false); });
  return py::bytes(run::read_text(file.path));
}

ModelPtr model_of_bytes(const py::bytes& bytes) {
  const PassingFile file;
  write_file(file.path, {std::string(bytes)});
  return model_of_file(file.path);
}

std::string describe_model(const VoxelModel& v) {
  const Vec3 size = v.box.hi - v.box.lo;
  const std::string motion = v.motion.levels.empty()
                                 ? "nothing changes"
                                 : fmt::format("{} control points on {} bricks", v.motion.points,
                                               v.motion.levels[0].topology->brick_count());
  return fmt::format("<splinevox.Model {:.3g} x {:.3g} x {:.3g}, {} bricks of radiance, {}>", size.x, size.y,
                     size.z, v.radiance.raw.topology->brick_count(), motion);
}

void bind_views(py::class_<VoxelModel, ModelPtr>& model) {
  for (const ColumnFacts& facts : kColumns)
    model.def_property_readonly(
        facts.array, [&facts](const py::object& self) { return view_of_column(facts, self); },
        about(facts).c_str());
  model
      .def(
          "radiance_positions", [](const VoxelModel& m) { return positions(*m.radiance.raw.topology); },
          "float32 (rows, 3): where density, rgb and sh are; scene units. A copy.")
      .def(
          "motion_positions",
          [](const VoxelModel& m) -> py::object {
            if (m.motion.levels.empty()) return py::none();
            return positions(*m.motion.levels[0].topology);
          },
          "float32 (rows, 3): where control_points, light, presence and rigidity are; None where nothing "
          "changes. A "
          "copy.");
}

}  // namespace

py::object evaluate(const VoxelModel& model, const Split& split) {
  run::Scores scores;
  released([&] {
    Renderer renderer(model);
    scores = run::evaluate(model, renderer, split);
  });
  return object_of(run::scores_json(scores));
}

void bind_model(py::module_& m) {
  py::class_<Pictures>(m, "Rendered", "What one view shows; float32 arrays.")
      .def_readonly("rgb", &Pictures::rgb, "(height, width, 3) over the background, not clamped")
      .def_readonly("alpha", &Pictures::alpha, "(height, width)")
      .def_readonly("depth", &Pictures::depth,
                    "(height, width), scene units along the viewing axis; 0 where alpha is 0")
      .def_readonly("flow", &Pictures::flow,
                    "(height, width, 3), displacement to the canonical volume, scene units")
      .def_readonly("rigidity", &Pictures::rigidity, "(height, width): 1 moves, 0 is static");

  py::class_<VoxelModel, ModelPtr> model(m, "Model", "A reconstructed scene.");
  model
      .def(
          "render",
          [](const ModelPtr& self, const Camera& camera, double time, double step_scale, double stop,
             std::optional<int> across) {
            return Pictures(Looker(self).look(camera, time, step_scale, stop, across));
          },
          "One picture at a time in [0, 1]; of several, a Renderer is faster. across x across rays go "
          "through a pixel; None: as many as `splinevox render` takes.",
          py::arg("camera"), py::arg("time"), py::arg("step_scale") = 1.0,
          py::arg("stop") = double(RenderOptions().stop), py::arg("across") = py::none())
      .def(
          "evaluate",
          [](const VoxelModel& self, const Dataset& data, const std::string& split) {
            const Split* found = data.find(split);
            if (!found)
              fail({data.path, "there is no split '" + split + "'", "train, val or test, if it was read",
                    split, ""});
            return evaluate(self, *found);
          },
          "psnr, ssim, ms_ssim of a split and of its frames, as `splinevox eval --json`.", py::arg("dataset"),
          py::arg("split") = "test")
      .def("warp", &warp_points,
           "The canonical places of points (n, 3) of a time, and where the warp is not one to one: float32 "
           "(n, 3), bool (n,).",
           py::arg("points"), py::arg("time"))
      .def("track", &track_points,
           "Points (n, 3) of one time carried to others: float32 (times, n, 3), bool (times, n) where they "
           "are not to be trusted.",
           py::arg("points"), py::arg("from_time"), py::arg("to_times"))
      .def_property_readonly(
          "box", [](const VoxelModel& v) { return corners(v.box); },
          "((x, y, z), (x, y, z)), scene units; outside it is empty")
      .def_property_readonly(
          "background",
          [](const VoxelModel& v) {
            const Vec3 c = v.background.color;
            return std::array<float, 3>{c.x, c.y, c.z};
          },
          "colour behind everything; of a learned background its mean")
      .def(
          "background_towards",
          [](const VoxelModel& v, const std::array<double, 3>& direction) {
            const Vec3d d{direction[0], direction[1], direction[2]};
            const double n = length(d);
            if (!(n > 0 && n < 1e150))
              fail({"direction", "is no direction", "three finite numbers, not all 0",
                    std::to_string(d.x) + ", " + std::to_string(d.y) + ", " + std::to_string(d.z), ""});
            const Vec3 c = v.background.towards(cast<float>(normalize(d)));
            return std::array<float, 3>{c.x, c.y, c.z};
          },
          "Colour behind everything in a direction: where it was learned it is not the same everywhere.",
          py::arg("direction"))
      .def_property_readonly(
          "moves", [](const VoxelModel& v) { return v.motion.moves(); }, "whether it has motion")
      .def_property_readonly(
          "points", [](const VoxelModel& v) { return v.motion.points; }, "control points of a curve")
      .def_property_readonly(
          "density_activation",
          [](const VoxelModel& v) {
            return std::pair(v.radiance.activation.scale, v.radiance.activation.shift);
          },
          "(scale, shift): density per scene unit is scale * softplus(raw + shift)")
      .def(
          "copy", [](const VoxelModel& v) { return std::make_shared<VoxelModel>(v); },
          "A model of its own with the same values.")
      .def(py::pickle(&model_bytes, &model_of_bytes))
      .def("__repr__", &describe_model);
  bind_views(model);

  py::class_<Looker>(
      m, "Renderer",
      "Renders one model many times: what it finds out about the model, and about the last time, it keeps.")
      .def(py::init([](const ModelPtr& v) { return std::make_unique<Looker>(v); }), py::arg("model"))
      .def(
          "render",
          [](Looker& self, const Camera& camera, double time, double step_scale, double stop,
             std::optional<int> across) {
            return Pictures(self.look(camera, time, step_scale, stop, across));
          },
          "A picture at a time in [0, 1]; see Model.render.", py::arg("camera"), py::arg("time"),
          py::arg("step_scale") = 1.0, py::arg("stop") = double(RenderOptions().stop),
          py::arg("across") = py::none());

  m.def("load_model", &model_of_file, "Reads a model.vdb.", py::arg("path"));
  m.def(
      "save_model",
      [](const std::string& path, const ModelPtr& v, const ModelNotes& notes, bool half) {
        released([&] { save_model(path, *v, notes, half); });
      },
      "Writes a model.vdb, whole or not at all. half: 16-bit floats.", py::arg("path"), py::arg("model"),
      py::arg("notes") = ModelNotes{}, py::arg("half") = false);
}

}  // namespace splinevox::python
