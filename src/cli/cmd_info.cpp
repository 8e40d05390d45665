// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "cli/command.hpp"
#include "cli/dataset_info.hpp"
#include "cli/export_info.hpp"
#include "cli/options.hpp"
#include "cli/vdb_info.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/near_miss.hpp"
#include "run/cameras_report.hpp"
#include "run/events.hpp"
#include "run/own_json.hpp"
#include "run/run_folder.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

Json run_json(const std::string& path) {
  Config config;
  RunRecord record;
  read_run_config(path, config, record);
  Json j{{"run", path},
         {"preset", config.preset},
         {"seed", config.run.seed},
         {"downscale", config.run.downscale},
         {"dataset", record.dataset},
         {"fingerprint", fmt::format("{:016x}", record.fingerprint)},
         {"time_map", {{"origin", record.time_map.origin}, {"scale", record.time_map.scale}}},
         {"version", record.version}};
  if (Json edits = read_history_if_there(path + "/" + kEditHistory); !edits.empty())
    j["edited"] = std::move(edits);
  if (Json metrics = read_metrics_if_there(path + "/metrics.json"); !metrics.empty())
    j["metrics"] = std::move(metrics);
  Json curve = Json::array();  // PSNR of the held-out view over training
  for (const MetricsLine& line : read_metrics_lines(path + "/metrics.jsonl"))
    if (const Json& l = line.json; l.contains("held_view"))
      curve.push_back({{"seconds", l.value("seconds", 0.0)}, {"psnr", l.value("held_psnr", 0.0)}});
  j["held_view"] = curve;
  j["model"] = vdb_json(path + "/model.vdb");
  return j;
}

/// What `edit` did, as the words that did it.
void print_history(const Json& history) {
  for (const Json& step : history) {
    fmt::print("edited from {}:", step.value("from", ""));
    for (const Json& o : step.value("operations", Json::array()))
      fmt::print(" --{}{}{}", o.value("operation", ""), o.contains("value") ? " " : "", o.value("value", ""));
    fmt::print("\n");
  }
}

void print_run(const Json& j) {
  fmt::print("{}: preset {}, seed {}, made by splinevox {}\n", j["run"].get<std::string>(),
             j["preset"].get<std::string>(), j["seed"].get<std::uint64_t>(), j["version"].get<std::string>());
  fmt::print("data {}, downscale {}\n", j["dataset"].get<std::string>(), j["downscale"].get<int>());
  if (j.contains("edited")) print_history(j["edited"]);
  if (!j["held_view"].empty()) fmt::print("held-out view:");
  for (const Json& p : j["held_view"])
    fmt::print("  {:.0f} s {:.1f} dB", p["seconds"].get<double>(), p["psnr"].get<double>());
  if (!j["held_view"].empty()) fmt::print("\n");
  const Json metrics = j.value("metrics", Json::object());
  if (metrics.contains("steps"))
    fmt::print("{} steps in {:.1f} s on {}\n", metrics["steps"].get<std::int64_t>(),
               metrics.value("train_seconds", 0.0), metrics.value("device", "cpu"));
  if (metrics.contains("psnr")) {
    fmt::print("{} split: PSNR {:.2f} dB", metrics.value("split", ""), metrics["psnr"].get<double>());
    for (const auto& [key, name] : {std::pair{"ssim", "SSIM"}, {"ms_ssim", "MS-SSIM"}})
      if (metrics.contains(key)) fmt::print(", {} {:.4f}", name, metrics[key].get<double>());
    fmt::print("\n");
  }
  if (metrics.contains("psnr_inside"))
    fmt::print("  inside the masks: PSNR {:.2f} dB\n", metrics["psnr_inside"].get<double>());
  if (metrics.contains("psnr_best_gain"))
    fmt::print("each view times its best gain per channel: PSNR {:.2f} dB\n",
               metrics["psnr_best_gain"].get<double>());
  if (metrics.contains("held_camera"))
    fmt::print("camera held still: the still part moves by up to {:.2f}% of the width (95th percentile)\n",
               metrics["held_camera"].value("p95_percent", 0.0));
  for (const Json& camera : metrics.value("cameras", Json::array()))
    fmt::print("camera {}\n", camera_line(camera));
  print_vdb(j["model"]);
}

int info(const std::string& path, const DatasetRules& rules, bool pixels, bool json) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    fail({path, "there is nothing of that name", "a run, an export, a .vdb file or a data set", "", ""});
  void (*print)(const Json&) = print_dataset;
  Json j;
  if (!fs::is_directory(path, ignored) && data::kind_of(path) == data::FileKind::film)
    fail({path, "a film has no cameras: " + data::how_to_capture(path), "", "", ""});
  if (const fs::path file(path);
      file.filename().string().starts_with("transforms") && file.extension() == ".json")
    fail({path, "this is one file of a data set", "the folder that holds it", "",
          "splinevox info " + (file.has_parent_path() ? file.parent_path().string() : ".")});
  if (!fs::is_directory(path, ignored)) {
    j = vdb_json(path);
    print = print_vdb;
  } else if (fs::exists(path + "/config.toml")) {
    check_run(path);
    j = run_json(path);
    print = print_run;
  } else if (std::optional<Json> exported = export_json(path)) {
    j = std::move(*exported);
    print = print_export;
  } else
    j = dataset_json(path, rules, pixels);
  if (json)
    write_event("result", j);
  else
    print(printable_json(j));
  return 0;
}

}  // namespace

Action info_command(CLI::App& verb) {
  struct Options {
    std::string path;
    DatasetRules rules;
    bool pixels = false, json = false;
  };
  auto o = std::make_shared<Options>();
  verb.add_option("RUN|EXPORT|FILE.vdb|DATASET", o->path, "a run, an export, any VDB file, or a data set")
      ->required();
  add_rules(verb, o->rules);
  verb.add_flag(
      "--pixels", o->pixels,
      "of a data set: decode every picture too, for what headers do not tell (empty or damaged ones)");
  add_json(verb, o->json);
  return [o] { return info(o->path, o->rules, o->pixels, o->json); };
}

}  // namespace splinevox::cli
