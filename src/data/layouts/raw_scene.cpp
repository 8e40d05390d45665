// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/raw_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <tuple>

#include "data/layouts/axes.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/message_text.hpp"
#include "data/rig_cameras.hpp"

namespace splinevox::data {
namespace {

constexpr std::size_t kEvery = 8;  // the custom of LLFF and of NR-NeRF

double percentile(std::vector<double> values, double share) {
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

void set_pose(RawFrame& frame, const std::array<double, 16>& matrix, const std::string& where) {
  frame.matrix = matrix;
  try {
    frame.pose = rigid_pose(matrix, where);
  } catch (const Error& error) {
    frame.fault = error;
  }
}

void leave_out(RawScene& scene, const DatasetRules& rules,
               const std::function<std::optional<Error>(RawFrame&, const std::string&)>& look_for,
               const std::string& lack) {
  if (!rules.missing.empty() && rules.missing != "skip" && rules.missing != "refuse")
    fail({"--missing", "there is no such rule", "skip or refuse", in_quotes(rules.missing), ""});
  std::optional<Error> first;
  bool mirrored = false;
  std::size_t all = 0, missing = 0, faulty = 0;
  for (RawSplit& split : scene.splits)
    for (std::size_t i = 0; i < split.frames.size(); ++i, ++all) {
      RawFrame& frame = split.frames[i];
      const bool bad_camera = frame.fault.has_value();
      if (!bad_camera) frame.fault = look_for(frame, split.where(i));
      if (!frame.fault) continue;
      (bad_camera ? faulty : missing) += 1;
      if (!first) mirrored = bad_camera && is_mirrored(frame.matrix);
      if (!first) first = frame.fault;
    }
  const std::size_t out = missing + faulty;
  if (out == 0) return;
  const std::string count = std::to_string(out) + " of " + std::to_string(all);
  if (out == all || rules.missing == "refuse" || (rules.missing.empty() && out * 10 > all)) {
    Problem problem = first->problem;
    if (mirrored) problem.hint = mirrored_hint(scene);
    if (out > 1 || all > 10)
      problem.got += (problem.got.empty() ? "" : "; ") + count + " frames are like this";
    if (out < all)
      problem.hint += (problem.hint.empty() ? "" : ", or ") + ("--missing skip to go on without " + count);
    fail(problem);
  }
  for (RawSplit& split : scene.splits) {
    for (std::size_t i = 0; i < split.frames.size(); ++i)  // numbers as in the file
      if (split.frames[i].label.empty()) split.frames[i].label = "frame " + std::to_string(i);
    std::erase_if(split.frames, [](const RawFrame& frame) { return frame.fault.has_value(); });
    if (split.frames.empty())
      fail({split.file, "every frame of the " + split.name + " split would be left out",
            "pictures and cameras", "none that can be used", ""});
  }
  if (missing > 0)
    scene.notes.push_back(std::to_string(missing) + " of " + std::to_string(all) + " " + lack +
                          " left out (" + first->problem.where + ", ...)");
  if (faulty > 0)
    scene.notes.push_back(std::to_string(faulty) + " of " + std::to_string(all) +
                          " frames have no usable camera and are left out (" + first->problem.where + ": " +
                          first->problem.what + ")");
}

namespace {

/// Every eighth frame, as far as both ends of time keep some for training. Cameras take turns: the same place
/// in each eight would be the same camera of two or four.
std::vector<bool> every_eighth(const RawSplit& all, int cameras) {
  const std::size_t n = all.frames.size();
  const double first = n > 0 ? all.frames.front().time : 0, last = n > 0 ? all.frames.back().time : 0;
  constexpr std::ptrdiff_t kManyCameras = 4;  // a moment with as many keeps some for training
  const auto seen_at = [&](double time) {
    return std::count_if(all.frames.begin(), all.frames.end(),
                         [&](const RawFrame& f) { return f.time == time; });
  };
  const bool first_may = seen_at(first) >= kManyCameras, last_may = seen_at(last) >= kManyCameras;
  const auto may_test = [&](std::size_t i) {
    const double time = all.frames[i].time;
    return (time > first || first_may) && (time < last || last_may);
  };
  std::vector<bool> tests(n, false);
  for (std::size_t block = 0; block + kEvery / 2 < n; block += kEvery) {
    const int turn = cameras > 0 ? int(block / kEvery) % cameras : -1;
    std::optional<std::size_t> taken;
    for (const std::size_t in_block : {4, 3, 2, 1, 5, 6, 7}) {  // the middle, or near it
      const std::size_t i = block + in_block;
      if (i >= n || !may_test(i)) continue;
      if (!taken) taken = i;
      if (all.frames[i].camera_id != turn) continue;
      taken = i;
      break;
    }
    if (taken) tests[*taken] = true;
  }
  return tests;
}

constexpr const char* kNone = "none";

/// The cameras that the rule names, in ascending order.
std::vector<int> named_cameras(const std::string& rule, const std::vector<RigCamera>& cameras) {
  std::vector<std::string> names;
  for (const RigCamera& c : cameras) names.push_back(c.name);
  std::vector<int> out;
  if (rule == kNone) return out;
  std::istringstream words(rule);
  for (std::string word; std::getline(words, word, ',');) {
    const auto at = std::find(names.begin(), names.end(), word);
    if (at == names.end())
      fail({"--hold-out", "there is no such camera",
            names.empty() ? "none: the data has no cameras with several pictures"
                          : "none, or " + list_of(names),
            in_quotes(word), ""});
    out.push_back(int(at - names.begin()));
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.size() == names.size())
    fail({"--hold-out", "no camera is left to train on", "some of " + list_of(names), in_quotes(rule), ""});
  return out;
}

/// What a note says of the pictures that are held out.
std::string how_held_out(const std::string& rule, const std::vector<int>& held_out,
                         const std::vector<RigCamera>& cameras) {
  if (held_out.empty())
    return "the data names no test split: every eighth picture in the order of time is one, ";
  std::vector<std::string> names;
  for (const int camera : held_out) names.push_back(cameras[std::size_t(camera)].name);
  return fmt::format("{}{} of {} cameras{} are held out: {}; pictures: ",
                     rule.empty() ? "the data names no test split: " : "", held_out.size(), cameras.size(),
                     rule.empty() ? ", which stand still," : "", list_of(names));
}

}  // namespace

void hold_out(RawScene& scene, const std::string& rule) {
  RawSplit all = std::move(scene.splits.at(0));
  scene.one_list = false;
  sort_by_time(all);
  // Of a picture that is listed twice one would train and the other be held out.
  std::set<std::tuple<double, std::string, int>> known;
  std::erase_if(all.frames, [&](const RawFrame& f) {
    return !known.emplace(f.time, f.found.empty() ? f.file_path : f.found.string(), f.film_frame).second;
  });
  const std::size_t n = all.frames.size();
  const std::vector<int> cameras =
      rule.empty() ? cameras_to_hold_out(all, scene.cameras) : named_cameras(rule, scene.cameras);
  std::vector<bool> tests(n, false);
  if (cameras.empty() && rule.empty()) tests = every_eighth(all, int(scene.cameras.size()));
  for (std::size_t i = 0; i < n && !cameras.empty(); ++i)
    tests[i] = std::binary_search(cameras.begin(), cameras.end(), all.frames[i].camera_id);
  RawSplit train{"train", all.file, all.timed, {}, {}, all.tracks}, test{"test", all.file, all.timed, {}};
  for (std::size_t i = 0; i < n; ++i) (tests[i] ? test : train).frames.push_back(std::move(all.frames[i]));
  scene.splits = {std::move(train)};
  if (rule == kNone) scene.notes.push_back("nothing is held out: all pictures train");
  if (test.frames.empty()) return;
  scene.notes.push_back(how_held_out(rule, cameras, scene.cameras) + std::to_string(test.frames.size()) +
                        " in all");
  scene.splits.push_back(std::move(test));
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

std::array<double, 16> matrix_of_opencv(const std::array<Vec3d, 3>& rows, const Vec3d& t) {
  return matrix_of({rows[0], -rows[1], -rows[2]}, -(t.x * rows[0] + t.y * rows[1] + t.z * rows[2]));
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
    if (f.fault) continue;
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
