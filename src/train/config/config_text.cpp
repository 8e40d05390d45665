// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "splinevox/train/config_keys.hpp"
#include "train/config/config_value.hpp"
#include "train/config/toml_text.hpp"

namespace splinevox {
namespace {

using config_value::Source;

std::string at(const std::string& path, const toml::node& node) {
  return fmt::format("{}, line {}", path, node.source().begin.line);
}

/// A scalar node as text, so that --set and TOML share one parser.
std::string text_of(const toml::node& node) {
  if (const auto* v = node.as_string()) return v->get();
  if (const auto* v = node.as_boolean()) return v->get() ? "true" : "false";
  if (const auto* v = node.as_integer()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_floating_point()) return fmt::format("{}", v->get());
  return node.is_table() ? "a table" : node.is_array() ? "a list" : "a date or time";
}

template <class T>
T scalar(const toml::node& node, const Source& source) {
  if (node.is_string() != std::is_enum_v<T>)
    config_value::refuse<T>(source, "has the wrong kind of value", text_of(node));
  return config_value::parse<T>(text_of(node), source);
}

template <class T>
void assign(T& member, const toml::node& node, const Source& source) {
  if constexpr (config_value::IsList<T>::value) {
    const toml::array* list = node.as_array();
    if (!list) config_value::refuse<T>(source, "is not a list", text_of(node));
    T values;
    for (const toml::node& v : *list) values.push_back(scalar<typename T::value_type>(v, source));
    member = values;
  } else {
    member = scalar<T>(node, source);
  }
}

/// Keys of earlier versions that mean nothing any more. Files that have them stay readable.
constexpr std::string_view kRetired[] = {"loss.along"};

void apply(Config& config, const std::string& key, const toml::node& node, const std::string& path) {
  bool found = false;
  visit_config(config, [&](const char* name, auto& member, const char*, double lo, double hi) {
    if (key != name) return;
    found = true;
    assign(member, node, {at(path, node), key, lo, hi});
  });
  if (!found && std::find(std::begin(kRetired), std::end(kRetired), key) == std::end(kRetired))
    config_value::unknown_key(at(path, node), key);
}

toml::table parse_file(const std::string& path) {
  constexpr std::size_t kEnough = std::size_t(1) << 20;
  const std::string text = toml_text(path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error&) {  // without memory the library finds mistakes where there are none
    ::operator delete(::operator new(kEnough));
  }
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& e) {
    fail({fmt::format("{}, line {}", path, e.source().begin.line), "this is not TOML", "",
          std::string(e.description()), ""});
  }
}

}  // namespace

void read_config(Config& config, const std::string& path) {
  const toml::table file = parse_file(path);
  // The preset is the ground the other lines stand on, so it is applied first wherever it is written.
  if (const toml::node* name = file.get("preset")) {
    if (!name->is_string())
      fail({at(path, *name), "'preset' is not a name", "text, as preset = \"fast\"", text_of(*name), ""});
    config = preset(name->as_string()->get());
  }
  for (const auto& [group, node] : file) {
    const std::string name(group.str());
    if (name == "preset" || name == "record") continue;  // [record]: what the program wrote down about a run
    if (const toml::table* table = node.as_table())
      for (const auto& [key, value] : *table) apply(config, name + "." + std::string(key.str()), value, path);
    else
      config_value::unknown_key(at(path, node), name);
  }
}

std::string write_config(const Config& config) {
  std::string text = fmt::format("preset = \"{}\"\n", config.preset), group;
  visit_config(config, [&](const char* key, const auto& member, const char* doc, double lo, double hi) {
    const std::string name = key;
    const std::size_t dot = name.find('.');
    if (name.substr(0, dot) != group) {
      group = name.substr(0, dot);
      text += fmt::format("\n[{}]\n", group);
    }
    using T = std::decay_t<decltype(member)>;
    std::string line = fmt::format("{} = {}", name.substr(dot + 1), config_value::print(member));
    if (line.size() < 40) line.resize(40, ' ');
    const std::string range = config_value::expected<T>(lo, hi);
    text += fmt::format("{}  # {}{}\n", line, doc, range == doc ? "" : "; " + range);
  });
  return text;
}

}  // namespace splinevox
