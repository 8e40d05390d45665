// SPDX-License-Identifier: Apache-2.0
#include "run/volume_score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "field/matter_reach.hpp"
#include "math/activation.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox::run {
namespace {

constexpr double kCoarser = 0.75;  ///< of the truth's voxel: a model's voxels from this size need one sample
constexpr double kLeastMass = 0.02;  ///< of the largest: moments with less have no correlation to speak of

/// The truth's lattice, continued to hold the model's matter.
struct Extended {
  Lattice lattice;
  Int3 before{};  ///< voxels before the truth's first
  int samples = 1;
  std::size_t index(const Int3& v) const {
    return (std::size_t(v.x) * lattice.size.y + v.y) * lattice.size.z + v.z;
  }
  std::size_t voxels() const { return std::size_t(lattice.size.x) * lattice.size.y * lattice.size.z; }
};

Extended extend(const VoxelModel& model, const TruthVolumes& truth) {
  const Vec3d lo = truth.lo(), hi = truth.hi(), span = hi - lo;
  const Vec3d model_lo = cast<double>(model.box.lo), model_hi = cast<double>(model.box.hi);
  for (int a = 0; a < 3; ++a)
    if (model_hi[a] <= lo[a] || model_lo[a] >= hi[a])
      fail({truth.folder, "the truth volumes lie beside the model's box",
            fmt::format("something of {:.3g} {:.3g} {:.3g} to {:.3g} {:.3g} {:.3g}, the model's box",
                        model_lo.x, model_lo.y, model_lo.z, model_hi.x, model_hi.y, model_hi.z),
            fmt::format("{:.3g} {:.3g} {:.3g} to {:.3g} {:.3g} {:.3g}", lo.x, lo.y, lo.z, hi.x, hi.y, hi.z),
            "volumes in the coordinates of the cameras that the run was trained with"});
  Extended out;
  const double h = truth.spacing;
  Int3 after{};
  for (int a = 0; a < 3; ++a) {
    const auto beyond = [&](double by) { return int(std::ceil(std::clamp(by, 0.0, span[a]) / h - 1e-6)); };
    out.before[a] = beyond(lo[a] - model_lo[a]);
    after[a] = beyond(model_hi[a] - hi[a]);
  }
  out.lattice = {cast<float>(truth.origin - h * cast<double>(out.before)), float(h),
                 truth.size + out.before + after};
  const double own = double(model.radiance.raw.topology->lattice.spacing);
  out.samples = own > kCoarser * h ? 1 : int(std::ceil(h / own));
  return out;
}

/// The model's density on an extended lattice, moment by moment.
class ModelDensity {
 public:
  ModelDensity(const VoxelModel& model, const Extended& at)
      : model_(model),
        at_(at),
        least_(float(optical_depth(ExportOptions().min_alpha)) /
               model.radiance.raw.topology->lattice.spacing),
        reach_(model, least_) {
    const auto n = float(at.samples);
    fine_.spacing = at.lattice.spacing / n;
    fine_.origin = at.lattice.origin - (0.5f * (n - 1) / n * at.lattice.spacing) * Vec3{1, 1, 1};
    fine_.size = at.samples * at.lattice.size;
  }

  std::vector<float> operator()(double time) const {
    const FrameSampler sampler(model_, time);
    std::vector<float> out(at_.voxels());
    const std::vector<Int3> blocks = blocks_at(time);
    const float share = 1 / float(at_.samples * at_.samples * at_.samples);
    parallel_for(int(blocks.size()), [&](int b) {
      for (int i = 0; i < kBrickRows; ++i) {
        const Int3 v = kBrick * blocks[std::size_t(b)] + Int3{i >> 6, i >> 3 & 7, i & 7},
                   n = at_.lattice.size;
        if (v.x >= n.x || v.y >= n.y || v.z >= n.z) continue;
        float sum = 0;
        for (int x = 0; x < at_.samples; ++x)
          for (int y = 0; y < at_.samples; ++y)
            for (int z = 0; z < at_.samples; ++z) {
              const float density = sampler.density(fine_.position(at_.samples * v + Int3{x, y, z}));
              if (density >= least_) sum += density;
            }
        out[at_.index(v)] = share * sum;
      }
    });
    return out;
  }

