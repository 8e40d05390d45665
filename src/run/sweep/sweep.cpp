// SPDX-License-Identifier: Apache-2.0
#include "run/sweep/sweep.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>

#include "core/nearest.hpp"
#include "core/printable.hpp"
#include "core/shell_word.hpp"
#include "core/system.hpp"
#include "run/own_json.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/train/config.hpp"
#include "train/config/toml_text.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

/// The text of a number or a string; "" of anything else.
std::string scalar(const toml::node& node) {
  if (const auto s = node.value_exact<std::string>()) return *s;
  if (const auto i = node.value_exact<std::int64_t>()) return std::to_string(*i);
  return "";
}

std::vector<std::string> list(const toml::node* node, const std::string& path, const std::string& key) {
  std::vector<std::string> words;
  const toml::array* array = node ? node->as_array() : nullptr;
  for (std::size_t i = 0; array && i < array->size(); ++i) words.push_back(scalar((*array)[i]));
  if ((node && !array) || std::find(words.begin(), words.end(), "") != words.end())
    fail({path, fmt::format("'{}' is not a list of words or whole numbers", key),
          "for example " + key + " = [\"a\", \"b\"]", "", ""});
  return words;
}

toml::table read(const std::string& path) {
  const std::string text = toml_text(path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& e) {
    fail({fmt::format("{}, line {}", path, e.source().begin.line), std::string(e.description()),
          "TOML, see docs/scaling.md", "", ""});
  }
}

/// What each script for Slurm has, whatever a cluster wants added to it.
constexpr std::string_view kScriptName = "#SBATCH --job-name=splinevox\n",
                           kScriptTask =
                               " --task \"$SLURM_ARRAY_TASK_ID\" --threads \"${SLURM_CPUS_PER_TASK:-";

/// Text as a file name may be.
std::string file_name(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return text;
}

/// Words that become lines of files and arguments of this program.
void check_word(const std::string& path, const char* key, const std::string& word) {
  if (all_printable(word) != word)
    fail({path, fmt::format("'{}' has a word with control characters", key), "words that can be shown",
          printable(word), ""});
}

/// A preset and a seed become part of a folder's name.
void check_names(const std::string& path, const std::vector<std::string>& names,
                 const std::vector<std::string>& seeds) {
  for (const std::string& name : names) preset(name);
  for (const std::string& seed : seeds) {
    const bool digits = seed.find_first_not_of("0123456789") == seed.npos;
    if (!digits || seed.empty() || seed.size() > 15)
      fail({path, "'seeds' has one that is no seed", "whole numbers from 0 on, below 10^15", seed, ""});
  }
}

/// "group.key = value" is of "group.key".
std::string key_of(const std::string& set) {
  const std::string before = set.substr(0, set.find('='));
  const std::size_t from = std::min(before.find_first_not_of(" \t"), before.size());
  return before.substr(from, before.find_last_not_of(" \t") + 1 - from);
}

/// Options of `train` that set a key, and count before `--set`.
constexpr std::pair<std::string_view, std::string_view> kNamedSets[] = {{"--downscale", "run.downscale"},
                                                                        {"--max-time", "run.max_time"},
                                                                        {"--max-steps", "run.max_steps"},
                                                                        {"--background", "run.background"},
                                                                        {"--seed", "run.seed"}};

/// Throws Error (input) if a setting's value would not count.
void check_named(const std::string& path, const std::string& setting, const std::vector<std::string>& sets,
                 const std::vector<std::string>& words) {
  for (const auto& [option, key] : kNamedSets)
    for (const std::string& own : sets)
      if (const std::string start = std::string(option) + "=";
          key_of(own) == key &&
          (option == "--seed" || std::any_of(words.begin(), words.end(), [&](const std::string& word) {
             return word == option || word.starts_with(start);
           })))
        fail({path, fmt::format("setting '{}' has {}, and {} would count", setting, own, option),
              "one of them", "",
              option == "--seed" ? "seeds = [...]" : "a line of [settings] for each value"});
}

/// Words that every training gets, but for `--set` of keys that a setting has values of its own for: of two
/// the last would count.
std::vector<std::string> without_sets(const std::vector<std::string>& words,
                                      const std::vector<std::string>& sets) {
  const auto is_own = [&](const std::string& set) {
    return std::any_of(sets.begin(), sets.end(),
                       [&](const std::string& own) { return key_of(own) == key_of(set); });
  };
  std::vector<std::string> out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--set" && i + 1 < words.size() && is_own(words[i + 1]))
      ++i;
    else if (!words[i].starts_with("--set=") || !is_own(words[i].substr(6)))
      out.push_back(words[i]);
  }
  return out;
}

}  // namespace

