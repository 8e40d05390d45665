// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "python/convert.hpp"
#include "run/cameras_report.hpp"
#include "run/effects_report.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/run/train.hpp"
#include "splinevox/train/config_keys.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox::python {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kListenEvery = std::chrono::milliseconds(20);  // for Ctrl-C

/// A trainer that keeps what it is trained on.
struct Learning {
  Learning(std::shared_ptr<Dataset> d, const Config& c) : data(std::move(d)) {
    validate(c);
    released([&] {
      const Config ready = prepare(c, *data, {.effects = EffectPolicy::keep}).config;
      cameras = ready.cameras;
      trainer = std::make_unique<Trainer>(ready, *data->find("train"), data->time_map);
    });
  }
  std::shared_ptr<Dataset> data;
  CamerasConfig cameras;  ///< what is learned of them
  std::unique_ptr<Trainer> trainer;
  std::mutex mutex;  ///< of the trainer; waited for without the interpreter's lock, held only while a loss of
                     ///< the caller's own is called
  std::atomic<std::thread::id> asking{};  ///< the thread that calls this loss
};

/// The trainer is busy where its loss is called.
void check_free(const Learning& l) {
  if (l.asking == std::this_thread::get_id())
    fail({"Trainer", "its own loss asks it for something in the midst of a step",
          "a loss that looks at its Rays alone", "", "a callback, which is called between steps"});
}

/// Calls work(trainer) while no other thread uses the trainer.
template <class Work>
void alone(Learning& l, const Work& work) {
  check_free(l);
  released([&] {
    const std::lock_guard lock(l.mutex);
    work(*l.trainer);
  });
}

/// Until the budget is spent or the callback returns False. Takes the interpreter's lock only to call back
/// and to hear Ctrl-C.
bool run(Learning& l, const py::object& callback, int every) {
  if (every < 1) fail({"train", "'every' is not a number of steps", "at least 1", std::to_string(every), ""});
  check_free(l);
  bool stopped = false;
  released([&] {
    auto listened = Clock::now();
    for (std::int64_t since = 1; !stopped; ++since) {
      StepReport report;
      bool done = false;
      {
        const std::lock_guard lock(l.mutex);
        if (l.trainer->done()) return;
        report = l.trainer->step();
        done = l.trainer->done();
      }
      const bool call = !callback.is_none() && (since % every == 0 || done);
      if (!call && Clock::now() - listened < kListenEvery) continue;
      const py::gil_scoped_acquire lock;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (call) stopped = is_false(callback(report));
      listened = Clock::now();
    }
  });
  return !stopped;
}

std::string text_of(const py::handle& given) {
  const py::object value = own_scalar(given);
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (!py::isinstance<py::sequence>(value)) return py::str(value);
  std::string text;
  for (const auto item : py::cast<py::sequence>(value)) text += (text.empty() ? "" : ",") + text_of(item);
  return text;
}

template <class T>
py::object setting_of(const T& value) {
  if constexpr (std::is_enum_v<T>)
    return py::str(choice_name(value));
  else
    return py::cast(value);
}

py::dict settings_of(const Config& c) {
  py::dict all;
  visit_config(c, [&](const char* key, const auto& value, const char*, double, double) {
    all[key] = setting_of(value);
  });
  return all;
}

/// As it can be made again: its preset, and what differs from that.
std::string describe_config(const Config& c) {
  const py::dict usual = settings_of(preset(c.preset));
  py::dict other;
  for (const auto& [key, value] : settings_of(c))
    if (!value.equal(usual[key])) other[key] = value;
  return fmt::format("splinevox.Config('{}', settings={})", c.preset, py::repr(other).cast<std::string>());
}

Config make_config(std::optional<std::string> preset, const std::string& file, const py::dict& settings,
                   std::optional<double> max_time, std::optional<int> max_steps,
                   std::optional<std::uint64_t> seed, std::optional<int> downscale,
                   std::optional<std::string> background, const std::string& effects) {
  run::TrainOptions o;
  o.preset = std::move(preset);
  o.config_file = file;
  o.effects = effects;
  o.max_time = max_time;
  o.max_steps = max_steps;
  o.seed = seed;
  o.downscale = downscale;
  o.background = std::move(background);
  for (const auto& [key, value] : settings) o.sets.push_back(text_of(key) + "=" + text_of(value));
  return run::effective_config(o);
}

/// Ctrl-C ends it after the fit under way.
Prepared prepared(const Config& config, Dataset& data, bool choose) {
  struct Stopped {};
  Prepared out;
  listening([&](const std::atomic<bool>& stopped) {
    const auto obey = [&](const auto&) {
      if (stopped) throw Stopped{};
    };
    PrepareOptions options;
    options.effects = choose ? EffectPolicy::choose : EffectPolicy::keep;
    options.on_trial = obey;
    options.on_film = obey;
    out = prepare(config, data, options);
  });
  return out;
}