 private:
  /// Blocks of 8^3 voxels that may hold matter.
  std::vector<Int3> blocks_at(double time) const {
    std::vector<Int3> blocks;
    for (const Int3& leaf : reach_.candidates(fine_, stored_weights(model_.motion, time))) {
      Int3 first{}, last{};
      for (int a = 0; a < 3; ++a) {
        first[a] = kBrick * leaf[a] / at_.samples / kBrick;
        last[a] = std::min((kBrick * leaf[a] + kBrick - 1) / at_.samples, at_.lattice.size[a] - 1) / kBrick;
      }
      for (int x = first.x; x <= last.x; ++x)
        for (int y = first.y; y <= last.y; ++y)
          for (int z = first.z; z <= last.z; ++z) blocks.push_back({x, y, z});
    }
    const auto key = [](const Int3& b) { return std::tuple{b.x, b.y, b.z}; };
    std::sort(blocks.begin(), blocks.end(), [&](const Int3& a, const Int3& b) { return key(a) < key(b); });
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    return blocks;
  }

  const VoxelModel& model_;
  const Extended& at_;
  float least_;  ///< 1 / scene unit
  MatterReach reach_;
  Lattice fine_;
};

/// A voxel with matter at a moment.
struct VoxelPair {
  float truth, model;
};

/// What a moment's figures are made of.
struct Sums {
  double t = 0, m = 0, tt = 0, mm = 0, tm = 0, inside = 0;
  double apart = 0, apart_unscaled = 0, least = 0, most = 0;  ///< with the factor

  Sums& operator+=(const Sums& o) {
    for (double Sums::*each : {&Sums::t, &Sums::m, &Sums::tt, &Sums::mm, &Sums::tm, &Sums::inside,
                               &Sums::apart, &Sums::apart_unscaled, &Sums::least, &Sums::most})
      this->*each += o.*each;
    return *this;
  }
};

/// NaN for what divides by nothing.
double over(double a, double b) { return b > 0 ? a / b : std::numeric_limits<double>::quiet_NaN(); }

/// @param voxels  with matter at some moment, times the moments
VolumeFigures figures_of(const Sums& s, double voxels) {
  VolumeFigures out;
  out.l1 = over(s.apart, s.t);
  out.l1_unscaled = over(s.apart_unscaled, s.t);
  const double tt = s.tt - s.t * s.t / voxels, mm = s.mm - s.m * s.m / voxels;
  const double among = tt > 0 && mm > 0 ? (s.tm - s.t * s.m / voxels) / std::sqrt(tt * mm) : 0;
  out.correlation = over(s.t, s.t) * among;
  out.iou = over(s.least, s.most);
  out.outside = over(s.m - s.inside, s.m);
  return out;
}

}  // namespace

