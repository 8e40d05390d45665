// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <functional>

#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

/// The same few cameras written in the layout of every program, each by formulas of its own, independent of
/// the readers'.
namespace splinevox::test {

constexpr int kWide = 12, kHigh = 8, kCameras = 16;

/// A lens as OpenCV knows it.
struct TrueLens {
  double fx = 11, fy = 11, cx = 6, cy = 4;
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0, p1 = 0, p2 = 0;
  bool fisheye = false;
  int wide = kWide, high = kHigh;  ///< pixels
};
const TrueLens kBent{11, 12, 5.5, 4.25, -0.12, 0.03, -0.004, 0, 0.002, -0.003};  ///< in every way
constexpr double kPixel = 1e-6;  ///< how far a reader's camera may be off, pixels

inline const Frame& first_frame(const Dataset& data) { return data.find("train")->frames[0]; }

/// A camera and what it must show of a world point.
struct TrueCamera {
  std::array<double, 16> to_world{};  ///< OpenGL axes
  TrueLens lens{};
  double time = 0;

  double world(int row, int column) const { return to_world[std::size_t(4 * row + column)]; }
  /// In pixels; no better than a few rounding errors of a picture's width.
  std::array<double, 2> see(const std::array<double, 3>& point) const {
    double c[3] = {};  // right, down, forwards
    for (int axis = 0; axis < 3; ++axis)
      for (int row = 0; row < 3; ++row)
        c[axis] += (axis == 0 ? 1 : -1) * world(row, axis) * (point[std::size_t(row)] - world(row, 3));
    double x = c[0] / c[2], y = c[1] / c[2];
    const double r = std::hypot(x, y);
    if (lens.fisheye) {
      const double a = std::atan(r), bent = a + lens.k1 * std::pow(a, 3) + lens.k2 * std::pow(a, 5) +
                                            lens.k3 * std::pow(a, 7) + lens.k4 * std::pow(a, 9);
      x *= bent / r;
      y *= bent / r;
    } else {
      const double f = 1 + lens.k1 * std::pow(r, 2) + lens.k2 * std::pow(r, 4) + lens.k3 * std::pow(r, 6) +
                       lens.k4 * std::pow(r, 8);
      const double u = x * f + 2 * lens.p1 * x * y + lens.p2 * (r * r + 2 * x * x),
                   v = y * f + lens.p1 * (r * r + 2 * y * y) + 2 * lens.p2 * x * y;
      x = u;
      y = v;
    }
    return {lens.cx + lens.fx * x, lens.cy + lens.fy * y};
  }
};

/// Cameras round the origin, at times 0, 1, 2, ...
inline std::vector<TrueCamera> true_cameras(const TrueLens& lens = {}, int count = kCameras) {
  std::vector<TrueCamera> cameras;
  for (int i = 0; i < count; ++i) cameras.push_back({orbit_matrix(0.37 * i), lens, double(i)});
  return cameras;
}

inline std::string exactly(double value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

inline std::string padded(int i) { return (i < 10 ? "000" : "00") + std::to_string(i); }

template <class T>
void append(Bytes& out, T value) {
  std::uint8_t bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.insert(out.end(), bytes, bytes + sizeof(T));
}

/// A table as numpy.save writes it.
inline Bytes npy_bytes(std::size_t rows, std::size_t columns, const std::vector<double>& values,
                       const std::string& kind = "<f8") {
  std::string header = "{'descr': '" + kind + "', 'fortran_order': False, 'shape': (" + std::to_string(rows) +
                       ", " + std::to_string(columns) + "), }";
  while ((header.size() + 11) % 64 != 0) header += ' ';
  header += '\n';
  Bytes out{0x93,
            'N',
            'U',
            'M',
            'P',
            'Y',
            1,
            0,
            std::uint8_t(header.size() & 255),
            std::uint8_t(header.size() >> 8)};
  for (const char c : header) out.push_back(std::uint8_t(c));
  for (const double v : values)
    if (kind == "<f8")
      append(out, v);
    else
      append(out, float(v));
  return out;
}

using Cameras = std::vector<TrueCamera>;
namespace fs = std::filesystem;

inline void write_pictures(const fs::path& folder, int count, const std::string& stem = "frame_") {
  for (int i = 0; i < count; ++i)
    write_png(folder / (stem + padded(i) + ".png"),
              flat_png(kWide, kHigh, {std::uint8_t(10 * i), 80, 90, 255}));
}

inline std::string lens_fields(const TrueLens& l) {
  std::string text = "\"fl_x\": " + exactly(l.fx) + ", \"fl_y\": " + exactly(l.fy) +
                     ", \"cx\": " + exactly(l.cx) + ", \"cy\": " + exactly(l.cy) +
                     ", \"w\": " + std::to_string(l.wide) + ", \"h\": " + std::to_string(l.high) +
                     ", \"k1\": " + exactly(l.k1) + ", \"k2\": " + exactly(l.k2) +
                     ", \"k3\": " + exactly(l.k3) + ", \"k4\": " + exactly(l.k4);
  return text + (l.fisheye ? ", \"camera_model\": \"OPENCV_FISHEYE\","
                           : ", \"p1\": " + exactly(l.p1) + ", \"p2\": " + exactly(l.p2) +
                                 ", \"camera_model\": \"OPENCV\",");
}

/// One file; every frame its own lens.
/// @param fields  further ones of the file, each with a comma after it
inline void write_nerfstudio_with(const fs::path& folder, const Cameras& cameras, const std::string& fields) {
  write_pictures(folder / "images", int(cameras.size()));
  std::vector<std::string> frames;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    std::string frame = frame_text("images/frame_" + padded(int(i)) + ".png", exactly(cameras[i].time),
                                   matrix_text(cameras[i].to_world));
    frames.push_back(frame.insert(1, lens_fields(cameras[i].lens)));
  }
  write_text(
      folder / "transforms.json",
      transforms_text(
          frames, "\"applied_transform\": [[0,1,0,0],[1,0,0,0],[0,0,-1,0]], \"aabb_scale\": 16," + fields));
}

inline void write_nerfstudio(const fs::path& folder, const Cameras& cameras) {
  write_nerfstudio_with(folder, cameras, "");
}

/// Cameras of a film: one a moment, from 0 to 1.
inline Cameras film_cameras(int count) {
  Cameras cameras = true_cameras({}, count);
  for (int i = 0; i < count; ++i) cameras[std::size_t(i)].time = double(i) / (count - 1);
  return cameras;
}

inline void write_gibson(const fs::path& folder, const Cameras& cameras) {
  write_pictures(folder / "train", int(cameras.size()));
  std::vector<std::string> frames;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    std::array<double, 16> seen{};  // world to camera: the rotation transposed
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        seen[std::size_t(4 * r + c)] = cameras[i].world(c, r);
        seen[std::size_t(4 * r + 3)] -= cameras[i].world(c, r) * cameras[i].world(c, 3);
      }
    seen[15] = 1;
    std::string frame = frame_text("train/frame_" + padded(int(i)) + ".png", "", matrix_text(seen));
    frames.push_back(frame.insert(1, "\"timestep\": " + exactly(3 * cameras[i].time) + ", "));
  }
  const double degrees = 2 * std::atan(0.5 * kWide / cameras[0].lens.fx) * 180 / 3.14159265358979323846;
  write_text(folder / "transform_train.json",
             transforms_text(frames, "\"camera_angle_x\": " + exactly(degrees) + ","));
}

