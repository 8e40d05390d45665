// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <png.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "data/pictures/exr.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "support/file_size_limit.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for one test, removed at the end.
struct Folder {
  fs::path path = fs::temp_directory_path() / ("splinevox_image_write_" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string operator/(const std::string& name) const { return (path / name).string(); }
  int files() const { return int(std::distance(fs::directory_iterator(path), fs::directory_iterator())); }
};

Image ramp(int w, int h, int c, unsigned seed) {
  Image image(w, h, c);
  std::mt19937 rng(seed);
  for (float& v : image.data) v = float(rng() % 256) / 255.0f;
  return image;
}

std::vector<char> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Decodes with libpng's own reader, keeping the stored channels.
std::vector<std::uint8_t> decode(const std::vector<char>& png, int channels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&image, png.data(), png.size()));
  const std::uint32_t format = channels == 1   ? PNG_FORMAT_GRAY
                               : channels == 3 ? PNG_FORMAT_RGB
                                               : PNG_FORMAT_RGBA;
  CHECK(image.format == format);
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr));
  return bytes;
}

std::string message_of(auto&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

Fault fault_of(auto&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.fault;
  }
  return Fault::numeric;
}

TEST_SUITE("data/image_write") {
  TEST_CASE("a PNG holds every 8-bit value exactly, for 1, 3 and 4 channels") {
    for (int channels : {1, 3, 4}) {
      CAPTURE(channels);
      const Image image = ramp(37, 21, channels, 5);
      const std::vector<std::uint8_t> back = decode(encode_png(image), channels);
      REQUIRE(back.size() == image.data.size());
      int wrong = 0;
      for (std::size_t i = 0; i < back.size(); ++i) wrong += back[i] != std::lround(image.data[i] * 255);
      CHECK(wrong == 0);
    }
  }

  TEST_CASE("PNG values are clamped and rounded; NaN is black") {
    Image image(6, 1, 1);
    image.data = {-1,
                  2,
                  std::numeric_limits<float>::quiet_NaN(),
                  0.5f / 255 - 1e-6f,
                  0.5f / 255 + 1e-6f,
                  std::numeric_limits<float>::infinity()};
    CHECK(decode(encode_png(image), 1) == std::vector<std::uint8_t>{0, 255, 0, 0, 1, 255});
  }

  TEST_CASE("a picture PNG cannot hold is refused") {
    CHECK_THROWS_AS(encode_png(Image(4, 4, 2)), Error);
    CHECK_THROWS_AS(encode_png(Image(0, 4, 3)), Error);
    CHECK(message_of([] { write_png("out.png", Image(4, 4, 2)); }) ==
          "out.png: this picture cannot be stored as PNG\n"
          "  expected: 1, 3 or 4 channels and sides of 1 to 65535 pixels\n"
          "  got:      4x4 with 2 channels");
  }

  TEST_CASE("EXR layers come back with the same bits, names and channel order") {
    const Folder folder;
    Image position = ramp(19, 13, 3, 1), depth = ramp(19, 13, 1, 2), rest = ramp(19, 13, 3, 3);
    position.data[0] = std::numeric_limits<float>::infinity();
    depth.data[5] = 1e-42f;
    rest.data[7] = -3.25e30f;
    write_exr(folder / "a.exr", {{"position", position, {"X", "Y", "Z"}},
                                 {"rest", rest, {}},
                                 {"depth", depth, {}},
                                 {"", ramp(19, 13, 4, 4), {}}});
    CHECK(folder.files() == 1);
    const auto layers = read_exr_layers(folder / "a.exr");
    REQUIRE(layers.size() == 4);
    const auto same = [&](const char* name, const Image& image, const std::vector<std::string>& channels) {
      const ExrLayer& got = find_exr_layer(layers, name, "a.exr");
      CHECK(got.channels == channels);
      CHECK(got.image.width == 19);
      CHECK(std::memcmp(got.image.data.data(), image.data.data(), image.data.size() * sizeof(float)) == 0);
    };
    same("position", position, {"X", "Y", "Z"});
    same("rest", rest, {"R", "G", "B"});
    same("depth", depth, {""});
    same("", ramp(19, 13, 4, 4), {"R", "G", "B", "A"});
    CHECK(
        message_of([&] { find_exr_layer(layers, "flow", "a.exr"); }) ==
        "a.exr: there is no layer 'flow'\n  expected: 'flow'\n  got:      (unnamed), depth, position, rest");
  }

  TEST_CASE("layers that do not fit together are refused") {
    const Folder folder;
    CHECK_THROWS_AS(write_exr(folder / "a.exr", {}), Error);
    CHECK_THROWS_AS(write_exr(folder / "a.exr", {{"a", Image(2, 2, 1), {}}, {"b", Image(3, 2, 1), {}}}),
                    Error);
    CHECK_THROWS_AS(write_exr(folder / "a.exr", {{"a", Image(2, 2, 1), {}}, {"a", Image(2, 2, 1), {}}}),
                    Error);
    CHECK_THROWS_AS(write_exr(folder / "a.exr", {{"a", Image(2, 2, 3), {"X", "Y"}}}), Error);
    CHECK(folder.files() == 0);
  }

  TEST_CASE("a damaged EXR is an input error, and no header makes us ask for absurd memory") {
    const Folder folder;
    write_exr(folder / "good.exr", {{"", ramp(16, 16, 3, 1), {}}});
    const std::vector<char> good = bytes_of(folder / "good.exr");
    const auto try_bytes = [&](const std::vector<char>& bytes) {
      std::ofstream(folder / "bad.exr", std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
      return fault_of([&] { read_exr_layers(folder / "bad.exr"); });
    };
    for (std::size_t size : {std::size_t(0), std::size_t(7), std::size_t(40), std::size_t(200),
                             good.size() / 2, good.size() - 1}) {
      CAPTURE(size);
      CHECK(try_bytes({good.begin(), good.begin() + std::ptrdiff_t(size)}) == Fault::input);
    }
    std::vector<char> huge = good;
    const char key[] = "dataWindow\0box2i";
    const auto at = std::search(huge.begin(), huge.end(), key, key + sizeof key);
    REQUIRE(at != huge.end());
    const std::int32_t corners[4] = {0, 0, 2000000000, 2000000000};
    std::memcpy(&*at + sizeof key + 4, corners, sizeof corners);
    CHECK(try_bytes(huge) == Fault::input);
    CHECK(message_of([&] { read_exr_layers(folder / "bad.exr"); }).find("2000000001x2000000001") !=
          std::string::npos);
    std::vector<char> multipart = good;
    multipart[5] = char(multipart[5] | 0x10);
    CHECK(try_bytes(multipart) == Fault::input);
    CHECK(fault_of([&] { read_exr_layers(folder / "absent.exr"); }) == Fault::input);
  }

  TEST_CASE("a device in place of a picture is an output error that names the path, and stays a device") {
    const std::string message = message_of([] { write_png("/dev/full", ramp(8, 8, 3, 1)); });
    for (const char* part :
         {"/dev/full: could not be written", "got:      a pipe or a device, where a file belongs"})
      CHECK_MESSAGE(message.find(part) != std::string::npos, message);
    CHECK(fault_of([] { write_exr("/dev/full", {{"", ramp(8, 8, 3, 1), {}}}); }) == Fault::output);
    CHECK(fs::is_character_file("/dev/full"));
  }

  TEST_CASE("a file size limit is an output error; the earlier file survives and no draft is left behind") {
    const Folder folder;
    const std::string path = folder / "picture.png";
    write_png(path, ramp(4, 4, 3, 1));
    const std::vector<char> before = bytes_of(path);
    const std::string message = message_of([&] {
      const test::FileSizeLimit limit(1000);
      write_png(path, ramp(200, 200, 3, 2));
    });
    for (const std::string& part : {path + ": could not be written", std::string("got:      File too large"),
                                    std::string("try:      raise the file size limit (ulimit -f)")})
      CHECK_MESSAGE(message.find(part) != std::string::npos, message);
    CHECK(bytes_of(path) == before);
    CHECK(folder.files() == 1);
  }

  TEST_CASE("an absent folder and a folder in the file's place are output errors naming the path") {
    const Folder folder;
    CHECK(message_of([&] {
            write_png(folder / "no/such/a.png", ramp(4, 4, 1, 1));
          }).find("no/such/a.png: could not") != std::string::npos);
    fs::create_directories(folder / "taken.png");
    CHECK(fault_of([&] { write_png(folder / "taken.png", ramp(4, 4, 1, 1)); }) == Fault::output);
  }

  TEST_CASE("a picture is not written through a link") {
    const Folder folder;
    write_png(folder / "real.png", ramp(4, 4, 1, 1));
    fs::create_symlink("real.png", folder / "link.png");
    CHECK_THROWS_AS(write_png(folder / "link.png", ramp(4, 4, 1, 2)), Error);
    CHECK(fs::is_symlink(folder / "link.png"));
    CHECK(bytes_of(folder / "real.png") == encode_png(ramp(4, 4, 1, 1)));
  }
}

}  // namespace
}  // namespace splinevox
