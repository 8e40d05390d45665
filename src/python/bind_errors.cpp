// SPDX-License-Identifier: Apache-2.0
#include "python/convert.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::python {
namespace {

struct Kinds {
  PyObject *error, *input, *output, *numeric, *memory;
};
Kinds g_kinds;

PyObject* make_kind(py::module_& m, const char* name, const char* doc, const py::tuple& bases) {
  PyObject* kind =
      PyErr_NewExceptionWithDoc((std::string("splinevox.") + name).c_str(), doc, bases.ptr(), nullptr);
  if (!kind) throw py::error_already_set();
  m.add_object(name, kind);
  return kind;
}

PyObject* kind_of(Fault fault) {
  switch (fault) {
    case Fault::input:
      return g_kinds.input;
    case Fault::output:
      return g_kinds.output;
    case Fault::numeric:
      return g_kinds.numeric;
    case Fault::memory:
      return g_kinds.memory;
  }
  return g_kinds.error;
}

/// The same message as on the command line, and its parts as attributes.
void raise(const Error& e) {
  PyObject* kind = kind_of(e.fault);
  const py::object exception = py::reinterpret_borrow<py::object>(kind)(py::str(e.what()));
  exception.attr("where") = e.problem.where;
  exception.attr("what") = e.problem.what;
  exception.attr("expected") = e.problem.expected;
  exception.attr("got") = e.problem.got;
  exception.attr("hint") = e.problem.hint;
  PyErr_SetObject(kind, exception.ptr());
}

}  // namespace

void bind_errors(py::module_& m) {
  const auto base = [](PyObject* type) { return py::reinterpret_borrow<py::object>(type); };
  g_kinds.error = make_kind(
      m, "Error", "Anything splinevox refuses or cannot do. Attributes: where, what, expected, got, hint.",
      py::make_tuple(base(PyExc_Exception)));
  g_kinds.input =
      make_kind(m, "InputError", "A file or an argument is wrong (exit code 2 of the command line).",
                py::make_tuple(base(g_kinds.error), base(PyExc_ValueError)));
  g_kinds.output = make_kind(m, "OutputError", "A file could not be written.",
                             py::make_tuple(base(g_kinds.error), base(PyExc_OSError)));
  g_kinds.numeric =
      make_kind(m, "NumericError", "The computation itself failed: steps in a row that were not finite.",
                py::make_tuple(base(g_kinds.error), base(PyExc_ArithmeticError)));
  g_kinds.memory =
      make_kind(m, "OutOfMemoryError", "There is not enough memory for this, or not as much as was allowed.",
                py::make_tuple(base(g_kinds.error), base(PyExc_MemoryError)));
  py::register_exception_translator([](std::exception_ptr p) {
    try {
      if (p) std::rethrow_exception(p);
    } catch (const Error& e) {
      raise(e);
    }
  });
}

}  // namespace splinevox::python
