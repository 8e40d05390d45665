// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <array>
#include <type_traits>

#include "splinevox/core/error.hpp"

namespace splinevox::mlp {
namespace {

constexpr std::array kNames{"spline", "nr-nerf", "t-nerf"};

/// Calls visit(key, member) for every number of the settings: the one list behind the text in both
/// directions.
template <class S, class Visit>
void visit_settings(S& s, Visit&& visit) {
  visit("preset", s.preset);
  visit("points", s.points);
  visit("samples", s.samples);
  visit("crops", s.crops);
  visit("crop", s.crop);
  visit("lr", s.lr);
  visit("lr_final", s.lr_final);
  visit("offset", s.offset);
  visit("offset_rigidity", s.offset_rigidity);
  visit("divergence", s.divergence);
  visit("ramp", s.ramp);
  visit("view_sees_position", s.view_sees_position);
  visit("rigidity_scale", s.rigidity_scale);
  visit("density_noise", s.density_noise);
  visit("shrink", s.shrink);
  visit("shrink_start", s.shrink_start);
  visit("max_time", s.max_time);
  visit("cpu_time", s.cpu_time);
  visit("max_steps", s.max_steps);
  visit("device", s.device);
  visit("seed", s.seed);
  visit("downscale", s.downscale);
  visit("background", s.background);
  visit("test_at", s.test_at);
  visit("test_stride", s.test_stride);
}

}  // namespace

const char* name(Kind kind) { return kNames[std::size_t(kind)]; }

Kind kind_of(const std::string& text) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (text == kNames[i]) return Kind(i);
  fail({.where = "--kind",
        .what = "there is no such method",
        .expected = fmt::format("one of {}", fmt::join(kNames, ", ")),
        .got = text,
        .hint = {}});
}

Settings preset(const std::string& preset_name, Kind kind) {
  Settings s;
  s.kind = kind;
  s.preset = preset_name;
  if (preset_name == "paper") return s;
  if (preset_name != "nerf_atlas")
    fail({.where = "--preset",
          .what = "there is no such preset",
          .expected = "paper or nerf_atlas",
          .got = preset_name,
          .hint = {}});
  s.points = 6;
  s.lr = kind == Kind::spline ? 3e-4 : 1e-3;
  s.crop = kind == Kind::spline ? 18 : 20;
  s.offset_rigidity = 3e-3;
  s.divergence = 0;
  s.ramp = true;
  s.view_sees_position = true;
  s.rigidity_scale = 0.5;
  s.background = {0, 0, 0};
  s.shrink = {4, 2, 1};
  s.shrink_start = {0, .25, .5};
  return s;
}

std::string settings_text(const Settings& s) {
  std::string out = fmt::format("[mlp]\nkind = \"{}\"\n", name(s.kind));
  visit_settings(s, [&](const char* key, const auto& value) {
    using T = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<T, std::string>)
      out += fmt::format("{} = \"{}\"\n", key, value);
    else if constexpr (std::is_arithmetic_v<T>)
      out += fmt::format("{} = {}\n", key, value);
    else
      out += fmt::format("{} = [{}]\n", key, fmt::join(value, ", "));
  });
  return out;
}

Settings read_settings(const std::string& path) {
  Settings s;
  toml::table file;
  try {
    file = toml::parse_file(path);
  } catch (const toml::parse_error& error) {
    fail({.where = path,
          .what = "cannot be read",
          .expected = "the config.toml that `splinevox-mlp train` wrote",
          .got = error.what(),
          .hint = {}});
  }
  const auto table = file["mlp"];
  const auto missing = [&](const char* key) {
    fail({.where = path,
          .what = fmt::format("[mlp] has no usable '{}'", key),
          .expected = "the file that `splinevox-mlp train` wrote, unchanged",
          .got = {},
          .hint = {}});
  };
  const auto kind = table["kind"].value<std::string>();
  if (!kind) missing("kind");
  s.kind = kind_of(*kind);
  visit_settings(s, [&](const char* key, auto& value) {
    using T = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, bool>) {
      const auto v = table[key].template value<T>();
      if (!v) missing(key);
      value = *v;
    } else if constexpr (std::is_arithmetic_v<T>) {
      const auto v = table[key].template value<double>();
      if (!v) missing(key);
      value = T(*v);
    } else {
      const toml::array* list = table[key].as_array();
      if (!list) missing(key);
      value.clear();
      for (const toml::node& node : *list) value.push_back(typename T::value_type(node.value_or(0.0)));
    }
  });
  return s;
}

}  // namespace splinevox::mlp
