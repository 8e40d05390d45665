// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

/// The JSON library's parser and writer, compiled once: they take the compiler two seconds wherever they are
/// called.
namespace splinevox {

/// What the library's own `parse` gives. `guard` hears every event and may throw; it may be empty.
/// Throws nlohmann::json::exception for malformed text.
nlohmann::json parse_json(std::string_view text, const nlohmann::json::parser_callback_t& guard);
/// The same with fields in the text's order.
nlohmann::ordered_json parse_ordered_json(std::string_view text,
                                          const nlohmann::ordered_json::parser_callback_t& guard);

/// What to do with bytes that are not UTF-8.
using NotUtf8 = nlohmann::json::error_handler_t;
/// What the library's own `dump` gives. @param indent  -1: one line.
/// Throws nlohmann::json::exception for bytes that are not UTF-8, if they are to be errors (strict).
std::string dump_json(const nlohmann::json& json, int indent = -1, NotUtf8 wrong = NotUtf8::strict);
std::string dump_json(const nlohmann::ordered_json& json, int indent = -1, NotUtf8 wrong = NotUtf8::strict);

}  // namespace splinevox
