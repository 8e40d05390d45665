// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "field/columns.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/config_keys.hpp"
#include "train/config/config_value.hpp"
#include "train/effects/effect_table.hpp"

namespace splinevox {
namespace {

using config_value::Source;

std::string_view trim(std::string_view s) {
  const auto space = [](char c) { return c == ' ' || c == '\t'; };
  while (!s.empty() && space(s.front())) s.remove_prefix(1);
  while (!s.empty() && space(s.back())) s.remove_suffix(1);
  return s;
}

/// A scalar, or a comma separated list with or without brackets; "" and "[]" are the empty list.
template <class T>
void assign(T& member, std::string_view text, const Source& source) {
  text = trim(text);
  if constexpr (config_value::IsList<T>::value) {
    if (text.size() >= 2 && text.front() == '[' && text.back() == ']')
      text = trim(text.substr(1, text.size() - 2));
    T list;
    while (!text.empty()) {
      const std::size_t comma = text.find(',');
      list.push_back(config_value::parse<typename T::value_type>(trim(text.substr(0, comma)), source));
      text = comma == text.npos ? std::string_view{} : text.substr(comma + 1);
    }
    member = list;
  } else {
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
    member = config_value::parse<T>(text, source);
  }
}

[[noreturn]] void wrong(const char* key, const std::string& what, std::string expected, std::string got) {
  fail({"configuration", fmt::format("'{}' {}", key, what), std::move(expected), std::move(got), ""});
}

/// Stage starts: as many as stages, the first at 0 where `from_zero`, never going back.
void check_starts(const char* key, const char* of, const std::vector<float>& starts, std::size_t stages,
                  bool from_zero) {
  const std::string got = config_value::print(starts);
  if (starts.size() != stages)
    wrong(key, "has the wrong length", fmt::format("{} numbers, one for each of {}", stages, of), got);
  if (from_zero && !starts.empty() && starts[0] != 0) wrong(key, "does not begin at 0", "0 first", got);
  for (std::size_t i = 1; i < starts.size(); ++i)
    if (starts[i] < starts[i - 1]) wrong(key, "goes back", "numbers that do not decrease", got);
}

void check_grid(const Config& c) {
  const GridConfig& g = c.grid;
  if (g.radiance.empty()) wrong("grid.radiance", "is empty", "at least one stage", "[]");
  for (std::size_t i = 1; i < g.radiance.size(); ++i)
    if (g.radiance[i] < g.radiance[i - 1])
      wrong("grid.radiance", "gets coarser", "numbers that do not decrease", config_value::print(g.radiance));
  check_starts("grid.surroundings_start", "grid.surroundings", g.surroundings_start, g.surroundings.size(),
               true);
  if (!std::is_sorted(g.surroundings.begin(), g.surroundings.end()))
    wrong("grid.surroundings", "gets coarser", "numbers that do not decrease",
          config_value::print(g.surroundings));
  check_starts("grid.radiance_start", "grid.radiance", g.radiance_start, g.radiance.size(), true);
  if (changes(effects_of(c)) && g.motion.empty())
    wrong("grid.motion", "is empty",
          "at least one level, or motion.enabled, motion.light and motion.presence = false", "[]");
  for (std::size_t i = 1; i < g.motion.size(); ++i)
    if (g.motion[i] != 2 * g.motion[i - 1])
      wrong("grid.motion", "has a level that does not halve the one before",
            "each number twice the one before, as 4, 8, 16", config_value::print(g.motion));
  check_starts("grid.motion_start", "grid.motion", g.motion_start, g.motion.size(), false);
  check_starts("grid.empty_start", "the emptyings", g.empty_start, g.empty_start.size(), false);
  if (!g.box.empty()) {
    if (g.box.size() != 6)
      wrong("grid.box", "has the wrong length", "6 numbers: lo.xyz, hi.xyz, or none",
            config_value::print(g.box));
    for (int a = 0; a < 3; ++a)
      if (!(g.box[a] < g.box[a + 3]))
        wrong("grid.box", "is empty", "lo < hi on every axis", config_value::print(g.box));
  }
}

void check_motion(const MotionConfig& m) {
  const Basis& basis = basis_of(m.basis);
  const std::string unsuited = fmt::format("does not suit motion.basis = \"{}\"", basis.name);
  if (!basis.trained) wrong("motion.basis", "cannot be trained", trained_basis_names(), basis.name);
  if (!basis.pinnable && m.first_point != FirstPoint::free)
    wrong("motion.first_point", unsuited, "free (its curves do not begin in their first point)", "zero");
  if (!basis.trained_points().allows(m.points))
    wrong("motion.points", unsuited, basis.trained_points().text(), fmt::format("{}", m.points));
  if (!basis.elevates() && !m.elevate_points.empty())
    wrong("motion.elevate_points", unsuited, basis.halves() ? "[], or motion.halve_start" : "[]",
          config_value::print(m.elevate_points));
  int before = m.points;
  for (int k : m.elevate_points) {
    if (k <= before)
      wrong("motion.elevate_points", "does not grow",
            fmt::format("numbers above motion.points = {}, each above the one before", m.points),
            config_value::print(m.elevate_points));
    if (!basis.points.allows(k))
      wrong("motion.elevate_points", unsuited, basis.points.text(), config_value::print(m.elevate_points));
    before = k;
  }
  if (basis.halves()) {
    if (m.points > basis.most_points(int(m.halve_start.size())))
      wrong("motion.halve_start", "leads to too many control points",
            fmt::format("at most {}: fewer halvings, or fewer of motion.points", basis.points.most),
            fmt::format("{} from {}", config_value::print(m.halve_start), m.points));
    check_starts("motion.halve_start", "the halvings", m.halve_start, m.halve_start.size(), false);
  }
  check_starts("motion.elevate_start", "motion.elevate_points", m.elevate_start, m.elevate_points.size(),
               false);
}

/// Writers obey the readers' limit: a model of more grids could be trained and never be read.
void check_grids(const Config& c) {
  if (const int grids = grids_at_end(c); grids > kMostGrids)
    wrong("motion.points", "leads to more grids than a model file may have",
          fmt::format("at most {} grids: fewer control points in the end{}", kMostGrids,
                      c.motion.enabled && c.motion.light ? ", of motion and light each" : ""),
          fmt::format("{} grids with {} control points", grids, points_at_end(c.motion)));
}

}  // namespace

int grids_at_end(const Config& c) {
  RadianceField radiance;
  radiance.sh_order = c.radiance.sh_order;
  MotionField motion;
  motion.basis = c.motion.basis;
  motion.points = points_at_end(c.motion);
  motion.first_point = c.motion.first_point;
  store(effects_of(c), motion);
  return int(radiance_columns(radiance).size() + motion_columns(motion).size());
}

int points_at_end(const MotionConfig& motion) {
  const Basis& basis = basis_of(motion.basis);
  if (!basis.halves()) return motion.elevate_points.empty() ? motion.points : motion.elevate_points.back();
  int points = motion.points;
  for (std::size_t i = 0; i < motion.halve_start.size(); ++i) points = basis.refinement.refined(points);
  return points;
}

int reached(const std::vector<float>& starts, double progress) {
  int i = -1;
  while (i + 1 < int(starts.size()) && progress >= starts[i + 1]) ++i;
  return i;
}

int order_at(const RadianceConfig& config, double progress) {
  const int joined = reached(config.sh_start, progress) + 1;
  return joined == int(config.sh_start.size()) ? config.sh_order : std::min(config.sh_order, joined);
}

Config preset(const std::string& name) {
  std::vector<std::string> names;
  for (const Preset& p : presets()) {
    if (p.name == name) return p.config;
    names.emplace_back(p.name);
  }
  fail({"--preset", "there is no preset '" + name + "'", fmt::format("{}", fmt::join(names, ", ")), name,
        "--preset " + nearest(name, names)});
}

void set_config(Config& config, const std::string& assignment, const std::string& where) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos)
    fail({where, "this is not a setting", "group.key=value", assignment, "optimiser.lr_color=0.1"});
  const std::string key(trim(std::string_view(assignment).substr(0, equals)));
  const std::string_view text = std::string_view(assignment).substr(equals + 1);
  bool found = false;
  visit_config(config, [&](const char* name, auto& member, const char*, double lo, double hi) {
    if (key != name) return;
    found = true;
    assign(member, text, {where, key, lo, hi});
  });
  if (!found && key == "preset")
    fail({where, "a preset is no setting: settings change it", "--preset NAME", assignment,
          "--preset " + std::string(trim(text))});
  if (!found) config_value::unknown_key(where, key);
}

