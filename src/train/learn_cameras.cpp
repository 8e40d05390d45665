// SPDX-License-Identifier: Apache-2.0
#include "train/learn_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "data/times/seen_moments.hpp"
#include "math/exposure.hpp"
#include "math/median.hpp"
#include "math/tridiagonal.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

constexpr std::size_t kMostGains = 25;  ///< of a camera, over time

constexpr double kClocksBegin = 0.2;  ///< progress: before it little is known of motion
constexpr double kGainsBegin = 0.03;  ///< progress: before it the model is fog, and gains would be those of
                                      ///< what a camera happens to look at
constexpr double kNoise = 0.01;       ///< of brightness: a gain is told by rays brighter than that
constexpr double kStray = 0.25;       ///< intervals

}  // namespace

CameraFits rig_of(const Split& train) {
  constexpr std::size_t kFewest = 3;  // moments: poses that are met twice by chance are no camera
  CameraFits out;
  int trained = 0;
  for (const std::set<double>& m : times_of_cameras(train)) {
    const bool one = m.size() >= kFewest;
    out.cameras.push_back({.interval = one ? interval_of(m) : 0, .trained = one});
    trained += one;
  }
  return trained > 1 ? out : CameraFits{};
}

bool in_sequence(const Split& train) {
  constexpr std::size_t kFewest = 12;
  constexpr double kNear = 0.25;  // of the way between pictures at any times: D-NeRF's are at 1
  std::vector<const Frame*> frames;
  for (const Frame& f : train.frames) frames.push_back(&f);
  if (frames.size() < kFewest) return false;
  std::sort(frames.begin(), frames.end(), [](const Frame* a, const Frame* b) { return a->time < b->time; });
  std::vector<double> next, any;
  for (std::size_t i = 0, n = frames.size(); i + 1 < n; ++i) {
    if (frames[i]->time == frames[i + 1]->time) return false;
    next.push_back(length(frames[i + 1]->camera.position - frames[i]->camera.position));
    any.push_back(length(frames[(i + n / 2) % n]->camera.position - frames[i]->camera.position));
  }
  const double way = median(any);
  return way > 0 && median(next) < kNear * way;
}

TakenBy taken_by(const Split& train) {
  if (!rig_of(train).cameras.empty()) return TakenBy::rig;
  return in_sequence(train) ? TakenBy::film : TakenBy::any;
}

CameraFits cameras_to_learn(const CamerasConfig& config, const Split& train) {
  constexpr std::size_t kEach = 6;  // pictures a gain
  CameraFits out;
  if (config.exposure || config.clock || config.drift) out = rig_of(train);
  if (!config.drift) return out;
  if (out.cameras.empty() && in_sequence(train)) {
    out.film = true;
    out.cameras.push_back({.trained = true});
  }
  std::size_t pictures = 0, trained = 0;
  for (const Frame& f : train.frames) pictures += out.knows(out.index_of(f));
  for (const CameraFit& c : out.cameras) trained += c.trained;
  if (trained == 0) return out;
  const std::size_t gains = std::clamp(1 + pictures / (trained * kEach), std::size_t(1), kMostGains);
  for (CameraFit& c : out.cameras) c.gains.resize(gains, {1, 1, 1});
  return out;
}

CameraLearner::CameraLearner(const CamerasConfig& config, const CameraFits& fits, float unit)
    : config_(config), unit_(unit), learned_(fits.cameras.size()) {
  for (std::size_t c = 0; c < learned_.size(); ++c) learned_[c].rows.resize(fits.cameras[c].gains.size());
}

void CameraLearner::update(CameraFits& fits, const Split& train, const Batch& batch, const StepSums& sums,
                           const MomentFactors& factors, double progress, double rate) {
  if (gains() && progress >= kGainsBegin) update_gains(fits, batch, sums);
  if (clocks() && progress >= kClocksBegin) update_clocks(fits, train, batch, sums, factors, rate);
}

