// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_mesh.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/parallel.hpp"
#include "io/model/exact_text.hpp"
#include "io/vdb/openvdb_grid.hpp"
#include "math/srgb.hpp"

namespace splinevox {
namespace {

constexpr int kVerticesPerTask = 4096;

std::uint8_t byte_of(float v) { return std::uint8_t(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); }

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

ColorMesh make_mesh(const VdbGrid& density, const VdbGrid& color, double isovalue, bool linear) {
  openvdb::initialize();
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  const auto sigma = openvdb::gridPtrCast<openvdb::FloatGrid>(to_openvdb(density));
  openvdb::tools::volumeToMesh(*sigma, points, triangles, quads, isovalue, 0.0);

  ColorMesh mesh;
  mesh.points.resize(points.size());
  mesh.colors.resize(points.size());
  const auto rgb = openvdb::gridPtrCast<openvdb::Vec3SGrid>(to_openvdb(color));
  const int tasks = int((points.size() + kVerticesPerTask - 1) / kVerticesPerTask);
  parallel_for(tasks, [&](int task) {
    const openvdb::Vec3SGrid::ConstAccessor accessor = rgb->getConstAccessor();
    const std::size_t first = std::size_t(task) * kVerticesPerTask;
    for (std::size_t i = first; i < std::min(first + kVerticesPerTask, points.size()); ++i) {
      mesh.points[i] = {points[i].x(), points[i].y(), points[i].z()};
      const auto at = rgb->transform().worldToIndex(openvdb::Vec3d(points[i]));
      const openvdb::Vec3s c = openvdb::tools::BoxSampler::sample(accessor, at);
      for (int a = 0; a < 3; ++a)
        mesh.colors[i][std::size_t(a)] = byte_of(linear ? linear_to_srgb(c[a]) : c[a]);
    }
  });
  mesh.triangles.reserve(triangles.size() + 2 * quads.size());
  // OpenVDB winds its polygons clockwise.
  for (const openvdb::Vec3I& t : triangles) mesh.triangles.push_back({t[0], t[2], t[1]});
  for (const openvdb::Vec4I& q : quads) {
    mesh.triangles.push_back({q[0], q[2], q[1]});
    mesh.triangles.push_back({q[0], q[3], q[2]});
  }
  return mesh;
}

std::string ply_bytes(const ColorMesh& mesh) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment splinevox\nelement vertex " +
      std::to_string(mesh.points.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
      "green\nproperty uchar blue\nelement face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  bytes.reserve(bytes.size() + 15 * mesh.points.size() + 13 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (int a = 0; a < 3; ++a) append(bytes, mesh.points[i][a]);
    append(bytes, mesh.colors[i]);
  }
  for (const auto& triangle : mesh.triangles) {
    bytes += char(3);
    append(bytes, triangle);
  }
  return bytes;
}

std::string obj_text(const ColorMesh& mesh) {
  std::string text = "# splinevox\n";
  text.reserve(60 * mesh.points.size() + 24 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    text += "v";
    for (int a = 0; a < 3; ++a) text += ' ' + exact_text<float>({mesh.points[i][a]});
    for (const std::uint8_t c : mesh.colors[i]) text += ' ' + exact_text<float>({float(c) / 255});
    text += '\n';
  }
  for (const auto& triangle : mesh.triangles) {
    text += "f";
    for (const std::uint32_t v : triangle) text += ' ' + std::to_string(v + 1);
    text += '\n';
  }
  return text;
}

}  // namespace splinevox
