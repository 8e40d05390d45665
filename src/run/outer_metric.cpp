// SPDX-License-Identifier: Apache-2.0
#include "run/outer_metric.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/atomic_file.hpp"
#include "core/child.hpp"
#include "core/number_text.hpp"
#include "core/printable.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

constexpr std::string_view kList = "{list}";

fs::path make_temporary_folder() {
  std::string name = (fs::temp_directory_path() / "splinevox_metric_XXXXXX").string();
  if (!::mkdtemp(name.data()))
    fail_output({name, "no folder for the pictures of --metric", "a place that can be written",
                 std::strerror(errno), "another TMPDIR"});
  return name;
}

bool is_name(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.';
  });
}

/// The number that a line is.
std::optional<double> number_of(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t"), last = line.find_last_not_of(" \t");
  if (first == line.npos) return {};
  const auto value = parse_number<double>(std::string_view(line).substr(first, last + 1 - first));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string last_line(const std::string& text) {
  const std::vector<std::string> lines = split_list(text, '\n');
  return lines.empty() ? "" : printable(lines.back());
}

}  // namespace

OuterMetrics::OuterMetrics(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals),
                      expected = "NAME=COMMAND, such as lpips='python3 lpips.py'";
    if (equals == word.npos || !is_name(name))
      fail({"--metric", "this does not begin with a name",
            expected + "; a name has letters, digits, _ - and .", printable(word), ""});
    Metric metric{name, word.substr(equals + 1)};
    if (metric.command.find_first_not_of(' ') == std::string::npos)
      fail({"--metric", "there is no command", expected, printable(word), ""});
    if (std::any_of(metrics_.begin(), metrics_.end(), [&](const Metric& m) { return m.name == name; }))
      fail({"--metric", "two have one name", "names of their own", name, ""});
    if (const std::size_t at = metric.command.find(kList); at != std::string::npos) {
      metric.at_once = true;
      metric.command.replace(at, kList.size(), "\"$1\"");
    } else {
      metric.command += " \"$@\"";
    }
    metrics_.push_back(std::move(metric));
  }
}

OuterMetrics::~OuterMetrics() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

void OuterMetrics::take(const Frame& frame, const View& view) {
  if (metrics_.empty()) return;
  if (folder_.empty()) folder_ = make_temporary_folder();
  const std::string start = (folder_ / fmt::format("{:06}_", views_++)).string();
  const std::string render = start + "render.png", truth = start + "truth.png";
  write_png(render, without_ignored(view, frame));
  write_png(truth, view.truth);
  list_ += render + "\t" + truth + "\n";
  bool keep = false;
  for (Metric& metric : metrics_) {
    keep |= metric.at_once;
    if (!metric.at_once) metric.values.push_back(ask(metric, {render, truth})[0]);
  }
  if (keep) return;
  fs::remove(render);
  fs::remove(truth);
}

void OuterMetrics::finish(Json& figures) {
  if (views_ == 0) return;
  const std::string list = (folder_ / "list.txt").string();
  write_file(list, {list_});
  for (Metric& metric : metrics_) {
    if (metric.at_once) metric.values = ask(metric, {list});
    for (std::size_t i = 0; i < views_; ++i) figures["frames"][i]["metrics"][metric.name] = metric.values[i];
    figures["metrics"][metric.name] =
        std::accumulate(metric.values.begin(), metric.values.end(), 0.0) / double(views_);
  }
}

/// What the command prints: a number, or one of each view.
std::vector<double> OuterMetrics::ask(const Metric& metric, const std::vector<std::string>& words) const {
  const std::string errors = (folder_ / "errors.txt").string(), where = "--metric " + metric.name;
  ChildWords start{{"sh", "-c", "exec 2>\"$0\"\n" + metric.command, errors}, where, "it runs commands", ""};
  start.words.insert(start.words.end(), words.begin(), words.end());
  Child child(start);
  std::string printed;
  std::vector<double> values;
  bool good = true;
  for (std::string line; child.read_line(line, {});) {
    printed += line + "\n";
    if (line.find_first_not_of(" \t") == line.npos) continue;
    const std::optional<double> value = number_of(line);
    good &= value.has_value();
    values.push_back(value.value_or(0));
  }
  const bool ended = child.finish();
  const std::string said = last_line(read_text_if_there(errors));
  const std::string why = said.empty() ? last_line(printed) : said;
  const std::size_t wanted = metric.at_once ? views_ : 1;
  const std::string expected =
      metric.at_once ? fmt::format("{} numbers, one a line of the list and nothing else", wanted)
                     : "one number and nothing else";
  const std::string hint = "the same by hand, with two PNG files: " + metric.command;
  if (!ended) fail({where, "the command failed", expected, why, hint});
  if (!good || values.size() != wanted)
    fail({where, "the command did not print what was asked for", expected,
          good ? fmt::format("{} numbers {}", values.size(), why) : last_line(printed), hint});
  return values;
}

}  // namespace splinevox::run
