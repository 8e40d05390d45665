// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "cli/command.hpp"
#include "cli/dataset_info.hpp"
#include "cli/options.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/near_miss.hpp"
#include "run/cameras_report.hpp"
#include "run/own_json.hpp"
#include "run/run_folder.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

template <class T>
Json triple(const Vec3T<T>& v) {
  return Json::array({v.x, v.y, v.z});
}

Json vdb_json(const std::string& path) {
  const VdbInfo info = inspect_vdb(path);
  Json grids = Json::array();
  for (const GridInfo& g : info.grids)
    grids.push_back({{"name", g.name},
                     {"type", g.type},
                     {"class", g.grid_class},
                     {"active_voxels", g.active_voxels},
                     {"leaves", g.leaves},
                     {"memory_bytes", g.memory_bytes},
                     {"half", g.half},
                     {"linear", g.linear},
                     {"voxel_size", triple(g.voxel_size)},
                     {"origin", triple(g.origin)},
                     {"bounds", {triple(g.lo), triple(g.hi)}},
                     {"meta", g.meta}});
  return {{"file", path},          {"bytes", info.file_bytes}, {"version", info.version},
          {"sealed", info.sealed}, {"meta", info.meta},        {"grids", grids}};
}

/// The digits a grid's name ends in.
std::string number_of(const std::string& name) {
  return name.substr(name.find_last_not_of("0123456789") + 1);
}

/// Whether two grids have names that differ in their last number only, and the same shape.
bool same_family(const Json& a, const Json& b) {
  const std::string x = a["name"].get<std::string>(), y = b["name"].get<std::string>();
  const std::string p = number_of(x), q = number_of(y);
  if (p.empty() || q.empty() || x.substr(0, x.size() - p.size()) != y.substr(0, y.size() - q.size()))
    return false;
  for (const char* key : {"type", "class", "active_voxels", "leaves", "voxel_size", "half", "bounds"})
    if (a[key] != b[key]) return false;
  return true;
}

/// How large voxels are and where voxel (0, 0, 0) is.
std::string transform_text(const Json& grid) {
  if (!grid["linear"].get<bool>()) return "not linear";
  const auto v = grid["voxel_size"].get<std::array<double, 3>>(),
             o = grid["origin"].get<std::array<double, 3>>();
  const std::string size = v[0] == v[1] && v[1] == v[2]
                               ? fmt::format("{:.6g}", v[0])
                               : fmt::format("{:.6g} x {:.6g} x {:.6g}", v[0], v[1], v[2]);
  return fmt::format("{} from ({:.5g}, {:.5g}, {:.5g})", size, o[0], o[1], o[2]);
}

void print_vdb(const Json& j) {
  fmt::print("{}: {:.2f} MB, {}{}\n", j["file"].get<std::string>(), j["bytes"].get<double>() / 1e6,
             j["version"].get<std::string>(), j["sealed"].get<bool>() ? ", checksum right" : "");
  fmt::print("  {:<14} {:<7} {:<11} {:>11} {:>9} {:>10}           {:<44}voxels\n", "grid", "type", "class",
             "active", "leaves", "memory", "voxel size and origin");
  const Json& grids = j["grids"];
  for (std::size_t i = 0; i < grids.size();) {
    const Json& g = grids[i];
    std::size_t next = i + 1;  // sh0, sh1, ... or control_0, control_1, ... of one shape share a line
    while (next < grids.size() && same_family(g, grids[next])) ++next;
    std::string name = g["name"].get<std::string>();
    const bool several = next > i + 1;
    if (several) name += ".." + number_of(grids[next - 1]["name"].get<std::string>());
    i = next;
    const Json &lo = g["bounds"][0], &hi = g["bounds"][1];
    fmt::print("  {:<14} {:<7} {:<11} {:>11} {:>9} {:>7.1f} MB{:5} {:4} {:<44}", name,
               g["type"].get<std::string>(), g["class"].get<std::string>(),
               g["active_voxels"].get<std::uint64_t>(), g["leaves"].get<std::uint64_t>(),
               g["memory_bytes"].get<double>() / 1e6, several ? " each" : "",
               g["half"].get<bool>() ? "half" : "", transform_text(g));
    if (lo[0] <= hi[0])
      fmt::print("[{} {} {}] to [{} {} {}]", json_text(lo[0]), json_text(lo[1]), json_text(lo[2]),
                 json_text(hi[0]), json_text(hi[1]), json_text(hi[2]));
    fmt::print("\n");
  }
  for (const auto& [key, value] : j["meta"].items())
    if (!key.empty()) fmt::print("  {} = {}\n", key, value.get<std::string>());
}

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
  if (metrics.contains("psnr"))
    fmt::print("{} split: PSNR {:.2f} dB, SSIM {:.4f}, MS-SSIM {:.4f}\n", metrics.value("split", ""),
               metrics["psnr"].get<double>(), metrics.value("ssim", 0.0), metrics.value("ms_ssim", 0.0));
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
    fail({path, "there is nothing of that name", "a run, a .vdb file or a data set", "", ""});
  void (*print)(const Json&) = print_dataset;
  Json j;
  if (!fs::is_directory(path, ignored) && data::kind_of(path) == data::FileKind::film)
    fail({path, "a film has no cameras: " + data::how_to_capture(path), "", "", ""});
  if (!fs::is_directory(path, ignored)) {
    j = vdb_json(path);
    print = print_vdb;
  } else if (fs::exists(path + "/config.toml")) {
    check_run(path);
    j = run_json(path);
    print = print_run;
  } else
    j = dataset_json(path, rules, pixels);
  if (json)
    fmt::print("{}\n", json_text(j, 2));
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
  verb.add_option("RUN|FILE.vdb|DATASET", o->path, "a run, any VDB file, or a data set")->required();
  add_rules(verb, o->rules);
  verb.add_flag(
      "--pixels", o->pixels,
      "of a data set: decode every picture too, for what headers do not tell (empty or damaged ones)");
  verb.add_flag("--json", o->json, "the same as JSON");
  return [o] { return info(o->path, o->rules, o->pixels, o->json); };
}

}  // namespace splinevox::cli
