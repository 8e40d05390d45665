// SPDX-License-Identifier: Apache-2.0
#include "run/own_json.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "data/json_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

enum class Is { number, text, flag, list, object };

/// What a field is, by where it is: [] for every element of a list, * for every field of an object.
struct Rule {
  std::string_view path;
  Is is;
};

constexpr Rule kOfMetrics[] = {{"", Is::object},
                               {"finished", Is::flag},
                               {"split", Is::text},
                               {"preset", Is::text},
                               {"device", Is::text},
                               {"machine", Is::text},
                               {"commit", Is::text},
                               {"psnr", Is::number},
                               {"ssim", Is::number},
                               {"ms_ssim", Is::number},
                               {"psnr_inside", Is::number},
                               {"inside_views", Is::number},
                               {"inside_share", Is::number},
                               {"ignored_share", Is::number},
                               {"steps", Is::number},
                               {"preset_steps", Is::number},
                               {"preset_share", Is::number},
                               {"stride", Is::number},
                               {"seconds", Is::number},
                               {"train_seconds", Is::number},
                               {"samples_per_second", Is::number},
                               {"peak_memory_bytes", Is::number},
                               {"moving_share", Is::number},
                               {"psnr_best_gain", Is::number},
                               {"held_camera", Is::object},
                               {"held_camera.*", Is::number},
                               {"truth_volume", Is::object},
                               {"truth_volume.scale", Is::number},
                               {"truth_volume.l1", Is::number},
                               {"truth_volume.correlation_per_moment", Is::number},
                               {"truth_volume.moments", Is::list},
                               {"truth_volume.moments[]", Is::object},
                               {"truth_volume.moments[].time", Is::number},
                               {"truth_volume.moments[].mass", Is::number},
                               {"truth_volume.moments[].mass_truth", Is::number},
                               {"truth_volume.moments[].l1", Is::number},
                               {"metrics", Is::object},
                               {"metrics.*", Is::number},
                               {"cameras", Is::list},
                               {"cameras[]", Is::object},
                               {"cameras[].name", Is::text},
                               {"cameras[].gain", Is::list},
                               {"cameras[].gain[]", Is::number},
                               {"cameras[].gains", Is::list},
                               {"cameras[].gains[]", Is::list},
                               {"cameras[].gains[][]", Is::number},
                               {"cameras[].offset", Is::number},
                               {"cameras[].offset_frames", Is::number},
                               {"phases", Is::object},
                               {"phases.*", Is::number},
                               {"frames", Is::list},
                               {"frames[]", Is::object},
                               {"frames[].name", Is::text},
                               {"frames[].time", Is::number},
                               {"frames[].psnr", Is::number},
                               {"frames[].psnr_inside", Is::number},
                               {"frames[].metrics", Is::object},
                               {"frames[].metrics.*", Is::number},
                               {"frames[].ssim", Is::number},
                               {"frames[].ms_ssim", Is::number}};
constexpr Rule kOfLine[] = {{"", Is::object},         {"step", Is::number}, {"seconds", Is::number},
                            {"psnr", Is::number},     {"loss", Is::number}, {"held_psnr", Is::number},
                            {"held_ssim", Is::number}};
constexpr Rule kOfEffects[] = {{"", Is::object},
                               {"note", Is::text},
                               {"forced", Is::flag},
                               {"effects", Is::list},
                               {"effects[]", Is::object},
                               {"effects[].effect", Is::text},
                               {"effects[].used", Is::flag},
                               {"effects[].decision", Is::text},
                               {"effects[].gain_db", Is::number},
                               {"effects[].gain_lo", Is::number},
                               {"effects[].gain_hi", Is::number},
                               {"effects[].time_ratio", Is::number},
                               {"effects[].bytes_ratio", Is::number},
                               {"effects[].where", Is::number},
                               {"effects[].far", Is::number},
                               {"effects[].spread", Is::number},
                               {"effects[].whole", Is::number},
                               {"effects[].apart", Is::number},
                               {"effects[].offsets", Is::list},
                               {"effects[].offsets[]", Is::object},
                               {"effects[].offsets[].frames", Is::number},
                               {"effects[].offsets[].frames_lo", Is::number},
                               {"effects[].offsets[].frames_hi", Is::number},
                               {"still_cameras", Is::object},
                               {"still_cameras.verdict", Is::text},
                               {"still_cameras.*", Is::number},
                               {"film", Is::object},
                               {"film.given", Is::flag},
                               {"film.moves", Is::flag},
                               {"film.*", Is::number}};
