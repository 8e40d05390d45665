// SPDX-License-Identifier: Apache-2.0
#include "data/times/seen_moments.hpp"

#include <algorithm>
#include <iterator>

#include "math/median.hpp"

namespace splinevox {
namespace {

double interval_of(const std::vector<std::set<double>>& cameras) {
  std::vector<double> intervals;
  for (const std::set<double>& times : cameras) {
    std::vector<double> between;
    for (auto t = times.begin(); t != times.end() && std::next(t) != times.end(); ++t)
      between.push_back(*std::next(t) - *t);
    if (!between.empty()) intervals.push_back(median(std::move(between)));
  }
  return intervals.empty() ? 0 : median(std::move(intervals));
}

bool has_near(const std::set<double>& times, double time, double reach) {
  const auto next = times.lower_bound(time - reach);
  return next != times.end() && *next <= time + reach;
}

}  // namespace

std::vector<double> shares_of_moments(const std::vector<std::set<double>>& cameras,
                                      const std::set<double>& moments) {
  constexpr double kReach = 0.3;  // of an interval
  const double reach = kReach * interval_of(cameras);
  std::vector<double> out;
  for (const std::set<double>& times : cameras) {
    const auto seen = std::count_if(moments.begin(), moments.end(),
                                    [&](double time) { return has_near(times, time, reach); });
    out.push_back(moments.empty() ? 0 : double(seen) / double(moments.size()));
  }
  return out;
}

std::size_t count_moments(const std::vector<std::set<double>>& cameras, const std::set<double>& moments) {
  const std::vector<double> shares = shares_of_moments(cameras, moments);
  std::size_t most = 0, lasting = 0;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (shares[c] >= kLastingShare) {
      ++lasting;
      most = std::max(most, cameras[c].size());
    }
  return lasting > 1 ? most : moments.size();
}

}  // namespace splinevox
