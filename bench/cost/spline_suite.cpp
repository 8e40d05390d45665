// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "suites.hpp"
#include "timing.hpp"

namespace splinevox::cost {
namespace {

constexpr int kMost = 64;  ///< control points
constexpr int kCurves = 4096;
constexpr int kTimes = 16;  ///< equally spaced, for all curves

/// Curves of one length: structure of arrays would favour the shared weights, so points lie as the motion
/// rows do.
struct Curves {
  int points;
  std::vector<float> p;  ///< [kCurves][points][3]
  const float* curve(int c) const { return p.data() + std::size_t(c) * points * 3; }
};

Curves make_curves(int points) {
  Curves out{points, std::vector<float>(std::size_t(kCurves) * points * 3)};
  std::mt19937 random{unsigned(points)};
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (float& v : out.p) v = uniform(random);
  return out;
}

/// Times that floats hold too, so that no method starts from another time than the reference.
double time_of(int i) { return (i + 0.375) / kTimes; }

template <class T>
void casteljau(const float* p, int points, T t, T* out) {
  T b[kMost][3];
  for (int k = 0; k < points; ++k)
    for (int a = 0; a < 3; ++a) b[k][a] = T(p[3 * k + a]);
  for (int n = points - 1; n > 0; --n)
    for (int k = 0; k < n; ++k)
      for (int a = 0; a < 3; ++a) b[k][a] = (T(1) - t) * b[k][a] + t * b[k + 1][a];
  for (int a = 0; a < 3; ++a) out[a] = b[0][a];
}

/// As math/bernstein.hpp, for more points than a model may have.
template <class T>
void weights(int points, T t, T* w) {
  std::fill_n(w, points, T(0));
  w[0] = T(1);
  for (int degree = 1; degree < points; ++degree) {
    for (int k = degree; k > 0; --k) w[k] = (T(1) - t) * w[k] + t * w[k - 1];
    w[0] = (T(1) - t) * w[0];
  }
}

void weigh(const float* p, int points, const float* w, float* out) {
  float sum[3] = {};
  for (int k = 0; k < points; ++k)
    for (int a = 0; a < 3; ++a) sum[a] += w[k] * p[3 * k + a];
  for (int a = 0; a < 3; ++a) out[a] = sum[a];
}

/// Nested multiplication of sum_k C(n, k) t^k (1 - t)^(n - k) p_k: powers of t go along, (1 - t) is
/// multiplied in from outside.
void horner(const float* p, int points, float t, float* out) {
  const int n = points - 1;
  const float s = 1 - t;
  float power = 1, choose = 1, sum[3];
  for (int a = 0; a < 3; ++a) sum[a] = p[a] * s;
  for (int k = 1; k < n; ++k) {
    power *= t;
    choose = choose * float(n - k + 1) / float(k);
    for (int a = 0; a < 3; ++a) sum[a] = (sum[a] + power * choose * p[3 * k + a]) * s;
  }
  for (int a = 0; a < 3; ++a) out[a] = n > 0 ? sum[a] + power * t * p[3 * n + a] : p[a];
}

struct Method {
  const char* name;
  bool shared;                                                  ///< recommended: what the renderer does
  std::function<void(const Curves&, std::vector<float>&)> run;  ///< out[kTimes][kCurves][3]
};

template <class Each>
void every(const Curves& c, std::vector<float>& out, Each&& each) {
  for (int i = 0; i < kTimes; ++i)
    for (int k = 0; k < kCurves; ++k) each(i, c.curve(k), out.data() + (std::size_t(i) * kCurves + k) * 3);
}

/// Differences of each curve at the first times, then one addition per degree and time: fast, and errors pile
/// up.
void forward_differences(const Curves& c, std::vector<float>& out) {
  const int n = c.points;
  for (int k = 0; k < kCurves; ++k) {
    float d[kMost][3];
    for (int i = 0; i < n; ++i) casteljau<float>(c.curve(k), n, float(time_of(i)), d[i]);
    for (int level = 1; level < n; ++level)
      for (int i = n - 1; i >= level; --i)
        for (int a = 0; a < 3; ++a) d[i][a] -= d[i - 1][a];
    for (int i = 0; i < kTimes; ++i) {
      for (int a = 0; a < 3; ++a) out[(std::size_t(i) * kCurves + k) * 3 + a] = d[0][a];
      for (int level = 0; level + 1 < n; ++level)
        for (int a = 0; a < 3; ++a) d[level][a] += d[level + 1][a];
    }
  }
}

const std::vector<Method>& methods() {
  static const std::vector<Method> list = {
      {"weights shared by all curves of a time, from double", true,
       [](const Curves& c, std::vector<float>& out) {
         for (int i = 0; i < kTimes; ++i) {
           double exact[kMost];
           float w[kMost];
           weights(c.points, time_of(i), exact);
           for (int k = 0; k < c.points; ++k) w[k] = float(exact[k]);
           for (int k = 0; k < kCurves; ++k)
             weigh(c.curve(k), c.points, w, out.data() + (std::size_t(i) * kCurves + k) * 3);
         }
       }},
      {"Bernstein weights per curve", false,
       [](const Curves& c, std::vector<float>& out) {
         every(c, out, [&](int i, const float* p, float* x) {
           float w[kMost];
           weights(c.points, float(time_of(i)), w);
           weigh(p, c.points, w, x);
         });
       }},
      {"De Casteljau", false,
       [](const Curves& c, std::vector<float>& out) {
         every(c, out,
               [&](int i, const float* p, float* x) { casteljau<float>(p, c.points, float(time_of(i)), x); });
       }},
      {"Horner", false,
       [](const Curves& c, std::vector<float>& out) {
         every(c, out, [&](int i, const float* p, float* x) { horner(p, c.points, float(time_of(i)), x); });
       }},
      {"forward differences", false,
       forward_differences},  // last: left out for curves of more points than there are times
  };
  return list;
}

/// Largest error in units of float rounding (2^-24) of the largest coordinate, which is 1.
double error_of(const Curves& c, const std::vector<float>& out) {
  double worst = 0;
  for (int i = 0; i < kTimes; ++i)
    for (int k = 0; k < kCurves; k += 16) {
      long double exact[3];
      casteljau<long double>(c.curve(k), c.points, (long double)time_of(i), exact);
      for (int a = 0; a < 3; ++a)
        worst = std::max(
            worst, double(std::fabs(exact[a] - (long double)out[(std::size_t(i) * kCurves + k) * 3 + a])));
    }
  return worst * 0x1p24;
}

}  // namespace

void spline_suite(const SuiteOptions& o, const OnRecord& on_record) {
  const std::vector<int> lengths = o.micro ? std::vector{4, 12} : std::vector{2, 4, 5, 8, 12, 16, 32, 64};
  for (const int points : lengths) {
    const Curves curves = make_curves(points);
    const std::size_t count = methods().size() - (points > kTimes);
    std::vector<Candidate> candidates;
    std::vector<std::vector<float>> outs(count, std::vector<float>(std::size_t(kTimes) * kCurves * 3));
    for (std::size_t m = 0; m < count; ++m)
      candidates.push_back({methods()[m].name, [&, m] { methods()[m].run(curves, outs[m]); }});
    candidates.push_back({"A/A", candidates[0].run});
    const std::vector<Timed> timed = interleave(candidates, o.micro ? 5 : o.rounds);
    constexpr double kEach = double(kTimes) * kCurves;
    for (std::size_t m = 0; m < candidates.size(); ++m) {
      const bool again = m == count;
      const double error = error_of(curves, outs[again ? 0 : m]);
      const auto each = [&](double v) { return v / kEach; };
      Record r;
      r.suite = "spline";
      r.scene = fmt::format("{} points", points);
      r.knob = again ? "A/A" : "method";
      r.value = candidates[m].name;
      r.order = double(m);
      r.error = {error, error, error};
      r.seconds = {each(timed[m].seconds.value), each(timed[m].seconds.lo), each(timed[m].seconds.hi)};
      r.instructions = each(timed[m].instructions);
      r.runs = o.micro ? 5 : o.rounds;
      r.is_default = !again && methods()[m].shared;
      r.failed = !std::isfinite(error);
      if (again)
        r.note = fmt::format("the default against itself: {:.3f} [{:.3f}, {:.3f}] times",
                             timed[m].ratio.value, timed[m].ratio.lo, timed[m].ratio.hi);
      on_record(r);
    }
  }
}

}  // namespace splinevox::cost