/// What effects.json holds, as a dict.
py::object effects_of(const Prepared& p) { return object_of(run::effects_json(p)); }

py::dict phases_of(const PhaseSeconds& p) {
  return py::dict(py::arg("slices") = p.slices, py::arg("rays") = p.rays, py::arg("scatter") = p.scatter,
                  py::arg("regularise") = p.regularise, py::arg("update") = p.update,
                  py::arg("occupancy") = p.occupancy, py::arg("refine") = p.refine);
}

void set_loss(Learning& l, const py::object& function) {
  ColourLoss loss = loss_of(function);
  if (loss)
    loss = [&l, ask = std::move(loss)](const RayBatch& rays, std::span<Vec3> gradients) {
      l.asking = std::this_thread::get_id();
      struct Asked {
        Learning& l;
        ~Asked() { l.asking = std::thread::id(); }
      } asked{l};
      return ask(rays, gradients);
    };
  alone(l, [&](Trainer& t) { t.set_loss(std::move(loss)); });
}

/// What is learned of a rig's cameras, as `cameras` of metrics.json has it.
py::object cameras_of(Learning& l) {
  run::Json cameras;
  alone(l, [&](const Trainer& t) { cameras = run::cameras_json(*l.data, l.cameras, t.cameras()); });
  return object_of(cameras);
}

std::shared_ptr<VoxelModel> learned_model(Learning& l) {
  auto model = std::make_shared<VoxelModel>();
  alone(l, [&](const Trainer& t) { *model = t.model(); });
  return model;
}

void bind_trainer(py::module_& m) {
  py::class_<Learning>(m, "Trainer", "Trains a model on the train split of a data set.")
      .def(py::init<std::shared_ptr<Dataset>, const Config&>(),
           "The configuration's effects are used as they are; its box is settled as by prepare.",
           py::arg("dataset"), py::arg("config"))
      .def(
          "step",
          [](Learning& l) {
            StepReport r;
            alone(l, [&](Trainer& t) { r = t.step(); });
            return r;
          },
          "One step.")
      .def("train", &run,
           "Steps until the budget is spent, with the interpreter free for other threads. callback(report) "
           "is called every `every` steps and after the last; "
           "if it returns False training stops. True if the budget is spent. After KeyboardInterrupt the "
           "trainer is as it was after its last step.",
           py::arg("callback") = py::none(), py::arg("every") = 10)
      .def_property_readonly(
          "done",
          [](Learning& l) {
            bool done = false;
            alone(l, [&](const Trainer& t) { done = t.done(); });
            return done;
          },
          "whether the budget is spent")
      .def_property_readonly(
          "seconds",
          [](Learning& l) {
            double seconds = 0;
            alone(l, [&](const Trainer& t) { seconds = t.seconds(); });
            return seconds;
          },
          "of the budget spent so far")
      .def_property_readonly(
          "phases",
          [](Learning& l) {
            PhaseSeconds phases;
            alone(l, [&](const Trainer& t) { phases = t.phases(); });
            return phases_of(phases);
          },
          "seconds in each part of a step")
      .def_property_readonly(
          "moving_share",
          [](Learning& l) {
            double share = 1;
            alone(l, [&](const Trainer& t) { share = t.moving_share(); });
            return share;
          },
          "share of what is visible that was moving when the static regions were frozen; 1: motion is "
          "learned everywhere")
      .def("set_loss", &set_loss,
           "From the next step on loss(rays) takes the place of the photometric loss; None: that comes back. "
           "It is given Rays and returns d loss / d colour, (n, 3), of the loss summed over the rays, or "
           "(loss, d loss / d colour): then reports have this loss. All other terms stay as configured. The "
           "same bits in every run if the function has. save does not keep it. An exception of it leaves the "
           "trainer as it was before the step.",
           py::arg("loss"))
      .def_property_readonly(
          "cameras", &cameras_of,
          "what is known of a rig's cameras by now, as `cameras` of metrics.json: gains and "
          "offsets in time; empty: nothing is learned of them")
      .def("__repr__",
           [](Learning& l) {
             double seconds = 0;
             bool done = false;
             alone(l, [&](const Trainer& t) {
               seconds = t.seconds();
               done = t.done();
             });
             return fmt::format("<splinevox.Trainer on '{}', {:.1f} s, {}>", l.data->path, seconds,
                                done ? "done" : "not done");
           })
      .def("model", &learned_model, "The model as it is now: a copy.")
      .def(
          "save",
          [](Learning& l) {
            std::vector<char> bytes;
            alone(l, [&](const Trainer& t) { bytes = t.save(); });
            return py::bytes(bytes.data(), bytes.size());
          },
          "Everything that restore needs to go on in the same bits.")
      .def(
          "restore",
          [](Learning& l, const py::bytes& bytes) {
            const std::string_view view = bytes;
            const std::vector<char> own(view.begin(), view.end());
            alone(l, [&](Trainer& t) { t.restore(own); });
          },
          "Goes back to what save of a trainer with the same data and configuration gave.", py::arg("bytes"));
}

}  // namespace

