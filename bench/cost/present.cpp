// SPDX-License-Identifier: Apache-2.0
#include "present.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "plot.hpp"

namespace splinevox::cost {
namespace {

std::string time_text(double s) {
  if (s < 1e-6) return fmt::format("{:.3g} ns", s * 1e9);
  if (s < 1e-3) return fmt::format("{:.3g} us", s * 1e6);
  return s < 1      ? fmt::format("{:.3g} ms", s * 1e3)
         : s < 1000 ? fmt::format("{:.3g} s", s)
                    : fmt::format("{:.0f} s", s);
}

const char* error_name(const std::string& suite) {
  return suite == "spline"   ? "largest error, units of float rounding"
         : suite == "render" ? "RMS colour error against the double reference"
                             : "RMS colour error of the test views";
}
const char* time_name(const std::string& suite) {
  return suite == "spline"   ? "time per 3-vector"
         : suite == "render" ? "time per frame"
                             : "processor seconds of training, summed over cores";
}

const Record* aa_row(const std::vector<Record>& records) {
  for (const Record& r : records)
    if (r.knob == "A/A") return &r;
  return nullptr;
}

const Record* default_row(const std::vector<Record>& records) {
  for (const Record& r : records)
    if (r.is_default) return &r;
  return nullptr;
}

/// Whether there is a place for it in a diagram whose axes are logarithmic.
bool shown(const Record& r) { return !r.failed && r.error.value > 0 && r.seconds.value > 0; }

/// Within what the default differs from itself.
bool same(const Figure& a, const Figure& b, const Figure& x, const Figure& y) {
  const double noise =
      std::max({x.hi / x.lo, y.hi / y.lo, std::max(x.value / y.value, y.value / x.value), 1.01});
  return std::max(a.value / b.value, b.value / a.value) <= noise;
}

}  // namespace

std::vector<std::vector<Record>> by_scene(const std::vector<Record>& records) {
  std::vector<std::vector<Record>> out;
  for (const Record& r : records) {
    auto it = std::find_if(out.begin(), out.end(), [&](const auto& g) {
      return g.front().suite == r.suite && g.front().scene == r.scene;
    });
    if (it == out.end()) it = out.insert(out.end(), std::vector<Record>{});
    it->push_back(r);
  }
  return out;
}

std::string diagram(const std::vector<Record>& records, const std::string& title) {
  double t0 = 1e300, t1 = 0, e0 = 1e300, e1 = 0;
  for (const Record& r : records) {
    if (!shown(r)) continue;
    t0 = std::min(t0, r.seconds.lo);
    t1 = std::max(t1, r.seconds.hi);
    e0 = std::min(e0, r.error.lo);
    e1 = std::max(e1, r.error.hi);
  }
  if (t1 == 0) return {};
  const Axis x(t0, t1, kLeft, kWidth - kRight), y(e0, e1, kHeight - kBottom, kTop);
  std::string svg = open_diagram(title, x, y, time_text, [](double v) { return fmt::format("{:g}", v); });
  const std::string suite = records.front().suite;
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                     (kLeft + kWidth - kRight) / 2, kHeight - 14, time_name(suite));
  svg += fmt::format("<text transform=\"translate(18 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (kTop + kHeight - kBottom) / 2, error_name(suite));

  std::string line;
  for (const std::size_t i : pareto_front(records))
    if (shown(records[i]))
      line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : " L", x.at(records[i].seconds.value),
                          y.at(records[i].error.value));
  svg += fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"#999\" stroke-width=\"2\" stroke-dasharray=\"5 3\"/>\n", line);

  std::map<std::string, const char*> color;
  for (const Record& r : records) {
    if (!shown(r)) continue;
    const std::string group = suite == "spline" ? r.value : r.knob;
    const char* c = color.try_emplace(group, kColors[color.size() % std::size(kColors)]).first->second;
    svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\"/>",
                       x.at(r.seconds.lo), x.at(r.seconds.hi), y.at(r.error.value), c);
    svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\"/>",
                       x.at(r.seconds.value), y.at(r.error.lo), y.at(r.error.hi), c);
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"{}><title>{}: {}, {}, error "
        "{:.3g}</title></circle>\n",
        x.at(r.seconds.value), y.at(r.error.value), r.is_default ? 7 : 4, c,
        r.is_default ? " stroke=\"black\" stroke-width=\"2\"" : "", escape(r.knob), escape(r.value),
        time_text(r.seconds.value), r.error.value);
  }
  for (const Record& r : records) {
    if (!r.failed) continue;
    const double at = r.seconds.value > 0 ? std::clamp(x.at(r.seconds.value), kLeft, kWidth - kRight) : kLeft;
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1:.1f} l8 8 m-8 0 l8 -8\" stroke=\"black\"><title>{2}: {3}, failed: "
        "{4}</title></path>\n",
        at - 4, kTop - 4, escape(r.knob), escape(r.value), escape(r.note));
  }
  double row = kTop + 8;
  for (const auto& [group, c] : color) {
    svg +=
        fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"4\" fill=\"{}\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
                    kWidth - kRight + 16, row - 4, c, kWidth - kRight + 26, row, escape(group.substr(0, 26)));
    row += 18;
  }
  svg += fmt::format(
      "<text x=\"{}\" y=\"{}\" fill=\"#777\">dashed: Pareto front; ring: default</text>\n</svg>\n", kLeft,
      kTop - 4);
  return svg;
}

