// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <vector>

namespace splinevox {

/// Median time between moments. @pre two or more
double interval_of(const std::set<double>& moments);

/// The share of a scene's moments that each camera saw, in [0, 1]. Films of one rig have time stamps of their
/// own, so a camera saw a moment if it took a picture within three tenths of an interval of it. The interval
/// is that between two pictures of a camera, the median over each and over all. Where stamps are equal, that
/// is nothing but the pictures it took. Cameras that take turns see three quarters at most.
/// @param cameras  when each took pictures, in any unit  @param moments  when any did
std::vector<double> shares_of_moments(const std::vector<std::set<double>>& cameras,
                                      const std::set<double>& moments);

/// Of all moments the share that a camera must see to count as one that was on all the time.
inline constexpr double kLastingShare = 0.9;

/// The moments of a scene: where several cameras were on all the time, those of the one with the most
/// pictures, else all.
std::set<double> scene_moments(const std::vector<std::set<double>>& cameras, const std::set<double>& moments);

}  // namespace splinevox
