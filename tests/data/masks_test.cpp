// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>

#include "data/masked.hpp"
#include "splinevox/data/image_io.hpp"

/// Masks beside pictures: which is whose, and what becomes of the pixels.
namespace {

using namespace splinevox;
using namespace splinevox::test;

TEST_SUITE("data/masks") {
  TEST_CASE("subject: white is kept, soft edges and all; without a word nothing is") {
    const Masked masked;
    const Dataset plain = masked.load({}), none = masked.load(with("none")),
                  data = masked.load(with("subject")), black = masked.load(with("subject-black"));
    CHECK_FALSE(plain.has_alpha);
    CHECK(plain.fingerprint == none.fingerprint);
    CHECK(notes_with(plain,
                     "masks are not used: 10 of 10 pictures have one, such as "
                     "'masks/frame_0000.png', on average 46% white")
              .size() == 1);
    CHECK(notes_with(plain, "--masks ignore passes over what is black").size() == 1);
    CHECK(notes_with(none, "mask").empty());
    CHECK(data.has_alpha);
    CHECK(masked
              .load([] {
                LoadOptions o = with("subject");
                o.pixels = false;
                return o;
              }())
              .has_alpha);
    CHECK(data.fingerprint != plain.fingerprint);
    CHECK(data.fingerprint != black.fingerprint);
    CHECK(notes_with(data, "masks show the subject: what is white is the scene").size() == 1);
    REQUIRE(data.masks.has_value());
    CHECK(data.masks->pictures == 10);
    CHECK(data.masks->white == doctest::Approx((5 + 128 / 255.0) / 12));
    for (int x = 0; x < kWide; ++x) {
      CHECK(first_frame(data).image.pixel(x, 3)[3] == 257 * left_half(x, 3));
      CHECK(first_frame(black).image.pixel(x, 3)[3] == 65535 - 257 * left_half(x, 3));
      CHECK(first_frame(data).image.pixel(x, 3)[1] == first_frame(plain).image.pixel(x, 3)[1]);
    }
    CHECK(first_frame(data).ignored.empty());
    const Dataset small = masked.load(with("subject", 2));
    CHECK(first_frame(small).image.pixel(2, 0)[3] == std::lround(257 * (255 + 128) / 2.0));
  }

  TEST_CASE("subject: pictures with alpha keep what both keep") {
    const Masked masked;
    for (int i = 0; i < kMasks; ++i)
      write_png(masked.folder.path() / "images" / ("frame_" + padded(i) + ".png"),
                flat_png(kWide, kHigh, {9, 80, 90, 51}));
    const Dataset data = masked.load(with("subject"));
    CHECK(first_frame(data).image.pixel(0, 0)[3] == 51 * 257);
    CHECK(first_frame(data).image.pixel(5, 0)[3] == std::lround(51 * 257 * (128 / 255.0)));
    CHECK(first_frame(data).image.pixel(6, 0)[3] == 0);
  }

  TEST_CASE("ignore: black says nothing; of a block all is ignored if any pixel is") {
    const Masked masked;
    const Dataset plain = masked.load({}), data = masked.load(with("ignore")),
                  white = masked.load(with("ignore-white")), small = masked.load(with("ignore", 4));
    CHECK_FALSE(data.has_alpha);
    CHECK(first_frame(plain).ignored.empty());
    CHECK(notes_with(data, "masks say what to ignore: what is black is neither drawn nor scored").size() ==
          1);
    CHECK(notes_with(white, "what is white is neither drawn").size() == 1);
    for (int x = 0; x < kWide; ++x) {
      CHECK(first_frame(data).ignored.test(x, 2) == (x > 5));
      CHECK(first_frame(white).ignored.test(x, 2) == (x <= 5));
      CHECK(first_frame(data).image.pixel(x, 2) == first_frame(plain).image.pixel(x, 2));
    }
    CHECK(first_frame(small).ignored.width() == 3);
    for (int x = 0; x < 3; ++x) CHECK(first_frame(small).ignored.test(x, 1) == (x > 0));
    CHECK(data.fingerprint != plain.fingerprint);
    CHECK(data.fingerprint != white.fingerprint);
  }

  TEST_CASE("moving: white moves; a square moves if any pixel of it does, and nothing else is changed") {
    const Masked masked;
    const Dataset plain = masked.load({}), data = masked.load(with("moving")),
                  black = masked.load(with("moving-black")), small = masked.load(with("moving", 4));
    CHECK(notes_with(plain, "--masks moving takes white as what moves").size() == 1);
    CHECK(
        notes_with(data, "masks say what moves: what is white may, all else stands still; 10 of 10").size() ==
        1);
    CHECK(notes_with(black, "what is black may").size() == 1);
    CHECK(data.masks->use == "moving");
    CHECK_FALSE(data.has_alpha);
    CHECK(first_frame(plain).moving.empty());
    CHECK(first_frame(data).image == first_frame(plain).image);
    CHECK(first_frame(data).ignored.empty());
    REQUIRE(first_frame(data).moving.factor == 1);
    CHECK(first_frame(data).moving.squares.width() == kWide);
    for (int x = 0; x < kWide; ++x)
      for (int y = 0; y < kHigh; ++y) {
        CHECK(first_frame(data).moving.test(x, y) == (x <= 5));
        CHECK(first_frame(black).moving.test(x, y) == (x > 5));
      }
    CHECK(first_frame(small).moving.squares.width() == 3);
    for (int x = 0; x < 3; ++x) CHECK(first_frame(small).moving.test(x, 1) == (x < 2));
    for (const Dataset* other : {&plain, &black}) CHECK(data.fingerprint != other->fingerprint);
    CHECK(data.fingerprint != masked.load(with("ignore-white")).fingerprint);
  }

  TEST_CASE(
      "moving: of large pictures at most 200 squares along them are known, the last with what is over") {
    const TempFolder folder;
    constexpr int kLarge = 407, kLow = 20;
    TrueLens lens;
    lens.wide = kLarge;
    lens.high = kLow;
    write_nerfstudio(folder.path(), true_cameras(lens, kMasks));
    for (int i = 0; i < kMasks; ++i) {
      const std::string name = "frame_" + padded(i) + ".png";
      write_png(folder.path() / "images" / name, grey_png([](int, int) { return 99; }, kLarge, kLow));
      write_png(folder.path() / "masks" / name,
                grey_png([](int x, int y) { return (x == 7 && y == 4) || (x == 406 && y == 19) ? 255 : 0; },
                         kLarge, kLow));
    }
    const CoarseMask moving = first_frame(load_dataset(folder.str(), with("moving"))).moving;
    CHECK(moving.factor == 3);
    CHECK(moving.squares.width() == 135);
    CHECK(moving.squares.height() == 6);
    CHECK(moving.squares.count() == 2);
    CHECK(moving.test(7, 4));
    CHECK(moving.squares.test(134, 5));
  }

  TEST_CASE("a mask that says where things move in its name ignores white") {
    const Masked masked(grey_png(left_half), "images/dynamic_mask_frame_");
    for (const auto& [use, ignores_white] :
         {std::pair{"ignore", true}, {"ignore-white", true}, {"ignore-black", false}}) {
      CAPTURE(use);
      const Dataset data = masked.load(with(use));
      CHECK(first_frame(data).ignored.test(0, 0) == ignores_white);
      CHECK(first_frame(data).ignored.test(9, 0) != ignores_white);
    }
  }

  TEST_CASE("white inside unused masks is marked for scores alone") {
    const Masked masked;
    LoadOptions options = with("");
    options.inside = true;
    options.downscale = 2;
    const Dataset data = masked.load(options);
    CHECK(data.fingerprint == masked.load(with("", 2)).fingerprint);
    CHECK(first_frame(data).ignored.empty());
    for (int x = 0; x < kWide / 2; ++x) CHECK(first_frame(data).inside.test(x, 0) == (x <= 2));
    options.rules.masks = "none";
    CHECK(first_frame(masked.load(options)).inside.empty());
  }

  TEST_CASE("a rig's masks belong to their cameras, in every place where programs put them") {
    using Name = std::string (*)(int, int);
    for (const Name& name :
         {Name([](int c, int k) { return "masks/cam0" + std::to_string(c) + "/" + padded(k); }),
          Name([](int c, int k) { return "seg/cam0" + std::to_string(c) + "/" + padded(k); }),
          Name([](int c, int k) { return "cam0" + std::to_string(c) + "/mask/" + padded(k); }),
          Name([](int c, int k) { return "cam0" + std::to_string(c) + "/" + padded(k) + "_mask"; }),
          Name([](int c, int k) { return "masks/cam0" + std::to_string(c) + "/" + padded(k) + ".png"; })}) {
      CAPTURE(name(0, 0));
      const TempFolder folder;
      write_rig(folder.path(), 3, 5,
                [](int c, int k) { return "cam0" + std::to_string(c) + "/" + padded(k) + ".png"; });
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 5; ++k)
          write_png(folder.path() / (name(c, k) + ".png"),
                    grey_png([&](int x, int y) { return x == c && y == k ? 255 : 0; }));
      const Dataset data = load_dataset(folder.str(), with("subject"));
      CHECK(frames_of(data) == 15);
      for (const Split& split : data.splits)
        for (const Frame& frame : split.frames) {
          const auto colour = frame.image.pixel(0, 0);
          const int c = colour[0] / 2570, k = colour[1] / 5140;
          for (int y = 0; y < kHigh; ++y)
            for (int x = 0; x < kWide; ++x)
              CHECK((frame.image.pixel(x, y)[3] == 65535) == (x == c && y == k));
        }
    }
  }