void CameraLearner::add_rays(const CameraFits& fits, const Batch& batch, const StepSums& sums) {
  struct Met {
    Row row;
    double weight = 0, rays = 0;
  };
  std::vector<std::vector<Met>> met(learned_.size());
  for (std::size_t c = 0; c < met.size(); ++c) met[c].resize(learned_[c].rows.size());
  for (std::size_t i = 0; i < batch.shown.size(); ++i) {
    const CameraRay& shown = batch.shown[i];
    if (!fits.knows(shown.camera)) continue;
    const auto c = std::size_t(shown.camera);
    const Vec3 gain = fits.cameras[c].gain_at(shown.time);
    Vec3d along, square;
    for (int a = 0; a < 3; ++a) {
      const GainTerm<double> term = gain_term(double(shown.colour[a]), double(sums.errors[i][a]),
                                              double(gain[a]), is_bound(batch.targets[i][a]));
      along[a] = term.along;
      square[a] = term.square;
    }
    const auto [first, share] = fits.cameras[c].between(shown.time);
    const double shares[] = {1 - double(share), double(share)};
    for (std::size_t k = 0; k < 2; ++k) {
      if (shares[k] == 0) continue;
      Met& m = met[c][first + k];
      m.row.along += shares[k] * along;
      m.row.square += shares[k] * shares[k] * square;
      (k == 0 ? m.row.next : m.row.before) += shares[0] * shares[1] * square;
      m.weight += shares[k];
      ++m.rays;
    }
  }
  const double noise = kNoise * unit_ * kNoise * unit_;
  for (std::size_t c = 0; c < met.size(); ++c)
    for (std::size_t k = 0; k < met[c].size(); ++k) {
      const Met& m = met[c][k];
      if (m.rays == 0) continue;
      Row& row = learned_[c].rows[k];
      const double fade = config_.exposure_rate * (m.weight / m.rays);
      for (int a = 0; a < 3; ++a) {
        row.along[a] += fade * ((m.row.along[a] / m.weight + noise) - row.along[a]);
        row.square[a] += fade * ((m.row.square[a] / m.weight + noise) - row.square[a]);
        row.before[a] += fade * (m.row.before[a] / m.weight - row.before[a]);
        row.next[a] += fade * (m.row.next[a] / m.weight - row.next[a]);
      }
    }
}

/// The logarithms of the gains of a camera's channel, 0 where no ray was met.
std::vector<double> CameraLearner::logs_of(const std::vector<Row>& rows, int channel, double most) {
  std::vector<double> before, middle, after, right;
  for (const Row& row : rows) {
    const bool met = row.square[channel] > 0;
    before.push_back(row.before[channel]);
    middle.push_back(met ? row.square[channel] : 1);
    after.push_back(row.next[channel]);
    right.push_back(met ? row.along[channel] : 1);
  }
  std::vector<double> out = solve_tridiagonal(before, middle, after, right);
  for (double& x : out) x = x > 0 ? std::log(x) : -most;
  return out;
}

void CameraLearner::update_gains(CameraFits& fits, const Batch& batch, const StepSums& sums) {
  add_rays(fits, batch, sums);
  const double most = std::log(double(config_.most_gain));
  const std::size_t gains = learned_[0].rows.size();
  for (int a = 0; a < 3; ++a) {
    std::vector<std::vector<double>> logs;
    std::vector<double> sum(gains);
    std::vector<int> count(gains);
    for (std::size_t c = 0; c < learned_.size(); ++c) {
      logs.push_back(logs_of(learned_[c].rows, a, most));
      for (std::size_t k = 0; k < gains; ++k) {
        if (!fits.cameras[c].trained || std::abs(logs[c][k]) >= most) continue;
        const std::size_t of = fits.film ? 0 : k;
        sum[of] += logs[c][k];
        ++count[of];
      }
    }
    for (std::size_t c = 0; c < learned_.size(); ++c)
      for (std::size_t k = 0; fits.cameras[c].trained && k < gains; ++k) {
        const std::size_t of = fits.film ? 0 : k;
        const double log = logs[c][k] - sum[of] / std::max(1, count[of]);
        fits.cameras[c].gains[k][a] = float(std::exp(std::clamp(log, -most, most)));
      }
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
  a(square_);
  for (Learned& l : learned_) {
    const std::size_t gains = l.rows.size();
    a(l.rows, l.m, l.looked);
    // Of a film whose camera rests, an older version knew the resting pictures alone, and gave them fewer.
    check_fits(l.rows.size() == gains || (fits.film && !l.rows.empty() && l.rows.size() <= kMostGains));
  }
  for (std::size_t c = 0; c < fits.cameras.size(); ++c) {
    CameraFit& camera = fits.cameras[c];
    a(camera.gains, camera.offset);
    check_fits(camera.gains.size() == learned_[c].rows.size());
  }
}

}  // namespace splinevox