void bind_train(py::module_& m) {
  py::class_<Config>(m, "Config", "Every number of a training run.")
      .def(py::init(&make_config),
           "As the command line: a preset (fast), a TOML file over it, settings such as {'loss.offset': "
           "0.1}, then the named ones. max_steps alone leaves time out of it.",
           py::arg("preset") = py::none(), py::arg("file") = "", py::arg("settings") = py::dict(),
           py::arg("max_time") = py::none(), py::arg("max_steps") = py::none(), py::arg("seed") = py::none(),
           py::arg("downscale") = py::none(), py::arg("background") = py::none(), py::arg("effects") = "auto")
      .def_property_readonly("settings", &settings_of, "every number by its key, a copy")
      .def(
          "__getitem__",
          [](const Config& c, const std::string& key) -> py::object { return settings_of(c)[py::str(key)]; },
          py::arg("key"))
      .def(
          "__setitem__",
          [](Config& c, const std::string& key, const py::object& value) {
            set_config(c, key + "=" + text_of(value), "Config");
          },
          py::arg("key"), py::arg("value"))
      .def("to_toml", &write_config, "As config.toml has it.")
      .def(
          "__eq__", [](const Config& a, const Config& b) { return write_config(a) == write_config(b); },
          py::is_operator())
      .def("__repr__", &describe_config)
      .def(py::pickle([](const Config& c) { return py::make_tuple(c.preset, settings_of(c)); },
                      [](const py::tuple& state) {
                        Config c = preset(state[0].cast<std::string>());
                        for (const auto& [key, value] : state[1].cast<py::dict>())
                          set_config(c, text_of(key) + "=" + text_of(value), "Config");
                        return c;
                      }))
      .def(
          "copy", [](const Config& c) { return c; }, "One of its own.");

  py::class_<Prepared>(m, "Prepared", "A configuration made ready for a data set, and what was found.")
      .def_readonly("config", &Prepared::config, "what to train with")
      .def_readonly("brightness", &Prepared::brightness,
                    "unit that colours are trained in; 1 unless the pictures are dark")
      .def_readonly("notes", &Prepared::notes, "what was settled and why, one line each")
      .def_property_readonly("effects", &effects_of,
                             "which effects were tried out and what is used, as in RUN/effects.json")
      .def("__repr__",
           [](const Prepared& p) { return fmt::format("<splinevox.Prepared: {}>", to_string(p.used)); });

  py::class_<StepReport>(m, "StepReport", "What one step reports.")
      .def_readonly("step", &StepReport::step, "steps done, this one included")
      .def_readonly("progress", &StepReport::progress, "0 to 1 of the budget")
      .def_readonly("seconds", &StepReport::seconds, "of training so far")
      .def_readonly("loss", &StepReport::loss, "of this batch")
      .def_readonly("psnr", &StepReport::psnr, "of this batch's rays, dB")
      .def_readonly("rays", &StepReport::rays, "of this step")
      .def_readonly("samples", &StepReport::samples, "of this step")
      .def_readonly("discarded", &StepReport::discarded,
                    "something was not finite, so no parameter was touched")
      .def("__repr__", [](const StepReport& r) {
        return fmt::format("<splinevox.StepReport: step {}, loss {:.4g}, {:.2f} dB, {:.1f} s>", r.step,
                           r.loss, r.psnr, r.seconds);
      });
  bind_trainer(m);

  m.def("prepare", &prepared,
        "The configuration made ready for a data set as the command line does: opaque pictures train in the "
        "box that the data gives, if the configuration names none; choose: only the effects that the scene "
        "calls for are used, as with --effects auto, otherwise all that the configuration has, untried.",
        py::arg("config"), py::arg("dataset"), py::arg("choose") = true);
  m.def(
      "choose_effects",
      [](const Config& config, Dataset& data) { return prepared(config, data, true).config; },
      "prepare(config, dataset).config: with only those effects that the scene calls for.", py::arg("config"),
      py::arg("dataset"));
  m.def(
      "train",
      [](std::shared_ptr<Dataset> data, const Config& config, const py::object& callback, int every,
         const py::object& loss) {
        Learning l(std::move(data), config);
        set_loss(l, loss);
        run(l, callback, every);
        return learned_model(l);
      },
      "A trained model: in the box that prepare settles, with the effects of the configuration, untried. See "
      "Trainer.train, and Trainer.set_loss.",
      py::arg("dataset"), py::arg("config"), py::arg("callback") = py::none(), py::arg("every") = 10,
      py::arg("loss") = py::none());
}

}  // namespace splinevox::python
