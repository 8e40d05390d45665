// SPDX-License-Identifier: Apache-2.0
#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "report/chart.hpp"
#include "run/cameras_report.hpp"
#include "run/effects_report.hpp"
#include "run/html.hpp"

namespace splinevox::run {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// @param key  one within an object as "object.key"
double number(const Json& j, const std::string& key) {
  if (const std::size_t dot = key.find('.'); dot != key.npos)
    return number(j.is_object() ? j.value(key.substr(0, dot), Json()) : Json(), key.substr(dot + 1));
  return j.is_object() && j.contains(key) && j[key].is_number() ? j[key].get<double>() : kNone;
}

/// A text of a file as it may stand in the page; "" if it is none.
std::string text_of(const Json& j, const char* key) {
  return j.is_object() && j.contains(key) && j[key].is_string() ? escape(j[key].get<std::string>()) : "";
}

/// A figure with its unit, "-" where it is not known.
std::string figure(double v, int digits, const char* unit = "") {
  if (!std::isfinite(v)) return "&ndash;";
  return fmt::format("{:.{}f}{}{}", v, digits, *unit ? "<small>" : "",
                     *unit ? fmt::format("{}</small>", unit) : "");
}

struct Column {
  const char* title;
  const char* unit;
  const char* key;
  double scale;
  int digits;
  int better;              ///< +1: more is better, -1: less, 0: neither
  bool of_pixels = false;  ///< depends on what was compared: scene, pictures, pixels
  bool optional = false;   ///< shown where some run has it
};
constexpr Column kColumns[] = {
    {"PSNR", "dB", "psnr", 1, 2, 1, true},
    {"PSNR inside the masks", "dB", "psnr_inside", 1, 2, 1, true, true},
    {"PSNR at best exposure", "dB", "psnr_best_gain", 1, 2, 1, true},
    {"SSIM", "", "ssim", 1, 4, 1, true},
    {"MS-SSIM", "", "ms_ssim", 1, 4, 1, true},
    {"volume L1", "", "truth_volume.l1", 1, 3, -1, true, true},
    {"volume correlation, mean of moments", "", "truth_volume.correlation_per_moment", 1, 3, 1, true, true},
    {"still part, camera held, moves", "% of the width", "held_camera.p95_percent", 1, 2, -1, true, true},
    {"training", "s", "train_seconds", 1, 1, -1},
    {"steps", "", "steps", 1, 0, 0},
    {"samples/s", "M", "samples_per_second", 1e-6, 2, 1},
    {"peak memory", "GB", "peak_memory_bytes", 1e-9, 2, -1}};

std::string name_of(const ReportRun& run, std::size_t i) {
  return fmt::format("<span class=\"run-name c{}\"><i></i>{}</span>", i % 8, escape(run.name));
}

std::string tiles(const ReportRun& run) {
  std::string html = "<div class=\"tiles\">";
  const auto tile = [&](const std::string& value, const std::string& name) {
    html += fmt::format("<div class=\"tile\"><b>{}</b><span>{}</span></div>", value, name);
  };
  const std::string split = text_of(run.metrics, "split");
  for (const Column& c : kColumns) {
    if (c.optional && !std::isfinite(number(run.metrics, c.key))) continue;
    const bool quality = c.better == 1 && c.scale == 1;
    tile(figure(number(run.metrics, c.key) * c.scale, c.digits, c.unit),
         c.title + (quality && !split.empty() ? ", " + split : ""));
  }
  tile(figure(run.model_bytes / 1e6, 1, "MB"), run.model_file);
  if (const std::string device = text_of(run.metrics, "device"); !device.empty()) tile(device, "trained on");
  return html + "</div>";
}

/// Whether the figures of two runs are of the same pictures at the same pixels.
bool same_pixels(const ReportRun& a, const ReportRun& b) {
  const auto of = [](const ReportRun& run) {
    return std::tuple(run.metrics.value("stride", 1), text_of(run.metrics, "split"),
                      run.metrics.value("frames", Json::array()).size());
  };
  // Figures of an older version, or of a network, do not say all.
  const auto may_be_same = [&](const char* key) {
    return !a.metrics.contains(key) || !b.metrics.contains(key) || a.metrics[key] == b.metrics[key];
  };
  const std::string data = text_of(a.metrics, "eval_data"), other = text_of(b.metrics, "eval_data");
  return of(a) == of(b) && (data.empty() || other.empty() || folder_name(data) == folder_name(other)) &&
         may_be_same("downscale") && may_be_same("background") && may_be_same("masks");
}

std::string table(const std::vector<ReportRun>& runs) {
  std::string html = "<div class=\"card\"><div class=\"wide\"><table><tr><th>run</th><th>preset</th>";
  std::vector<Column> columns(std::begin(kColumns), std::end(kColumns));
  std::erase_if(columns, [&](const Column& c) {
    return c.optional && std::none_of(runs.begin(), runs.end(), [&](const ReportRun& run) {
             return std::isfinite(number(run.metrics, c.key));
           });
  });
  for (const Column& c : columns)
    html += fmt::format("<th>{}{}</th>", c.title, *c.unit ? fmt::format(" [{}]", c.unit) : "");
  html += "</tr>";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int every = runs[i].metrics.value("stride", 1);
    html += fmt::format(
        "<tr><td>{}{}</td><td>{}</td>", name_of(runs[i], i),
        every > 1 ? fmt::format(" <span class=\"note\">every {}th pixel and row of a view</span>", every)
                  : "",
        text_of(runs[i].metrics, "preset"));
    for (const Column& c : columns) {
      const double v = number(runs[i].metrics, c.key);
      // Figures of other pictures do not compete, nor those of some pixels (splinevox-mlp).
      bool best = c.better != 0 && std::isfinite(v) && runs.size() > 1;
      for (const ReportRun& other : runs)
        best = best && (!std::isfinite(number(other.metrics, c.key)) ||
                        ((!c.of_pixels || same_pixels(other, runs[i])) &&
                         !(c.better * number(other.metrics, c.key) > c.better * v)));
      html += fmt::format("<td{}>{}</td>", best ? " class=\"best\"" : "", figure(v * c.scale, c.digits));
    }
    html += "</tr>";
  }
  return html + "</table></div></div>";
}

