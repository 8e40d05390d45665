// SPDX-License-Identifier: Apache-2.0
#include "data/times/seen_moments.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "math/median.hpp"

namespace splinevox {
namespace {

bool has_near(const std::set<double>& times, double time, double reach) {
  const auto next = times.lower_bound(time - reach);
  return next != times.end() && *next <= time + reach;
}

}  // namespace

double interval_of(const std::set<double>& moments) {
  std::vector<double> between;
  for (auto next = std::next(moments.begin()); next != moments.end(); ++next)
    between.push_back(*next - *std::prev(next));
  return median(std::move(between));
}

std::vector<double> shares_of_moments(const std::vector<std::set<double>>& cameras,
                                      const std::set<double>& moments) {
  constexpr double kReach = 0.3;  // of an interval
  std::vector<double> intervals;
  for (const std::set<double>& times : cameras)
    if (times.size() > 1) intervals.push_back(interval_of(times));
  const double reach = intervals.empty() ? 0 : kReach * median(std::move(intervals));
  std::vector<double> out;
  for (const std::set<double>& times : cameras) {
    const auto seen = std::count_if(moments.begin(), moments.end(),
                                    [&](double time) { return has_near(times, time, reach); });
    out.push_back(moments.empty() ? 0 : double(seen) / double(moments.size()));
  }
  return out;
}

std::set<double> scene_moments(const std::vector<std::set<double>>& cameras,
                               const std::set<double>& moments) {
  const std::vector<double> shares = shares_of_moments(cameras, moments);
  const std::set<double>* most = nullptr;
  int lasting = 0;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (shares[c] >= kLastingShare) {
      ++lasting;
      if (!most || cameras[c].size() > most->size()) most = &cameras[c];
    }
  return lasting > 1 ? *most : moments;
}

}  // namespace splinevox
