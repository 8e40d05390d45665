// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace splinevox::run {

/// One line or cloud of a chart. Points that are not finite are left out.
struct Series {
  enum class Mark { line, faint_line, dots };
  std::string name;
  int colour = 0;  ///< --c0..--c7 of the style sheet: the run, or what it shows of the only one
  Mark mark = Mark::line;
  std::vector<std::pair<double, double>> points;
};

struct ChartText {
  std::string title, x, y;
  bool log_y = false;
};

/// A chart that chart_scripts() draws: axes, grid, legend, values under the pointer.
std::string line_chart(const ChartText& text, const std::vector<Series>& series);

/// The library (Chart.js, from the system's package at build time) and what makes charts of the page's
/// line_charts. Once, at the end of the page.
std::string chart_scripts();

/// A script of the page as an element.
std::string script_element(std::string_view asset);

/// A row of parts of a whole, widths in proportion, with a legend.
std::string stacked_bar(const std::vector<std::pair<std::string, double>>& parts, const std::string& unit);

}  // namespace splinevox::run
