// SPDX-License-Identifier: Apache-2.0
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

#include "splinevox/math/metrics.hpp"

namespace splinevox {

PairedGain paired_gain(std::span<const double> differences, double level) {
  PairedGain out;
  out.count = int(differences.size());
  for (const double d : differences) out.mean += d / out.count;
  constexpr double inf = std::numeric_limits<double>::infinity();
  if (out.count < 2) {
    out.lo = -inf;
    out.hi = inf;
    return out;
  }
  double squares = 0;
  for (const double d : differences) squares += (d - out.mean) * (d - out.mean);
  const double error = std::sqrt(squares / (out.count - 1) / out.count);  // of the mean
  if (error == 0) {
    out.lo = out.hi = out.mean;
    out.p = out.mean > 0 ? 0 : 1;
    return out;
  }
  const boost::math::students_t t(out.count - 1);
  const double reach = quantile(complement(t, level)) * error;
  out.lo = out.mean - reach;
  out.hi = out.mean + reach;
  out.p = cdf(complement(t, out.mean / error));
  return out;
}

}  // namespace splinevox
