// SPDX-License-Identifier: Apache-2.0
#include "record.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace splinevox::cost {
namespace {

Json figure(const Figure& f) { return {f.value, f.lo, f.hi}; }
double number(const Json& j) {
  return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>();
}
Figure figure(const Json& j) { return {number(j.at(0)), number(j.at(1)), number(j.at(2))}; }

/// The default measured twice does not compete with itself, and what took no time does not compete at all.
bool comparable(const Record& a, const Record& b) {
  return !a.failed && !b.failed && a.seconds.value > 0 && b.seconds.value > 0 && a.suite == b.suite &&
         a.scene == b.scene && a.knob != "A/A" && b.knob != "A/A";
}

}  // namespace

Json to_json(const Record& r) {
  return {{"suite", r.suite},
          {"scene", r.scene},
          {"knob", r.knob},
          {"value", r.value},
          {"order", r.order},
          {"error", figure(r.error)},
          {"seconds", figure(r.seconds)},
          {"quality", r.quality},
          {"samples", r.samples},
          {"memory", r.memory},
          {"instructions", r.instructions},
          {"runs", r.runs},
          {"default", r.is_default},
          {"expected_dominated", r.expected_dominated},
          {"failed", r.failed},
          {"note", r.note},
          {"where", r.where}};
}

Record from_json(const Json& j) {
  Record r;
  r.suite = j.at("suite");
  r.scene = j.at("scene");
  r.knob = j.at("knob");
  r.value = j.at("value");
  r.order = j.at("order");
  r.error = figure(j.at("error"));
  r.seconds = figure(j.at("seconds"));
  r.quality = number(j.at("quality"));
  r.samples = j.at("samples");
  r.memory = j.value("memory", 0.0);
  r.instructions = j.at("instructions");
  r.runs = j.at("runs");
  r.is_default = j.at("default");
  r.expected_dominated = j.at("expected_dominated");
  r.failed = j.at("failed");
  r.note = j.at("note");
  r.where = j.value("where", "");
  return r;
}

std::vector<std::size_t> pareto_front(const std::vector<Record>& records) {
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Record& a = records[i];
    const bool beaten = a.failed || a.seconds.value <= 0 || a.knob == "A/A" ||
                        std::any_of(records.begin(), records.end(), [&](const Record& b) {
                          return comparable(a, b) && b.error.value <= a.error.value &&
                                 b.seconds.value <= a.seconds.value &&
                                 (b.error.value < a.error.value || b.seconds.value < a.seconds.value);
                        });
    if (!beaten) front.push_back(i);
  }
  std::sort(front.begin(), front.end(), [&](std::size_t a, std::size_t b) {
    return records[a].seconds.value < records[b].seconds.value;
  });
  return front;
}

double distance_to_front(const std::vector<Record>& records, const Record& of) {
  double fastest = of.seconds.value;
  for (const Record& r : records)
    if (comparable(r, of) && r.error.value <= of.error.value) fastest = std::min(fastest, r.seconds.value);
  return of.seconds.value / fastest;
}

}  // namespace splinevox::cost
