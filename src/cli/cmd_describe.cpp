// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/command.hpp"
#include "cli/tree.hpp"
#include "run/support.hpp"

namespace splinevox::cli {

Action man_command(CLI::App& verb) {
  return [&verb] {
    fmt::print("{}", man_page(*verb.get_parent(), kVersion));
    return 0;
  };
}

Action completion_command(CLI::App& verb) {
  auto shell = std::make_shared<std::string>();
  verb.add_option("SHELL", *shell, "whose script to print")
      ->required()
      ->type_name(fmt::format("{{{}}}", fmt::join(completion_shells(), ",")));
  return [shell, &verb] {
    fmt::print("{}", completion(*verb.get_parent(), *shell));
    return 0;
  };
}

}  // namespace splinevox::cli
