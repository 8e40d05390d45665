// SPDX-License-Identifier: Apache-2.0
#include <atomic>

#include "data/pictures/exr.hpp"
#include "python/convert.hpp"
#include "report/write_report.hpp"
#include "run/edit_run.hpp"
#include "run/run_folder.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/run/run.hpp"
#include "view/write_view.hpp"

namespace splinevox::python {
namespace {

using RunPtr = std::shared_ptr<run::Run>;

/// The folder of a Run, or a path.
std::string folder_of(const py::handle& run) {
  if (py::isinstance<run::Run>(run)) return run.cast<const run::Run&>().path;
  return py::str(py::module_::import("os").attr("fspath")(run));
}

py::dict frame_of(const ExportedFrame& f) {
  py::list files;
  files.append(f.file.name);
  for (const ManifestFile& beside : f.beside) files.append(beside.name);
  py::dict out(py::arg("frame") = f.frame, py::arg("time") = f.time, py::arg("files") = files,
               py::arg("kept") = f.kept, py::arg("seconds") = f.seconds);
  for (const auto& [name, figure] : f.file.figures)
    if (name != "frame" && name != "time") out[py::str(name)] = figure;  // which are above
  return out;
}

/// Calls back with a frame; false ends the export.
bool call_back(const py::object& callback, const ExportedFrame& frame) {
  if (callback.is_none()) return true;
  const py::gil_scoped_acquire lock;
  return !is_false(callback(frame_of(frame)));
}

py::list export_frames(const py::object& source, const std::string& folder, const std::string& profile,
                       std::pair<int, int> frames, double fps, double seconds, std::optional<int> at,
                       double voxel_size, bool half, const std::string& bake_view, bool sh, bool flame,
                       const std::string& colorspace, double shutter, double min_alpha, bool controls,
                       bool mesh, const std::string& mesh_format, double mesh_alpha, const py::object& points,
                       std::optional<int> clusters, bool afresh, const py::object& callback) {
  ExportOptions o;
  o.first = frames.first;
  o.last = frames.second;
  o.fps = fps;
  o.seconds = seconds;
  o.at = at;
  o.profile = profile;
  o.voxel_size = voxel_size;
  o.half = half;
  o.bake_view = bake_view;
  o.sh = sh;
  o.flame = flame;
  o.colorspace = colorspace;
  o.shutter = shutter;
  o.min_alpha = min_alpha;
  o.controls = controls;
  o.mesh = mesh;
  o.mesh_format = mesh_format;
  o.mesh_alpha = mesh_alpha;
  if (const py::object count = own_scalar(points); py::isinstance<py::int_>(count))
    o.points.chosen = count.cast<int>();
  else
    o.points.position = points_of(points.cast<Floats>());
  o.clusters = clusters;
  o.resume = !afresh;
  const bool of_run = py::isinstance<run::Run>(source);
  if (of_run) o.run = run::whole_path(folder_of(source)).string();
  const ModelPtr model =
      of_run ? ModelPtr(source.cast<RunPtr>(), &source.cast<RunPtr>()->model) : source.cast<ModelPtr>();
  ExportResult result;
  listening([&](const std::atomic<bool>& stopped) {
    validate(o);
    run::refuse_run_folder(folder, "an export");
    run::probe_output_folder(folder);
    const run::FolderLock lock(folder, run::kWriting);
    result = export_vdb(*model, folder, o, [&](const ExportedFrame& frame, int, int) {
      return call_back(callback, frame) && !stopped;
    });
  });
  py::list out;
  for (const ExportedFrame& frame : result.frames) out.append(frame_of(frame));
  return out;
}

RunPtr edit(const py::object& run, const std::string& out, const py::sequence& operations) {
  std::vector<run::AskedEdit> asked;
  for (const auto item : operations) {
    if (py::isinstance<py::str>(item)) {
      asked.push_back({item.cast<std::string>(), ""});
      continue;
    }
    const auto pair = py::isinstance<py::sequence>(item) ? item.cast<py::sequence>() : py::sequence();
    if (pair.size() != 2)
      fail({"edit", "this is no operation", "a name, or a name and its value", py::repr(item), ""});
    asked.push_back({py::str(pair[0]), py::str(pair[1])});
  }
  const std::string from = folder_of(run);
  auto edited = std::make_shared<run::Run>();
  released(
      [&] { *edited = run::open_run(run::edit_run(from, out, asked, [](const std::string&) {}).folder); });
  return edited;
}

py::list view(const py::object& run, const std::string& out, double max_mb, int views, int view_size,
              const std::string& split, const std::string& data) {
  const run::ViewRequest request{folder_of(run), out, data, split, views, view_size, max_mb};
  run::WrittenView written;
  released([&] { written = run::write_view(request); });
  return py::cast(written.lacks);
}

void report(const py::object& runs, const std::string& out, int views, const std::string& data) {
  run::ReportRequest request{{}, out, data, views};
  const bool one = py::isinstance<py::str>(runs) || !py::isinstance<py::sequence>(runs);
  if (one) request.runs.push_back(folder_of(runs));
  for (const auto item : one ? py::list() : py::list(runs)) request.runs.push_back(folder_of(item));
  if (request.runs.empty()) fail({"report", "there is no run", "one or more", "", ""});
  released([&] { run::write_report(request); });
}

void write_layers(const std::string& path, const py::dict& layers, const std::optional<Camera>& camera,
                  double fps, std::optional<int> frame, std::optional<double> time,
                  const std::string& color_space, bool half) {
  std::vector<ExrLayer> out;
  for (const auto& [name, array] : layers) {
    const std::string layer = py::str(name);
    out.push_back(
        {layer, image_of(array.cast<Floats>(), layer.empty() ? "layers['']" : layer.c_str()), {}, half});
    const int channels = out.back().image.channels;
    if (channels > 4)
      fail({path, "layer '" + layer + "' has too many channels", "1 to 4", std::to_string(channels), ""});
    if (layer.empty() && channels == 1) out.back().channels = {"Y"};
  }
  if (out.empty()) fail({path, "there are no layers", "{name: array}", "{}", ""});
  for (const ExrLayer& layer : out)
    if (layer.image.width != out[0].image.width || layer.image.height != out[0].image.height)
      fail({path, "layers are not of one size", "that of the first", "layer '" + layer.name + "'", ""});
  released([&] { write_exr(path, out, {camera, fps, frame, time, color_space}); });
}

py::dict read_layers(const std::string& path) {
  std::vector<ExrLayer> layers;
  released([&] { layers = read_exr_layers(path); });
  py::dict out;
  for (ExrLayer& layer : layers) out[py::str(layer.name)] = array_of(std::move(layer.image));
  return out;
}

}  // namespace

void bind_outputs(py::module_& m) {
  const ExportOptions usual;
  m.def("export", &export_frames,
        "Writes an animated VDB sequence as `splinevox export` does, of a Run or a Model; the options are "
        "its. frames: first and last. points: how many, or [n, 3] of the first frame. clusters: 2 to 16 "
        "parts, 0 = as many as there are. Returns a dict for "
        "each frame, with its files; callback gets each, too, and ends the export if it returns False, as "
        "Ctrl-C does: the same call goes on from there.",
        py::arg("source"), py::arg("folder"), py::arg("profile") = usual.profile,
        py::arg("frames") = std::pair(usual.first, usual.last), py::arg("fps") = usual.fps,
        py::arg("seconds") = usual.seconds, py::arg("at") = py::none(),
        py::arg("voxel_size") = usual.voxel_size, py::arg("half") = usual.half,
        py::arg("bake_view") = usual.bake_view, py::arg("sh") = usual.sh, py::arg("flame") = usual.flame,
        py::arg("colorspace") = usual.colorspace, py::arg("shutter") = usual.shutter,
        py::arg("min_alpha") = usual.min_alpha, py::arg("controls") = usual.controls,
        py::arg("mesh") = usual.mesh, py::arg("mesh_format") = usual.mesh_format,
        py::arg("mesh_alpha") = usual.mesh_alpha, py::arg("points") = 0, py::arg("clusters") = py::none(),
        py::arg("afresh") = false, py::arg("callback") = py::none());
  m.def("edit", &edit,
        "An edited copy of a run in a folder of its own. operations: those of `splinevox edit` without "
        "dashes, in order: a name, or a name and its value, such as ['reverse', ('speed', 0.5)].",
        py::arg("run"), py::arg("out"), py::arg("operations"));
  const run::ViewRequest page;
  m.def("view", &view,
        "Writes a run as one page for a browser, as `splinevox view`. Returns what the page is without, and "
        "why.",
        py::arg("run"), py::arg("out"), py::arg("max_mb") = page.max_mb, py::arg("views") = page.views,
        py::arg("view_size") = page.view_size, py::arg("split") = page.split, py::arg("data") = page.data);
  m.def("report", &report, "Writes the page of curves, pictures and tables of a run or several.",
        py::arg("runs"), py::arg("out"), py::arg("views") = run::ReportRequest().views, py::arg("data") = "");
  m.def("write_exr", &write_layers,
        "Layers of one size as an OpenEXR file: {name: (height, width) or (height, width, channels)}, "
        "channels R, G, B, A; '' is the picture itself. Values are written as they are. half: 16-bit floats. "
        "camera, fps, frame, time (of the model) and color_space (colorInteropID) go into the header.",
        py::arg("path"), py::arg("layers"), py::arg("camera") = py::none(), py::arg("fps") = 0.0,
        py::arg("frame") = py::none(), py::arg("time") = py::none(), py::arg("color_space") = "",
        py::arg("half") = false);
  m.def("read_exr", &read_layers,
        "The layers of a single-part OpenEXR file as write_exr takes them; channels in the order R G B A, X "
        "Y Z, then by name.",
        py::arg("path"));
}

}  // namespace splinevox::python
