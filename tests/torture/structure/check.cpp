// SPDX-License-Identifier: Apache-2.0
// The oracle: what the loader returns against what is true.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "splinevox/core/error.hpp"
#include "splinevox/data/scene.hpp"
#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

/// What can be wrong, and the words in notes that own up to a guess about it.
enum Topic : std::size_t { kTimes, kCameras, kPictures, kSplits, kLeftOut, kTopics };
constexpr const char* kTopicNames[] = {"times", "cameras", "pictures", "splits", "left out"};
const std::vector<std::string> kOwnUp[kTopics] = {
    {"a guess", "may be meant", "their first frames are taken at the same time"},
    {"may be meant", "are taken in the order", "rows of poses_bounds.npy are taken", "do not agree", "EXIF",
     "last row of every matrix", "as no usual lens", "off rigid", "as world to camera"},
    {"EXIF", "another frame has", "are named as masks are"},
    {"in several lists", "is the test split", "another frame has"},
    {"left out", "have no camera", "are named as masks are"}};

bool owned_up(const Dataset& data, Topic topic) {
  return std::any_of(data.notes.begin(), data.notes.end(), [&](const std::string& note) {
    return std::any_of(kOwnUp[topic].begin(), kOwnUp[topic].end(),
                       [&](const std::string& words) { return note.find(words) != std::string::npos; });
  });
}

bool near(double a, double b, double tolerance) {
  return std::abs(a - b) <= tolerance * std::max(1.0, std::abs(b));
}

/// Empty, or how a camera differs from the truth.
std::string differs(const Camera& camera, const test::TrueCamera& truth) {
  constexpr double kClose = 1e-5;
  const test::TrueLens& lens = truth.lens;
  for (int r = 0; r < 3; ++r) {
    if (!near(camera.position[r], truth.world(r, 3), kClose)) return "position";
    for (int k = 0; k < 3; ++k)
      if (!near(camera.axes[std::size_t(k)][r], truth.world(r, k), kClose)) return "direction";
  }
  if (camera.width != lens.wide || camera.height != lens.high) return "size";
  if (!near(camera.fx, lens.fx, kClose) || !near(camera.fy, lens.fy, kClose))
    return fmt::format("focal length {} {} for {} {}", camera.fx, camera.fy, lens.fx, lens.fy);
  if (!near(camera.cx, lens.cx, kClose) || !near(camera.cy, lens.cy, kClose)) return "centre";
  return {};
}

/// What was found wrong, the first of each topic.
struct Faults {
  std::string of[kTopics];
  void add(Topic topic, const std::string& words) {
    if (of[topic].empty()) of[topic] = words;
  }
  /// But for pictures that were left out, which is right if it is said.
  bool any() const {
    return std::any_of(std::begin(of), std::begin(of) + kLeftOut,
                       [](const std::string& s) { return !s.empty(); });
  }
};

struct Loaded {
  const Frame* frame;
  std::string split;
  int shot;
};

/// Times are true up to an affine map that keeps their order, and fill the model's time.
void check_times(const Case& c, const std::vector<Loaded>& all, Faults& faults) {
  const Loaded *first = nullptr, *last = nullptr;
  std::set<double> trained;  // moments
  double lo = 1e300, hi = -1e300, train_lo = 1e300, train_hi = -1e300;
  const auto tick = [&](const Loaded& l) { return c.shots[std::size_t(l.shot)].time; };
  for (const Loaded& l : all) {
    if (!first || tick(l) < tick(*first)) first = &l;
    if (!last || tick(l) > tick(*last)) last = &l;
    lo = std::min(lo, l.frame->time);
    hi = std::max(hi, l.frame->time);
    if (l.split != "train") continue;
    trained.insert(tick(l));
    train_lo = std::min(train_lo, l.frame->time);
    train_hi = std::max(train_hi, l.frame->time);
  }
  if (all.empty()) return;
  const double ticks = tick(*last) - tick(*first), range = last->frame->time - first->frame->time;
  if (ticks == 0) {
    if (hi != lo) faults.add(kTimes, "one moment has several times");
    return;
  }
  if (trained.size() < 2 && hi == lo) return;  // nothing to map times by is left
  if (!(range > 0))
    return faults.add(
        kTimes, fmt::format("first and last moment are at {} and {}", first->frame->time, last->frame->time));
  for (const Loaded& l : all) {
    const double want = first->frame->time + range * (tick(l) - tick(*first)) / ticks;
    if (std::abs(l.frame->time - want) > 1e-3 * range)
      return faults.add(kTimes, fmt::format("{} is at {}, not {}", l.frame->name, l.frame->time, want));
  }
  if (train_lo < -1e-9 || train_hi > 1 + 1e-9 || train_hi - train_lo < 0.25)
    faults.add(kTimes, fmt::format("training is in {} to {}", train_lo, train_hi));
}

