// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace splinevox::run {

/// A table as text, and the forms it is written in. Every row has a cell for each column.
struct Table {
  struct Column {
    std::string name;     ///< for programs
    std::string heading;  ///< for people
    bool number;          ///< aligned to the right
  };
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows = {};
};

/// With a line of names. For spreadsheets too: what would be a formula gets a ' in front.
std::string csv(const Table& table);
std::string markdown(const Table& table);
/// A tabular that needs no package.
std::string latex(const Table& table);

}  // namespace splinevox::run
