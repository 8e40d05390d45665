// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "splinevox/core/image.hpp"
#include "splinevox/core/pixel_mask.hpp"

namespace splinevox {

// Quality of picture `a` against picture `b`. All take values with data range 1, are symmetric in their
// arguments, compute in double, and throw Error (Fault::input) when the pictures are empty or their shapes
// differ. A non-finite pixel makes the result non-finite; it is never hidden.

/// Decibels that stand for "identical" wherever PSNRs are averaged.
inline constexpr double kPsnrCap = 100.0;

/// Mean of (a - b)^2 over all pixels and channels.
double mean_squared_error(const Image& a, const Image& b);

/// -10 log10(mse) for data range 1; +infinity at mse = 0.
double psnr_from_mse(double mse);

/// Peak signal to noise ratio in decibels; +infinity for identical pictures.
double psnr(const Image& a, const Image& b);

/// min(db, kPsnrCap): what may be averaged or written to JSON. NaN stays NaN.
double capped_psnr(double db);

/// Mean of capped_psnr over the values; NaN for none.
double mean_psnr(std::span<const double> db);

/// Structural similarity (Wang et al. 2004): Gaussian window of 11x11, sigma 1.5, K1 = 0.01, K2 = 0.03; the
/// mean over the valid region (windows entirely inside) and over channels. Each channel's own mean is taken
/// out before the windowed moments, so flat regions do not cancel.
///
/// A picture smaller than the window gets the largest odd window that fits, same sigma, weights summing to 1;
/// for a side of 1 pixel that window is 1x1 and only the luminance term remains.
double ssim(const Image& a, const Image& b);

/// Multi-scale SSIM (Wang et al. 2003).
struct MsSsim {
  double value = 0;
  int scales = 5;        ///< how many were used
  bool clamped = false;  ///< a negative factor was raised to 0 (a power of it would not be a number)
};

/// Up to five scales, weights .0448 .2856 .3001 .2363 .1333, 2x2 average pooling between them (a last odd row
/// or column is dropped); per channel the product over scales, then the mean over channels.
///
/// Five scales need 176 pixels on the shorter side. A smaller picture uses as many scales as keep an 11x11
/// window inside, at least one, with their weights renormalised to sum 1; below 11 pixels it is ssim().
MsSsim ms_ssim_detail(const Image& a, const Image& b);

/// The value alone.
double ms_ssim(const Image& a, const Image& b);

/// The same without the pixels of a mask, which has none or is of the pictures' size. The structural ones
/// take only windows that meet no such pixel; at a coarser scale a pixel is left out if any of its four is.
/// Scales without a window left are left out, their weights with them. NaN where nothing is left.
/// @{
double psnr(const Image& a, const Image& b, const PixelMask& without);
double ssim(const Image& a, const Image& b, const PixelMask& without);
double ms_ssim(const Image& a, const Image& b, const PixelMask& without);
/// @}

/// What one treatment gains over another on the same units (here: held-out pictures), with what is known
/// about it.
struct PairedGain {
  double mean = 0;        ///< of the differences
  double lo = 0, hi = 0;  ///< one-sided bounds of the true mean, each at the level asked for
  double p = 1;           ///< chance of a mean at least this large if the true one is at most zero
  int count = 0;          ///< differences
};

/// Student's t on the differences. Fewer than two, or all equal, tell nothing of their spread: the bounds are
/// then infinite and p is 1 for fewer than two; for equal ones the bounds are the mean itself.
/// @param level  chance that a bound is on the wrong side, in (0, 0.5).
PairedGain paired_gain(std::span<const double> differences, double level);

}  // namespace splinevox
