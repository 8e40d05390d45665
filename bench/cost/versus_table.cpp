// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "present.hpp"

namespace splinevox::cost {
namespace {

constexpr double kCores = 2;  ///< the minutes of the table are those of this many
constexpr double kMinutes[] = {1, 5, 15};
constexpr double kQualities[] = {24, 27, 30};  ///< dB
constexpr const char* kVoxels = "voxels";

/// The first of a system's records, by time, that is at least as good.
const Record* first_to(const std::vector<Record>& by_time, double db) {
  for (const Record& r : by_time)
    if (r.quality >= db) return &r;
  return nullptr;
}

/// The best of a system's records that take no longer, with 5% for the step that was under way. With its time
/// where it took less than half of what it could: more would have given more.
std::string best_within(const std::vector<Record>& by_time, double seconds) {
  const Record* best = nullptr;
  for (const Record& r : by_time)
    if (r.seconds.value <= 1.05 * seconds && (!best || r.quality > best->quality)) best = &r;
  if (!best) return "";
  return 2 * best->seconds.value >= seconds
             ? fmt::format("{:.2f}", best->quality)
             : fmt::format("{:.2f} ({:.0f} s)", best->quality, best->seconds.value);
}

}  // namespace

std::string versus_table(const std::vector<Record>& records) {
  std::map<std::string, std::vector<Record>> systems;
  std::string out;
  for (const Record& r : records) {
    if (r.knob == kBackgroundAlone)
      out += fmt::format("A picture of nothing but the {} background has {:.2f} dB{}{}.\n\n", r.value,
                         r.quality, r.note.empty() ? "" : ", all on ", r.note);
    else
      systems[r.knob].push_back(r);
  }
  for (auto& [name, rows] : systems)
    std::sort(rows.begin(), rows.end(),
              [](const Record& a, const Record& b) { return a.seconds.value < b.seconds.value; });
  std::string head = "| system |", rule = "| --- |", body;
  for (const double db : kQualities) {
    head += fmt::format(" {:g} dB after |", db);
    rule += " --- |";
  }
  for (const double m : kMinutes) {
    head += fmt::format(" PSNR, {:g} min of {:g} cores |", m, kCores);
    rule += " --- |";
  }
  for (const auto& [name, rows] : systems) {
    body += fmt::format("| {} |", name);
    for (const double db : kQualities) {
      const Record* r = first_to(rows, db);
      body += r ? fmt::format(" {:.1f} s |", r->seconds.value)
                : fmt::format(" not in {:.0f} s |", rows.back().seconds.value);
    }
    for (const double m : kMinutes) body += fmt::format(" {} |", best_within(rows, 60 * m * kCores));
    double memory = 0;  // of those where it is known
    for (const Record& r : rows) memory = std::max(memory, r.memory);
    body += memory > 0 ? fmt::format(" {:.2f} |\n", memory / 1e9) : " |\n";
  }
  out += head + " peak memory GB |\n" + rule + " --- |\n" + body + "\n";
  for (const auto& [name, rows] : systems) {
    if (name == kVoxels || !systems.count(kVoxels)) continue;
    const Record& best = *std::max_element(
        rows.begin(), rows.end(), [](const Record& a, const Record& b) { return a.quality < b.quality; });
    const std::vector<Record>& voxels = systems.at(kVoxels);
    if (const Record* r = first_to(voxels, best.quality); r == &voxels.front())
      out += fmt::format(
          "- {} comes to {:.2f} dB in {:.0f} s of processor time; the voxels' shortest run has {:.2f} dB in "
          "{:.2f} s "
          "already, so how much faster they get there cannot be told.\n",
          name, best.quality, best.seconds.value, r->quality, r->seconds.value);
    else if (r)
      out += fmt::format(
          "- {} comes to {:.2f} dB in {:.0f} s of processor time; the voxels pass that ({:.2f} dB) in {:.2f} "
          "s: {:.0f} times as fast.\n",
          name, best.quality, best.seconds.value, r->quality, r->seconds.value,
          best.seconds.value / r->seconds.value);
    else
      out += fmt::format("- The voxels do not come to the {:.2f} dB of {}.\n", best.quality, name);
  }
  return out;
}

}  // namespace splinevox::cost
