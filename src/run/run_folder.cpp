// SPDX-License-Identifier: Apache-2.0
#include "run/run_folder.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/own_folder.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"
#include "train/config/toml_text.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {

RunFolder::RunFolder(const std::string& path, bool resume) : path_(path) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  std::error_code ignored;
  made_ = !fs::exists(path_, ignored);
  check_own_folder(path_, Depth::all);
  probe_output_folder(path_);
  lock_.emplace(path_, "training into");
  remove_unfinished();
  if (fs::is_empty(path_)) return;
  const bool run = has("config.toml");
  const std::string another = "another folder for --out";
  if (!run)
    fail({path_, "this folder is not empty and holds no run", "an empty folder, or a name that is free", "",
          another});
  if (!resume)
    fail({path_, "this folder already holds a run", "an empty folder, or a name that is free", "",
          has(kEditHistory) ? another : "--resume to go on with it, or " + another});
}

RunFolder::~RunFolder() {
  if (made_) ::rmdir(path_.c_str());  // does nothing unless the folder is empty
}

/// A run that was killed before it wrote config.toml leaves what stands before it, and nothing else.
void RunFolder::remove_unfinished() {
  constexpr const char* kBefore[] = {kEffects, kAskedConfig, kTrainingPictures};
  std::error_code ignored;
  for (const std::string& name : names_in_folder(path_))
    if (std::find(std::begin(kBefore), std::end(kBefore), name) == std::end(kBefore)) return;
  for (const char* name : kBefore) fs::remove(file(name), ignored);
}

bool RunFolder::has(const std::string& name) const {
  std::error_code ignored;
  return fs::exists(file(name), ignored);
}

void refuse_run_folder(const std::string& out, const std::string& what) {
  std::error_code ignored;
  if (fs::exists(out + "/config.toml", ignored))
    fail({out, fmt::format("this is the folder of a run, and {} would replace the list of its files", what),
          "a folder of its own", "", "--out " + out + "/vdb"});
}

std::string record_text(const RunRecord& record) {
  const auto quoted = [](const std::string& text) { return json_text(text); };
  const std::string parallax = record.parallax ? fmt::format("parallax = {:.6g}\n", *record.parallax) : "";
  std::string rules;
  each_rule(
      [&](const char* key, const std::string& rule) { rules += fmt::format("{} = {}\n", key, quoted(rule)); },
      record.rules);
  return fmt::format(
      "\n[record]  # written by the program, not read as configuration\n"
      "splinevox = {}\ncompiler = {}\ndataset = {}\nfingerprint = \"{:016x}\"\n"
      "time_origin = {}\ntime_scale = {}\n{}{}",
      quoted(record.version), quoted(record.compiler), quoted(record.dataset), record.fingerprint,
      record.time_map.origin, record.time_map.scale, rules, parallax);
}

void read_run_config(const std::string& run, Config& config, RunRecord& record) {
  const std::string path = run + "/config.toml";
  read_config(config, path);
  const toml::table file = toml::parse(toml_text(path), path);  // read_config found it well formed
  const toml::node_view<const toml::node> table = file["record"];
  const auto text = [&](const char* key) { return table[key].value_or(std::string()); };
  const auto number = [&](const char* key) {
    const std::optional<double> value = table[key].value<double>();
    if (!value || !std::isfinite(*value))
      fail({path, fmt::format("[record] has no '{}'", key), "a finite number",
            value ? fmt::format("{}", *value) : "none", "the file that the run wrote, unchanged"});
    return *value;
  };
  record = {text("splinevox"),
            text("compiler"),
            text("dataset"),
            0,
            {number("time_origin"), number("time_scale")},
            {},
            table["parallax"].value<double>()};
  each_rule([&](const char* key, std::string& rule) { rule = text(key); }, record.rules);
  record.fingerprint = std::strtoull(text("fingerprint").c_str(), nullptr, 16);
}

std::string config_difference(const Config& saved, const Config& asked) {
  const auto lines = [](const Config& c) {
    std::vector<std::string> all;
    std::string group;
    for (const std::string& line : split_list(write_config(c), '\n')) {
      if (line[0] == '[') group = line.substr(1, line.size() - 2) + ".";
      const std::string value = line.substr(0, line.find('#'));
      all.push_back(group + value.substr(0, value.find_last_not_of(' ') + 1));
    }
    return all;
  };
  const auto a = lines(saved), b = lines(asked);
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < a.size() && parts.size() < 5; ++i)
    if (a[i] != b[i])
      parts.push_back(fmt::format("{} (the run has {})", b[i], a[i].substr(a[i].find("= ") + 2)));
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace splinevox::run
