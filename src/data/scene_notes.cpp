// SPDX-License-Identifier: Apache-2.0
#include "data/scene_notes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/printable.hpp"
#include "data/fingerprint.hpp"

namespace splinevox::data {
namespace {

void note_pictures(const Split& split, const std::vector<PictureFacts>& facts, bool PictureFacts::*odd,
                   const std::string& what, std::vector<std::string>& notes) {
  const auto found = std::find_if(facts.begin(), facts.end(), [&](const PictureFacts& f) { return f.*odd; });
  if (found == facts.end()) return;
  const auto count = std::count_if(facts.begin(), facts.end(), [&](const PictureFacts& f) { return f.*odd; });
  notes.push_back(split.name + ": " + std::to_string(count) + " of " + std::to_string(facts.size()) +
                  " pictures are " + what + ", first " +
                  printable(split.frames[std::size_t(found - facts.begin())].name));
}

/// Nothing of a frame without depth, which has the hash it always had.
void add_depth(const DepthMap& depth, Fingerprint& hash) {
  if (depth.empty()) return;
  hash.add(std::uint64_t(depth.kind()));
  hash.add(std::uint64_t(depth.width()));
  for (int i = 0; i < depth.width() * depth.height(); ++i) hash.add(double(depth.value(std::size_t(i))));
}

}  // namespace

void note_cameras(const RawSplit& raw, std::vector<std::string>& notes) {
  constexpr double kRounding = 1e-5;  // of matrices made in 32-bit floats; D-NeRF's own reach 2.4e-6
  std::size_t count = 0;
  double worst = 0;
  for (const RawFrame& frame : raw.frames) {
    count += frame.pose.deviation > kRounding ? 1 : 0;
    worst = std::max(worst, frame.pose.deviation);
  }
  if (count > 0)
    notes.push_back(raw.name + ": " + std::to_string(count) + " of " + std::to_string(raw.frames.size()) +
                    " camera matrices were off rigid by up to " + fmt::format("{:.2g}", worst) +
                    " and were made orthonormal");
}

void note_facts(const Split& split, std::vector<PictureFacts>& facts, std::vector<std::string>& notes) {
  for (PictureFacts& f : facts) f.black &= !f.invisible;
  note_pictures(split, facts, &PictureFacts::invisible, "wholly transparent", notes);
  note_pictures(split, facts, &PictureFacts::black, "wholly black", notes);
  note_pictures(split, facts, &PictureFacts::odd, "below 0 or not finite in places, which are taken as 0",
                notes);
}

std::uint64_t fingerprint_of(const RawSplit& raw, const Split& split,
                             const std::vector<PictureFacts>& facts) {
  Fingerprint hash;
  hash.add(std::uint64_t(raw.frames.size()));
  for (std::size_t i = 0; i < raw.frames.size(); ++i) {
    const RawFrame& frame = raw.frames[i];
    for (const double value : frame.matrix) hash.add(value);
    const Lens& lens = frame.lens;
    for (const auto& value :
         {lens.camera_angle_x, lens.camera_angle_y, lens.fl_x, lens.fl_y, lens.cx, lens.cy})
      hash.add(value);
    std::uint64_t place = 0;
    for (const auto& value : {lens.k1, lens.k2, lens.k3, lens.k4, lens.p1,
                              lens.p2})  // a lens without them has the hash it always had
      if (++place; value && *value != 0) {
        hash.add(place);
        hash.add(value);
      }
    if (lens.fisheye.value_or(false)) hash.add(std::uint64_t(1));
    hash.add(frame.time);
    hash.add(facts[i].hash);
    split.frames[i].ignored.each_word([&](std::uint64_t word) { hash.add(word); });
    const CoarseMask& moving = split.frames[i].moving;
    if (!moving.empty()) hash.add(std::uint64_t(moving.factor));
    moving.squares.each_word([&](std::uint64_t word) { hash.add(word); });
    add_depth(split.frames[i].depth, hash);
    for (const VisiblePoint& p : split.frames[i].tracks) {
      hash.add(std::uint64_t(p.point));
      hash.add(double(p.u));
      hash.add(double(p.v));
    }
  }
  return hash.value();
}

}  // namespace splinevox::data
