// SPDX-License-Identifier: Apache-2.0
#include "app/report_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace splinevox::app {
namespace {

constexpr double kWidth = 430, kHeight = 270, kLeft = 62, kRight = 14, kTop = 14, kBottom = 44;

struct Scale {
  double lo = 0, hi = 1, from = 0, to = 1;
  bool log = false;
  double operator()(double v) const {
    const double s = log ? (std::log10(v) - std::log10(lo)) / (std::log10(hi) - std::log10(lo)) : (v - lo) / (hi - lo);
    return from + s * (to - from);
  }
};

/// 1, 2 or 5 times a power of ten, about `count` of them over a range.
double tick_step(double range, int count) {
  const double raw = range / count, power = std::pow(10, std::floor(std::log10(raw)));
  const double m = raw / power;
  return power * (m < 1.5 ? 1 : m < 3.5 ? 2 : m < 7.5 ? 5 : 10);
}

std::vector<double> ticks(const Scale& s) {
  std::vector<double> all;
  if (s.log) {
    const double decades = std::log10(s.hi / s.lo);
    for (double p = std::floor(std::log10(s.lo)); p <= std::log10(s.hi); ++p)
      for (double m : {1.0, 2.0, 5.0})
        if ((m == 1 || decades < 2.5) && m * std::pow(10, p) >= s.lo * 0.999 && m * std::pow(10, p) <= s.hi * 1.001)
          all.push_back(m * std::pow(10, p));
    if (all.size() > 2) return all;
    all.clear();  // less than about a decade: equal steps tell more
  }
  const double step = tick_step(s.hi - s.lo, 6);
  for (double v = std::ceil(s.lo / step - 1e-9) * step; v <= s.hi + 1e-9 * step; v += step)
    all.push_back(std::abs(v) < 1e-12 * step ? 0 : v);
  return all;
}

/// The range of a coordinate over all series, a little wider than the points.
Scale fit(const std::vector<Series>& series, bool y, bool log) {
  double lo = 1e300, hi = -1e300;
  for (const Series& s : series)
    for (const auto& p : s.points) {
      const double v = y ? p.second : p.first;
      if (!std::isfinite(v) || (log && v <= 0)) continue;
      lo = std::min(lo, v), hi = std::max(hi, v);
    }
  if (lo > hi) lo = log ? 0.1 : 0, hi = 1;
  if (log) return {lo / 1.15, hi * 1.15, 0, 1, true};
  const double pad = hi > lo ? 0.06 * (hi - lo) : 0.5;
  return y ? Scale{lo - pad, hi + pad} : Scale{std::min(0.0, lo), hi > lo ? hi : hi + 1};
}

/// At most about 400 points, so that a long run does not make a heavy page: means of equal stretches.
std::vector<std::pair<double, double>> thin(const Series& s) {
  const std::size_t stride = s.mark == Series::Mark::dots ? 1 : (s.points.size() + 399) / 400;
  std::vector<std::pair<double, double>> out;
  for (std::size_t i = 0; i < s.points.size(); i += std::max<std::size_t>(stride, 1)) {
    double x = 0, y = 0;
    const std::size_t end = std::min(s.points.size(), i + stride);
    for (std::size_t k = i; k < end; ++k) x += s.points[k].first, y += s.points[k].second;
    const double n = double(end - i);
    if (std::isfinite(x) && std::isfinite(y)) out.emplace_back(x / n, y / n);
  }
  return out;
}

std::string draw(const Series& s, const Scale& x, const Scale& y) {
  std::string text;
  if (s.mark != Series::Mark::dots) {
    for (const auto& [px, py] : thin(s))
      if (!y.log || py > 0) text += fmt::format("{}{:.1f} {:.1f}", text.empty() ? "M" : "L", x(px), y(py));
    return fmt::format("<path class=\"line {} c{}\" d=\"{}\"/>", s.mark == Series::Mark::faint_line ? "faint" : "",
                       s.colour, text);
  }
  for (const auto& [px, py] : thin(s))
    text += fmt::format(
        "<circle class=\"dot c{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"><title>{:.4g}, {:.4g}</title></circle>",
        s.colour, x(px), y(py), px, py);
  return text;
}

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
  Scale x = fit(series, false, false), y = fit(series, true, text.log_y);
  x.from = kLeft, x.to = kWidth - kRight, y.from = kHeight - kBottom, y.to = kTop;
  std::string svg = fmt::format(
      "<figure class=\"chart\"><figcaption>{}</figcaption><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
      escape(text.title), kWidth, kHeight, escape(text.title));
  for (const double v : ticks(y))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{} {:.1f}H{}\"/><text class=\"tick\" x=\"{}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{:.4g}</text>",
        kLeft, y(v), kWidth - kRight, kLeft - 8, y(v) + 4, v);
  for (const double v : ticks(x))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{0:.1f} {1}V{2}\"/><text class=\"tick\" x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4:.4g}</text>",
        x(v), kTop, kHeight - kBottom, kHeight - kBottom + 18, v);
  svg += fmt::format("<path class=\"axis\" d=\"M{0} {1}V{2}H{3}\"/>", kLeft, kTop, kHeight - kBottom, kWidth - kRight);
  svg += fmt::format("<text class=\"label\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                     (kLeft + kWidth - kRight) / 2, kHeight - 6, escape(text.x));
  svg +=
      fmt::format("<text class=\"label\" transform=\"translate(12 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
                  (kTop + kHeight - kBottom) / 2, escape(text.y));
  for (const Series& s : series) svg += draw(s, x, y);
  svg += "</svg><p class=\"legend\">";
  for (const Series& s : series) {
    const char* kind = s.mark == Series::Mark::dots         ? "key-dot"
                       : s.mark == Series::Mark::faint_line ? "key faint"
                                                            : "key";
    svg += fmt::format("<span><i class=\"{} c{}\"></i>{}</span>", kind, s.colour, escape(s.name));
  }
  return svg + "</p></figure>";
}

std::string stacked_bar(const std::vector<std::pair<std::string, double>>& parts, const std::string& unit) {
  double sum = 0;
  for (const auto& p : parts) sum += std::max(p.second, 0.0);
  std::string bar, legend;
  int colour = 0;
  for (const auto& [name, value] : parts) {
    if (value > 0 && sum > 0) {
      const double share = 100 * value / sum;
      bar += fmt::format("<i class=\"c{}\" style=\"width:{:.2f}%\" title=\"{} {:.1f} {}\"></i>", colour % 8, share,
                         escape(name), value, unit);
      legend += fmt::format("<span><i class=\"key-dot c{}\"></i>{} {:.1f} {} ({:.0f}%)</span>", colour % 8,
                            escape(name), value, unit, share);
    }
    ++colour;
  }
  return fmt::format("<div class=\"stack\">{}</div><p class=\"legend\">{}</p>", bar, legend);
}

}  // namespace splinevox::app
