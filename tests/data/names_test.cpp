// SPDX-License-Identifier: Apache-2.0
#include "data/times/names.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

#include "data/expect_error.hpp"
#include "data/times/digits.hpp"

namespace {

using namespace splinevox::data;
using Verdict = NamesRead::Verdict;

/// `cameras` x `moments` pictures in the order of cameras. @param still  whether a camera keeps its place.
std::vector<NamedPicture> rig(int cameras, int moments, bool still,
                              const std::function<std::string(int camera, int moment)>& name) {
  std::vector<NamedPicture> all;
  for (int c = 0; c < cameras; ++c)
    for (int t = 0; t < moments; ++t) all.push_back({name(c, t), still ? std::size_t(c) : all.size(), 0});
  return all;
}

/// One camera that goes about.
std::vector<NamedPicture> film(int pictures, const std::function<std::string(int)>& name) {
  return rig(1, pictures, false, [&](int, int t) { return name(t); });
}

std::string padded(int value, std::size_t width) {
  std::string text = std::to_string(value);
  return std::string(width > text.size() ? width - text.size() : 0, '0') + text;
}

/// Whether times grow by equal steps with the moment, for every camera alike.
bool counts_moments(const NamesRead& read, int cameras, int moments) {
  if (read.verdict != Verdict::times || read.times.size() != std::size_t(cameras * moments)) return false;
  const double step = read.times[1] - read.times[0];
  for (int c = 0; c < cameras; ++c)
    for (int t = 0; t < moments; ++t)
      if (std::abs(read.times[std::size_t(c * moments + t)] - (read.times[0] + step * t)) >
          1e-4 * std::abs(step))
        return false;
  return step > 0;
}

TEST_SUITE("data/names") {
  TEST_CASE("a rig's frame number is the time, wherever it stands and whatever it is called") {
    const std::function<std::string(int, int)> forms[] = {
        [](int c, int t) { return "images/Scene_undist_" + padded(t + 1, 5) + "_" + padded(c, 2) + ".png"; },
        [](int c, int t) { return "images/" + padded(c, 2) + "_" + padded(t, 4) + ".png"; },
        [](int c, int t) { return "cam" + padded(c, 2) + "/" + padded(t, 5) + ".png"; },
        [](int c, int t) { return padded(t, 5) + "/" + padded(c, 2) + ".jpg"; },
        [](int c, int t) {
          return "cam" + padded(c, 2) + "/cam" + padded(c, 2) + "_" + padded(t, 3) + ".png";
        },
        [](int c, int t) { return "a\\b" + std::to_string(c) + "\\f" + std::to_string(t) + ".PNG"; },
        [](int c, int t) {
          return std::string(c % 2 ? "left" : "right") + std::to_string(c / 2) + "/" + std::to_string(t) +
                 "_1080p.png";
        },
    };
    for (const auto& form : forms) {
      CAPTURE(form(1, 2));
      const NamesRead read = read_names(rig(10, 12, true, form));
      CHECK_MESSAGE(counts_moments(read, 10, 12), read.reason);
      CHECK(read.sure);
    }
  }

  TEST_CASE("where no place repeats, words and folders tell camera from time") {
    const auto words = rig(6, 9, false, [](int c, int t) {
      return "out/frame" + padded(t, 4) + "_cam" + padded(c, 2) + ".png";
    });
    CHECK(counts_moments(read_names(words), 6, 9));
    CHECK(read_names(words).sure);
    const auto views = rig(6, 9, false, [](int c, int t) { return padded(t, 4) + "/view_" + padded(c, 2); });
    CHECK(counts_moments(read_names(views), 6, 9));
    const auto folders =
        rig(6, 9, false, [](int c, int t) { return padded(c, 2) + "/" + padded(t, 4) + ".png"; });
    CHECK(counts_moments(read_names(folders), 6, 9));
    CHECK_FALSE(read_names(folders).sure);
    const auto named = rig(3, 9, false, [](int c, int t) {
      return std::string(c == 0 ? "left" : c == 1 ? "right" : "top") + "/" + padded(t, 4) + ".png";
    });
    CHECK(counts_moments(read_names(named), 3, 9));
  }

  TEST_CASE("two numbers that nothing tells apart are asked for") {
    const NamesRead read =
        read_names(rig(8, 8, false, [](int c, int t) { return padded(t, 2) + "_" + padded(c, 2) + ".png"; }));
    CHECK(read.verdict == Verdict::unclear);
    CHECK(read.reason == "several numbers count in them, in '00_00.png': 1: 00, 2: 00");
  }

  TEST_CASE("a film's frame number is the time, with a copy number, a resolution, a fixed serial number") {
    const std::function<std::string(int)> forms[] = {
        [](int t) { return "images/frame_" + padded(t + 1, 5) + ".png"; },
        [](int t) { return "frame_" + padded(t, 4) + "_1080p.jpg"; },
        [](int t) { return "GX010137_" + padded(t, 4) + ".jpg"; },
        [](int t) { return "./" + std::to_string(t); },
        [](int t) { return "frame_" + padded(t, 4) + (t == 3 ? " (1).png" : ".png"); },
        [](int t) { return "550e8400-e29b-41d4-a716-446655440000_" + padded(t, 3) + ".png"; },
        [](int t) { return padded(t, 4) + "/frame_" + padded(t + 1, 4) + ".png"; },
    };
    for (const auto& form : forms) {
      CAPTURE(form(3));
      const NamesRead read = read_names(film(20, form));
      CHECK_MESSAGE(counts_moments(read, 1, 20), read.reason);
    }
    CHECK(
        read_names(film(20, forms[0])).reason ==
        "'images/frame_00001.png' is at 1, 'images/frame_00020.png' at 20 (the only number that counts up)");
    CHECK_FALSE(read_names(film(20, forms[0])).sure);  // nerfstudio's programs call photographs so
  }

  TEST_CASE("decimals, date and time of day, nanoseconds are times") {
    CHECK(counts_moments(read_names(film(11, [](int t) { return "t_" + std::to_string(0.25 * t) + ".png"; })),
                         1, 11));
    const auto clock = [](int t) {
      return "PXL_20240229_2359" + padded(30 + 10 * t > 59 ? 59 : 30 + 10 * t, 2) + "000.jpg";
    };
    CHECK(counts_moments(read_names(film(3, clock)), 1, 3));
    const auto midnight = [](int t) {
      return "IMG_" + std::string(t == 0 ? "2024-02-29_23-59-50" : "2024-03-01_00-00-00");
    };
    const NamesRead across = read_names(film(2, midnight));
    REQUIRE(across.verdict == Verdict::times);
    CHECK(across.times[1] - across.times[0] == doctest::Approx(10));
    const auto nanoseconds = [](int t) {
      return std::to_string(1700000000000000000LL + 33333333LL * t) + ".png";
    };
    const NamesRead read = read_names(film(30, nanoseconds));
    REQUIRE(read.verdict == Verdict::times);
    CHECK(read.times[29] - read.times[0] == doctest::Approx(29 * 0.033333333));
    CHECK(read_names(film(30, [&](int t) { return padded(t, 3) + "_" + nanoseconds(t); })).times[1] ==
          read.times[1]);
  }

  TEST_CASE("a point between a camera and a frame is no decimal point") {
    CHECK(counts_moments(
        read_names(rig(3, 12, true,
                       [](int c, int t) { return "cam" + std::to_string(c) + "." + padded(t, 4) + ".png"; })),
        3, 12));
  }

  TEST_CASE("cameras of one moment, photographs and splits that start again have no times") {
    const NamesRead cameras =
        read_names(film(76, [](int t) { return "images/cam_" + padded(t, 3) + ".png"; }));
    CHECK(cameras.verdict == Verdict::one_moment);
    CHECK_FALSE(cameras.sure);  // a film may be called that as well
    const NamesRead folders =
        read_names(film(9, [](int t) { return "camera" + padded(t, 3) + "/image.png"; }));
    CHECK(folders.verdict == Verdict::one_moment);
    const NamesRead words = read_names({{"left/image.png", 0, 0}, {"right/image.png", 1, 0}});
    CHECK(words.verdict == Verdict::one_moment);
    const NamesRead photographs =
        read_names(film(40, [](int t) { return "DSC0" + std::to_string(7956 + t); }));
    CHECK(photographs.verdict == Verdict::one_moment);
    CHECK_FALSE(photographs.sure);
    std::vector<NamedPicture> splits;
    for (std::size_t split = 0; split < 2; ++split)
      for (int i = 0; i < 20; ++i)
        splits.push_back(
            {(split == 0 ? "./train/r_" : "./test/r_") + std::to_string(i), splits.size(), split});
    CHECK(read_names(splits).verdict == Verdict::one_moment);
    CHECK(read_names({{"a", 0, 0}}).verdict == Verdict::one_moment);
  }

  TEST_CASE("photographs of a camera that stands still are moments") {
    std::vector<NamedPicture> all = film(40, [](int t) { return "DSC0" + std::to_string(7956 + t); });
    for (NamedPicture& p : all) p.place = 0;
    CHECK(counts_moments(read_names(all), 1, 40));
  }

  TEST_CASE("identifiers and names without numbers tell nothing and are asked for") {
    const char* ids[] = {"550e8400-e29b-41d4-a716-446655440000", "6ba7b810-9dad-11d1-80b4-00c04fd430c8",
                         "f47ac10b-58cc-4372-a567-0e02b2c3d479"};
    CHECK(read_names(film(3, [&](int t) { return std::string(ids[t]) + ".png"; })).verdict ==
          Verdict::unclear);
    const char* hashes[] = {"d41d8cd98f00b204e9800998", "0cc175b9c0f1b6a831c399e2",
                            "92eb5ffee6ae2fec3ad71c77"};
    CHECK(read_names(film(3, [&](int t) { return hashes[t]; })).verdict == Verdict::unclear);
    CHECK(read_names(film(3, [](int t) { return std::string(1, char('a' + t)); })).verdict ==
          Verdict::unclear);
  }

  TEST_CASE("one number far off all others, or one name of another form, is asked for") {
    const NamesRead serial =
        read_names(film(20, [](int t) { return "frame_" + std::to_string(t == 7 ? 19837261 : t) + ".png"; }));
    CHECK(serial.verdict == Verdict::unclear);
    CHECK(serial.reason ==
          "'frame_19.png' and 'frame_19837261.png' lie further apart than all others together");
    const NamesRead other = read_names(
        film(20, [](int t) { return t == 7 ? "DSC_0412.png" : "frame_" + padded(t, 4) + ".png"; }));
    CHECK(other.verdict == Verdict::unclear);
    CHECK(other.reason == "'DSC_0412.png' has another form than the other names");
  }

  TEST_CASE("a number that no two pictures share may count pictures: said as a guess") {
    const auto running = [](int c, int t) { return "img" + padded(12 * c + t, 4) + ".png"; };
    CHECK_FALSE(read_names(rig(3, 12, true, running)).sure);
    const auto with_camera = [&](int c, int t) { return "cam" + std::to_string(c) + "/" + running(c, t); };
    CHECK_FALSE(read_names(rig(3, 12, true, with_camera)).sure);
    CHECK_FALSE(read_names(rig(3, 12, false, with_camera)).sure);
    CHECK(read_names(rig(1, 12, true, running)).sure);  // one camera that stands still
    CHECK_FALSE(read_names(film(12, [](int t) { return "view_" + padded(t, 4) + ".png"; })).sure);
  }

  TEST_CASE("a date or decimals in a camera's name are not the time") {
    const auto start = [](int c, int t) {
      return "take_20240501_12000" + std::to_string(3 + c) + "/" + padded(t, 4) + ".png";
    };
    CHECK(counts_moments(read_names(rig(4, 12, true, start)), 4, 12));
    CHECK_FALSE(read_names(rig(4, 12, false, start)).sure);
    const auto angle = [](int c, int t) {
      return "view_" + std::to_string(10 + c) + ".50/frame_" + padded(t, 4) + ".png";
    };
    CHECK(counts_moments(read_names(rig(4, 12, true, angle)), 4, 12));
    CHECK(counts_moments(read_names(rig(4, 12, false, angle)), 4, 12));
    CHECK(read_names(film(20, [](int t) { return std::to_string(0.25 * t) + ".png"; })).sure == false);
    CHECK(read_names(film(20, [](int t) { return "t_" + std::to_string(0.25 * t) + ".png"; })).sure);
  }

  TEST_CASE("a camera's number behind a time of day is no part of a second, nor is a serial number a date") {
    const auto behind = [](int c, int t) {
      return "20240229_1059" + std::to_string(10 + t) + "_" + std::to_string(c) + ".png";
    };
    CHECK(counts_moments(read_names(rig(5, 12, false, behind)), 5, 12));
    const auto of_date = [](int c, int t) {
      return "2024-05-01_" + padded(t, 4) + "_" + padded(c, 2) + ".png";
    };
    CHECK(counts_moments(read_names(rig(5, 12, true, of_date)), 5, 12));
    const auto serial = [](int c, int t) {
      return "kinect" + std::to_string(20250114 + c) + "_20240229_1059" + std::to_string(10 + t) + ".png";
    };
    CHECK(counts_moments(read_names(rig(3, 12, false, serial)), 3, 12));
    const auto part = [](int t) { return "2024-02-29_10-59-07-" + std::to_string(100 + 40 * t) + ".png"; };
    CHECK(counts_moments(read_names(film(12, part)), 1, 12));
    const NamesRead mixed = read_names(film(4, [](int t) {
      return (t % 2 ? "20240229_105910" : "12345678_105910") + std::string("_") + std::to_string(t) + ".png";
    }));
    CHECK(mixed.verdict == Verdict::unclear);
  }

  TEST_CASE("points: padded numbers, three groups and nanoseconds are no decimals; even steps are") {
    const auto padded_point = [](int c, int t) { return "f" + padded(t, 4) + "." + padded(c, 3) + ".png"; };
    CHECK(counts_moments(read_names(rig(4, 12, true, padded_point)), 4, 12));
    const auto nanoseconds = [](int c, int t) {
      return "cam" + std::to_string(c) + "." + std::to_string(1700000000000000000LL + 40000000LL * t) +
             ".png";
    };
    CHECK(counts_moments(read_names(rig(3, 12, true, nanoseconds)), 3, 12));
    const auto quarters = [](int t) { return "t" + std::to_string(0.25 * t).substr(0, 4) + ".png"; };
    CHECK(counts_moments(read_names(film(20, quarters)), 1, 20));  // 0.00 to 4.75: five wholes, four parts
    CHECK_FALSE(read_names(rig(4, 12, false, [](int c, int t) {
                  return "view" + std::to_string(c) + ".000." + std::to_string(t) + ".png";
                })).sure);
  }

  TEST_CASE("a count behind a camera's number and a point is no decimal") {
    const auto form = [](int, int t) { return "kinect23117042." + std::to_string(t) + ".png"; };
    CHECK(counts_moments(read_names(rig(1, 12, true, form)), 1, 12));
    CHECK_FALSE(read_names(rig(1, 12, true, form)).sure);
    const char* quarters[] = {"t0.05.png", "t0.3.png", "t0.55.png", "t0.8.png"};
    CHECK(counts_moments(read_names(film(4, [&](int t) { return quarters[t]; })), 1, 4));
  }

  TEST_CASE("a count of six digits behind a date may look like a time after midnight: a guess") {
    const auto step = [](int by) {
      return [by](int t) { return "2024-05-01_" + padded(by * t, 6) + ".png"; };
    };
    CHECK_FALSE(read_names(film(12, step(1))).sure);
    CHECK(read_names(film(12, step(20))).verdict == Verdict::unclear);  // 000060 is no time
  }

  TEST_CASE("clocks keep their microseconds and nanoseconds") {
    const NamesRead read =
        read_names(film(8, [](int t) { return "20240229_105951." + padded(137 + 10 * t, 6) + ".png"; }));
    REQUIRE(read.times.size() == 8);
    for (int t = 0; t < 8; ++t) CHECK(read.times[std::size_t(t)] == doctest::Approx(1e-5 * t).epsilon(1e-12));
    const NamesRead nano =
        read_names(film(8, [](int t) { return std::to_string(1709204391000000100 + 7 * t) + ".png"; }));
    REQUIRE(nano.times.size() == 8);
    for (int t = 0; t < 8; ++t) CHECK(nano.times[std::size_t(t)] == doctest::Approx(7e-9 * t).epsilon(1e-12));
  }

  TEST_CASE("uneven decimals may be moments and cameras, some of them missing: a guess") {
    std::vector<std::string> names;
    for (int t = 0; t < 40; t += 3)
      for (const int camera : {1, 2})
        if (t + camera > 1)
          names.push_back("time" + std::to_string(t) + "." + std::to_string(camera) + ".png");
    CHECK_FALSE(read_names(film(int(names.size()), [&](int i) { return names[std::size_t(i)]; })).sure);
  }

  TEST_CASE("decimals of one whole number may be a moment and cameras: a guess") {
    CHECK_FALSE(read_names(film(17, [](int t) { return "frame1." + padded(t, 3) + ".png"; })).sure);
    CHECK_FALSE(read_names(film(17, [](int t) { return "20240229_105950." + padded(t, 2) + ".png"; })).sure);
    CHECK_FALSE(read_names(film(17, [](int t) {
                  return std::to_string(0.25 * t) + "frame_" + padded(t, 4) + ".png";
                })).sure);
  }

  TEST_CASE("two pictures of one camera and one moment contradict each other") {
    const auto depth = [](int c, int t) {
      return "cam" + std::to_string(c) + "/" + padded(t / 2, 4) + (t % 2 ? "_depth.png" : ".png");
    };
    const NamesRead read = read_names(rig(3, 12, true, depth));
    CHECK(read.verdict == Verdict::unclear);
    CHECK(read.reason == "'cam0/0000.png' and 'cam0/0000_depth.png' would be of one camera and one moment");
  }

  TEST_CASE("a picture that is listed twice does not contradict itself") {
    std::vector<NamedPicture> all = film(12, [](int t) { return "images/frame_" + padded(t, 4) + ".png"; });
    all.push_back({all[3].path, all[3].place, 1});
    const NamesRead read = read_names(all);
    REQUIRE(read.verdict == Verdict::times);
    CHECK(read.times[12] == read.times[3]);
  }

  TEST_CASE("a word that is a hexadecimal digit is no part of an identifier") {
    const auto form = [](int c, int t) {
      return "cam" + std::to_string(c) + "/f" + std::to_string(1700000000000LL + 40 * t) + ".png";
    };
    CHECK(counts_moments(read_names(rig(3, 12, true, form)), 3, 12));
  }

  TEST_CASE("a group may be chosen from either end; names without it are named") {
    const auto all =
        rig(2, 3, false, [](int c, int t) { return padded(t, 2) + "/x_" + padded(c, 2) + "_7.png"; });
    CHECK(times_of_group(all, 1) == std::vector<double>{0, 1, 2, 0, 1, 2});
    CHECK(times_of_group(all, -2) == std::vector<double>{0, 0, 0, 1, 1, 1});
    splinevox::test::expect_error(
        [&] { times_of_group(all, 4); },
        {"'00/x_00_7.png'", "no such group of digits", "there are 1: 00, 2: 00, 3: 7"});
    splinevox::test::expect_error([] { times_of_group({{"a", 0, 0}}, 1); }, {"there are none"});
  }

  TEST_CASE("names are ordered as people count") {
    CHECK(natural_less("a2", "a10"));
    CHECK_FALSE(natural_less("a10", "a2"));
    CHECK(natural_less("a2b1", "a2b02"));
    CHECK_FALSE(natural_less("a", "a"));
    CHECK(natural_less("a", "a1"));
    CHECK((natural_less("a1", "a01") != natural_less("a01", "a1")));
  }
}

}  // namespace
