// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/// Small data sets on disk for tests. Needs no library but the standard one, so any test may include it.
namespace splinevox::test {

/// A fresh empty folder under the system's temporary one; removed with all it holds.
class TempFolder {
 public:
  TempFolder() {
    static std::atomic<unsigned> count{0};
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    path_ = std::filesystem::temp_directory_path() /
            ("splinevox_test_" + std::to_string(now) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::string str() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

using Bytes = std::vector<std::uint8_t>;

inline void write_bytes(const std::filesystem::path& path, const Bytes& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::filesystem::remove(path);  // to overwrite in place would wait for the disk on some file systems
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  if (!out) throw std::runtime_error("test set-up: cannot write " + path.string());
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  write_bytes(path, Bytes(text.begin(), text.end()));
}

/// The PNG colour types, by the number the file holds.
enum class PngKind : std::uint8_t { grey = 0, rgb = 2, palette = 3, grey_alpha = 4, rgba = 6 };

/// A picture as the file stores it: rows of packed samples, 16-bit samples big-endian, no filter byte.
struct TinyPng {
  int width = 1, height = 1, bits = 8;
  PngKind kind = PngKind::rgba;
  Bytes rows;          ///< height * ceil(width * samples * bits / 8)
  Bytes palette = {};  ///< RGB triples, for PngKind::palette
  Bytes trns = {};     ///< contents of a tRNS chunk; none if empty
};

inline void put_be32(Bytes& out, std::uint32_t v) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(std::uint8_t(v >> shift));
}

inline std::uint32_t crc32(const std::uint8_t* data, std::size_t n) {
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t i = 0; i < n; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

inline void put_chunk(Bytes& out, const char* type, const Bytes& body) {
  put_be32(out, std::uint32_t(body.size()));
  const std::size_t start = out.size();
  out.insert(out.end(), type, type + 4);
  out.insert(out.end(), body.begin(), body.end());
  put_be32(out, crc32(out.data() + start, out.size() - start));
}

/// A zlib stream of stored (uncompressed) blocks.
inline Bytes zlib_stored(const Bytes& raw) {
  Bytes out{0x78, 0x01};
  std::uint32_t a = 1, b = 0;
  for (std::uint8_t v : raw) {
    a = (a + v) % 65521;
    b = (b + a) % 65521;
  }
  std::size_t at = 0;
  do {
    const std::size_t n = std::min<std::size_t>(65535, raw.size() - at);
    out.push_back(at + n == raw.size() ? 1 : 0);
    for (std::size_t v : {n, ~n}) {
      out.push_back(std::uint8_t(v));
      out.push_back(std::uint8_t(v >> 8));
    }
    out.insert(out.end(), raw.begin() + std::ptrdiff_t(at), raw.begin() + std::ptrdiff_t(at + n));
    at += n;
  } while (at < raw.size());
  put_be32(out, (b << 16) | a);
  return out;
}

/// Signature and IHDR alone: what a reader sees before it allocates anything.
inline Bytes png_header(std::uint32_t width, std::uint32_t height, int bits, PngKind kind) {
  Bytes out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, ihdr;
  put_be32(ihdr, width);
  put_be32(ihdr, height);
  for (int v : {bits, int(kind), 0, 0, 0}) ihdr.push_back(std::uint8_t(v));
  put_chunk(out, "IHDR", ihdr);
  return out;
}

inline Bytes png_bytes(const TinyPng& png) {
  Bytes out = png_header(std::uint32_t(png.width), std::uint32_t(png.height), png.bits, png.kind);
  if (!png.palette.empty()) put_chunk(out, "PLTE", png.palette);
  if (!png.trns.empty()) put_chunk(out, "tRNS", png.trns);
  Bytes raw;
  const std::size_t row = png.rows.size() / std::size_t(png.height);
  for (int y = 0; y < png.height; ++y) {
    raw.push_back(0);
    raw.insert(raw.end(), png.rows.begin() + std::ptrdiff_t(row * y),
               png.rows.begin() + std::ptrdiff_t(row * (y + 1)));
  }
  put_chunk(out, "IDAT", zlib_stored(raw));
  put_chunk(out, "IEND", {});
  return out;
}

inline void write_png(const std::filesystem::path& path, const TinyPng& png) {
  write_bytes(path, png_bytes(png));
}

/// An RGBA picture of one 8-bit colour.
inline TinyPng flat_png(int width, int height, std::array<std::uint8_t, 4> rgba = {200, 100, 50, 255}) {
  TinyPng png{width, height, 8, PngKind::rgba, {}};
  for (int i = 0; i < width * height; ++i)
    for (const std::uint8_t v : rgba) png.rows.push_back(v);
  return png;
}

/// A camera on a circle of radius 3 around the z axis, height 1, looking at the origin: row-major
/// camera-to-world.
inline std::array<double, 16> orbit_matrix(double angle) {
  const double px = 3 * std::cos(angle), py = 3 * std::sin(angle), pz = 1, r = std::sqrt(10.0);
  const double bx = px / r, by = py / r, bz = pz / r;  // backward, the camera's +z
  const double n = std::hypot(bx, by);
  const double rx = -by / n, ry = bx / n;                            // right = world z x backward
  const double ux = -bz * ry, uy = bz * rx, uz = bx * ry - by * rx;  // up = backward x right
  return {rx, ux, bx, px, ry, uy, by, py, 0, uz, bz, pz, 0, 0, 0, 1};
}

inline std::string matrix_text(const std::array<double, 16>& m) {
  std::ostringstream out;
  out.precision(17);
  for (int row = 0; row < 4; ++row) {
    out << (row ? ", [" : "[[");
    for (int col = 0; col < 4; ++col) out << (col ? ", " : "") << m[std::size_t(row * 4 + col)];
    out << "]";
  }
  return out.str() + "]";
}

/// One element of "frames". An empty `time` leaves the field out.
inline std::string frame_text(const std::string& file, const std::string& time, const std::string& matrix) {
  return "{\"file_path\": \"" + file + "\", " + (time.empty() ? "" : "\"time\": " + time + ", ") +
         "\"transform_matrix\": " + matrix + "}";
}

/// A whole transforms file. `head` holds the fields before "frames", each ending in a comma.
inline std::string transforms_text(const std::vector<std::string>& frames,
                                   const std::string& head = "\"camera_angle_x\": 0.8,") {
  std::string text = "{" + head + "\n \"frames\": [";
  for (std::size_t i = 0; i < frames.size(); ++i) text += (i ? ",\n  " : "\n  ") + frames[i];
  return text + "\n]}\n";
}

/// A shaded ball of radius 0.5 that moves along x from -0.4 at t = 0 to 0.4 at t = 1, on a transparent
/// ground.
struct MovingBall {
  int train = 8, val = 2, test = 3;  ///< frames per split; 0 leaves the split out
  int size = 16;                     ///< pixels per side
  double angle_x = 0.8;              ///< field of view, radians
};

inline TinyPng ball_png(int size, double angle_x, const std::array<double, 16>& m, double t) {
  TinyPng png{size, size, 8, PngKind::rgba, Bytes(std::size_t(size) * size * 4, 0)};
  const double focal = 0.5 * size / std::tan(0.5 * angle_x), cx = -0.4 + 0.8 * t;
  const double o[3] = {m[3] - cx, m[7], m[11]};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double u = (x + 0.5 - 0.5 * size) / focal, v = -(y + 0.5 - 0.5 * size) / focal;
      double d[3], b = 0, c = -0.25, dd = 0;
      for (int k = 0; k < 3; ++k) {
        d[k] = u * m[std::size_t(4 * k)] + v * m[std::size_t(4 * k + 1)] - m[std::size_t(4 * k + 2)];
        b += d[k] * o[k];
        c += o[k] * o[k];
        dd += d[k] * d[k];
      }
      const double disc = b * b - dd * c;
      if (disc <= 0) continue;
      const double s = (-b - std::sqrt(disc)) / dd;
      std::uint8_t* out = png.rows.data() + (std::size_t(y) * size + x) * 4;
      for (int k = 0; k < 3; ++k)
        out[k] = std::uint8_t(127.5 + 120 * std::clamp((o[k] + s * d[k]) / 0.5, -1.0, 1.0));
      out[3] = 255;
    }
  return png;
}

/// Writes the ball as transforms_{train,val,test}.json and PNGs, in the layout of the D-NeRF scenes.
inline void write_moving_ball(const std::filesystem::path& folder, const MovingBall& ball = {}) {
  const std::pair<const char*, int> splits[] = {
      {"train", ball.train}, {"val", ball.val}, {"test", ball.test}};
  double phase = 0;
  for (const auto& [name, count] : splits) {
    std::vector<std::string> frames;
    for (int i = 0; i < count; ++i) {
      const double t = count > 1 ? double(i) / (count - 1) : 0.0;
      const auto m = orbit_matrix(phase + 2.4 * i);
      std::ostringstream time;
      time.precision(17);
      time << t;
      const std::string file = std::string(name) + "/r_" + std::to_string(i);
      frames.push_back(frame_text("./" + file, time.str(), matrix_text(m)));
      write_png(folder / (file + ".png"), ball_png(ball.size, ball.angle_x, m, t));
    }
    std::ostringstream head;
    head.precision(17);
    head << "\"camera_angle_x\": " << ball.angle_x << ",";
    if (count > 0)
      write_text(folder / (std::string("transforms_") + name + ".json"), transforms_text(frames, head.str()));
    phase += 0.7;
  }
}

}  // namespace splinevox::test