void check_splits(const Case& c, const Dataset& data, const std::vector<Loaded>& all, Faults& faults) {
  const bool said =
      std::any_of(c.shots.begin(), c.shots.end(), [](const Shot& s) { return s.split == "test"; });
  double first = 1e300, last = -1e300, train_first = 1e300, train_last = -1e300;
  for (const Loaded& l : all) {
    const Shot& s = c.shots[std::size_t(l.shot)];
    if (said && (s.split == "test") != (l.split != "train"))
      faults.add(kSplits, fmt::format("{} is in {}", l.frame->name, l.split));
    first = std::min(first, l.frame->time);
    last = std::max(last, l.frame->time);
    if (l.split != "train") continue;
    train_first = std::min(train_first, l.frame->time);
    train_last = std::max(train_last, l.frame->time);
  }
  if (!said && (train_first > first || train_last < last) && data.format != "DyNeRF")
    faults.add(kSplits, "the first or the last moment is held out");
}

Faults compare(const Case& c, const Dataset& data) {
  Faults faults;
  std::vector<Loaded> all;
  std::set<int> seen;
  for (const Split& split : data.splits)
    for (const Frame& frame : split.frames) {
      bool upright = true;
      const int shot = shot_in(frame.image, upright);
      if (shot < 0 || std::size_t(shot) >= c.shots.size()) {
        faults.add(kPictures, frame.name + " is no picture of the scene");
        continue;
      }
      const Shot& s = c.shots[std::size_t(shot)];
      if (!seen.insert(shot).second) faults.add(kPictures, frame.name + " is there twice");
      if (!s.there) faults.add(kPictures, frame.name + " cannot be there");
      if (upright == c.as_stored) faults.add(kPictures, frame.name + " is turned");
      if (const std::string words = differs(frame.camera, s.seen); !words.empty())
        faults.add(kCameras, frame.name + ": " + words);
      all.push_back({&frame, split.name, shot});
    }
  for (std::size_t i = 0; i < c.shots.size(); ++i)
    if (!seen.count(int(i)) &&
        (c.shots[i].there || !c.layout.starts_with("DyNeRF")))  // nothing lists a rig's
      faults.add(c.shots[i].there ? kPictures : kLeftOut, c.shots[i].path + " is not read");
  check_times(c, all, faults);
  check_splits(c, data, all, faults);
  return faults;
}

/// Whether a message names something that exists.
bool names_something(const Case& c, const std::string& message) {
  if (message.find(c.folder) != std::string::npos) return true;
  return std::any_of(c.shots.begin(), c.shots.end(),
                     [&](const Shot& s) { return message.find(s.path) != std::string::npos; });
}

}  // namespace

Outcome check(const Case& c, std::string& words) {
  try {
    const Dataset data = load_dataset(c.folder);
    const Faults faults = compare(c, data);
    words = fmt::format("notes: {}", fmt::join(data.notes, "\n       "));
    bool silent = false;
    for (std::size_t t = 0; t < kTopics; ++t)
      if (!faults.of[t].empty()) {
        words = fmt::format("{}: {}\n{}", kTopicNames[t], faults.of[t], words);
        silent |= !owned_up(data, Topic(t));
      }
    if (silent) return Outcome::silent;
    if (faults.any()) return Outcome::wrong_noted;
    bool noted = false;
    for (std::size_t t = 0; t < kTopics; ++t) noted |= owned_up(data, Topic(t));
    return noted ? Outcome::right_noted : Outcome::right;
  } catch (const Error& e) {
    words = e.what();
    if (e.fault != Fault::input || !names_something(c, words)) return Outcome::silent;
    if (words.find("--times") != std::string::npos) return Outcome::asked;
    return c.broken ? Outcome::refused : Outcome::unneeded;
  } catch (const std::exception& e) {
    words = std::string("another exception: ") + e.what();
    return Outcome::silent;
  }
}

}  // namespace splinevox::torture::structure
