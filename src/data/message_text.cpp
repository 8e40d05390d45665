// SPDX-License-Identifier: Apache-2.0
#include "data/message_text.hpp"

#include <fmt/format.h>

namespace splinevox::data {

std::string in_quotes(std::string_view text) { return fmt::format("'{}'", printable(text)); }

std::string number(double value) { return fmt::format("{:.9g}", value); }
std::string time_text(double time) { return fmt::format("{:.15g}", time); }

}  // namespace splinevox::data
