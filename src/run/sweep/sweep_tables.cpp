// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "run/sweep/sweep.hpp"

namespace splinevox::run {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// kNone where a run has no such figure, as SSIM where masks leave no window whole.
double recorded(const Json& j, const char* key) {
  return j.contains(key) && j[key].is_number() ? j[key].get<double>() : kNone;
}

/// What the tables say of a task that is done.
struct Outcome {
  double steps, seconds, memory, psnr, ssim, ms_ssim;
  std::string effects, commit, machine;
};

Outcome outcome_of(const SweepState& s) {
  const Json& m = s.metrics;
  return {recorded(m, "steps"),
          recorded(m, "train_seconds"),
          recorded(m, "peak_memory_bytes"),
          recorded(m, "psnr"),
          recorded(m, "ssim"),
          recorded(m, "ms_ssim"),
          s.effects,
          m.value("commit", ""),
          m.value("machine", "")};
}

/// Of those that have the figure; kNone: none has.
double mean(const std::vector<Outcome>& all, double Outcome::*figure) {
  double sum = 0;
  int count = 0;
  for (const Outcome& o : all)
    if (std::isfinite(o.*figure)) {
      sum += o.*figure;
      ++count;
    }
  return count > 0 ? sum / count : kNone;
}

/// Empty where there is none.
std::string cell(fmt::format_string<double&> form, double figure) {
  return std::isfinite(figure) ? fmt::format(form, figure) : "";
}

/// What all say, or each once.
std::string together(const std::vector<Outcome>& all, std::string Outcome::*text) {
  std::set<std::string> said;
  for (const Outcome& o : all) said.insert(o.*text);
  return fmt::format("{}", fmt::join(said, "; "));
}

std::string psnr_text(const std::vector<Outcome>& all) {
  const auto less = [](const Outcome& a, const Outcome& b) { return a.psnr < b.psnr; };
  const auto [low, high] = std::minmax_element(all.begin(), all.end(), less);
  return cell("{:.2f}", mean(all, &Outcome::psnr)) +
         (all.size() > 1 ? fmt::format(" ± {:.2f}", (high->psnr - low->psnr) / 2) : "");
}

}  // namespace

Table tasks_table(const std::vector<SweepTask>& tasks) {
  Table table{{{"run", "run", false},
               {"dataset", "dataset", false},
               {"preset", "preset", false},
               {"setting", "setting", false},
               {"seed", "seed", true},
               {"steps", "steps", true},
               {"train_seconds", "training s", true},
               {"psnr", "PSNR", true},
               {"ssim", "SSIM", true},
               {"ms_ssim", "MS-SSIM", true},
               {"peak_memory_bytes", "memory, bytes", true},
               {"effects", "effects", false},
               {"commit", "commit", false},
               {"machine", "machine", false}}};
  for (const SweepTask& t : tasks) {
    std::vector<std::string> row{t.name, t.dataset, t.preset, t.setting, t.seed};
    if (const SweepState s = state_of(t); s.done) {
      const Outcome o = outcome_of(s);
      for (const double figure : {o.steps, o.seconds, o.psnr, o.ssim, o.ms_ssim, o.memory})
        row.push_back(cell("{}", figure));
      row.insert(row.end(), {o.effects, o.commit, o.machine});
    }
    row.resize(table.columns.size());
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table settings_table(const std::vector<SweepTask>& tasks) {
  Table table{{{"dataset", "dataset", false},
               {"preset", "preset", false},
               {"setting", "setting", false},
               {"done", "done", false},
               {"psnr", "PSNR", true},
               {"ssim", "SSIM", true},
               {"train_seconds", "training s", true},
               {"peak_memory_gb", "memory, GB", true},
               {"effects", "effects", false},
               {"commit", "commit", false},
               {"machine", "machine", false}}};
  struct Group {
    std::vector<std::string> names;
    std::vector<Outcome> done;
    std::size_t tasks = 0;
  };
  std::vector<Group> groups;
  for (const SweepTask& t : tasks) {
    const std::vector<std::string> names{t.dataset, t.preset, t.setting};
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.names == names; });
    if (group == groups.end()) group = groups.insert(groups.end(), {names, {}, 0});
    ++group->tasks;
    if (const SweepState s = state_of(t); s.done) group->done.push_back(outcome_of(s));
  }
  for (const Group& g : groups) {
    std::vector<std::string> row = g.names;
    row.push_back(fmt::format("{} of {}", g.done.size(), g.tasks));
    if (!g.done.empty())
      row.insert(row.end(),
                 {psnr_text(g.done), cell("{:.4f}", mean(g.done, &Outcome::ssim)),
                  cell("{:.0f}", mean(g.done, &Outcome::seconds)),
                  cell("{:.2f}", mean(g.done, &Outcome::memory) / 1e9), together(g.done, &Outcome::effects),
                  together(g.done, &Outcome::commit), together(g.done, &Outcome::machine)});
    row.resize(table.columns.size());
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace splinevox::run
