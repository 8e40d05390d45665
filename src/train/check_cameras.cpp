// SPDX-License-Identifier: Apache-2.0
#include "train/check_cameras.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "math/median.hpp"
#include "splinevox/core/error.hpp"
#include "train/bounds/hull.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

constexpr const char* kLikelyCauses =
    "matrices that are world to camera or have other axes than OpenGL's (x right, y up, z backwards), a "
    "wrong "
    "angle of view, or pictures of other cameras";

/// PSNR of a picture by its own mean colour, over an eighth of its pixels.
double psnr_of_mean(const Frame& frame) {
  const Picture& image = frame.image;
  const ReadAll all_of(image);
  Vec3d sum{}, squares{};
  double count = 0;
  for (std::size_t i = 0; i < image.pixels(); i += 8) {
    if (frame.ignored.test(i)) continue;
    const auto p = image.rgba(i);
    for (int a = 0; a < 3; ++a) {
      const double v = p[std::size_t(a)] / 65535.0;
      sum[a] += v;
      squares[a] += v * v;
    }
    ++count;
  }
  count = std::max(count, 1.0);
  double error = 0;
  for (int a = 0; a < 3; ++a) error += squares[a] / count - sum[a] * sum[a] / count / count;
  return -10 * std::log10(std::max(error / 3, 1e-10));
}

/// The largest distance of a camera from the first, scene units.
double spread_of(const std::vector<Camera>& cameras) {
  double spread = 0;
  for (const Camera& c : cameras) spread = std::max(spread, length(c.position - cameras.front().position));
  return spread;
}

}  // namespace

void check_silhouettes(const Split& train, const std::function<void(std::string)>& note,
                       std::optional<double> known) {
  constexpr double kMeets = 0.5, kAgrees = 0.97, kBetter = 0.05;
  constexpr std::size_t kFewest = 3;  // two silhouettes always meet somewhere
  if (train.frames.size() < kFewest) return;
  const std::vector<Camera> own = cameras_of(train);
  const double share = known ? *known : explained_by_hull(train, own);
  if (share >= kAgrees) return;
  // From nearly one place most silhouettes agree. Cameras that go round an object are in nearly one place if
  // their matrices are read the wrong way round, so the right way is the one that is spread wider.
  const double spread = spread_of(own);
  const std::string found = fmt::format("{:.0f}% of what the pictures show", 100 * share);
  for (const OtherCameras& other : other_cameras(train)) {
    const double theirs = explained_by_hull(train, other.cameras);
    if (theirs < std::max(kAgrees, share + kBetter) || spread_of(other.cameras) < spread) continue;
    fail({"the training cameras", "the silhouettes of the pictures do not meet where the cameras look",
          "cameras to world with OpenGL's axes (x right, y up, z backwards)",
          fmt::format("{}; as {} it would be {:.0f}%", found, other.what, 100 * theirs),
          fmt::format("write 'transform_matrix' from camera to world in OpenGL's axes: it looks like {}",
                      other.what)});
  }
  if (share >= kMeets) return;
  note(fmt::format(
      "silhouettes of neighbouring times meet in only {}: the cameras may not belong to the pictures. "
      "Likely causes: {}",
      found, kLikelyCauses));
}

double check_parallax(const Config& config, const Split& train,
                      const std::function<void(std::string)>& note) {
  const std::vector<float>& b = config.grid.box;
  const std::vector<Camera> cameras = cameras_of(train);
  const Box box = b.size() == 6 ? Box{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}} : camera_cube(cameras);
  const double angle = parallax(cameras, box);
  if (angle < kLeastParallax)
    note(fmt::format(
        "all cameras see the scene from within {:.2g} degrees: its depth is not determined, and views "
        "from elsewhere are a guess. More cameras, or a camera that moves, would tell",
        angle));
  else if (b.empty() && look_alike(cameras))
    note(
        "all cameras look in one direction: where the scene is, between them and far away, is a guess. --set "
        "grid.box=X0,Y0,Z0,X1,Y1,Z1 says it");
  return angle;
}

void note_bad_fits(const Split& train, const EffectChoice& effects,
                   const std::function<void(std::string)>& note) {
  constexpr double kBetter = 1;  // dB
  if (effects.trials.empty()) return;
  double best = -1e9;
  for (const EffectTrial& trial : effects.trials) best = std::max(best, trial.mean());
  const std::vector<const Frame*> frames = some_frames(train);
  std::vector<double> flat(frames.size());
  parallel_for(int(flat.size()), [&](int f) { flat[f] = psnr_of_mean(*frames[f]); });
  const double usual = median(flat);
  if (best >= usual + kBetter) return;
  note(fmt::format(
      "first fits show held-out pictures at {:.1f} dB, one colour per picture reaches {:.1f}: the "
      "cameras may not belong to the pictures. Likely causes: {}; or a box in the wrong place "
      "(--set grid.box=x0,y0,z0,x1,y1,z1)",
      best, usual, kLikelyCauses));
}

}  // namespace splinevox
