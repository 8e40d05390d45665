// SPDX-License-Identifier: Apache-2.0
#include "python/convert.hpp"

#include <chrono>
#include <exception>
#include <future>

#include "splinevox/core/error.hpp"

namespace splinevox::python {
namespace {

std::string shape_text(const py::array& array) { return py::str(array.attr("shape")); }

int g_threads = 0;

}  // namespace

py::array_t<float> array_of(Image&& picture) {
  auto* kept = new Image(std::move(picture));
  const py::capsule owner(kept, [](void* p) { delete static_cast<Image*>(p); });
  std::vector<py::ssize_t> shape{kept->height, kept->width};
  if (kept->channels != 1) shape.push_back(kept->channels);
  return py::array_t<float>(shape, kept->data.data(), owner);
}

void fail_values(const std::string& where, const py::array& array) {
  fail({where, "these are no values of a picture", "uint8, uint16, or floats with 1 = 1",
        py::str(array.dtype()), ""});
}

Image image_of(const py::object& object, const char* argument) {
  const py::array array = py::array::ensure(object);
  if (!array) fail({argument, "this is not a picture", "an array", py::str(py::type::of(object)), ""});
  if (array.ndim() != 2 && array.ndim() != 3)
    fail({argument, "this is not a picture", "an array of shape (height, width) or (height, width, channels)",
          shape_text(array), ""});
  Image picture(int(array.shape(1)), int(array.shape(0)), array.ndim() == 3 ? int(array.shape(2)) : 1);
  const char kind = array.dtype().kind();
  const auto bytes = array.dtype().itemsize();
  if (kind != 'f' && kind != 'b' && !(kind == 'u' && bytes <= 2)) fail_values(argument, array);
  const float one = kind != 'u' ? 1.0f : bytes == 1 ? 255.0f : 65535.0f;
  const Floats values(array);
  std::transform(values.data(), values.data() + picture.data.size(), picture.data.begin(),
                 [&](float v) { return v / one; });
  return picture;
}

std::vector<Vec3> points_of(const Floats& array) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    fail({"points", "these are not points", "an array of shape (n, 3)", shape_text(array), ""});
  std::vector<Vec3> points(std::size_t(array.shape(0)));
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {array.data()[3 * i], array.data()[3 * i + 1], array.data()[3 * i + 2]};
  return points;
}

py::array_t<double> matrix_of(const Camera& c) {
  py::array_t<double> matrix({4, 4});
  auto m = matrix.mutable_unchecked<2>();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 3; ++column)
      m(row, column) = row < 3 ? c.axes[std::size_t(column)][row] : 0;
    m(row, 3) = row < 3 ? c.position[row] : 1;
  }
  return matrix;
}

Corners corners(const Box& box) { return {{{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}}; }

void released(const std::function<void()>& work) {
  const py::gil_scoped_release release;
  run::with_threads(g_threads, [&] {
    work();
    return 0;
  });
}

bool is_false(const py::object& answer) {
  return py::isinstance<py::bool_>(own_scalar(answer)) && PyObject_IsTrue(answer.ptr()) == 0;
}

py::object own_scalar(const py::handle& value) {
  if (!py::isinstance(value, py::module_::import("numpy").attr("generic")))
    return py::reinterpret_borrow<py::object>(value);
  return value.attr("item")();
}

void listening(const std::function<void(const std::atomic<bool>& stopped)>& work) {
  constexpr auto kEvery = std::chrono::milliseconds(20);
  const py::gil_scoped_release release;
  std::atomic<bool> stopped = false;
  std::exception_ptr heard;
  std::future<void> worked = std::async(std::launch::async, [&] {
    run::with_threads(g_threads, [&] {
      work(stopped);
      return 0;
    });
  });
  while (!heard && worked.wait_for(kEvery) != std::future_status::ready) {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() == 0) continue;
    heard = std::make_exception_ptr(py::error_already_set());
    stopped = true;
  }
  worked.wait();
  if (heard) std::rethrow_exception(heard);
  worked.get();
}

py::object object_of(const run::Json& json) {
  return py::module_::import("json").attr("loads")(run::json_text(json));
}

void set_threads(int threads) {
  if (threads < 0 || threads > 4096)
    fail({"set_threads", "there cannot be so many threads", "a whole number in [0, 4096], 0 = one per core",
          std::to_string(threads), ""});
  g_threads = threads;
}

int get_threads() { return g_threads; }

}  // namespace splinevox::python
