// SPDX-License-Identifier: Apache-2.0
#include "train/learn_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "math/exposure.hpp"
#include "math/median.hpp"

namespace splinevox {
namespace {

constexpr double kClocksBegin = 0.2;  ///< progress: before it little is known of motion
constexpr double kGainsBegin = 0.03;  ///< progress: before it the model is fog, and gains would be those of
                                      ///< what a camera happens to look at
constexpr double kNoise = 0.01;       ///< of brightness: a gain is told by rays brighter than that
constexpr double kStray = 0.25;       ///< intervals

/// Median time between moments.
double interval_of(const std::set<double>& moments) {
  std::vector<double> between;
  for (auto next = std::next(moments.begin()); next != moments.end(); ++next)
    between.push_back(*next - *std::prev(next));
  return median(between);
}

}  // namespace

CameraFits rig_of(const Split& train) {
  constexpr std::size_t kFewest = 3;  // moments: poses that are met twice by chance are no camera
  std::vector<std::set<double>> moments;
  for (const Frame& f : train.frames) {
    if (f.camera_id < 0) continue;
    if (f.camera_id >= int(moments.size())) moments.resize(std::size_t(f.camera_id) + 1);
    moments[std::size_t(f.camera_id)].insert(f.time);
  }
  CameraFits out;
  int trained = 0;
  for (const std::set<double>& m : moments) {
    const bool one = m.size() >= kFewest;
    out.cameras.push_back({.interval = one ? interval_of(m) : 0, .trained = one});
    trained += one;
  }
  return trained > 1 ? out : CameraFits{};
}

CameraLearner::CameraLearner(const CamerasConfig& config, const CameraFits& fits, float unit)
    : config_(config), unit_(unit), learned_(fits.cameras.size()) {}

void CameraLearner::update(CameraFits& fits, const Split& train, const Batch& batch, const StepSums& sums,
                           const MomentFactors& factors, double progress, double rate) {
  if (gains() && progress >= kGainsBegin) update_gains(fits, batch, sums);
  if (clocks() && progress >= kClocksBegin) update_clocks(fits, train, batch, sums, factors, rate);
}

void CameraLearner::update_gains(CameraFits& fits, const Batch& batch, const StepSums& sums) {
  std::vector<Vec3d> along(learned_.size()), square(learned_.size());
  std::vector<double> rays(learned_.size());
  for (std::size_t i = 0; i < batch.shown.size(); ++i) {
    if (!fits.knows(batch.shown[i].camera)) continue;
    const auto c = std::size_t(batch.shown[i].camera);
    ++rays[c];
    for (int a = 0; a < 3; ++a) {
      const GainTerm<double> term = gain_term(double(batch.shown[i].colour[a]), double(sums.errors[i][a]),
                                              double(fits.cameras[c].gain[a]), is_bound(batch.targets[i][a]));
      along[c][a] += term.along;
      square[c][a] += term.square;
    }
  }
  const double fade = config_.exposure_rate, most = std::log(double(config_.most_gain)),
               noise = kNoise * unit_ * kNoise * unit_;
  std::vector<Vec3d> logs(learned_.size());
  for (std::size_t c = 0; c < learned_.size(); ++c) {
    Learned& l = learned_[c];
    for (int a = 0; a < 3; ++a) {
      if (rays[c] > 0) {
        l.along[a] += fade * ((along[c][a] / rays[c] + noise) - l.along[a]);
        l.square[a] += fade * ((square[c][a] / rays[c] + noise) - l.square[a]);
      }
      logs[c][a] = l.along[a] > 0 ? std::log(l.along[a] / l.square[a]) : 0;
    }
  }
  for (int a = 0; a < 3; ++a) {
    double mean = 0;
    int count = 0;
    for (std::size_t c = 0; c < logs.size(); ++c)
      if (fits.cameras[c].trained && std::abs(logs[c][a]) < most) {
        mean += logs[c][a];
        ++count;
      }
    if (count > 0) mean /= count;
    for (std::size_t c = 0; c < logs.size(); ++c)
      if (fits.cameras[c].trained)
        fits.cameras[c].gain[a] = float(std::exp(std::clamp(logs[c][a] - mean, -most, most)));
  }
}

void CameraLearner::update_clocks(CameraFits& fits, const Split& train, const Batch& batch,
                                  const StepSums& sums, const MomentFactors& factors, double rate) {
  std::vector<double> slope(learned_.size());
  std::vector<char> met(learned_.size());
  for (std::size_t s = 0; s < batch.frames.size(); ++s) {
    const Frame& frame = train.frames[std::size_t(batch.frames[s])];
    if (!fits.knows(frame.camera_id)) continue;
    const auto c = std::size_t(frame.camera_id);
    const double t = frame.time + fits.cameras[c].offset;
    if (t < 0 || t > 1) continue;  // the curves end there, and what they show does not change
    slope[c] += sums.slopes[s];
    met[c] = 1;
  }
  double squares = 0;
  int count = 0;
  for (std::size_t c = 0; c < learned_.size(); ++c) {
    if (!met[c]) continue;
    slope[c] *= fits.cameras[c].interval;
    squares += slope[c] * slope[c];
    ++count;
  }
  if (count == 0) return;
  square_ += (1 - double(factors.beta2)) * (squares / count - square_);
  const double scale = rate * double(config_.clock_rate) / (std::sqrt(square_) + double(factors.epsilon));
  std::vector<double> offsets;
  for (std::size_t c = 0; c < learned_.size(); ++c) {
    CameraFit& camera = fits.cameras[c];
    if (!camera.trained) continue;
    if (met[c]) {
      learned_[c].m += (1 - double(factors.beta1)) * (slope[c] - learned_[c].m);
      camera.offset -= scale * learned_[c].m * camera.interval;
    }
    offsets.push_back(camera.offset);
  }
  const double middle = median(offsets);
  for (CameraFit& camera : fits.cameras) {
    const double most = double(config_.most_offset) * camera.interval;
    if (camera.trained) camera.offset = std::clamp(camera.offset - middle, -most, most);
  }
}

bool CameraLearner::strayed(const CameraFits& fits) const {
  for (std::size_t c = 0; c < learned_.size(); ++c)
    if (std::abs(fits.cameras[c].offset - learned_[c].looked) > kStray * fits.cameras[c].interval)
      return true;
  return false;
}

void CameraLearner::look(const CameraFits& fits) {
  for (std::size_t c = 0; c < learned_.size(); ++c) learned_[c].looked = fits.cameras[c].offset;
}

void CameraLearner::archive(Archive& a, CameraFits& fits) {
  const std::size_t count = learned_.size();
  a(learned_, square_);
  check_fits(learned_.size() == count);
  for (CameraFit& camera : fits.cameras) a(camera.gain, camera.offset);
}

}  // namespace splinevox
