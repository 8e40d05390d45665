// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/vdb/child.hpp"
#include "io/vdb/vdb_file.hpp"

/// What the child process that parses a VDB sends to its parent. Whatever the file made of the child, the
/// readers here give plain values within the limits, or throw std::length_error.
namespace splinevox::vdb_pack {

void put(const Sink& sink, std::uint64_t number);
void put(const Sink& sink, double number);
void put(const Sink& sink, const std::string& text);
void put(const Sink& sink, const VdbMeta& meta);
void put(const Sink& sink, const VdbInfo& info);
/// A grid without its voxels: leaves, values and masks follow, leaf by leaf, as put_leaf has them.
void put_head(const Sink& sink, const VdbGrid& grid, std::uint64_t leaves);
void put_leaf(const Sink& sink, Int3 at, const std::uint64_t* active, const float* values, int width);

class Reader {
 public:
  Reader(const Source& source, const VdbLimits& limits) : source_(source), limits_(limits) {}
  std::uint64_t number(std::uint64_t most);
  double real();
  std::string text();
  VdbMeta meta();
  VdbGrid grid();
  VdbInfo info();

 private:
  std::map<std::string, std::string> texts();
  Int3 int3();
  Vec3d vec3d();

  const Source& source_;
  const VdbLimits& limits_;
  std::uint64_t voxels_ = 0;  ///< so far
};

}  // namespace splinevox::vdb_pack