std::vector<SweepTask> read_sweep(const std::string& path, const std::string& out) {
  const toml::table file = read(path);
  const std::vector<std::string> known = {"datasets", "presets", "seeds", "settings", "train"};
  for (const auto& [key, value] : file)
    if (std::find(known.begin(), known.end(), key.str()) == known.end())
      fail({path, fmt::format("there is no '{}' in a sweep", key.str()),
            fmt::format("{}", fmt::join(known, ", ")), std::string(key.str()),
            nearest(std::string(key.str()), known)});
  const auto words = [&](const char* key) { return list(file.get(key), path, key); };
  const std::vector<std::string> datasets = words("datasets"), common = words("train");
  std::vector<std::string> presets = words("presets"), seeds = words("seeds");
  if (datasets.empty()) fail({path, "there are no datasets", "datasets = [\"FOLDER\", ...]", "", ""});
  if (presets.empty()) presets = {"fast"};
  if (seeds.empty()) seeds = {"1"};
  check_names(path, presets, seeds);
  for (const std::string& dataset : datasets) {
    check_word(path, "datasets", dataset);
    if (dataset.starts_with('-'))
      fail({path, "'datasets' has one that would be an option", "folders", dataset, "./" + dataset});
  }
  for (const std::string& word : common) check_word(path, "train", word);
  check_word("--out", "--out", out);
  std::vector<std::pair<std::string, std::vector<std::string>>> settings;
  const toml::node* table = file.get("settings");
  if (table && !table->is_table())
    fail({path, "'settings' is not a table", "[settings], then lines NAME = [\"group.key=value\", ...]", "",
          ""});
  if (table)
    for (const auto& [name, value] : *table->as_table())
      settings.emplace_back(std::string(name.str()),
                            list(&value, path, "settings." + std::string(name.str())));
  for (const auto& [name, sets] : settings) {
    check_word(path, "settings", name);
    for (const std::string& s : sets) check_word(path, "settings", s);
    check_named(path, name, sets, common);
  }
  if (settings.empty()) settings.emplace_back("", std::vector<std::string>());

  std::vector<SweepTask> tasks;
  std::set<std::string> names;
  for (const std::string& dataset : datasets)
    for (const std::string& preset : presets)
      for (const auto& [setting, sets] : settings)
        for (const std::string& seed : seeds) {
          SweepTask t;
          t.name = fmt::format("{}_{}{}{}_s{}", file_name(folder_name(dataset)), preset,
                               setting.empty() ? "" : "_", file_name(setting), seed);
          if (!names.insert(t.name).second)
            fail({path, "two tasks would have the same folder",
                  "data sets and settings with names of their own", t.name, ""});
          t.dataset = dataset;
          t.preset = preset;
          t.setting = setting;
          t.seed = seed;
          t.run = out + "/" + t.name;
          t.train = {"train", dataset, "--out", t.run, "--preset", preset, "--seed", seed, "--resume"};
          for (const std::string& s : sets) t.train.insert(t.train.end(), {"--set", s});
          const std::vector<std::string> others = without_sets(common, sets);
          t.train.insert(t.train.end(), others.begin(), others.end());
          tasks.push_back(std::move(t));
        }
  return tasks;
}

SweepState state_of(const SweepTask& task) {
  SweepState s;
  Json j, effects;
  try {
    j = read_metrics_if_there(task.run + "/metrics.json");
    effects = read_effects_if_there(task.run + "/effects.json");
  } catch (const Error& e) {  // of this run alone: the others go on
    s.fault = e.what();
    return s;
  }
  if (!j.value("finished", false)) return s;
  s.trained = true;
  s.done = j.contains("psnr");
  if (!s.done) return s;
  s.metrics = j;
  if (!effects.is_object()) return s;
  for (const Json& e : effects.value("effects", Json::array()))
    if (e.value("used", false)) s.effects += (s.effects.empty() ? "" : " ") + e.value("effect", "");
  return s;
}

std::string sweep_commands(const std::vector<SweepTask>& tasks) {
  std::string text;
  for (const SweepTask& t : tasks) {
    text += "splinevox";
    for (const std::string& word : t.train) text += fmt::format(" {}", shell_word(word));
    text += fmt::format(" && splinevox eval {}\n", shell_word(t.run));
  }
  return text;
}

std::string slurm_script(const std::string& description, const std::string& out, std::size_t tasks,
                         int threads) {
  const std::string path = whole_path(out).string();
  // Slurm reads this line itself: quotes, and % for what it puts in, and no shell's escapes.
  if (path.find_first_of("\"\\%") != path.npos || all_printable(path) != path)
    fail({"--out", "this folder's path cannot stand in a script for Slurm", "a path without \", \\ and %",
          path, "another folder for --out"});
  return fmt::format(
      "#!/bin/bash\n{}#SBATCH --array=0-{}\n#SBATCH --cpus-per-task={}\n#SBATCH "
      "--output=\"{}/slurm_%a.log\"\n"
      "cd {} && exec {} sweep {} --out {}{}{}}}\"\n",
      kScriptName, tasks - 1, std::max(threads, 1), path, shell_word(fs::current_path().string()),
      shell_word(own_program()), shell_word(whole_path(description).string()), shell_word(out), kScriptTask,
      std::max(threads, 1));
}

bool is_slurm_script(std::string_view text) {
  return text.starts_with("#!/bin/bash\n") && text.find(kScriptName) != text.npos &&
         text.find(kScriptTask) != text.npos;
}

}  // namespace splinevox::run