VolumeScore score_volumes(const VoxelModel& model, const TruthVolumes& truth) {
  const Extended at = extend(model, truth);
  const ModelDensity density(model, at);
  const std::size_t count = truth.moments.size();
  std::vector<std::vector<VoxelPair>> pairs(count);
  std::vector<Sums> sums(count);
  std::vector<char> matter(at.voxels(), 0);  // at some moment
  double tm = 0, mm = 0;
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<float> t(at.voxels());
    const std::vector<float> own = read_truth_volume(truth, k), m = density(truth.moments[k].time);
    std::size_t i = 0;
    for (int x = 0; x < truth.size.x; ++x)
      for (int y = 0; y < truth.size.y; ++y)
        for (int z = 0; z < truth.size.z; ++z) {
          const std::size_t v = at.index(at.before + Int3{x, y, z});
          t[v] = own[i++];
          sums[k].inside += double(m[v]);
        }
    for (std::size_t v = 0; v < t.size(); ++v) {
      if (t[v] == 0 && m[v] == 0) continue;
      matter[v] = 1;
      pairs[k].push_back({t[v], m[v]});
      tm += double(t[v]) * double(m[v]);
      mm += double(m[v]) * double(m[v]);
    }
  }
  VolumeScore out;
  out.scale = mm > 0 ? tm / mm : 0;
  out.voxel = truth.spacing;
  out.samples = at.samples;
  Sums all;
  for (std::size_t k = 0; k < count; ++k) {
    for (const VoxelPair& p : pairs[k]) {
      const double t = double(p.truth), m = double(p.model), scaled = out.scale * m;
      Sums& s = sums[k];
      s.t += t;
      s.m += m;
      s.tt += t * t;
      s.mm += m * m;
      s.tm += t * m;
      s.apart += std::abs(scaled - t);
      s.apart_unscaled += std::abs(m - t);
      s.least += std::min(scaled, t);
      s.most += std::max(scaled, t);
    }
    all += sums[k];
  }
  if (!(all.t > 0))
    fail({truth.folder, "there is no matter in the truth volumes", "densities above 0",
          fmt::format("{} volumes of nothing", count), ""});
  const double voxels = double(std::count(matter.begin(), matter.end(), 1));
  static_cast<VolumeFigures&>(out) = figures_of(all, voxels * double(count));

  const double cell = std::pow(truth.spacing, 3), mean_t = all.t / double(count),
               mean_m = all.m / double(count);
  const double largest =
      std::max_element(sums.begin(), sums.end(), [](const Sums& a, const Sums& b) { return a.t < b.t; })->t;
  int correlated = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Sums& s = sums[k];
    VolumeMoment moment{figures_of(s, voxels), truth.moments[k].time, cell * s.t, cell * s.m};
    out.mass_curve += std::abs((mean_m > 0 ? s.m / mean_m : 0) - s.t / mean_t) / double(count);
    out.mass_unscaled += std::abs(s.m - s.t) / mean_t / double(count);
    if (s.t > kLeastMass * largest) {
      out.correlation_per_moment += moment.correlation;
      ++correlated;
    }
    out.moments.push_back(moment);
  }
  out.correlation_per_moment /= correlated;
  return out;
}

Json volume_json(const VolumeScore& score) {
  const auto figures = [](const VolumeFigures& f) {
    return Json{{"l1", f.l1},
                {"l1_unscaled", f.l1_unscaled},
                {"correlation", f.correlation},
                {"iou", f.iou},
                {"outside", f.outside}};
  };
  Json out{{"scale", score.scale}};
  out.update(figures(score));
  out.update(Json{{"correlation_per_moment", score.correlation_per_moment},
                  {"mass_curve", score.mass_curve},
                  {"mass_unscaled", score.mass_unscaled},
                  {"voxel", score.voxel},
                  {"samples_per_voxel", score.samples * score.samples * score.samples}});
  Json moments = Json::array();
  for (const VolumeMoment& m : score.moments) {
    Json moment{{"time", m.time}, {"mass_truth", m.mass_truth}, {"mass", m.mass}};
    moment.update(figures(m));
    moments.push_back(std::move(moment));
  }
  out["moments"] = std::move(moments);
  return out;
}

void print_volumes(const VolumeScore& score) {
  fmt::print("{:<16} {:>10} {:>10} {:>8} {:>8} {:>8} {:>8}\n", "volume at time", "true mass", "mass", "L1",
             "corr.", "IoU", "outside");
  for (const VolumeMoment& m : score.moments)
    fmt::print("{:<16.4f} {:>10.4f} {:>10.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>7.2f}%\n", m.time, m.mass_truth,
               m.mass, m.l1, m.correlation, m.iou, 100 * m.outside);
  const auto line = [](const char* what, double value, const std::string& more) {
    fmt::print("{:<28} {:.4f}   ({})\n", what, value, more);
  };
  line("volume: scale", score.scale, "the factor that brings the model's density to the true one");
  line("volume: L1", score.l1, fmt::format("after that factor; {:.4f} without it", score.l1_unscaled));
  line("volume: correlation", score.correlation,
       fmt::format("all moments together; {:.4f} is the mean of each by itself",
                   score.correlation_per_moment));
  line("volume: mass over time", score.mass_curve,
       fmt::format("mean error of its course; {:.4f} without any factor", score.mass_unscaled));
  line("volume: IoU", score.iou,
       fmt::format("{:.2f}% of the mass lies outside the true volumes' box", 100 * score.outside));
}

}  // namespace splinevox::run
