// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "run/support.hpp"
#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/colour_loss.hpp"

/// Between numpy's arrays and ours.
namespace splinevox::python {

namespace py = pybind11;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using ModelPtr = std::shared_ptr<VoxelModel>;

/// A picture as (height, width, channels), or (height, width) for one channel; takes its memory, copies
/// nothing.
py::array_t<float> array_of(Image&& picture);
/// Throws the Error (input) of an array that is not uint8, uint16 or of floats.
[[noreturn]] void fail_values(const std::string& where, const py::array& array);
/// A copy of anything that numpy takes as (height, width) or (height, width, channels): floats as they are,
/// uint8 and uint16 as shares of their largest value. Throws Error (input) naming `argument`.
Image image_of(const py::object& picture, const char* argument);
/// (n, 3) as points. Throws Error (input).
std::vector<Vec3> points_of(const Floats& array);
/// (4, 4) camera to world, row-major.
py::array_t<double> matrix_of(const Camera& camera);

/// The lower and the upper corner of a box.
using Corners = std::array<std::array<float, 3>, 2>;
Corners corners(const Box& box);

/// A data set of arrays, one of each for each picture. Throws Error (input) naming the argument.
std::shared_ptr<Dataset> dataset_of_arrays(const py::sequence& images, const Doubles& poses, const Doubles& k,
                                           const std::vector<double>& times,
                                           const std::optional<std::vector<std::string>>& splits,
                                           const std::optional<std::vector<std::string>>& names,
                                           const std::optional<std::vector<std::string>>& cameras,
                                           const std::optional<py::sequence>& ignored,
                                           const std::optional<Corners>& box, const std::string& name);

/// A function of Rays as a loss, which takes the interpreter's lock to be called; of None none. Throws Error
/// (input) if it is no function; the loss does for what it returns.
ColourLoss loss_of(const py::object& function);

/// Memory of `owner` as an array: no copy, and `owner` lives as long as the array does.
template <class T>
py::array view_of(T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                  py::handle owner) {
  return py::array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
}

/// Whether a callback returned False, Python's or numpy's. None and 0 are none.
bool is_false(const py::object& answer);
/// Python's own number or truth for one of numpy's; anything else as it is.
py::object own_scalar(const py::handle& value);

/// Runs without the interpreter's lock, on as many threads as set_threads asked for.
void released(const std::function<void()>& work);
/// The same on a thread of its own, while the caller's listens: Python tells its main thread alone of Ctrl-C.
/// Work ends early once `stopped` is set, and then what Python made of the signal is thrown.
void listening(const std::function<void(const std::atomic<bool>& stopped)>& work);
void set_threads(int threads);
int get_threads();

/// Each part of the module.
void bind_errors(py::module_& m);
void bind_data(py::module_& m);
void bind_model(py::module_& m);
void bind_loss(py::module_& m);
void bind_train(py::module_& m);
void bind_run(py::module_& m);
void bind_outputs(py::module_& m);

/// PSNR and its kin of a model against a split, as `splinevox eval --json` has them.
py::object evaluate(const VoxelModel& model, const Split& split);

/// JSON as Python's json module reads it: null is None.
py::object object_of(const run::Json& json);

}  // namespace splinevox::python