std::string table(const std::vector<Record>& records) {
  std::vector<Record> rows = records;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Record& a, const Record& b) { return a.seconds.value < b.seconds.value; });
  std::set<std::pair<std::string, std::string>> front;
  for (const std::size_t i : pareto_front(records)) front.insert({records[i].knob, records[i].value});
  const bool train = records.front().suite == "train" || records.front().suite == "versus";
  std::string out = fmt::format(
      "| changed | to | {} | 95% | {} | 95% |{} samples a ray | runs | front |\n| --- | --- | --- | --- | "
      "--- | --- |{} --- | --- | --- |\n",
      time_name(records.front().suite), error_name(records.front().suite), train ? " PSNR |" : "",
      train ? " --- |" : "");
  for (const Record& r : rows) {
    const std::string place = r.failed          ? "failed"
                              : r.knob == "A/A" ? ""
                              : front.count({r.knob, r.value})
                                  ? "on it"
                                  : fmt::format("{:.2f}x", distance_to_front(records, r));
    out +=
        fmt::format("| {}{} | {} | {} | {} to {} | {:.3g} | {:.3g} to {:.3g} |{} {} | {} | {} |\n",
                    r.is_default ? "**" + r.knob + "**" : r.knob, r.failed ? " (failed)" : "", r.value,
                    time_text(r.seconds.value), time_text(r.seconds.lo), time_text(r.seconds.hi),
                    r.error.value, r.error.lo, r.error.hi, train ? fmt::format(" {:.2f} |", r.quality) : "",
                    r.samples > 0 ? fmt::format("{:.1f}", r.samples) : "", r.runs, place);
  }
  return out;
}

std::string sentences(const std::vector<Record>& records) {
  const Record *aa = aa_row(records), *base = default_row(records);
  if (!aa || !base) return {};
  std::map<std::string, std::vector<Record>> knobs;
  for (const Record& r : records)
    if (!r.is_default && !r.failed && r.knob != "A/A") knobs[r.knob].push_back(r);
  std::string out;
  for (auto& [knob, rows] : knobs)
    for (const Record& r : rows) {
      const bool same_time = same(r.seconds, base->seconds, aa->seconds, base->seconds),
                 same_error = same(r.error, base->error, aa->error, base->error);
      const double time = r.seconds.value / base->seconds.value;
      std::string gain;
      if (same_error)
        gain = "makes no difference to the error";
      else if (r.suite == "train")
        gain = fmt::format("{} {:.2f} dB", r.quality > base->quality ? "gains" : "loses",
                           std::abs(r.quality - base->quality));
      else
        gain = fmt::format("is {:.3g} times {}",
                           std::max(r.error.value / base->error.value, base->error.value / r.error.value),
                           r.error.value < base->error.value ? "as accurate" : "less accurate");
      out += fmt::format("- {}, {}: {} and {}.\n", knob, r.value,
                         same_time   ? "costs the same"
                         : time >= 1 ? fmt::format("costs {:.2f} times as long", time)
                                     : fmt::format("takes {:.2f} of the time", time),
                         gain);
    }
  return out;
}

}  // namespace splinevox::cost
