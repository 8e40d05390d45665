// SPDX-License-Identifier: Apache-2.0
#include "report/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/page.hpp"
#include "run/html.hpp"
#include "run/support.hpp"

namespace splinevox::run {
namespace {

/// At most about 400 points, so that a long run does not make a heavy page: means of equal stretches.
Json thin(const Series& s, bool log_y) {
  const std::size_t stride =
      s.mark == Series::Mark::dots ? 1 : std::max<std::size_t>(1, (s.points.size() + 399) / 400);
  Json out = Json::array();
  for (std::size_t i = 0; i < s.points.size(); i += stride) {
    double x = 0, y = 0;
    const std::size_t end = std::min(s.points.size(), i + stride);
    for (std::size_t k = i; k < end; ++k) {
      x += s.points[k].first;
      y += s.points[k].second;
    }
    const double n = double(end - i);
    if (std::isfinite(x) && std::isfinite(y) && (!log_y || y > 0))
      out.push_back({{"x", x / n}, {"y", y / n}});
  }
  return out;
}

}  // namespace

std::string script_element(std::string_view asset) {
  std::string script(report_asset(asset));
  for (std::size_t at = 0; (at = script.find("</script", at)) != std::string::npos;)
    script.replace(at, 2, "<\\/");  // none of it can end the element
  return "<script>" + script + "</script>";
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

std::string chart_scripts() { return script_element("chart.min.js") + script_element("charts.js"); }

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