/// Rotation as a quaternion, of world to OpenCV camera.
inline std::array<double, 4> quaternion_of(const TrueCamera& c) {
  double m[3][3];
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k) m[r][k] = (r == 0 ? 1 : -1) * c.world(k, r);
  double q[4] = {1 + m[0][0] + m[1][1] + m[2][2], 1 + m[0][0] - m[1][1] - m[2][2],
                 1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2]};
  const int big = int(std::max_element(q, q + 4) - q);
  const double s = 0.5 / std::sqrt(q[big]);
  const double wx = m[2][1] - m[1][2], wy = m[0][2] - m[2][0], wz = m[1][0] - m[0][1], xy = m[0][1] + m[1][0],
               xz = m[0][2] + m[2][0], yz = m[1][2] + m[2][1];
  const double table[4][4] = {{q[0], wx, wy, wz}, {wx, q[1], xy, xz}, {wy, xy, q[2], yz}, {wz, xz, yz, q[3]}};
  return {s * table[big][0], s * table[big][1], s * table[big][2], s * table[big][3]};
}

inline std::array<double, 3> translation_of(const TrueCamera& c) {
  std::array<double, 3> t{};
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k) t[std::size_t(r)] -= (r == 0 ? 1 : -1) * c.world(k, r) * c.world(k, 3);
  return t;
}