  TEST_CASE("of masks in several sizes the one of the picture's size is taken") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, kMasks));
    for (int i = 0; i < kMasks; ++i) {
      const std::string name = "/frame_" + padded(i) + ".png";
      write_png(folder.path() / ("masks" + name), grey_png(left_half, 2 * kWide, 2 * kHigh));
      write_png(folder.path() / ("masks_2" + name), grey_png(left_half));
    }
    CHECK(first_frame(load_dataset(folder.str(), with("subject"))).image.pixel(5, 0)[3] == 128 * 257);
  }

  TEST_CASE("masks that cannot be taken at their word are refused by name") {
    const Masked masked;
    const fs::path folder = masked.folder.path();
    CHECK(holds(masked.error("figure"), "--masks: there is no such use of masks"));
    write_png(folder / "masks/frame_0003.png", grey_png(left_half, 10, 9));
    for (const std::string use : {"subject", "ignore", "moving"}) {
      const std::string error = masked.error(use);
      CAPTURE(error);
      CHECK(holds(error, "masks/frame_0003.png, the mask of images/frame_0003.png"));
      CHECK(holds(error, "the mask is of another size than its picture"));
      CHECK(holds(error, "12 x 8"));
      CHECK(holds(error, "10 x 9"));
    }
    CHECK(notes_with(masked.load({}), "1 cannot be used: ").size() == 1);
    write_text(folder / "masks/frame_0003.png", "no picture");
    CHECK(holds(masked.error("subject"), "masks/frame_0003.png"));
    fs::remove_all(folder / "masks");
    for (const std::string use : {"subject", "ignore", "ignore-white", "moving", "moving-black"}) {
      const std::string error = masked.error(use);
      CAPTURE(error);
      CHECK(holds(error, "--masks " + use + " was asked for, but no picture has a mask"));
      CHECK(holds(error, "a folder masks, mask or seg"));
    }
    const Masked black(grey_png([](int, int) { return 0; })), white(grey_png([](int, int) { return 255; })),
        labels(grey_png([](int x, int) { return x % 3; }));
    CHECK(holds(black.error("subject"), "every mask is wholly black"));
    CHECK(holds(black.error("subject"), "--masks subject-black"));
    CHECK(holds(black.error("ignore"), "--masks ignore-white"));
    CHECK(holds(white.error("ignore-white"), "wholly white: nothing would be left"));
    CHECK(holds(white.error("moving"), "every mask is wholly white: all would move"));
    CHECK(holds(white.error("moving"), "--masks moving-black"));
    CHECK(holds(black.error("moving-black"), "every mask is wholly black: all would move"));
    CHECK(notes_with(black.load(with("moving")), "10 of them wholly black").size() == 1);
    for (const std::string use : {"subject", "moving", "moving-black"})
      CHECK(holds(labels.error(use), "they seem to be numbers of parts"));
    const Masked ones(grey_png([](int x, int) { return x % 2; }));  // 0 and 1 are black and white
    CHECK(ones.load(with("subject")).has_alpha);
    CHECK(notes_with(white.load(with("ignore")), "10 of them wholly white").size() == 1);
    CHECK(notes_with(black.load({}), "10 of them wholly black").size() == 1);
    const TempFolder flat;  // one folder of masks for all cameras
    write_rig(flat.path(), 3, 5,
              [](int c, int k) { return "cam0" + std::to_string(c) + "/" + padded(k) + ".png"; });
    for (int k = 0; k < 5; ++k) write_png(flat.path() / "masks" / (padded(k) + ".png"), grey_png(left_half));
    expect_error([&] { load_dataset(flat.str(), with("subject")); },
                 {"one mask is for several pictures by its name", "'masks/0000.png' for 'cam01/0000.png'",
                  "'cam02/0000.png'"});
  }

  TEST_CASE("a picture without a mask: left out, or used in full, or refused") {
    const Masked masked;
    fs::remove(masked.folder.path() / "masks/frame_0003.png");
    const Dataset subject = masked.load(with("subject")), ignore = masked.load(with("ignore"));
    CHECK(frames_of(subject) == 9);
    CHECK(notes_with(subject, "1 of 10 pictures have no mask and are left out").size() == 1);
    CHECK(frames_of(ignore) == 10);
    CHECK(notes_with(ignore,
                     "1 of 10 pictures have no mask: nothing of them is ignored, such as "
                     "'images/frame_0003.png'")
              .size() == 1);
    const Dataset moving = masked.load(with("moving"));
    CHECK(frames_of(moving) == 10);
    CHECK(notes_with(moving, "1 of 10 pictures have no mask: all of them may move").size() == 1);
    for (const Split& split : moving.splits)
      for (const Frame& frame : split.frames)
        CHECK(frame.moving.squares.all() == (frame.name == "frame_0003"));
    LoadOptions refuse = with("ignore");
    refuse.rules.missing = "refuse";
    expect_error([&] { masked.load(refuse); },
                 {"the picture has no mask", "none of 'images/frame_0003.png'"});
    fs::remove(masked.folder.path() / "masks/frame_0005.png");
    expect_error([&] { masked.load(with("subject")); },
                 {"the picture has no mask", "2 of 10 frames are like this", "--missing skip"});
    LoadOptions skip = with("subject");
    skip.rules.missing = "skip";
    CHECK(frames_of(masked.load(skip)) == 8);
  }

  TEST_CASE("a picture of which all is ignored is left out") {
    const Masked masked;
    write_png(masked.folder.path() / "masks/frame_0001.png", grey_png([](int, int) { return 0; }));
    const Dataset data = masked.load(with("ignore"));
    CHECK(frames_of(data) == 9);
    CHECK(notes_with(data, "pictures are left out because their masks ignore all of them, first frame_0001")
              .size() == 1);
    for (const Frame& frame : data.find("train")->frames) CHECK(frame.name != "frame_0001");
    const Dataset subject = masked.load(with("subject"));  // nobody is there at that moment
    CHECK(frames_of(subject) == 10);
    CHECK(notes_with(subject, "wholly transparent, first frame_0001").size() == 1);
    const Masked last(grey_png([](int, int) { return 0; }));  // somebody comes in at the end
    write_png(last.folder.path() / "masks/frame_0009.png", grey_png(left_half));
    CHECK(frames_of(last.load(with("subject"))) == 10);
    const Masked fine(grey_png([](int x, int y) { return (x + y) % 2 == 0 ? 255 : 0; }));
    expect_error([&] { fine.load(with("ignore", 2)); }, {"the masks ignore every pixel of the train split"});
  }

  TEST_CASE("DyCheck: alpha says where depth was measured; such pixels are ignored, and pictures opaque") {
    const TempFolder folder, copy;
    write_nerfies(folder.path(), true_cameras({}));
    write_text(folder.path() / "extra.json", "{}");
    Image image(kWide, kHigh, 4);
    for (std::size_t i = 0; i < image.data.size(); ++i)
      image.data[i] = i % 4 < 3 ? 0.5f : i < 40 ? 0.0f : 1.0f;
    const std::vector<char> png = encode_png(image);
    write_bytes(folder.path() / "rgb/2x/000_0000.png", Bytes(png.begin(), png.end()));
    for (const bool converted : {false, true}) {
      CAPTURE(converted);
      if (converted) convert_dataset(folder.str(), copy.str() + "/new", {});
      LoadOptions options;
      if (converted) options.rules.masks = "ignore";
      const Dataset data = load_dataset(converted ? copy.str() + "/new" : folder.str(), options);
      CHECK_FALSE(data.has_alpha);
      const Frame& f = data.find("train")->frames[0];
      CHECK(f.image.opaque());
      CHECK(f.ignored.count() == 10);
      CHECK(data.find("train")->frames[1].ignored.count() == 0);
    }
    LoadOptions as_it_is;
    as_it_is.rules.masks = "none";
    CHECK(load_dataset(folder.str(), as_it_is).has_alpha);
  }

  TEST_CASE("converted sets say the same") {
    for (const std::string before : {"masks/frame_", "images/dynamic_mask_frame_"}) {
      CAPTURE(before);
      const Masked masked(grey_png(left_half), before);
      for (const std::string use :
           {"", "none", "subject", "subject-black", "ignore", "ignore-white", "moving", "moving-black"}) {
        CAPTURE(use);
        const TempFolder out;
        ConvertOptions options;
        options.rules.masks = use;
        convert_dataset(masked.folder.str(), out.str() + "/new", {}, options);
        const auto again = [&](const std::string& as) { return load_dataset(out.str() + "/new", with(as)); };
        if (use == "none") CHECK_FALSE(again("").masks.has_value());
        if (use.empty())
          for (const std::string later : {"subject", "ignore", "moving"}) {
            const Dataset a = masked.load(with(later)), b = again(later);
            CHECK(first_frame(a).image == first_frame(b).image);
            CHECK(first_frame(a).moving == first_frame(b).moving);
            CHECK(first_frame(a).ignored == first_frame(b).ignored);
          }
        if (use.starts_with("subject")) {
          CHECK(again("").has_alpha);
          CHECK(first_frame(masked.load(with(use))).image == first_frame(again("")).image);
        }
        if (use.starts_with("ignore"))
          CHECK(first_frame(masked.load(with(use))).ignored == first_frame(again("ignore")).ignored);
        if (use.starts_with("moving"))
          CHECK(first_frame(masked.load(with(use))).moving == first_frame(again("moving")).moving);
      }
    }
  }
}

}  // namespace