/// Of what else is shown of a run in one chart: of the only run another colour, of several theirs.
int second_colour(const std::vector<ReportRun>& runs, std::size_t i) {
  return runs.size() > 1 ? int(i % 8) : 1;
}

/// What `eval --truth-volume` found, moment by moment; "" where no run has it.
std::string volume_charts(const std::vector<ReportRun>& runs) {
  std::vector<Series> mass, l1;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Json volume = runs[i].metrics.value("truth_volume", Json());
    if (!volume.is_object() || !volume.contains("moments")) continue;
    const std::string prefix = runs.size() > 1 ? runs[i].name + ", " : "";
    Series truth{prefix + "true", second_colour(runs, i), Series::Mark::faint_line, {}};
    Series found{prefix + "found", int(i % 8), Series::Mark::line, {}};
    Series apart{runs.size() > 1 ? runs[i].name : "L1", int(i % 8), Series::Mark::line, {}};
    for (const Json& moment : volume["moments"]) {
      const double time = number(moment, "time");
      truth.points.emplace_back(time, number(moment, "mass_truth"));
      found.points.emplace_back(time, number(moment, "mass"));
      apart.points.emplace_back(time, number(moment, "l1"));
    }
    mass.push_back(truth);
    mass.push_back(found);
    l1.push_back(apart);
  }
  if (mass.empty()) return "";
  return line_chart({"Mass over time, of the true volumes and as found", "time in the scene", "mass"}, mass) +
         line_chart({"Error of the volume, against time", "time in the scene", "L1, share of the true mass"},
                    l1);
}

