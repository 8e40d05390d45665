// SPDX-License-Identifier: Apache-2.0
#include "core/json_text.hpp"

namespace splinevox {

using nlohmann::json;
using nlohmann::ordered_json;

json parse_json(std::string_view text, const json::parser_callback_t& guard) {
  return json::parse(text, guard);
}

ordered_json parse_ordered_json(std::string_view text, const ordered_json::parser_callback_t& guard) {
  return ordered_json::parse(text, guard);
}

std::string dump_json(const json& value, int indent, NotUtf8 wrong) {
  return value.dump(indent, ' ', false, wrong);
}

std::string dump_json(const ordered_json& value, int indent, NotUtf8 wrong) {
  return value.dump(indent, ' ', false, wrong);
}

}  // namespace splinevox
