// SPDX-License-Identifier: Apache-2.0
#include "report/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "run/support.hpp"

namespace splinevox::run {

extern const char* const kChartJs;  // generated from the packaged file, see CMakeLists.txt

namespace {

/// At most about 400 points, so that a long run does not make a heavy page: means of equal stretches.
Json thin(const Series& s, bool log_y) {
  const std::size_t stride =
      s.mark == Series::Mark::dots ? 1 : std::max<std::size_t>(1, (s.points.size() + 399) / 400);
  Json out = Json::array();
  for (std::size_t i = 0; i < s.points.size(); i += stride) {
    double x = 0, y = 0;
    const std::size_t end = std::min(s.points.size(), i + stride);
    for (std::size_t k = i; k < end; ++k) x += s.points[k].first, y += s.points[k].second;
    const double n = double(end - i);
    if (std::isfinite(x) && std::isfinite(y) && (!log_y || y > 0))
      out.push_back({{"x", x / n}, {"y", y / n}});
  }
  return out;
}

/// Turns every canvas with data-chart into a chart in the page's colours. Nothing moves: a page is also
/// looked at as a picture.
constexpr const char* kGlue = R"js(
for (const canvas of document.querySelectorAll("canvas[data-chart]")) {
  const style = getComputedStyle(document.documentElement), color = name => style.getPropertyValue(name).trim();
  const chart = JSON.parse(canvas.dataset.chart);
  const axis = (text, type) => ({ type, title: { display: true, text, color: color("--soft") },
    grid: { color: color("--line") }, ticks: { color: color("--soft") } });
  new Chart(canvas, {
    type: "scatter",
    data: { datasets: chart.series.map(s => ({ label: s.name, data: s.points, showLine: s.mark !== "dots",
      borderColor: color("--c" + s.color) + (s.mark === "faint" ? "66" : ""), backgroundColor: color("--c" + s.color),
      borderWidth: s.mark === "faint" ? 1.2 : 2, pointRadius: s.mark === "dots" ? (s.points.length > 60 ? 1.5 : 3.5) : 0, pointHitRadius: 6 })) },
    options: { animation: false, maintainAspectRatio: false,
      scales: { x: axis(chart.x, "linear"), y: axis(chart.y, chart.log ? "logarithmic" : "linear") },
      plugins: { legend: { position: "bottom", labels: { color: color("--soft"), boxWidth: 14 } } } }
  });
}
)js";

}  // namespace

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
    else
      out += c;
  }
  return out;
}

std::string line_chart(const ChartText& text, const std::vector<Series>& series) {
  Json chart{{"x", text.x}, {"y", text.y}, {"log", text.log_y}, {"series", Json::array()}};
  for (const Series& s : series) {
    const char* mark = s.mark == Series::Mark::dots         ? "dots"
                       : s.mark == Series::Mark::faint_line ? "faint"
                                                            : "line";
    chart["series"].push_back(
        {{"name", s.name}, {"color", s.colour}, {"mark", mark}, {"points", thin(s, text.log_y)}});
  }
  return fmt::format(
      "<figure class=\"chart\"><figcaption>{0}</figcaption><div><canvas role=\"img\" aria-label=\"{0}\" "
      "data-chart=\"{1}\"></canvas></div></figure>",
      escape(text.title), escape(json_text(chart)));
}

std::string chart_scripts() { return fmt::format("<script>{}</script><script>{}</script>", kChartJs, kGlue); }

std::string stacked_bar(const std::vector<std::pair<std::string, double>>& parts, const std::string& unit) {
  double sum = 0;
  for (const auto& p : parts) sum += std::max(p.second, 0.0);
  std::string bar, legend;
  int colour = 0;
  for (const auto& [name, value] : parts) {
    if (value > 0 && sum > 0) {
      const double share = 100 * value / sum;
      bar += fmt::format("<i class=\"c{}\" style=\"width:{:.2f}%\" title=\"{} {:.1f} {}\"></i>", colour % 8,
                         share, escape(name), value, unit);
      legend += fmt::format("<span><i class=\"key-dot c{}\"></i>{} {:.1f} {} ({:.0f}%)</span>", colour % 8,
                            escape(name), value, unit, share);
    }
    ++colour;
  }
  return fmt::format("<div class=\"stack\">{}</div><p class=\"legend\">{}</p>", bar, legend);
}

}  // namespace splinevox::run