/// A model's name, number and parameters, and how names of its pictures begin.
struct ColmapLens {
  std::string name;
  int id;
  std::vector<double> params;
  std::string stem = "frame_";
};

inline void write_colmap_text(const fs::path& folder, const Cameras& cameras, const ColmapLens& lens) {
  write_pictures(folder / "images", int(cameras.size()), lens.stem);
  std::string list = "# Camera list\n1 " + lens.name + " 12 8", images = "# Image list\n";
  for (const double p : lens.params) list.append(" ").append(exactly(p));
  for (int i = int(cameras.size()) - 1; i >= 0; --i) {  // COLMAP's order is that of registration
    images += std::to_string(i + 1);
    for (const double v : quaternion_of(cameras[std::size_t(i)])) images.append(" ").append(exactly(v));
    for (const double v : translation_of(cameras[std::size_t(i)])) images.append(" ").append(exactly(v));
    images += " 1 " + lens.stem + padded(i) + ".png\n" + (i % 2 ? "1.5 2.5 -1 3 4 7\n" : "\n");
  }
  std::string points = "# 3D point list\n";
  for (int i = 0; i < 20; ++i)
    points += std::to_string(i) + " " + exactly(0.1 * i - 1) + " " + exactly(0.05 * i) + " " +
              exactly(1 - 0.1 * i) + " 1 2 3 0.5 1 2\n";
  write_text(folder / "sparse/0/cameras.txt", list + "\n");
  write_text(folder / "sparse/0/images.txt", images);
  write_text(folder / "sparse/0/points3D.txt", points);
}

inline void write_colmap_binary(const fs::path& folder, const Cameras& cameras, const ColmapLens& lens) {
  write_pictures(folder / "images", int(cameras.size()), lens.stem);
  Bytes list, images, points;
  append(list, std::uint64_t(1));
  append(list, std::uint32_t(1));
  append(list, std::int32_t(lens.id));
  append(list, std::uint64_t(kWide));
  append(list, std::uint64_t(kHigh));
  for (const double p : lens.params) append(list, p);
  append(images, std::uint64_t(cameras.size()));
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    append(images, std::uint32_t(i + 1));
    for (const double v : quaternion_of(cameras[i])) append(images, v);
    for (const double v : translation_of(cameras[i])) append(images, v);
    append(images, std::uint32_t(1));
    const std::string name = lens.stem + padded(int(i)) + ".png";
    images.insert(images.end(), name.begin(), name.end());
    images.push_back(0);
    append(images, std::uint64_t(i % 3));
    for (std::size_t k = 0; k < i % 3; ++k) {
      append(images, 1.5);
      append(images, 2.5);
      append(images, std::uint64_t(7));
    }
  }
  append(points, std::uint64_t(20));
  for (int i = 0; i < 20; ++i) {
    append(points, std::uint64_t(i));
    append(points, 0.1 * i - 1);
    append(points, 0.05 * i);
    append(points, 1 - 0.1 * i);
    for (int k = 0; k < 3; ++k) points.push_back(9);
    append(points, 0.5);
    append(points, std::uint64_t(1));
    append(points, std::uint32_t(1));
    append(points, std::uint32_t(2));
  }
  write_bytes(folder / "sparse/0/cameras.bin", list);
  write_bytes(folder / "sparse/0/images.bin", images);
  write_bytes(folder / "sparse/0/points3D.bin", points);
}

