// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "python/convert.hpp"
#include "splinevox/core/version.hpp"
#include "splinevox/run/cameras.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox::python {
namespace {

ModelPtr model_of_run(const std::shared_ptr<run::Run>& run) { return {run, &run->model}; }

std::shared_ptr<run::Run> open_run(const std::string& path) {
  auto run = std::make_shared<run::Run>();
  released([&] { *run = run::open_run(path); });
  return run;
}

std::shared_ptr<Dataset> split_of_run(const run::Run& run, const std::string& split,
                                      const std::string& data) {
  auto out = std::make_shared<Dataset>();
  released([&] { *out = run::open_split(run, data, split); });
  return out;
}

}  // namespace

void bind_run(py::module_& m) {
  py::class_<run::Run, std::shared_ptr<run::Run>>(m, "Run", "A folder that `splinevox train` or `edit` made.")
      .def_readonly("path", &run::Run::path, "the folder")
      .def_readonly("config", &run::Run::config, "what it was trained with")
      .def_readonly("notes", &run::Run::notes, "kept with the model")
      .def_property_readonly("model", &model_of_run, "the model; keeps the run alive")
      .def(py::pickle([](const run::Run& run) { return py::str(run.path); },
                      [](const py::str& path) { return open_run(path); }))
      .def("__repr__",
           [](const run::Run& run) {
             return fmt::format("<splinevox.Run '{}', preset {}>", run.path, run.config.preset);
           })
      .def("dataset", &split_of_run,
           "The run's own pictures of one split, or those of another folder, with the run's downscale and "
           "times.",
           py::arg("split") = "test", py::arg("data") = "")
      .def(
          "evaluate",
          [](const run::Run& run, const std::string& split, const std::string& data) {
            return evaluate(run.model, *split_of_run(run, split, data)->find(split));
          },
          "The figures of `splinevox eval --json`; writes nothing.", py::arg("split") = "test",
          py::arg("data") = "")
      .def(
          "shots",
          [](const run::Run& run, const std::string& camera, const std::string& times, int size,
             double elevation) {
            std::vector<std::pair<Camera, double>> out;
            released([&] {
              for (const run::Shot& s : run::plan_shots(run, {camera, times, "", size, elevation}))
                out.emplace_back(s.camera, s.time);
            });
            return out;
          },
          "Cameras with times as `splinevox render` plans them: auto, orbit, stabilised, interpolate, "
          "spiral, "
          "held, data, dataset:SPLIT, dataset:SPLIT:INDEX or a transforms file; times A:B:N.",
          py::arg("camera") = "auto", py::arg("times") = "", py::arg("size") = 0,
          py::arg("elevation") = 20.0);
  m.def("open_run", &open_run, "Opens a run folder.", py::arg("path"));
}

}  // namespace splinevox::python

PYBIND11_MODULE(_core, m) {
  using namespace splinevox::python;
  m.doc() = "The compiled part of splinevox.";
  m.attr("__version__") = splinevox::kVersion;
  m.def("set_threads", &set_threads, "Threads that everything after it uses; 0 = one per core.",
        py::arg("threads"));
  m.def("get_threads", &get_threads, "What set_threads was given.");
  bind_errors(m);
  bind_data(m);
  bind_model(m);
  bind_loss(m);
  bind_train(m);
  bind_run(m);
  bind_outputs(m);
}
