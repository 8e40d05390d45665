// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "data/camera_check.hpp"
#include "python/convert.hpp"
#include "run/memory_needs.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/math/metrics.hpp"

namespace splinevox::python {
namespace {

Camera make_camera(int width, int height, const Doubles& matrix, std::optional<double> fx,
                   std::optional<double> fy, std::optional<double> cx, std::optional<double> cy,
                   std::optional<double> angle_x) {
  if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
    fail({"Camera", "camera_to_world is not a matrix", "an array of shape (4, 4)",
          py::str(matrix.attr("shape")), ""});
  if (width < 1 || height < 1 || width > 16384 || height > 16384)
    fail({"Camera", "this is not a picture's size", "1 to 16384 pixels",
          std::to_string(width) + " x " + std::to_string(height), ""});
  std::array<double, 16> m;
  std::copy_n(matrix.data(), 16, m.begin());
  data::Lens lens;
  lens.fl_x = fx;
  lens.fl_y = fy;
  lens.cx = cx;
  lens.cy = cy;
  lens.camera_angle_x = angle_x;
  return data::pinhole(lens, data::rigid_pose(m, "Camera"), width, height, "Camera");
}

const Split& split_of(const Dataset& data, const std::string& name) {
  const Split* split = data.find(name);
  std::string have;
  for (const Split& s : data.splits) have += (have.empty() ? "" : ", ") + s.name;
  if (!split) fail({data.path, "there is no split '" + name + "'", have, name, ""});
  return *split;
}

std::vector<std::string> split_names(const Dataset& data) {
  std::vector<std::string> names;
  for (const Split& s : data.splits) names.push_back(s.name);
  return names;
}

SynthOptions synth_options(int frames, int size, std::uint64_t seed) {
  SynthOptions o;
  o.frames = frames;
  o.size = size;
  o.seed = seed;
  return o;
}

/// Everything of a camera, in the order of its members.
py::tuple camera_state(const Camera& c) {
  const Distortion& d = c.lens;
  return py::make_tuple(c.width, c.height, c.fx, c.fy, c.cx, c.cy, matrix_of(c), int(d.kind), d.k, d.p,
                        d.reach);
}
Camera camera_of_state(const py::tuple& t) {
  Camera c{t[0].cast<int>(),    t[1].cast<int>(),    t[2].cast<double>(),
           t[3].cast<double>(), t[4].cast<double>(), t[5].cast<double>()};
  const auto m = t[6].cast<Doubles>();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) c.axes[std::size_t(column)][row] = m.at(row, column);
    c.position[row] = m.at(row, 3);
  }
  c.lens = {Distortion::Kind(t[7].cast<int>()), t[8].cast<std::array<double, 4>>(),
            t[9].cast<std::array<double, 2>>(), t[10].cast<double>()};
  return c;
}

std::string describe_dataset(const Dataset& d) {
  std::string splits;
  for (const Split& s : d.splits) splits += fmt::format(", {} {}", s.frames.size(), s.name);
  const Camera& first = d.splits.front().frames.front().camera;
  return fmt::format("<splinevox.Dataset '{}': {}x{}{}>", d.path, first.width, first.height, splits);
}

template <double (*Metric)(const Image&, const Image&)>
double metric(const py::object& a, const py::object& b) {
  const Image x = image_of(a, "a"), y = image_of(b, "b");
  double value = 0;
  released([&] { value = Metric(x, y); });
  return value;
}

}  // namespace