std::string charts(const std::vector<ReportRun>& runs) {
  std::vector<Series> psnr, loss, frames;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int colour = int(i % 8);
    const std::string prefix = runs.size() > 1 ? runs[i].name + ", " : "";
    Series batch{prefix + "training rays", colour, Series::Mark::faint_line, {}};
    Series held_out{prefix + "held-out view", second_colour(runs, i), Series::Mark::dots, {}};
    Series photo{runs.size() > 1 ? runs[i].name : "photometric loss", colour, Series::Mark::line, {}};
    Series view{runs.size() > 1 ? runs[i].name : "one view", colour, Series::Mark::dots, {}};
    // A run's clock also counts what came before its first step: trials, a still world, reading.
    // Lines of discarded steps have none.
    const auto timed = std::find_if(runs[i].lines.begin(), runs[i].lines.end(), [](const Json& j) {
      return (j.contains("loss") || j.contains("held_view")) && std::isfinite(number(j, "seconds"));
    });
    const double start = timed == runs[i].lines.end() ? 0 : number(*timed, "seconds");
    for (const Json& j : runs[i].lines) {
      const double s = number(j, "seconds") - start;
      if (j.contains("held_view")) {
        held_out.points.emplace_back(s, number(j, "held_psnr"));
        if (j.value("split", "val") == "train") held_out.name = prefix + "training view";
      } else if (j.contains("loss")) {
        batch.points.emplace_back(s, number(j, "psnr"));
        photo.points.emplace_back(s, number(j, "loss"));
      }
    }
    if (runs[i].metrics.contains("frames"))
      for (const Json& f : runs[i].metrics["frames"])
        view.points.emplace_back(number(f, "time"), number(f, "psnr"));
    psnr.push_back(batch);
    psnr.push_back(held_out);
    loss.push_back(photo);
    frames.push_back(view);
  }
  std::string html = "<div class=\"charts\">";
  html += line_chart({"PSNR against seconds of training", "seconds from the first step", "PSNR [dB]"}, psnr);
  html += line_chart(
      {"Loss against seconds of training", "seconds from the first step", "loss of a ray", true}, loss);
  if (std::any_of(frames.begin(), frames.end(), [](const Series& s) { return !s.points.empty(); }))
    html +=
        line_chart({"Views not trained on, against their time", "time in the scene", "PSNR [dB]"}, frames);
  return html + volume_charts(runs) + "</div>";
}

std::string views(const ReportRun& run) {
  std::string html = fmt::format("<p class=\"note\">{}</p>", escape(run.views_note));
  if (run.views.empty()) return html;
  if (!run.views[0].flow.empty())
    html +=
        "<p class=\"note\">Displacement leads to the canonical volume: direction is colour, grey is none. "
        "What "
        "moves is red, what stays is blue: the layer that model files call rigidity.</p>";
  html += "<div class=\"views\">";
  for (const ReportView& v : run.views) {
    const auto picture = [&](const std::vector<char>& png, const char* what) {
      if (png.empty()) return std::string();
      return fmt::format(
          "<div><button title=\"enlarge\"><img alt=\"{0} of {1}\" src=\"data:image/png;base64,{2}\">"
          "</button>{0}</div>",
          what, escape(v.name), base64(png));
    };
    html += fmt::format(
        "<figure><figcaption><b>{}</b><span>time {:.3f}</span><span>PSNR {} dB</span><span>SSIM "
        "{}</span></figcaption>"
        "<div class=\"row\">{}{}{}{}{}</div></figure>",
        escape(v.name), v.time, figure(v.psnr, 2), figure(v.ssim, 4), picture(v.truth, "truth"),
        picture(v.render, "render"), picture(v.error, "error"), picture(v.flow, "displacement"),
        picture(v.rigidity, "what moves"));
  }
  return html + "</div>";
}

/// A table that may be wider than the screen.
std::string scrolled(const std::string& table) {
  return table.empty() ? "" : "<div class=\"wide\">" + table + "</div>";
}

std::string facts(const ReportRun& run) {
  std::string html;
  for (const auto& [text, address] : run.links)
    html += fmt::format("<a href=\"{}\">{}</a>", escape(address), escape(text));
  if (!html.empty()) html = "<p class=\"links\">" + html + "</p>";
  if (run.facts.empty()) return html;
  html += "<dl class=\"facts\">";
  for (const auto& [what, text] : run.facts)
    html += fmt::format("<dt>{}</dt><dd>{}</dd>", escape(what), escape(text));
  return html + "</dl>";
}

