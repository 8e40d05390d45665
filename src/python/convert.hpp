// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"

/// Between numpy's arrays and ours.
namespace splinevox::python {

namespace py = pybind11;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using ModelPtr = std::shared_ptr<VoxelModel>;

/// A picture as (height, width, channels), or (height, width) for one channel; takes its memory, copies
/// nothing.
py::array_t<float> array_of(Image&& picture);
/// A copy, of (height, width) or (height, width, channels). Throws Error (input) naming `argument`.
Image image_of(const Floats& array, const char* argument);
/// (n, 3) as points. Throws Error (input).
std::vector<Vec3> points_of(const Floats& array);
/// (4, 4) camera to world, row-major.
py::array_t<double> matrix_of(const Camera& camera);

/// The lower and the upper corner of a box.
using Corners = std::array<std::array<float, 3>, 2>;
Corners corners(const Box& box);

/// Memory of `owner` as an array: no copy, and `owner` lives as long as the array does.
template <class T>
py::array view_of(T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                  py::handle owner) {
  return py::array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
}

/// Runs without the interpreter's lock, on as many threads as set_threads asked for.
void released(const std::function<void()>& work);
void set_threads(int threads);
int get_threads();

/// Each part of the module.
void bind_errors(py::module_& m);
void bind_data(py::module_& m);
void bind_model(py::module_& m);
void bind_train(py::module_& m);
void bind_run(py::module_& m);

/// PSNR and its kin of a model against a split, as `splinevox eval --json` has them.
py::dict evaluate(const VoxelModel& model, const Split& split);

}  // namespace splinevox::python
