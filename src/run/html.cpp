// SPDX-License-Identifier: Apache-2.0
#include "run/html.hpp"

#include <fmt/format.h>

#include "core/atomic_file.hpp"

namespace splinevox::run {

bool is_page(std::string_view start) {
  return start.starts_with("<!doctype html>") && start.find("<title>splinevox: ") != start.npos;
}

bool is_view(std::string_view start) {
  return is_page(start) && start.find("content=\"splinevox view\"") != start.npos;
}

std::string model_mark(const std::string& run) {
  return fmt::format("{:016x}", digest_file(run + "/model.vdb").hash);
}

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      out += c;
  }
  return out;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t v = 0;
    for (std::size_t k = 0; k < 3; ++k) v = v << 8 | (i + k < bytes.size() ? bytes[i + k] : 0);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[v >> (18 - 6 * k) & 63];
  }
  return out;
}

}  // namespace splinevox::run