std::string frame_table(const Json& metrics) {
  if (!metrics.contains("frames")) return "";
  std::vector<Json> frames(metrics["frames"].begin(), metrics["frames"].end());
  std::stable_sort(frames.begin(), frames.end(),
                   [](const Json& a, const Json& b) { return number(a, "psnr") < number(b, "psnr"); });
  const bool inside = metrics.contains("psnr_inside");
  std::string html = fmt::format(
      "<details><summary>All {} views, worst first</summary><div class=\"wide\"><table><tr><th>{} "
      "view</th><th>time</th><th>PSNR [dB]</th><th>SSIM</th><th>MS-SSIM</th>{}</tr>",
      frames.size(), text_of(metrics, "split"), inside ? "<th>PSNR inside the mask [dB]</th>" : "");
  for (const Json& f : frames)
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>{}</tr>",
                        text_of(f, "name"), figure(number(f, "time"), 3), figure(number(f, "psnr"), 2),
                        figure(number(f, "ssim"), 4), figure(number(f, "ms_ssim"), 4),
                        inside ? "<td>" + figure(number(f, "psnr_inside"), 2) + "</td>" : "");
  return html + "</table></div></details>";
}

std::string phases(const Json& metrics) {
  if (!metrics.contains("phases")) return "";
  std::vector<std::pair<std::string, double>> parts;
  double sum = 0;
  for (const auto& [name, seconds] : metrics["phases"].items()) {
    parts.emplace_back(name, seconds.get<double>());
    sum += parts.back().second;
  }
  const double rest = number(metrics, "train_seconds") - sum;
  if (rest > 0) parts.emplace_back("other", rest);
  const std::string still = metrics.contains("moving_share")
                                ? fmt::format(
                                      "<p class=\"note\">{:.0f}% of what is visible moves or changes. The "
                                      "rest is static: its motion was "
                                      "frozen and no longer learned.</p>",
                                      100 * number(metrics, "moving_share"))
                                : "";
  return "<h3>Where the time went</h3>" + stacked_bar(parts, "s") + still;
}

}  // namespace

std::string report_page(const std::vector<ReportRun>& runs) {
  std::string title = runs.size() == 1 ? runs[0].name : fmt::format("{} runs", runs.size());
  std::string html = fmt::format(
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\">"
      "<title>splinevox: {0}</title><style>\n{1}</style></head>"
      "<body><main><header><h1>{0}</h1><p>{2}</p></header>",
      escape(title), report_asset("report.css"),
      runs.size() == 1 ? fmt::format("reconstructed by splinevox{}, preset {}",
                                     runs[0].version.empty() ? "" : " " + runs[0].version,
                                     text_of(runs[0].metrics, "preset"))
                       : "compared by splinevox " + std::string(kVersion));
  html += runs.size() == 1 ? facts(runs[0]) + tiles(runs[0]) : table(runs);
  html += charts(runs);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    html += fmt::format("<h2>{}</h2>", runs.size() == 1 ? "Pictures" : name_of(runs[i], i));
    if (runs.size() > 1) html += facts(runs[i]);
    html += views(runs[i]);
    html += fmt::format(
        "<div class=\"card\" "
        "style=\"margin-top:14px\">{}{}{}<details><summary>Configuration</summary><pre>{}</pre></details></"
        "div>",
        scrolled(effects_table(runs[i].effects)) +
            scrolled(cameras_table(runs[i].metrics.value("cameras", Json()))),
        phases(runs[i].metrics), frame_table(runs[i].metrics), escape(runs[i].config));
  }
  return html +
         "<footer>One file: nothing is loaded from elsewhere. Charts are drawn by Chart.js (MIT "
         "licence).</footer></main><dialog id=\"large\"><form method=\"dialog\"><button "
         "aria-label=\"close\">&times;</button></form><img alt=\"\"><p></p></dialog>" +
         chart_scripts() + script_element("pictures.js") + "</body></html>\n";
}

}  // namespace splinevox::run