constexpr Rule kOfHistory[] = {{"", Is::object},
                               {"history", Is::list},
                               {"history[]", Is::object},
                               {"history[].from", Is::text},
                               {"history[].operations", Is::list},
                               {"history[].operations[]", Is::object},
                               {"history[].operations[].operation", Is::text},
                               {"history[].operations[].value", Is::text}};

const char* words(Is is) {
  switch (is) {
    case Is::number:
      return "a number";
    case Is::text:
      return "a text";
    case Is::flag:
      return "true or false";
    case Is::list:
      return "a list";
    case Is::object:
      return "an object";
  }
  return "";
}

bool is_one(const Json& json, Is is) {
  switch (is) {
    case Is::number:
      return json.is_number();
    case Is::text:
      return json.is_string();
    case Is::flag:
      return json.is_boolean();
    case Is::list:
      return json.is_array();
    case Is::object:
      return json.is_object();
  }
  return false;
}

const Rule* rule_for(std::span<const Rule> rules, std::string_view path) {
  for (const Rule& rule : rules) {
    const std::string_view before =
        rule.path.substr(0, rule.path.size() - (rule.path.ends_with(".*") ? 1 : 0));
    if (rule.path == path || (before.size() < rule.path.size() && path.starts_with(before))) return &rule;
  }
  return nullptr;
}

/// Checks a value that a rule is for, and what is in it. A number that was not finite is null in the file.
/// @return false if it is such a one
bool check(Json& json, std::span<const Rule> rules, const std::string& path, const std::string& where) {
  const Rule* rule = rule_for(rules, path);
  if (!rule) return true;
  if (rule->is == Is::number && json.is_null()) return false;
  if (!is_one(json, rule->is))
    fail({where,
          path.empty() ? "the file is not what it should hold" : "the field " + path + " is of a wrong type",
          words(rule->is), json.type_name(), "is this file of a run? leave it out, or copy it again"});
  if (json.is_array())
    for (Json& element : json)
      if (!check(element, rules, path + "[]", where))
        fail({where, "a number in the field " + path + "[] was not finite", words(Is::number), "null",
              "is this file of a run? leave it out, or copy it again"});
  if (json.is_object())
    for (auto at = json.begin(); at != json.end();) {
      const std::string inner = path.empty() ? at.key() : path + "." + at.key();
      if (check(at.value(), rules, inner, where))
        ++at;
      else
        at = json.erase(at);
    }
  return true;
}

Json read(const std::string& path, std::span<const Rule> rules) {
  Json json = read_json(path);
  check(json, rules, "", path);
  return json;
}

bool is_there(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(std::filesystem::symlink_status(path, ignored));
}

}  // namespace

Json read_metrics(const std::string& path) { return read(path, kOfMetrics); }

Json read_metrics_if_there(const std::string& path) {
  return is_there(path) ? read_metrics(path) : Json::object();
}

std::vector<MetricsLine> read_metrics_lines(const std::string& path) {
  std::vector<MetricsLine> lines;
  std::size_t number = 0;
  const std::string text = read_text_if_there(path);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    MetricsLine line{text.substr(at, end - at), {}};
    at = end + 1;
    const std::string where = path + ", line " + std::to_string(++number);
    std::optional<Json> json = data::read_json_line(line.text, where);
    if (!json) continue;
    line.json = std::move(*json);
    check(line.json, kOfLine, "", where);
    lines.push_back(std::move(line));
  }
  return lines;
}

Json read_effects_if_there(const std::string& path) {
  return is_there(path) ? read(path, kOfEffects) : Json(nullptr);
}

Json read_history_if_there(const std::string& path) {
  if (!is_there(path)) return Json::array();
  Json json = read(path, kOfHistory);
  return json.contains("history") ? json["history"] : Json::array();
}

}  // namespace splinevox::run
