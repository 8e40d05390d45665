// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <random>

#include "data/expect_error.hpp"
#include "data/jpeg_bytes.hpp"
#include "data/layouts.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::test;

struct File {
  TempFolder folder;
  fs::path path = folder.path() / "x.jpg";
  const fs::path& with(const std::string& bytes) const {
    write_text(path, bytes);
    return path;
  }
  void refuse(const std::string& bytes, const std::vector<std::string>& parts) const {
    with(bytes);
    expect_error([&] { read_jpeg(path); }, parts);
  }
};

TEST_SUITE("data/jpeg") {
  TEST_CASE("colour, grey, progressive: opaque pixels near what was written") {
    const File file;
    for (const JpegKind& kind : {JpegKind{64, 40}, JpegKind{64, 40, 1}, JpegKind{64, 40, 3, 95, true}}) {
      const Image16 image = read_jpeg(file.with(jpeg_bytes(kind)));
      REQUIRE(image.width == 64);
      REQUIRE(image.height == 40);
      int worst = 0;
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 64; ++x) {
          const std::uint16_t* p = image.pixel(x, y);
          CHECK(p[3] == 65535);
          CHECK(p[0] % 257 == 0);
          worst = std::max(worst, std::abs(p[0] / 257 - 255 * x / 64));
          if (kind.components == 3) worst = std::max(worst, std::abs(p[1] / 257 - 255 * y / 40));
        }
      CHECK(worst < 8);
      CHECK(read_picture_size(file.path).width == 64);
    }
  }

  TEST_CASE("kinds are told apart by bytes, not by names") {
    const File file;
    CHECK(read_picture(file.with(jpeg_bytes())).width == 16);
    write_png(file.path, flat_png(3, 2));
    CHECK(read_picture(file.path).width == 3);
    CHECK(read_picture_size(file.path).height == 2);
  }

  TEST_CASE("truncated, damaged, CMYK, claimed sizes, endless scans") {
    const File file;
    const std::string good = jpeg_bytes({64, 40});
    file.refuse(good.substr(0, good.size() - 2), {"x.jpg: the image is truncated or damaged", "JPEG"});
    file.refuse(good.substr(0, good.size() / 2), {"the image is truncated or damaged"});
    file.refuse(good.substr(0, 20), {"the image is truncated or damaged"});
    file.refuse("", {"x.jpg: the image is truncated or damaged"});
    file.refuse(jpeg_bytes({16, 8, 4}), {"the JPEG's colours are neither grey nor RGB", "convert it to PNG"});
    std::string large = good;
    const std::size_t frame = large.find("\xff\xc0");
    REQUIRE(frame != std::string::npos);
    large.replace(frame + 5, 4, "\x30\x00\x30\x00", 4);
    file.refuse(large, {"the image claims more pixels than its file can hold", "12288 x 12288"});
    large.replace(frame + 5, 4, "\xf0\x00\xf0\x00", 4);
    file.refuse(large, {"the image's size is out of range", "2^28"});
    std::string scans = jpeg_bytes({16, 8, 3, 95, true});
    const std::size_t last = scans.rfind("\xff\xda"), end = scans.size() - 2;
    const std::string scan = scans.substr(last, end - last);
    for (int i = 0; i < 200; ++i) scans.insert(end, scan);
    file.refuse(scans, {"the image is truncated or damaged"});
  }

  TEST_CASE("damaged bytes give an error or a picture, never a crash") {
    const File file;
    for (const bool progressive : {false, true}) {
      const std::string good = jpeg_bytes({48, 32, 3, 60, progressive});
      std::mt19937 random(9);
      int refused = 0;
      for (int trial = 0; trial < 400; ++trial) {
        std::string bad = good;
        for (unsigned k = 0; k < 1 + trial % 4u; ++k) bad[random() % bad.size()] = char(random());
        try {
          read_picture(file.with(bad));
        } catch (const Error& error) {
          CHECK(error.fault == Fault::input);
          ++refused;
        }
      }
      CHECK(refused > 40);
    }
  }

  TEST_CASE("a data set of JPEGs, converted byte for byte") {
    const TempFolder folder, out;
    const Cameras cameras = true_cameras();
    write_nerfstudio(folder.path(), cameras);
    std::ifstream in(folder.path() / "transforms.json");
    std::string text((std::istreambuf_iterator<char>(in)), {});
    for (std::size_t at; (at = text.find(".png")) != std::string::npos;)
      text.replace(at, 4, at % 2 ? ".jpg" : "");
    write_text(folder.path() / "transforms.json", text);
    const std::string picture = jpeg_bytes({kWide, kHigh});
    for (int i = 0; i < kCameras; ++i) {
      fs::remove(folder.path() / "images" / ("frame_" + padded(i) + ".png"));
      write_text(folder.path() / "images" / ("frame_" + padded(i) + ".jpg"), picture);
    }
    const Dataset data = load_dataset(folder.str());
    CHECK_FALSE(data.has_alpha);
    convert_dataset(folder.str(), out.str() + "/c");
    const Dataset again = load_dataset(out.str() + "/c");
    CHECK(again.find("train")->frames[5].image == data.find("train")->frames[5].image);
    CHECK(read_jpeg(out.path() / "c/train/frame_0000.jpg").width == kWide);
  }
}

}  // namespace
