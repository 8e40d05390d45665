// SPDX-License-Identifier: Apache-2.0
#include "cli/render_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "splinevox/core/error.hpp"

namespace splinevox::cli {
namespace {

/// Frames with the cameras of their own numbers, of the whole shot and of what is asked for beyond it. One
/// without has that before it, or the first.
void add_numbered(RenderFrames& out, const FrameRange& range, int from, int to,
                  const std::map<int, Camera>& given,
                  const std::function<void(const std::string&)>& on_note) {
  // Where file and motion go on, vectors at the ends lead to the next frame: a part has those of the whole.
  from -= given.begin()->first < from && range.time_at(from - 1) < range.time_at(from);
  to += given.rbegin()->first > to && range.time_at(to + 1) > range.time_at(to);
  if (given.size() > 1) {  // beyond the file nobody knows the cameras: there vectors go on as they came
    from = std::max(from, std::min(range.first, given.begin()->first));
    to = std::min(to, std::max(range.last, given.rbegin()->first));
  }
  int missing = 0;
  for (int f = from; f <= to; ++f) {
    auto camera = given.upper_bound(f);
    if (camera != given.begin()) --camera;
    out.shots.push_back({camera->second, range.time_at(f)});
    if (f < range.first || f > range.last) continue;
    missing += camera->first != f;
    out.shown.push_back(std::size_t(f - from));
    out.numbers.push_back(f);
    out.held.push_back(false);  // a camera may move on where the motion has ended
  }
  if (!on_note) return;
  on_note(moments_text(range));
  if (missing > 0)
    on_note(
        fmt::format("{} of {} frames have no camera of their number in the file, which has {} from {} to "
                    "{}: the one before is taken, or the first",
                    missing, range.count(), given.size(), given.begin()->first, given.rbegin()->first));
}

}  // namespace

RenderFrames plan_frames(const Run& run, CameraRequest cameras, const FrameWords& words,
                         const std::function<void(const std::string&)>& on_note) {
  RenderFrames out;
  if (words.frames.empty()) {
    if (!words.at.empty() || words.seconds > 0)
      fail({words.at.empty() ? "--seconds" : "--at",
            "says where frames are in a shot, and none are asked for", "--frames beside it", "",
            "--frames 1-120"});
    out.shots = plan_shots(run, cameras, on_note);
    for (std::size_t i = 0; i < out.shots.size(); ++i) {
      out.shown.push_back(i);
      out.numbers.push_back(int(i) + 1);
      out.held.push_back(false);
    }
    return out;
  }
  if (!cameras.times.empty())
    fail({"--times", "the times are given twice", "--frames or --times", cameras.times, ""});
  const FrameRange range = frame_range(words);
  const int last = std::max(range.start(), int(std::ceil(range.start() + range.length() * range.fps - 1e-6)));
  if (last - range.start() > 1'000'000)
    fail({"--seconds", "the whole motion has too many frames", "at most 1000000",
          std::to_string(last - range.start()), ""});
  const int end = range.at || range.seconds > 0 ? last : range.last;
  const std::map<int, Camera> given = numbered_cameras(run, cameras, on_note);
  if (const auto first = given.lower_bound(range.first); first != given.end() && first->first <= range.last) {
    add_numbered(out, range, std::min(range.first, range.start()), std::max(range.last, end), given, on_note);
    return out;
  }
  for (int f = range.start(); f <= end; ++f) cameras.moments.push_back(range.time_at(f));
  out.shots = plan_shots(run, cameras, on_note);
  if (on_note) on_note(moments_text(range));
  for (int f = range.first; f <= range.last; ++f) {
    out.shown.push_back(std::size_t(std::clamp(f - range.start(), 0, int(out.shots.size()) - 1)));
    out.numbers.push_back(f);
    out.held.push_back(f < range.start() || f > last);
  }
  return out;
}

}  // namespace splinevox::cli
