// SPDX-License-Identifier: Apache-2.0
#include "run/sweep/table.hpp"

#include <functional>
#include <string_view>

#include "core/number_text.hpp"

namespace splinevox::run {
namespace {

/// Quoted where it has to be, and no formula.
std::string csv_cell(const std::string& text) {
  const bool number = parse_number<double>(text).has_value();
  std::string cell =
      !number && !text.empty() && std::string_view("=+-@").find(text[0]) != std::string_view::npos
          ? "'" + text
          : text;
  if (cell.find_first_of(",\"\r\n") == cell.npos) return cell;
  std::string out = "\"";
  for (const char c : cell) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string markdown_cell(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string latex_cell(const std::string& text) {
  constexpr std::string_view kPlusMinus = "±";
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (text.compare(i, kPlusMinus.size(), kPlusMinus) == 0) {
      out += "$\\pm$";
      i += kPlusMinus.size() - 1;
    } else if (c == '\\') {
      out += "\\textbackslash{}";
    } else if (c == '<' || c == '>' || c == '|') {  // which are others in the fonts of plain LaTeX
      out += std::string("$") + c + "$";
    } else if (c == '~' || c == '^') {
      out += std::string("\\") + c + "{}";
    } else {
      if (std::string_view("&%$#_{}").find(c) != std::string_view::npos) out += '\\';
      out += c;
    }
  }
  return out;
}

using Cell = std::function<std::string(const std::string&)>;

/// Cells in one line.
std::string line(const std::vector<std::string>& cells, const Cell& cell, const std::string& start,
                 const std::string& between, const std::string& end) {
  std::string text = start;
  for (std::size_t i = 0; i < cells.size(); ++i) text += (i ? between : "") + cell(cells[i]);
  return text + end;
}

std::vector<std::string> all(const Table& table, std::string Table::Column::*member) {
  std::vector<std::string> out;
  for (const Table::Column& column : table.columns) out.push_back(column.*member);
  return out;
}

}  // namespace

std::string csv(const Table& table) {
  std::string text = line(all(table, &Table::Column::name), csv_cell, "", ",", "\n");
  for (const auto& row : table.rows) text += line(row, csv_cell, "", ",", "\n");
  return text;
}

std::string markdown(const Table& table) {
  std::string text = line(all(table, &Table::Column::heading), markdown_cell, "| ", " | ", " |\n");
  for (const Table::Column& column : table.columns) text += column.number ? "| ---: " : "| --- ";
  text += "|\n";
  for (const auto& row : table.rows) text += line(row, markdown_cell, "| ", " | ", " |\n");
  return text;
}

std::string latex(const Table& table) {
  std::string text = "\\begin{tabular}{";
  for (const Table::Column& column : table.columns) text += column.number ? 'r' : 'l';
  text += "}\n\\hline\n" + line(all(table, &Table::Column::heading), latex_cell, "", " & ", " \\\\\n") +
          "\\hline\n";
  for (const auto& row : table.rows) text += line(row, latex_cell, "", " & ", " \\\\\n");
  return text + "\\hline\n\\end{tabular}\n";
}

}  // namespace splinevox::run
