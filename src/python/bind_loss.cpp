// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "python/convert.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::python {
namespace {

/// Three numbers of each ray as (n, 3); the array keeps the rays.
template <class T, class Three>
py::array rows_of(const std::vector<Three>& rows, const py::object& self) {
  static_assert(sizeof(Three) == 3 * sizeof(T));
  return view_of(reinterpret_cast<T*>(const_cast<Three*>(rows.data())), {py::ssize_t(rows.size()), 3},
                 {3 * py::ssize_t(sizeof(T)), py::ssize_t(sizeof(T))}, self);
}

template <class Three, std::vector<Three> RayBatch::*Member>
py::array three(const py::object& self) {
  using T = std::conditional_t<std::is_same_v<Three, Vec3>, float, int>;
  return rows_of<T>(self.cast<const RayBatch&>().*Member, self);
}

template <class T, std::vector<T> RayBatch::*Member>
py::array one(const py::object& self) {
  const std::vector<T>& values = self.cast<const RayBatch&>().*Member;
  return view_of(const_cast<T*>(values.data()), {py::ssize_t(values.size())}, {py::ssize_t(sizeof(T))}, self);
}

/// What the function gave: the gradient, or the loss and it.
std::optional<double> take(const py::object& given, std::span<Vec3> gradients) {
  std::optional<double> loss;
  py::object gradient = given;
  if (py::isinstance<py::tuple>(given)) {
    const py::tuple both = given;
    if (both.size() != 2)
      fail({"loss", "what it returned is not understood", "a gradient, or (loss, gradient)",
            "a tuple of " + std::to_string(both.size()), ""});
    loss = both[0].cast<double>();
    gradient = both[1];
  }
  const Floats array = Floats::ensure(gradient);
  if (!array) PyErr_Clear();
  if (!array || array.ndim() != 2 || array.shape(0) != py::ssize_t(gradients.size()) || array.shape(1) != 3)
    fail({"loss", "what it returned is no gradient of the colours",
          "an array of shape (" + std::to_string(gradients.size()) + ", 3)",
          array ? std::string(py::str(array.attr("shape"))) : std::string(py::str(py::type::of(gradient))),
          ""});
  for (std::size_t r = 0; r < gradients.size(); ++r) {
    const float* g = array.data() + 3 * r;
    gradients[r] = {g[0], g[1], g[2]};
    for (int c = 0; c < 3; ++c)
      if (!std::isfinite(g[c]))
        fail({"loss", "its gradient is not finite", "finite numbers",
              std::to_string(g[c]) + " of ray " + std::to_string(r), ""});
  }
  return loss;
}

}  // namespace

ColourLoss loss_of(const py::object& function) {
  if (function.is_none()) return {};
  if (!PyCallable_Check(function.ptr()))
    fail({"loss", "this cannot be called", "a function of Rays, or None", py::str(py::type::of(function)),
          ""});
  // It is let go of, and copied, where the interpreter's lock is not held.
  const std::shared_ptr<py::object> kept(new py::object(function), [](py::object* p) {
    const py::gil_scoped_acquire lock;
    delete p;
  });
  return [kept](const RayBatch& rays, std::span<Vec3> gradients) {
    const py::gil_scoped_acquire lock;
    return take((*kept)(std::make_shared<RayBatch>(rays)), gradients);
  };
}

void bind_loss(py::module_& m) {
  py::class_<RayBatch, std::shared_ptr<RayBatch>>(
      m, "Rays",
      "The n rays of a training step and what they show, for a loss of one's own. Four in turn are of one "
      "block of 2 x 2 pixels. Colours are display values divided by Prepared.brightness, without the gains "
      "of cameras.")
      .def("__len__", [](const RayBatch& r) { return r.colours.size(); })
      .def("__repr__",
           [](const RayBatch& r) { return "<splinevox.Rays: " + std::to_string(r.colours.size()) + ">"; })
      .def_property_readonly("pixels", &three<RayBatch::Pixel, &RayBatch::pixels>,
                             "int32 (n, 3): frame of the train split, column, row; -1 of a ray that asks for "
                             "emptiness at another moment than its picture")
      .def_property_readonly("times", &one<double, &RayBatch::times>, "float64 (n,): of the model")
      .def_property_readonly("origins", &three<Vec3, &RayBatch::origins>,
                             "float32 (n, 3): where each enters the box, scene units")
      .def_property_readonly("directions", &three<Vec3, &RayBatch::directions>, "float32 (n, 3), of length 1")
      .def_property_readonly("colours", &three<Vec3, &RayBatch::colours>,
                             "float32 (n, 3): what the model shows, over the background")
      .def_property_readonly("targets", &three<Vec3, &RayBatch::targets>,
                             "float32 (n, 3): what the pictures show, over the background")
      .def_property_readonly("backgrounds", &three<Vec3, &RayBatch::backgrounds>,
                             "float32 (n, 3): behind each ray; random unless it is learned or fixed")
      .def_property_readonly("weights", &one<float, &RayBatch::weights>,
                             "float32 (n,): of the photometric loss, 1 on the mean")
      .def_property_readonly("photometric", &three<Vec3, &RayBatch::photometric>,
                             "float32 (n, 3): the gradient that training uses without a loss of one's own: 2 "
                             "weight (colour - target), and 0 where a clipped target is exceeded");
}

}  // namespace splinevox::python