void validate(const Config& config) {
  visit_config(config, [&](const char* name, const auto& member, const char*, double lo, double hi) {
    const Source source{"configuration", name, lo, hi};
    using T = std::decay_t<decltype(member)>;
    if constexpr (config_value::IsList<T>::value) {
      for (const auto& v : member)
        config_value::parse<typename T::value_type>(config_value::print(v), source);
    } else if constexpr (!std::is_enum_v<T>) {
      config_value::parse<T>(config_value::print(member), source);
    }
  });
  if (config.run.max_time <= 0 && config.run.max_steps <= 0)
    wrong("run.max_time", "and run.max_steps are both 0: the run would have no end", "one of them above 0",
          "0");
  if (config.run.background.size() != 3)
    wrong("run.background", "has the wrong length", "3 numbers: r, g, b",
          config_value::print(config.run.background));
  check_grid(config);
  check_starts("radiance.sh_start", "the orders", config.radiance.sh_start, config.radiance.sh_start.size(),
               false);
  if (changes(effects_of(config))) {
    check_motion(config.motion);
    check_grids(config);
  }
  if (config.sampling.rays < 4 * config.sampling.frames)
    wrong("sampling.rays", "is too small for sampling.frames",
          fmt::format("at least one 2 x 2 patch for each of {} frames", config.sampling.frames),
          fmt::format("{}", config.sampling.rays));
}

}  // namespace splinevox