/// The pictures are half as large as the cameras say, the world is 4 times as large and shifted by (1, 2, 3).
inline void write_nerfies(const fs::path& folder, const Cameras& cameras) {
  write_pictures(folder / "rgb/2x", int(cameras.size()), "000_");
  std::string train, val, meta;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string id = "000_" + padded(int(i));
    const TrueCamera& c = cameras[i];
    const TrueLens& l = c.lens;
    std::string& list = i % 5 == 2 ? val : train;
    list += (list.empty() ? "\"" : ", \"") + id + "\"";
    meta += (i ? ", \"" : "\"") + id + "\": {\"warp_id\": " + std::to_string(i) +
            ", \"appearance_id\": 0, \"camera_id\": 0}";
    std::string orientation;
    for (int r = 0; r < 3; ++r) {
      orientation += r ? ", [" : "[";
      for (int k = 0; k < 3; ++k) orientation += (k ? ", " : "") + exactly((r == 0 ? 1 : -1) * c.world(k, r));
      orientation += "]";
    }
    write_text(folder / "camera" / (id + ".json"),
               "{\"orientation\": [" + orientation + "], \"position\": [" + exactly(4 * c.world(0, 3) + 1) +
                   ", " + exactly(4 * c.world(1, 3) + 2) + ", " + exactly(4 * c.world(2, 3) + 3) +
                   "], \"focal_length\": " + exactly(2 * l.fx) + ", \"principal_point\": [" +
                   exactly(2 * l.cx) + ", " + exactly(2 * l.cy) +
                   "], \"skew\": 0.0, \"pixel_aspect_ratio\": " + exactly(l.fy / l.fx) +
                   ", \"radial_distortion\": [" + exactly(l.k1) + ", " + exactly(l.k2) + ", " +
                   exactly(l.k3) + "], \"tangential_distortion\": [" + exactly(l.p1) + ", " + exactly(l.p2) +
                   "], \"image_size\": [24, 16]}");
  }
  write_text(folder / "dataset.json",
             "{\"count\": 16, \"train_ids\": [" + train + "], \"val_ids\": [" + val + "]}");
  write_text(folder / "metadata.json", "{" + meta + "}");
  write_text(folder / "scene.json", "{\"scale\": 0.25, \"center\": [1, 2, 3], \"near\": 1.5, \"far\": 5}");
}

/// Rows of 17 numbers; the rotation's columns point down, right and back.
inline std::vector<double> llff_rows(const Cameras& cameras, double picture_scale = 1) {
  std::vector<double> rows;
  for (const TrueCamera& c : cameras) {
    const double hwf[3] = {picture_scale * kHigh, picture_scale * kWide, picture_scale * c.lens.fx};
    for (int r = 0; r < 3; ++r)
      for (const double v : {-c.world(r, 1), c.world(r, 0), c.world(r, 2), c.world(r, 3), hwf[r]})
        rows.push_back(v);
    rows.push_back(1.5);
    rows.push_back(5);
  }
  return rows;
}

/// The pictures are a quarter as large as the cameras say.
inline void write_llff(const fs::path& folder, const Cameras& cameras) {
  write_pictures(folder / "images_4", int(cameras.size()));
  write_bytes(folder / "poses_bounds.npy", npy_bytes(cameras.size(), 17, llff_rows(cameras, 4)));
}

inline void write_nrnerf(const fs::path& folder, const Cameras& cameras) {
  write_pictures(folder / "images", int(cameras.size()), "image");
  std::string poses, bounds;
  for (const TrueCamera& c : cameras) {
    const double hwf[3] = {double(kHigh), double(kWide), c.lens.fx};
    poses += poses.empty() ? "[" : ", [";
    for (int r = 0; r < 3; ++r) {
      poses += r ? ", [" : "[";
      for (int k = 0; k < 4; ++k) poses += exactly(c.world(r, k)) + ", ";
      poses += exactly(hwf[r]) + "]";
    }
    poses += "]";
    bounds += bounds.empty() ? "[1.5, 5]" : ", [1.5, 5]";
  }
  write_text(folder / "precomputed.json",
             "{\"poses\": [" + poses + "], \"bds\": [" + bounds + "], \"i_test\": 3}");
}

}  // namespace splinevox::test