void bind_data(py::module_& m) {
  py::class_<Camera>(m, "Camera",
                     "A pinhole camera. Pixel (i, j) has its centre at (i + 0.5, j + 0.5), j from the top; "
                     "axes are OpenGL's: x right, y up, looking along -z.")
      .def(py::init(&make_camera),
           "width and height in pixels; camera_to_world (4, 4); fx (or angle_x, the full field of view in "
           "radians), fy (fx), cx, cy (the middle) in pixels.",
           py::arg("width"), py::arg("height"), py::arg("camera_to_world"), py::arg("fx") = py::none(),
           py::arg("fy") = py::none(), py::arg("cx") = py::none(), py::arg("cy") = py::none(),
           py::arg("angle_x") = py::none())
      .def_readonly("width", &Camera::width, "pixels")
      .def_readonly("height", &Camera::height, "pixels")
      .def_readonly("fx", &Camera::fx, "focal length, pixels")
      .def_readonly("fy", &Camera::fy, "focal length, pixels")
      .def_readonly("cx", &Camera::cx, "centre, pixels")
      .def_readonly("cy", &Camera::cy, "centre, pixels")
      .def_property_readonly(
          "camera_to_world", &matrix_of,
          "float64 (4, 4): world axes of the camera in the first three columns, its place in the fourth.")
      .def(py::pickle(&camera_state, &camera_of_state))
      .def("__repr__", [](const Camera& c) {
        return fmt::format("<splinevox.Camera {}x{}, focal length {:.4g}, at ({:.4g}, {:.4g}, {:.4g})>",
                           c.width, c.height, c.fx, c.position.x, c.position.y, c.position.z);
      });

  py::class_<Frame>(m, "Frame", "One posed picture of a data set.")
      .def_readonly("name", &Frame::name, "file name without folder and extension")
      .def_readonly("camera", &Frame::camera, "where it was taken from")
      .def_readonly("time", &Frame::time, "the model's, in [0, 1] on the train split")
      .def_readonly("camera_id", &Frame::camera_id, "which of Dataset.cameras took it; -1: nobody knows")
      .def_property_readonly(
          "image",
          [](const Frame& f) {
            py::array_t<std::uint16_t> out(
                {py::ssize_t(f.image.height), py::ssize_t(f.image.width), py::ssize_t(4)});
            std::uint16_t* to = out.mutable_data();
            for (std::size_t i = 0; i < f.image.pixels(); ++i)
              for (const std::uint16_t v : f.image.pixel(i)) *to++ = v;
            return out;
          },
          "uint16 (height, width, 4), straight RGBA, 65535 = 1. A copy: in memory a picture of 8 bits is "
          "kept in 8.")
      .def_property_readonly(
          "ignored",
          [](const Frame& f) {
            py::array_t<bool> out({py::ssize_t(f.image.height), py::ssize_t(f.image.width)});
            bool* to = out.mutable_data();
            for (std::size_t i = 0; i < f.image.pixels(); ++i) *to++ = f.ignored.test(i);
            return out;
          },
          "bool (height, width): pixels that masks say to ignore; they are neither drawn nor scored. A copy.")
      .def(
          "composited",
          [](const Frame& f, std::array<float, 3> b) {
            return array_of(composite(f.image, {b[0], b[1], b[2]}));
          },
          "float32 (height, width, 3) over a background.",
          py::arg("background") = std::array<float, 3>{1, 1, 1})
      .def("__repr__", [](const Frame& f) {
        return fmt::format("<splinevox.Frame '{}', {}x{}, time {:.4g}>", f.name, f.camera.width,
                           f.camera.height, f.time);
      });

  py::class_<Dataset, std::shared_ptr<Dataset>>(m, "Dataset", "A data set, read and checked once.")
      .def(py::init(&dataset_of_arrays),
           "Of pictures in memory, n in all. images: arrays (height, width, 3 or 4), uint8, uint16 or floats "
           "with 1 = 1, straight alpha. camera_to_world (n, 4, 4) or (n, 3, 4), OpenGL axes. intrinsics (3, "
           "3) or (n, 3, 3), pixels. times in any unit. splits: train, val or test of each; None: every "
           "eighth picture, or of a rig whole cameras, are the test split. names: of their own. cameras: "
           "which took each; None: pose and lens tell. ignored: bool (height, width) or None for each. box: "
           "where the scene lies, scene units.",
           py::arg("images"), py::arg("camera_to_world"), py::arg("intrinsics"), py::arg("times"),
           py::arg("splits") = py::none(), py::arg("names") = py::none(), py::arg("cameras") = py::none(),
           py::arg("ignored") = py::none(), py::arg("box") = py::none(), py::arg("name") = "arrays")
      .def_readonly("path", &Dataset::path, "where it was read from")
      .def_property_readonly("splits", &split_names, "names of those that exist, train first")
      .def_readonly("notes", &Dataset::notes, "what is odd about it, one line each")
      .def_readonly("has_alpha", &Dataset::has_alpha, "whether any training pixel is not opaque")
      .def_readonly("downscale", &Dataset::downscale, "block size of the area filter")
      .def_property_readonly(
          "time_map", [](const Dataset& d) { return std::pair(d.time_map.origin, d.time_map.scale); },
          "(origin, scale): model time = (time - origin) * scale")
      .def_property_readonly(
          "box",
          [](const Dataset& d) {
            std::optional<Corners> box;
            if (d.box) box = corners(*d.box);
            return box;
          },
          "((x, y, z), (x, y, z)): where the scene lies, if the data says; scene units")
      .def_property_readonly(
          "cameras",
          [](const Dataset& d) {
            std::vector<std::pair<std::string, bool>> out;
            for (const RigCamera& c : d.cameras) out.emplace_back(c.name, c.still);
            return out;
          },
          "(name, whether it stands still) of each real camera of a rig; empty: every frame may be of "
          "another")
      .def("__repr__", &describe_dataset)
      .def(
          "frames",
          [](py::object self, const std::string& split) {
            py::list frames;
            for (const Frame& f : split_of(self.cast<const Dataset&>(), split).frames)
              frames.append(py::cast(f, py::return_value_policy::reference_internal, self));
            return frames;
          },
          "The pictures of a split, in order; they keep the data set alive.", py::arg("split") = "train");

  m.def(
      "load_dataset",
      [](const std::string& path, int downscale, std::vector<std::string> splits, const std::string& times,
         const std::string& missing, const std::string& masks, const std::string& transfer,
         const std::string& layer, const std::optional<std::string>& depth,
         const std::optional<std::string>& tracks, const std::string& memory, const std::string& cache,
         const std::string& between, const std::string& hold_out) {
        LoadOptions options;
        options.downscale = downscale;
        options.splits = std::move(splits);
        options.rules = {times,   missing, masks, transfer, layer, depth.value_or(""), tracks.value_or(""),
                         between, hold_out};
        options.depth = depth.has_value();
        options.tracks = tracks.has_value();
        options.cache = cache;
        if (!memory.empty())
          options.room = [most = run::memory_bound(memory)](const Dataset&) { return most; };
        auto data = std::make_shared<Dataset>();
        released([&] { *data = load_dataset(path, options); });
        return data;
      },
      "Reads a data set folder as the command line does. splits: which; none = all. times, missing, "
      "masks, transfer, layer, memory, cache, between, hold_out: as the options of `splinevox train`. "
      "depth: as --depth, '' = what the data says; None = depth maps are not read. tracks: as --tracks, in "
      "the same way.",
      py::arg("path"), py::arg("downscale") = 1, py::arg("splits") = std::vector<std::string>{},
      py::arg("times") = "", py::arg("missing") = "", py::arg("masks") = "", py::arg("transfer") = "",
      py::arg("layer") = "", py::arg("depth") = py::none(), py::arg("tracks") = py::none(),
      py::arg("memory") = "", py::arg("cache") = "", py::arg("between") = "", py::arg("hold_out") = "");
  m.def(
      "make_synth",
      [](const std::string& scene, int frames, int size, std::uint64_t seed) {
        auto data = std::make_shared<Dataset>();
        released([&] { *data = make_synth(scene, synth_options(frames, size, seed)); });
        return data;
      },
      "A built-in scene in memory: dancer, ball, snake or static.", py::arg("scene") = "dancer",
      py::arg("frames") = 100, py::arg("size") = 200, py::arg("seed") = 1);
  m.def(
      "write_synth",
      [](const std::string& scene, const std::string& folder, int frames, int size, std::uint64_t seed) {
        released([&] { write_synth(scene, folder, synth_options(frames, size, seed)); });
      },
      "A built-in scene as a data set folder with motion ground truth.", py::arg("scene"), py::arg("folder"),
      py::arg("frames") = 100, py::arg("size") = 200, py::arg("seed") = 1);

  m.def(
      "write_png",
      [](const std::string& path, const py::object& image) { write_png(path, image_of(image, "image")); },
      "1, 3 or 4 channels, floats clamped to [0, 1], or uint8 or uint16; 8 bit.", py::arg("path"),
      py::arg("image"));
  m.def("psnr", &metric<psnr>, "dB, of pictures: floats within [0, 1], uint8 or uint16.", py::arg("a"),
        py::arg("b"));
  m.def("ssim", &metric<ssim>, "Structural similarity of such pictures.", py::arg("a"), py::arg("b"));
  m.def("ms_ssim", &metric<ms_ssim>, "Multi-scale structural similarity of such pictures.", py::arg("a"),
        py::arg("b"));
}

}  // namespace splinevox::python
