// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/mapped_file.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

inline constexpr int kMostSplatHarmonics = 16;

/// One Gaussian, activated.
struct Splat {
  Vec3d place{};                       ///< scene units
  Vec3d size{};                        ///< standard deviations along its own axes, > 0
  std::array<double, 4> rotation{};    ///< w x y z, unit length: from its own axes to the scene's
  double opacity = 0;                  ///< in [0, 1]
  int harmonics = 1;                   ///< coefficients: 1, 4, 9 or 16
  Vec3d color[kMostSplatHarmonics]{};  ///< the colour along d is 0.5 + sum_j color_j Y_j(d); files' basis
};

/// A PLY of splats as their trainers write it: binary little-endian, or ASCII, which is read whole.
class SplatFile {
 public:
  /// Reads the header and checks that all splats are there. Throws Error (Fault::input) naming the file: not
  /// there, no PLY, big-endian, compressed or without the properties of splats, truncated.
  explicit SplatFile(const std::string& path);

  std::size_t size() const { return count_; }
  int degree() const { return degree_; }  ///< of the harmonics, 0..3
  /// @return false: the splat has a number that is none, or no direction, and is no splat
  bool read(std::size_t i, Splat& out) const;

 private:
  struct Property {
    int type = 0;
    std::size_t offset = 0;  ///< in a row, bytes
  };
  void read_header(std::string_view bytes);
  void read_text(std::string_view text);
  void find_fields(const std::vector<std::string>& names, const std::vector<Property>& properties);
  double value(const std::uint8_t* row, const Property& property) const;

  std::string path_;
  std::shared_ptr<const MappedFile> file_;
  std::vector<double> numbers_;  ///< of a text, row by row
  const std::uint8_t* rows_ = nullptr;
  std::size_t count_ = 0, stride_ = 0;
  int degree_ = 0;
  bool text_ = false;
  std::vector<Property> fields_;  ///< x y z, opacity, scale, rot, then f_dc and f_rest
};

}  // namespace splinevox
