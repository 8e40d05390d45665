// SPDX-License-Identifier: Apache-2.0
// Pictures that tell which shot they are: made once, linked into every data set.
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "data/jpeg_bytes.hpp"
#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

namespace fs = std::filesystem;
using test::kHigh, test::kWide;

constexpr int kColumns = 12, kRed = 20, kGreen = 10, kHalf = 5;
constexpr std::uint8_t kLeftBlue = 60, kRightBlue = 200;

const fs::path& pool() {
  static const fs::path path = [] {
    const fs::path memory = "/dev/shm";
    const fs::path root = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    const fs::path made = root / ("splinevox_structure_pool_" + std::to_string(::getpid()));
    fs::create_directories(made);
    return made;
  }();
  return path;
}

std::array<std::uint8_t, 3> colour(int shot, bool left) {
  return {std::uint8_t(kRed * (shot % kColumns) + 7), std::uint8_t(kGreen * (shot / kColumns) + kHalf),
          left ? kLeftBlue : kRightBlue};
}

/// RGB rows of a shot's picture as stored: turned so that EXIF's orientation makes it upright.
std::vector<std::uint8_t> stored(int shot, int turn, int& wide, int& high) {
  const bool side = turn >= 5;
  wide = side ? kHigh : kWide;
  high = side ? kWide : kHigh;
  std::vector<std::uint8_t> rows;
  for (int v = 0; v < high; ++v)
    for (int u = 0; u < wide; ++u) {
      const int x = turn == 1 ? u : turn == 3 ? kWide - 1 - u : turn == 6 ? kWide - 1 - v : v;
      for (const std::uint8_t value : colour(shot, x < kWide / 2)) rows.push_back(value);
    }
  return rows;
}

test::Bytes jpeg_of(int shot, int turn) {
  test::JpegKind kind{.quality = 100, .whole_colours = true};
  kind.app1 = test::exif_turn(turn);
  const std::vector<std::uint8_t> rows = stored(shot, turn, kind.width, kind.height);
  const std::string bytes = test::jpeg_bytes(kind, rows);
  return {bytes.begin(), bytes.end()};
}

test::Bytes png_of(int shot) {
  int wide = 0, high = 0;
  return test::png_bytes({kWide, kHigh, 8, test::PngKind::rgb, stored(shot, 1, wide, high)});
}

void link_to(const fs::path& made, const fs::path& path) {
  fs::create_directories(path.parent_path());
  std::error_code error;
  fs::create_hard_link(made, path, error);
  if (error && !fs::exists(path)) fs::copy_file(made, path);
}

}  // namespace

void place_picture(const Case& c, std::size_t shot) {
  const fs::path made = pool() / (std::to_string(shot) + "_" + std::to_string(c.turn));
  if (!fs::exists(made))
    test::write_bytes(made, c.turn == 1 ? png_of(int(shot)) : jpeg_of(int(shot), c.turn));
  link_to(made, fs::path(c.folder) / c.shots[shot].path);
}

void place_other(const Case& c, const std::string& path) {
  const fs::path made = pool() / "other";
  if (!fs::exists(made)) test::write_png(made, test::flat_png(kWide, kHigh, {250, 250, 250, 255}));
  link_to(made, fs::path(c.folder) / path);
}

bool can_film() {
  static const bool can = std::system("ffmpeg -version > /dev/null 2>&1") == 0;
  return can;
}

void place_film(const Case& c, int camera, const std::string& path, int every) {
  const fs::path frames = fs::path(c.folder + "_frames");
  fs::create_directories(frames);
  int count = 0;
  for (std::size_t i = 0; i < c.shots.size(); ++i)
    if (c.shots[i].camera == camera) {
      if (c.shots[i].moment % every == 0)
        test::write_bytes(frames / (std::to_string(count++) + ".png"), png_of(int(i)));
    }
  fs::create_directories((fs::path(c.folder) / path).parent_path());
  const std::string command = "ffmpeg -v error -r " + std::to_string(10.0 / every) + " -i " +
                              frames.string() + "/%d.png -c:v libx264 -qp 0 -pix_fmt yuv444p '" + c.folder +
                              "/" + path + "'";
  const int code = std::system(command.c_str());
  fs::remove_all(frames);
  if (code != 0) throw std::runtime_error("ffmpeg makes no film");
}

int shot_in(const Picture& picture, bool& upright) {
  if (picture.width < 2 || picture.height < 1) return -1;
  const auto at = [&](int x, int y, std::size_t channel) {
    return double(picture.pixel(std::size_t(y) * std::size_t(picture.width) + std::size_t(x))[channel]) / 257;
  };
  const int y = picture.height / 2, x = picture.width / 4;
  upright =
      std::abs(at(x, y, 2) - kLeftBlue) < 30 && std::abs(at(picture.width - 1 - x, y, 2) - kRightBlue) < 30;
  const double column = (at(x, y, 0) - 7) / kRed, row = (at(x, y, 1) - kHalf) / kGreen;
  if (std::abs(column - std::round(column)) > 0.3 || std::abs(row - std::round(row)) > 0.45) return -1;
  const int shot = int(std::round(column)) + kColumns * int(std::round(row));
  return std::round(column) >= kColumns ? -1 : shot;
}

void remove_pool() {
  std::error_code ignored;
  fs::remove_all(pool(), ignored);
}

}  // namespace splinevox::torture::structure
