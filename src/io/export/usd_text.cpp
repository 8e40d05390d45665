// SPDX-License-Identifier: Apache-2.0
#include "io/export/usd_text.hpp"

#include <fmt/format.h>

#include <charconv>

namespace splinevox {

std::string usd_head(const std::string& root, const UsdTime& time, const std::string& doc) {
  return fmt::format(
      "#usda 1.0\n(\n    defaultPrim = \"{}\"\n{}    endTimeCode = {}\n    framesPerSecond = {}\n"
      "    metersPerUnit = 1\n    startTimeCode = {}\n    timeCodesPerSecond = {}\n    upAxis = \"Z\"\n)\n\n",
      root, doc.empty() ? "" : fmt::format("    doc = \"{}\"\n", doc), time.last, time.fps, time.first,
      time.fps);
}

std::optional<double> usd_rate(const std::string& text) {
  const std::string key = "\n    timeCodesPerSecond = ";
  const std::size_t at = text.find(key);
  double rate = 0;
  if (at == text.npos || text.find("\n)\n") < at) return {};
  const char *first = text.data() + at + key.size(), *last = text.data() + text.size();
  if (std::from_chars(first, last, rate).ec != std::errc()) return {};
  return rate;
}

std::vector<std::size_t> usd_samples(std::size_t count,
                                     const std::function<bool(std::size_t, std::size_t)>& same) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < count; ++i)
    if (i == 0 || !same(i, i - 1) || (i + 1 < count && !same(i, i + 1))) kept.push_back(i);
  return kept;
}

std::string usd_attribute(const std::string& declaration, const std::vector<int>& frames,
                          const std::vector<std::size_t>& samples, bool plain,
                          const std::function<std::string(std::size_t)>& value) {
  if (plain) return fmt::format("    {} = {}\n", declaration, value(samples.front()));
  std::string text = fmt::format("    {}.timeSamples = {{\n", declaration);
  for (const std::size_t i : samples) {
    text += fmt::format("        {}: ", frames[i]);
    text += value(i);
    text += ",\n";
  }
  return text + "    }\n";
}

}  // namespace splinevox
