// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/raw_scene.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kEvery = 8;  // the custom of LLFF and of NR-NeRF

/// The last run of digits in a file's name, as a number.
std::optional<double> last_number(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  const std::size_t end = stem.find_last_of("0123456789");
  if (end == std::string::npos) return {};
  const std::size_t before = stem.find_last_not_of("0123456789", end),
                    begin = before == std::string::npos ? 0 : before + 1;
  double value = 0;
  std::from_chars(stem.data() + begin, stem.data() + end + 1, value);
  return value <= 1e12 ? std::optional(value) : std::nullopt;
}

std::map<std::string, double> read_times_file(const fs::path& path, const std::string& where) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, 64u << 20);
  std::istringstream text(std::string(bytes.begin(), bytes.end()));
  std::map<std::string, double> times;
  std::string line;
  for (int number_of_line = 1; std::getline(text, line); ++number_of_line) {
    line = line.substr(0, line.find('#'));
    const std::size_t last = line.find_last_not_of(" \t\r,");
    if (last == std::string::npos) continue;
    line.resize(last + 1);
    const std::size_t gap = line.find_last_of(" \t,");
    double time = 0;
    const char* begin = gap == std::string::npos ? line.data() : line.data() + gap + 1;
    const auto [end, error] = std::from_chars(begin, line.data() + line.size(), time);
    const std::size_t name_end =
        gap == std::string::npos ? std::string::npos : line.find_last_not_of(" \t,", gap);
    if (error != std::errc() || end != line.data() + line.size() || name_end == std::string::npos ||
        !(std::abs(time) <= 1e12))
      fail({where + ", line " + std::to_string(number_of_line), "this is no time",
            "a picture's name and a number, as in 'frame_0007.png 0.25'", in_quotes(line), ""});
    const std::string name = line.substr(0, name_end + 1);
    if (!times.emplace(name, time).second)
      fail({where + ", line " + std::to_string(number_of_line), "this picture has a time already",
            "each picture once", in_quotes(name), ""});
  }
  return times;
}

double percentile(std::vector<double> values, double share) {
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

RawScene hold_out(RawSplit all) {
  RawSplit train{"train", all.file, all.timed, {}}, test{"test", all.file, all.timed, {}};
  for (std::size_t i = 0; i < all.frames.size(); ++i) {
    if (all.frames[i].label.empty()) all.frames[i].label = "frame " + std::to_string(i);
    (i % kEvery == kEvery / 2 ? test : train).frames.push_back(std::move(all.frames[i]));
  }
  RawScene scene{{std::move(train)}};
  if (test.frames.empty()) return scene;
  scene.notes.push_back("the data names no test split: every eighth picture in the order of time is one, " +
                        std::to_string(test.frames.size()) + " in all");
  scene.splits.push_back(std::move(test));
  return scene;
}

void find_times(const fs::path& folder, RawSplit& split, std::vector<std::string>& notes) {
  std::error_code ignored;
  const fs::path file = folder / "times.txt";
  if (fs::exists(file, ignored)) {
    const std::string where = printable(file.string());
    const std::map<std::string, double> times = read_times_file(file, where);
    for (RawFrame& frame : split.frames) {
      const fs::path path(frame.file_path);
      auto found = times.end();
      for (const std::string& name : {frame.file_path, path.filename().string(), path.stem().string()})
        if (found == times.end()) found = times.find(name);
      if (found == times.end())
        fail({where, "a picture has no time", "a line for each picture",
              "none for " + in_quotes(frame.file_path), ""});
      frame.time = found->second;
    }
    notes.push_back("times are those of times.txt");
    split.timed = true;
    return;
  }
  std::sort(split.frames.begin(), split.frames.end(),
            [](const RawFrame& a, const RawFrame& b) { return a.file_path < b.file_path; });
  split.timed = std::all_of(split.frames.begin(), split.frames.end(),
                            [](const RawFrame& f) { return last_number(f.file_path).has_value(); });
  const double last = double(std::max<std::size_t>(split.frames.size() - 1, 1));
  for (std::size_t i = 0; i < split.frames.size(); ++i)
    split.frames[i].time = split.timed ? *last_number(split.frames[i].file_path) : double(i) / last;
  notes.push_back(split.timed ? "there is no times.txt: the last number in a picture's name is its time"
                              : "there is no times.txt and not every name has a number: pictures follow each "
                                "other evenly in the order of their names");
}

void sort_by_time(RawSplit& split) {
  std::sort(split.frames.begin(), split.frames.end(), [](const RawFrame& a, const RawFrame& b) {
    return std::tie(a.time, a.file_path, a.film_frame) < std::tie(b.time, b.file_path, b.film_frame);
  });
}

std::array<double, 16> matrix_of(const std::array<Vec3d, 3>& columns, const Vec3d& position) {
  std::array<double, 16> m{};
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) m[std::size_t(4 * row + col)] = columns[std::size_t(col)][row];
    m[std::size_t(4 * row + 3)] = position[row];
  }
  m[15] = 1;
  return m;
}

Box frusta_box(const RawSplit& split, const std::vector<std::array<double, 2>>& near_far) {
  std::vector<double> nears, fars;
  for (const auto& [near, far] : near_far) {
    nears.push_back(near);
    fars.push_back(far);
  }
  const double depths[] = {percentile(nears, 0.1), percentile(fars, 0.9)};
  Box box{{1e30f, 1e30f, 1e30f}, {-1e30f, -1e30f, -1e30f}};
  for (const RawFrame& f : split.frames) {
    const double fx = f.lens.fl_x.value_or(1), fy = f.lens.fl_y.value_or(fx), w = f.lens.w.value_or(1),
                 h = f.lens.h.value_or(1);
    for (const double depth : depths)
      for (const double u : {0.0, w})
        for (const double v : {0.0, h}) {
          const double x = (u - f.lens.cx.value_or(0.5 * w)) / fx, y = (v - f.lens.cy.value_or(0.5 * h)) / fy;
          const Vec3 p = cast<float>(f.pose.position +
                                     depth * (x * f.pose.axes[0] - y * f.pose.axes[1] - f.pose.axes[2]));
          box.lo = min(box.lo, p);
          box.hi = max(box.hi, p);
        }
  }
  return box;
}

std::optional<Box> points_box(std::vector<Vec3d> points) {
  if (points.size() < 10) return {};
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vec3d& p : points) values.push_back(p[axis]);
    const double lo = percentile(values, 0.01), hi = percentile(values, 0.99), margin = 0.05 * (hi - lo);
    if (!(hi > lo)) return {};
    box.lo[axis] = float(lo - margin);
    box.hi[axis] = float(hi + margin);
  }
  return box;
}

}  // namespace splinevox::data
