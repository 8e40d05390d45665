// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/pictures.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

Image filled(int w, int h, int c, std::vector<float> pixel) {
  Image image(w, h, c);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = pixel[i % pixel.size()];
  return image;
}

Vec3 at(const Image& image, int x, int y) {
  const float* p = image.pixel(x, y);
  return {p[0], p[1], p[2]};
}

TEST_SUITE("io/pictures") {
  TEST_CASE("flow: no motion is grey, direction is colour, distance is intensity and saturates") {
    Image flow(5, 1, 3);
    flow.data = {0, 0, 0, 0.2f, 0, 0, 0, -0.1f, 0, 0, 0, 7, std::numeric_limits<float>::quiet_NaN(), 0, 0};
    const Image picture = flow_picture(flow, 0.2f);
    CHECK(at(picture, 0, 0) == Vec3{0.5f, 0.5f, 0.5f});
    CHECK(at(picture, 1, 0) == Vec3{1, 0.5f, 0.5f});
    CHECK(at(picture, 2, 0) == Vec3{0.5f, 0.25f, 0.5f});
    CHECK(at(picture, 3, 0) == Vec3{0.5f, 0.5f, 1});
    CHECK(at(picture, 4, 0) == Vec3{0.5f, 0.5f, 0.5f});
    CHECK(flow_range(flow) == 7.0f);
    CHECK(flow_range(Image(4, 4, 3)) == 1.0f);
  }

  TEST_CASE("depth: near is white, far is black, nothing is background, and the range leaves outliers out") {
    Image depth(6, 1, 1);
    depth.data = {2, 4, 3, 0, std::numeric_limits<float>::infinity(), 100};
    const Image grey = depth_picture(depth, {2, 4}, ColourMap::grey, {0, 1, 0});
    CHECK(at(grey, 0, 0) == Vec3{1, 1, 1});
    CHECK(at(grey, 1, 0) == Vec3{0, 0, 0});
    CHECK(at(grey, 2, 0) == Vec3{0.5f, 0.5f, 0.5f});
    CHECK(at(grey, 3, 0) == Vec3{0, 1, 0});
    CHECK(at(grey, 4, 0) == Vec3{0, 1, 0});
    CHECK(at(grey, 5, 0) == Vec3{0, 0, 0});
    Image many(1000, 1, 1);
    for (int i = 0; i < 1000; ++i) many.data[std::size_t(i)] = 1 + 0.001f * float(i);
    many.data[7] = 1e6f;
    const ValueRange range = depth_range(many);
    CHECK(range.lo == doctest::Approx(1.01f).epsilon(0.01));
    CHECK(range.hi == doctest::Approx(1.99f).epsilon(0.01));
    CHECK(depth_range(Image(3, 3, 1)).hi == 1.0f);
  }

  TEST_CASE("the spectrum runs from blue to red, continuously, and takes any number") {
    CHECK(colour_of(ColourMap::spectrum, 0).z > colour_of(ColourMap::spectrum, 0).x);
    CHECK(colour_of(ColourMap::spectrum, 1).x > colour_of(ColourMap::spectrum, 1).z);
    float jump = 0;
    for (int i = 0; i < 1000; ++i)
      jump = std::max(jump, length(colour_of(ColourMap::spectrum, float(i + 1) / 1000) -
                                   colour_of(ColourMap::spectrum, float(i) / 1000)));
    CHECK(jump < 0.01f);
    CHECK(colour_of(ColourMap::spectrum, std::nanf("")) == colour_of(ColourMap::spectrum, 0));
    CHECK(colour_of(ColourMap::grey, 3) == Vec3{1, 1, 1});
  }

  TEST_CASE("rigidity is grey, and over() shows the background where nothing is") {
    Image r(3, 1, 1), alpha(3, 1, 1);
    r.data = {0, 0.25f, 1};
    alpha.data = {1, 0.5f, 0};
    const Image picture = over(rigidity_picture(r), alpha, {1, 0, 0});
    CHECK(at(picture, 0, 0) == Vec3{0, 0, 0});
    CHECK(at(picture, 1, 0) == Vec3{0.625f, 0.125f, 0.125f});
    CHECK(at(picture, 2, 0) == Vec3{1, 0, 0});
    CHECK_THROWS_AS(over(picture, Image(2, 1, 1)), Error);
    CHECK_THROWS_AS(rigidity_picture(Image(2, 2, 3)), Error);
  }

  TEST_CASE("a contact sheet has gaps between its pictures and understands grey, RGB and RGBA") {
    const std::vector<Image> pictures{filled(4, 3, 1, {0.5f}), filled(4, 3, 3, {1, 0, 0}),
                                      filled(2, 1, 4, {0, 1, 0, 0.5f})};
    const Image sheet = contact_sheet(pictures, 2, 5, {0, 0, 1});
    CHECK(sheet.width == 13);
    CHECK(sheet.height == 11);
    CHECK(at(sheet, 3, 2) == Vec3{0.5f, 0.5f, 0.5f});
    CHECK(at(sheet, 4, 0) == Vec3{0, 0, 1});
    CHECK(at(sheet, 9, 0) == Vec3{1, 0, 0});
    CHECK(at(sheet, 12, 2) == Vec3{1, 0, 0});
    CHECK(at(sheet, 1, 9) == Vec3{0, 0.5f, 0.5f});  // 2x1 in the middle of a 4x3 cell
    CHECK(at(sheet, 0, 9) == Vec3{0, 0, 1});
    CHECK(at(sheet, 9, 9) == Vec3{0, 0, 1});
    CHECK(contact_sheet(pictures, 9, 2).width == 16);
    CHECK(contact_sheet(pictures, 1, 2).height == 13);
    CHECK(contact_sheet({}, 3).pixels() == 0);
  }

  TEST_CASE("base64 as RFC 4648 has it") {
    const auto text = [](const std::string& s) { return base64(s); };
    CHECK(text("") == "");
    CHECK(text("f") == "Zg==");
    CHECK(text("fo") == "Zm8=");
    CHECK(text("foo") == "Zm9v");
    CHECK(text("foobar") == "Zm9vYmFy");
    CHECK(text("\xff\xfe") == "//4=");
    CHECK(png_data_uri(Image(2, 2, 3)).substr(0, 33) == "data:image/png;base64,iVBORw0KGgo");
  }
}

}  // namespace
}  // namespace splinevox
