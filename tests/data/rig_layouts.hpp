// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

#include "data/layouts.hpp"

/// Rigs of cameras that stand still, in the layout of every program, each by formulas of its own.
namespace splinevox::test {

/// The picture that camera c takes at moment k.
inline TinyPng rig_picture(int c, int k) {
  return flat_png(kWide, kHigh, {std::uint8_t(10 * c), std::uint8_t(20 * k), 90, 255});
}

inline std::string numbered(const std::string& stem, int i) {
  return stem + (i < 10 ? "0" : "") + std::to_string(i);
}

/// Cameras round the origin, each with a focal length of its own.
inline Cameras rig_cameras(int count, TrueLens lens = {}) {
  Cameras cameras;
  for (int c = 0; c < count; ++c) {
    cameras.push_back({orbit_matrix(0.3 * c), lens, 0});
    cameras.back().lens.fx += 0.1 * c;
    cameras.back().lens.fy = lens.fy + 0.1 * c;
  }
  return cameras;
}

inline std::string world_to_camera_text(const TrueCamera& c) {
  std::array<double, 16> m{};
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) m[std::size_t(4 * r + k)] = (r == 0 ? 1 : -1) * c.world(k, r);
    m[std::size_t(4 * r + 3)] = translation_of(c)[std::size_t(r)];
  }
  m[15] = 1;
  return matrix_text(m);
}

/// One file of Dynamic 3D Gaussians: the cameras from `first` to before `last`; pictures and masks of all.
inline void write_gaussians_file(const fs::path& folder, const std::string& split, const Cameras& cameras,
                                 int first, int last, int moments) {
  std::string k, w2c, fn, ids;
  for (int t = 0; t < moments; ++t) {
    for (std::string* table : {&k, &w2c, &fn, &ids}) *table += t ? ",\n[" : "[";
    for (int c = first; c < last; ++c) {
      const TrueCamera& camera = cameras[std::size_t(c)];
      const TrueLens& l = camera.lens;
      const std::string comma = c > first ? ", " : "", file = std::to_string(c) + "/" + padded(t);
      k += comma + "[[" + exactly(l.fx) + ", 0, " + exactly(l.cx) + "], [0, " + exactly(l.fy) + ", " +
           exactly(l.cy) + "], [0, 0, 1]]";
      w2c += comma + world_to_camera_text(camera);
      fn += comma + "\"" + file + ".png\"";
      ids += comma + std::to_string(c);
      write_png(folder / "ims" / (file + ".png"), rig_picture(c, t));
      write_png(folder / "seg" / (file + ".png"), flat_png(kWide, kHigh, {1, 1, 1, 255}));
    }
    for (std::string* table : {&k, &w2c, &fn, &ids}) *table += "]";
  }
  write_text(folder / (split + "_meta.json"), "{\"w\": 12, \"h\": 8,\n\"k\": [" + k + "],\n\"w2c\": [" + w2c +
                                                  "],\n\"fn\": [" + fn + "],\n\"cam_id\": [" + ids + "]}");
}

/// All cameras but the last two train, those test.
inline void write_gaussians(const fs::path& folder, const Cameras& cameras, int moments = 4) {
  const int n = int(cameras.size());
  write_gaussians_file(folder, "train", cameras, 0, n - 2, moments);
  write_gaussians_file(folder, "test", cameras, n - 2, n, moments);
}

inline bool has_ffmpeg() { return std::system("ffmpeg -version > /dev/null 2>&1") == 0; }

/// A film of one colour. @return whether it could be made
inline bool write_film(const fs::path& path, int frames, const std::string& colour = "blue",
                       const std::string& more = "") {
  fs::create_directories(path.parent_path());
  return std::system(("ffmpeg -v error -y -f lavfi -i color=c=" + colour + ":s=12x8:r=5 -frames:v " +
                      std::to_string(frames) + " -pix_fmt yuv420p " + more + " " + path.string())
                         .c_str()) == 0;
}

/// A film's entry of PINF's info.json: the angle of view alone, so lenses are plain. `poses` holds its matrix
/// or its list of them.
inline std::string pinf_film(const std::string& name, int frames, double fx, const std::string& poses) {
  return "{\"file_name\": \"" + name + "\", \"frame_rate\": 5, \"frame_num\": " + std::to_string(frames) +
         ", \"camera_angle_x\": " + exactly(2 * std::atan(0.5 * kWide / fx)) +
         ", \"camera_hw\": [80, 120], " + poses + "}";
}

