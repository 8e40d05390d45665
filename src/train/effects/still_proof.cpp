// SPDX-License-Identifier: Apache-2.0
#include "train/effects/still_proof.hpp"

#include <algorithm>
#include <map>

namespace splinevox {
namespace {

// Shares of a camera's blocks. With the noise of a dark film, a fiftieth of brightness, a static camera has
// 0.0007 at most; a ball that moves before one of eight has 0.004 (docs/experiments/effects.md).
constexpr double kChanged = 0.003, kUnchanged = 0.001;
constexpr double kDark = 0.2;      // of the blocks, in whose noise a change may hide
constexpr int kFewestCameras = 2;  // that prove change, where there are as many: one may have been touched
constexpr double kAgreeing = 0.3;  // of the cameras, that do at least

}  // namespace

StillProof prove(const Split& train, float unit) {
  StillProof out{still_cameras(train, unit), {}};
  if (out.cameras.empty()) return out;
  StillEvidence e;
  e.cameras = int(out.cameras.size());
  e.threshold = kChanged;
  std::size_t frames = 0;
  bool quiet = true;
  for (const StillCamera& camera : out.cameras) {
    e.changing += camera.share > kChanged;
    e.share += camera.share / e.cameras;
    frames += camera.frames.size();
    quiet &= camera.share < kUnchanged && share_of(camera.unknown) < kDark && camera.steady();
  }
  if (e.changing >= std::min(kFewestCameras, e.cameras) && e.changing >= kAgreeing * e.cameras)
    e.verdict = StillVerdict::changed;
  else if (quiet && frames == train.frames.size())
    e.verdict = StillVerdict::unchanged;
  out.evidence = e;
  return out;
}

std::vector<Image> changing_pixels(const StillProof& proof, const Halves& halves) {
  struct At {
    const StillCamera* camera;
    const std::vector<bool>* now;
  };
  std::map<int, At> of_frame;
  for (const StillCamera& camera : proof.cameras)
    for (std::size_t i = 0; i < camera.frames.size(); ++i)
      of_frame[camera.frames[i]] = {&camera, &camera.now[i]};
  std::vector<Image> out;
  for (std::size_t f = 0; f < halves.held_out.frames.size(); ++f) {
    const Picture& picture = halves.held_out.frames[f].image;
    Image& mask = out.emplace_back(picture.width, picture.height, 1);
    const auto found = of_frame.find(halves.held_out_frames[f]);
    if (found == of_frame.end()) continue;
    const StillCamera& c = *found->second.camera;
    const auto first = [](int at, int n, int blocks) {
      return std::clamp(at * blocks / n - 1, 0, blocks - 1);
    };
    const auto last = [](int at, int n, int blocks) {
      return std::clamp(((at + 1) * blocks - 1) / n + 1, 0, blocks - 1);
    };
    const PixelMask& ignored = halves.held_out.frames[f].ignored;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        for (int v = first(y, mask.height, c.height); v <= last(y, mask.height, c.height); ++v)
          for (int u = first(x, mask.width, c.width); u <= last(x, mask.width, c.width); ++u)
            if (!ignored.test(x, y) &&
                (*found->second.now)[std::size_t(v) * std::size_t(c.width) + std::size_t(u)])
              *mask.pixel(x, y) = 1;
  }
  return out;
}

}  // namespace splinevox
