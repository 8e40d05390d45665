// SPDX-License-Identifier: Apache-2.0
#include "run/memory_needs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/process.hpp"
#include "field/columns.hpp"
#include "field/lattice/slice.hpp"
#include "splinevox/core/error.hpp"
#include "train/occupancy.hpp"
#include "train/start.hpp"

namespace splinevox::run {
namespace {

/// Share of the box's bricks in which something is, where silhouettes say so: a guess, not measured.
constexpr double kFilled = 0.35;
constexpr double kArrays = 6;       ///< values, two moments, gradient; copies to show and to save
constexpr double kSample = 300;     ///< bytes of a sample's records, motion and radiance
constexpr double kSamples = 60;     ///< of a ray that leave a record
constexpr double kProgram = 150e6;  ///< code, threads, libraries

double cubed(double x) { return x * x * x; }

std::string gigabytes(double bytes) { return fmt::format("{:.2f} GB", bytes / 1e9); }

/// Floats of a motion row at the end of a run.
double motion_width(const Config& config) {
  MotionField m;
  m.basis = config.motion.basis;
  m.points = config.motion.points;
  m.first_point = config.motion.first_point;
  m.displaces = config.motion.enabled;
  m.rigidity = config.motion.rigidity;
  m.light = config.motion.light;
  m.presence = config.motion.presence;
  const Basis& basis = basis_of(m.basis);
  if (basis.halves())
    for (std::size_t i = 0; i < config.motion.halve_start.size(); ++i)
      m.points = basis.refinement.refined(m.points);
  else if (!config.motion.elevate_points.empty())
    m.points = config.motion.elevate_points.back();
  return m.displaces || m.light || m.presence ? m.width() : 0;
}

}  // namespace

MemoryNeeds memory_needs(const Config& config, const Dataset& data) {
  const double filled = data.has_alpha ? kFilled : 1;
  PictureStats stats;
  count_places(*data.find("train"), stats);
  MemoryNeeds out;
  out.cells = for_places(stats, config).grid.radiance.back();
  const double canonical = filled * cubed(out.cells) * radiance_width(config.radiance.sh_order);
  const double moving = motion_width(config), finest = filled * cubed(config.grid.motion.back());
  const double motion = 8.0 / 7 * finest * moving;  // every level has an eighth of the next
  const double grids = double(most_occupancies(data.find("train")->frames.size()));
  out.lattices = sizeof(float) * (kArrays * (canonical + motion) + 2 * finest * moving);
  out.occupancy = moving > 0 ? 2 * grids * cubed(config.sampling.occupancy_cells) / 8 : 0;
  const double rays = config.sampling.rays * double(config.sampling.growth);
  out.step = kProgram + rays * kSamples * kSample +
             (moving > 0 ? 2.0 * config.sampling.frames * finest * kSliceWidth * sizeof(float) : 0);
  out.checkpoint = sizeof(float) * 3 * (canonical + motion) + out.occupancy / 2;
  return out;
}

double parse_memory(const std::string& text, const std::string& option) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  std::string unit(rest, end);
  for (char& c : unit) c = char(std::toupper(static_cast<unsigned char>(c)));
  if (unit.ends_with("B")) unit.pop_back();
  const double base = unit.ends_with("I") ? 1024 : 1000;
  if (base == 1024) unit.pop_back();
  constexpr std::string_view kUnits = "KMGT";
  const std::size_t place = unit.size() == 1 ? kUnits.find(unit[0]) : std::string_view::npos;
  const bool plain = unit.empty() && base == 1000;
  if (error != std::errc() || !(number > 0) || !std::isfinite(number) || !(plain || place != kUnits.npos))
    fail({option, "this is no amount of memory", "a number and a unit, as 6G, 500M or 6GiB", text, ""});
  constexpr double kLeastPlain = 1e6;  // of bytes; nobody means fewer
  if (plain && number < kLeastPlain)
    fail({option, "this has no unit", "a number and a unit, as 6G, 500M or 6GiB", text,
          option + " " + text + (number < 1024 ? "G" : "M")});
  return plain ? number : number * std::pow(base, double(place + 1));
}

double memory_bound(const std::string& asked) {
  return asked.empty() ? usable_memory() : parse_memory(asked, "--memory");
}

double room_for_pictures(double bound, const MemoryNeeds& needs) {
  const double room = bound - needs.in_memory();
  if (room <= 0)
    fail({"--memory", "the training does not fit into it, with no picture at all",
          fmt::format("{}: {} for lattices up to {} cells, {} for the occupancy of all frames, {} for a step",
                      gigabytes(needs.in_memory()), gigabytes(needs.lattices), needs.cells,
                      gigabytes(needs.occupancy), gigabytes(needs.step)),
          gigabytes(bound), "more --memory, a smaller --preset, or fewer cells (--set grid.radiance=...)"});
  return room;
}

std::string memory_line(double bound, const MemoryNeeds& needs, const Dataset& data) {
  std::string pictures = gigabytes(data.pictures_in_memory);
  if (data.pictures_in_files > 0) pictures = gigabytes(data.pictures_in_files) + " in files, mapped";
  return fmt::format(
      "memory: pictures {}; lattices up to {}, occupancy {}, a step {}; at most {} may be used; checkpoints "
      "up to "
      "{} of disk",
      pictures, gigabytes(needs.lattices), gigabytes(needs.occupancy), gigabytes(needs.step),
      std::isfinite(bound) ? gigabytes(bound) : "what there is", gigabytes(needs.checkpoint));
}

}  // namespace splinevox::run