/// The last camera is the test film's and turns; all films have `frames` frames, of which one less is used.
inline void write_pinf(const fs::path& folder, const Cameras& cameras, int frames = 5) {
  std::string train;
  for (std::size_t c = 0; c + 1 < cameras.size(); ++c) {
    const std::string name = numbered("train", int(c)) + ".mp4";
    train += (c ? ", " : "") + pinf_film(name, frames - 1, cameras[c].lens.fx,
                                         "\"transform_matrix\": " + matrix_text(cameras[c].to_world));
    if (!fs::exists(folder / name)) write_film(folder / name, frames);
  }
  std::string list;
  for (int k = 0; k + 1 < frames; ++k) list += (k ? ", " : "") + matrix_text(orbit_matrix(2 + 0.1 * k));
  const std::string test = pinf_film("test00.mp4", frames - 1, cameras.back().lens.fx,
                                     "\"transform_matrix_list\": [" + list + "]");
  write_film(folder / "test00.mp4", frames, "red");
  write_text(folder / "info.json",
             "{\"train_videos\": [" + train + "], \"test_videos\": [" + test +
                 "], \"frame_bkg_color\": [0, 0, 0], \"voxel_scale\": [1, 2, 4], \"voxel_matrix\": "
                 "[[0, 0, 1, 0.5], [0, 1, 0, -0.5], [-1, 0, 0, 0.25], [0, 0, 0, 1]], \"near\": 1.1}");
}

inline std::string storage_matrix(const std::string& key, int rows, int columns,
                                  const std::vector<double>& values) {
  std::string text = key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
                     "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ ";
  for (std::size_t i = 0; i < values.size(); ++i)
    text += (i == 0 ? "" : i % 3 == 0 ? ",\n       " : ", ") + exactly(values[i]);
  return text + " ]\n";
}

/// A camera's rotation as an axis as long as its angle.
inline std::vector<double> axis_of(const TrueCamera& c) {
  const auto q = quaternion_of(c);
  const double s = std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), angle = 2 * std::atan2(s, q[0]);
  return {angle * q[1] / s, angle * q[2] / s, angle * q[3] / s};
}

/// Cameras "00", "01" ...: even ones have R alone, odd ones Rot too. Pictures in images, masks in mask. The
/// centre of a picture's first pixel is at (0, 0), as OpenCV calibrates.
inline void write_easymocap(const fs::path& folder, const Cameras& cameras, int moments = 4) {
  std::string intri = "%YAML:1.0\n---\nnames:\n", extri = intri;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const std::string line = "  - \"" + numbered("", int(c)) + "\"\n";
    intri += line;
    extri += line;
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const TrueCamera& camera = cameras[c];
    const TrueLens& l = camera.lens;
    const std::string name = numbered("", int(c));
    intri += storage_matrix("K_" + name, 3, 3, {l.fx, 0, l.cx - 0.5, 0, l.fy, l.cy - 0.5, 0, 0, 1});
    intri += storage_matrix((c % 2 ? "dist_" : "D_") + name, c % 2 ? 1 : 5, c % 2 ? 5 : 1,
                            {l.k1, l.k2, l.p1, l.p2, l.k3});
    extri += storage_matrix("R_" + name, 3, 1, axis_of(camera));
    std::vector<double> rotation;
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) rotation.push_back((r == 0 ? 1 : -1) * camera.world(k, r));
    if (c % 2) extri += storage_matrix("Rot_" + name, 3, 3, rotation);
    const auto t = translation_of(camera);
    extri += storage_matrix("T_" + name, 3, 1, {t[0], t[1], t[2]});
    for (int k = 0; k < moments; ++k) {
      write_png(folder / "images" / name / ("00" + padded(k) + ".png"), rig_picture(int(c), k));
      write_png(folder / "mask" / name / ("00" + padded(k) + ".png"), flat_png(kWide, kHigh));
    }
  }
  write_text(folder / "intri.yml", intri);
  write_text(folder / "extri.yml", extri);
}

/// A transforms.json of one moment: a picture cam00.png ... of each camera in images, or in a folder of its
/// own.
inline void write_still_model(const fs::path& folder, const Cameras& cameras, const std::string& head = "") {
  std::vector<std::string> frames;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const std::string path = "images/" + numbered("cam", int(c)) + ".png";
    write_png(folder / path, rig_picture(int(c), 0));
    frames.push_back(
        frame_text(path, "", matrix_text(cameras[c].to_world)).insert(1, lens_fields(cameras[c].lens)));
  }
  write_text(folder / "transforms.json", transforms_text(frames, head));
}

/// A folder of pictures for each of `cameras` cameras, in `place`.
inline void write_camera_folders(const fs::path& place, int cameras, int moments) {
  for (int c = 0; c < cameras; ++c)
    for (int k = 0; k < moments; ++k)
      write_png(place / numbered("cam", c) / (padded(k) + ".png"), rig_picture(c, k));
}

}  // namespace splinevox::test
