// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "app/ball_scene.hpp"

using namespace splinevox::test;
using Json = nlohmann::json;

namespace {

/// Numbers behind `name` in USD's text: one value, or that of a frame.
std::vector<double> usd_numbers(const std::string& text, const std::string& name, int frame) {
  const std::size_t at = text.find(" " + name);
  REQUIRE(at != std::string::npos);
  std::size_t begin = text.find('=', at) + 1, end = text.find('\n', begin);
  if (text.compare(at + 1 + name.size(), 12, ".timeSamples") == 0) {
    begin = text.find("        " + std::to_string(frame) + ": ", at);
    REQUIRE(begin != std::string::npos);
    begin = text.find(':', begin) + 1;
    end = text.find('\n', begin);
  }
  std::vector<double> numbers;
  const std::string part = text.substr(begin, end - begin);
  const std::regex number("-?[0-9.]+(e-?[0-9]+)?");
  for (std::sregex_iterator i(part.begin(), part.end(), number), none; i != none; ++i)
    numbers.push_back(std::stod(i->str()));
  return numbers;
}

}  // namespace

TEST_SUITE("cli/cameras") {
  TEST_CASE("cameras as files: JSON that render reads as the same, and USD that sees the same") {
    const SmallRun small;
    const auto written = [&](const std::string& camera, const std::string& out) {
      const Ended e = program({"render", small.run, "--out", small.path(out), "--format", "cameras",
                               "--camera", camera, "--frames", "3-6", "--fps", "25"});
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      CHECK(contains(e.out, "4 cameras"));
      return Json::parse(slurp(small.path(out) + "/cameras.json"));
    };
    const Json once = written("dataset:train", "once");
    REQUIRE(once["frames"].size() == 4);
    CHECK(once["fps"] == 25);
    CHECK(once["frames"][0]["transform_matrix"] != once["frames"][3]["transform_matrix"]);
    const Json again = written(small.path("once") + "/cameras.json", "again");
    const std::string usd = slurp(small.path("once") + "/cameras.usda");
    CHECK(contains(usd, "startTimeCode = 3\n"));
    for (std::size_t i = 0; i < 4; ++i) {
      const Json& c = once["frames"][i];
      CHECK(c["frame"] == 3 + int(i));
      CHECK(again["frames"][i]["fl_x"] == c["fl_x"]);
      const auto value = [&](const char* name) { return usd_numbers(usd, name, 3 + int(i)).at(0); };
      const double focal = value("focalLength"), wide = value("horizontalAperture"),
                   high = value("verticalAperture"), right = value("horizontalApertureOffset"),
                   up = value("verticalApertureOffset");
      CHECK((right - wide / 2) / focal == doctest::Approx(-c["cx"].get<double>() / c["fl_x"].get<double>()));
      CHECK((up + high / 2) / focal == doctest::Approx(c["cy"].get<double>() / c["fl_y"].get<double>()));
      CHECK(wide / focal == doctest::Approx(c["w"].get<double>() / c["fl_x"].get<double>()));
      CHECK(high / focal == doctest::Approx(c["h"].get<double>() / c["fl_y"].get<double>()));
      const std::vector<double> rows = usd_numbers(usd, "xformOp:transform", 3 + int(i));
      REQUIRE(rows.size() == 16);
      for (std::size_t r = 0; r < 4; ++r)
        for (std::size_t k = 0; k < 4; ++k) {
          const double ours = c["transform_matrix"][r][k],
                       back = again["frames"][i]["transform_matrix"][r][k];
          CHECK(rows[4 * k + r] == doctest::Approx(ours));
          CHECK(back == doctest::Approx(ours));
        }
    }
  }
}
