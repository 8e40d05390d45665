// SPDX-License-Identifier: Apache-2.0
#include "backend/host/gradient.hpp"

#include <algorithm>
#include <atomic>

#include "core/parallel.hpp"
#include "core/simd.hpp"

#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "built with -ffast-math or -ffinite-math-only: usable() below could no longer see a NaN"
#endif

namespace splinevox {
namespace {

using Eight = Simd<float>::Eight;

bool usable_row(const float* row, int width) {
  auto good = Eight{} == Eight{};  // all set: NaN fails any comparison
  for (int k = 0; k < width; k += 8) {
    const Eight g = load<Eight>(row + k);
    good &= (g < kLargestGradient) & (g > -kLargestGradient);
  }
  for (int lane = 0; lane < 8; ++lane)
    if (!good[lane]) return false;
  return true;
}

}  // namespace

Gradient::Gradient(const Channels& of)
    : values{of.topology, of.width, {}}, touched(of.topology->brick_count() + 1) {
  values.values.assign(of.values.size(), 0.0f);
}

bool usable(const Gradient& gradient, int brick) {
  bool all = true;
  gradient.touched[brick].for_each([&](int i) {
    all &= usable_row(gradient.values.row(std::size_t(brick) * kBrickRows + i), gradient.values.width);
  });
  return all;
}

std::int64_t unusable_rows(const Gradient& gradient) {
  std::atomic<std::int64_t> bad = 0;
  parallel_for(int(gradient.touched.size()), [&](int brick) {
    std::int64_t here = 0;
    gradient.touched[brick].for_each([&](int i) {
      here += !usable_row(gradient.values.row(std::size_t(brick) * kBrickRows + i), gradient.values.width);
    });
    bad += here;
  });
  return bad;
}

void discard(Gradient& gradient) {
  parallel_for(int(gradient.touched.size()), [&](int brick) {
    gradient.touched[brick].for_each([&](int i) {
      std::fill_n(gradient.values.row(std::size_t(brick) * kBrickRows + i), gradient.values.width, 0.0f);
    });
    gradient.touched[brick] = {};
  });
}

}  // namespace splinevox
