// SPDX-License-Identifier: Apache-2.0
#include "data/times/between.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {

std::optional<Between> parse_between(const std::string& text) {
  if (text.empty()) return {};
  const char *at = text.data(), *const end = at + text.size();
  Between out{};
  const auto read = [&](double& value) {
    const auto [next, error] = std::from_chars(at, end, value);
    at = next;
    return error == std::errc() && std::isfinite(value);
  };
  const bool good = read(out.from) && at != end && *at++ == ':' && read(out.to) && at == end;
  if (!good || !(out.from < out.to))
    fail({"--between", good ? "the part ends before it begins" : "this is no part of time",
          "FROM:TO, two times as the data has them, FROM < TO, as in 0.25:0.5", in_quotes(text), ""});
  return out;
}

void keep_between(const Between& part, const std::vector<std::string>& asked, std::vector<RawSplit>& splits,
                  std::vector<std::string>& notes) {
  for (std::size_t s = 0; s < splits.size(); ++s) {
    RawSplit& split = splits[s];
    if (split.frames.empty()) continue;
    const auto earlier = [](const RawFrame& a, const RawFrame& b) { return a.time < b.time; };
    const auto [first, last] = std::minmax_element(split.frames.begin(), split.frames.end(), earlier);
    const double from = first->time, to = last->time;
    const std::size_t all = split.frames.size();
    std::erase_if(split.frames,
                  [&](const RawFrame& f) { return !(f.time >= part.from && f.time <= part.to); });
    const bool wanted = s == 0 || std::find(asked.begin(), asked.end(), split.name) != asked.end();
    if (split.frames.empty() && wanted)
      fail({split.file, "no picture was taken in the part of time that --between asks for",
            "times from " + time_text(from) + " to " + time_text(to),
            time_text(part.from) + ":" + time_text(part.to), ""});
    notes.push_back(split.name + ": " + std::to_string(split.frames.size()) + " of " + std::to_string(all) +
                    " frames lie between " + time_text(part.from) + " and " + time_text(part.to));
  }
  std::erase_if(splits, [](const RawSplit& split) { return split.frames.empty(); });
}

}  // namespace splinevox::data
