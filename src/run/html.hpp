// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// How text and bytes may stand in a page.
namespace splinevox::run {

/// Whether a file begins as the pages of `view` and `report` do.
bool is_page(std::string_view start);
/// Of these, those of `view`.
bool is_view(std::string_view start);
/// What tells the model of a run from others of the same name, as a page of `view` has it in its head. Throws
/// Error if there is no model.vdb.
std::string model_mark(const std::string& run);

/// Text made safe for HTML, also within an attribute.
std::string escape(const std::string& text);

/// Bytes as text: RFC 4648 with padding, no line breaks.
std::string base64(std::span<const std::uint8_t> bytes);
inline std::string base64(const std::vector<char>& bytes) {
  return base64({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace splinevox::run
