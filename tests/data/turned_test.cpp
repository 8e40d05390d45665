// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cstdlib>
#include <map>
#include <string>
#include <utility>

#include "data/expect_error.hpp"
#include "data/jpeg_bytes.hpp"
#include "data/pictures/film_read.hpp"
#include "data/rig_layouts.hpp"
#include "data/wild.hpp"
#include "splinevox/data/image_io.hpp"

/// Pictures and films that say how they are to be turned: which are, and what films' programs say of it.
namespace {

using namespace splinevox;
using namespace splinevox::test;

/// Which quarters of a black picture are bright.
std::string bright_in(const Picture& picture) {
  std::string found;
  for (const bool low : {false, true})
    for (const bool right : {false, true}) {
      const int x = (right ? 3 : 1) * picture.width / 4, y = (low ? 3 : 1) * picture.height / 4;
      if (picture.pixel(x, y)[1] < 40000) continue;
      found += found.empty() ? "" : ", ";
      found += low ? "lower " : "upper ";
      found += right ? "right" : "left";
    }
  return found;
}

/// A film of 12 x 8 with four frames, bright in its upper left quarter, that players turn clockwise.
void write_turned_film(const fs::path& path, int degrees) {
  fs::create_directories(path.parent_path());
  const std::string film = path.string(), plain = film + ".plain.mp4", angle = std::to_string(degrees),
                    other_way = std::to_string((360 - degrees) % 360);
  const std::string draw =
      "ffmpeg -v error -y -f lavfi -i color=c=black:s=12x8:r=5,drawbox=w=6:h=4:color=white:t=fill "
      "-frames:v 4 -c:v libx264 -qp 0 -pix_fmt yuv420p " +
      plain;
  const std::string turn_6 =
      "ffmpeg -v quiet -y -display_rotation -" + angle + " -i " + plain + " -c copy " + film;
  const std::string turn_5 =
      "ffmpeg -v error -y -i " + plain + " -c copy -metadata:s:v:0 rotate=" + other_way + " " + film;
  REQUIRE(std::system(draw.c_str()) == 0);
  REQUIRE(std::system((turn_6 + " || " + turn_5).c_str()) == 0);  // as ffmpeg 6 and later does it, or 5
  fs::remove(plain);
}

/// Scripts that stand before all programs of PATH.
class Scripts {
 public:
  Scripts() : usual_(std::getenv("PATH")) { ::setenv("PATH", (folder_.str() + ":" + usual_).c_str(), 1); }
  ~Scripts() { ::setenv("PATH", usual_.c_str(), 1); }
  Scripts(const Scripts&) = delete;
  Scripts& operator=(const Scripts&) = delete;
  void write(const std::string& program, const std::string& lines) const {
    write_text(folder_.path() / program, "#!/bin/sh\n" + lines);
    fs::permissions(folder_.path() / program, fs::perms::owner_all);
  }

 private:
  TempFolder folder_;
  std::string usual_;
};

/// A picture that EXIF turns, bright in its upper left quarter as it is stored: 12 x 8, or standing 8 x 12.
struct TurnedPicture {
  std::string name;
  int turn;
  bool standing = false;
};

/// Grey values of a picture that is bright in its upper left quarter.
Bytes quarter_rows(int wide, int high) {
  Bytes rows;
  for (int y = 0; y < high; ++y)
    for (int x = 0; x < wide; ++x) rows.push_back(x < wide / 2 && y < high / 2 ? 255 : 0);
  return rows;
}

/// The mask of such a picture, bright in its upper left quarter.
void write_quarter_mask(const fs::path& folder, const std::string& name, bool standing) {
  const int wide = standing ? kHigh : kWide, high = standing ? kWide : kHigh;
  write_png(folder / "m" / (name + ".png"), {wide, high, 8, PngKind::grey, quarter_rows(wide, high)});
}

/// A transforms file whose lens is for pictures of 12 x 8.
void write_turned_split(const fs::path& folder, const std::string& split,
                        const std::vector<TurnedPicture>& pictures) {
  std::vector<std::string> frames;
  for (const TurnedPicture& p : pictures) {
    JpegKind kind{p.standing ? kHigh : kWide, p.standing ? kWide : kHigh, 1, 100};
    kind.app1 = exif_turn(p.turn);
    write_text(folder / (p.name + ".jpg"), jpeg_bytes(kind, quarter_rows(kind.width, kind.height)));
    std::string frame = frame_text(p.name + ".jpg", std::to_string(frames.size()),
                                   matrix_text(orbit_matrix(0.3 * double(frames.size()))));
    if (fs::exists(folder / "m" / (p.name + ".png")))
      frame.insert(1, "\"mask_path\": \"m/" + p.name + ".png\", ");
    frames.push_back(std::move(frame));
  }
  write_text(folder / ("transforms_" + split + ".json"),
             transforms_text(frames, "\"fl_x\": 11, \"fl_y\": 11, \"w\": 12, \"h\": 8,"));
}

TEST_SUITE("data/turned") {
  TEST_CASE("films are turned as a player turns them, each for its lens, and stay so when converted") {
    if (!has_ffmpeg()) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    struct Kind {
      int degrees;
      TrueLens lens;
      std::string bright;
    };
    const TrueLens lying{11, 11, 6, 4}, standing{11, 11, 4, 6};
    for (const Kind& kind : {Kind{0, lying, "upper left"}, Kind{90, standing, "upper right"},
                             Kind{180, lying, "lower right"}, Kind{270, standing, "lower left"}}) {
      CAPTURE(kind.degrees);
      const TempFolder folder, out;
      write_easymocap(folder.path(), rig_cameras(3, kind.lens), 0);
      const fs::path first = folder.path() / "videos/00.mp4";
      write_turned_film(first, kind.degrees);
      for (const char* other : {"01.mp4", "02.mp4"}) fs::copy_file(first, folder.path() / "videos" / other);
      const Dataset data = load_dataset(folder.str());
      CHECK(frames_of(data) == 12);
      for (const Split& split : data.splits)
        for (const Frame& frame : split.frames) {
          CHECK(frame.image.width == int(2 * kind.lens.cx));
          CHECK(frame.camera.width == frame.image.width);
          CHECK(bright_in(frame.image) == kind.bright);
        }
      CHECK(notes_with(data, "are turned upright, as their film says").empty() == (kind.degrees == 0));
      CHECK(notes_with(data, "does not tell").empty());
      convert_dataset(folder.str(), out.str() + "/new");
      CHECK(bright_in(first_frame(load_dataset(out.str() + "/new")).image) == kind.bright);
    }
  }

  TEST_CASE("films whose lens is for the stored picture are read as stored, but for half turns") {
    if (!has_ffmpeg()) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    const TempFolder folder;
    write_easymocap(folder.path(), rig_cameras(3, {11, 11, 6, 4}), 0);
    for (int c = 0; c < 3; ++c)
      write_turned_film(folder.path() / "videos" / (numbered("", c) + ".mp4"), 90 * (c + 1));
    const Dataset data = load_dataset(folder.str());
    CHECK(frames_of(data) == 12);
    std::map<std::string, int> bright;
    for (const Split& split : data.splits)
      for (const Frame& frame : split.frames) {
        CHECK(frame.image.width == kWide);
        ++bright[bright_in(frame.image)];
      }
    CHECK(bright == std::map<std::string, int>{{"lower right", 4}, {"upper left", 8}});
    CHECK(notes_with(data, "are taken as stored, not turned as their film says: their cameras").size() ==
          data.splits.size());
  }

  TEST_CASE("a film's rotation is understood in the words of every ffprobe") {
    const Scripts scripts;
    const TempFolder folder;
    const fs::path film = folder.path() / "a.mp4";
    write_text(film, "film");
    const std::string stream = "stream|width=96|height=64|color_transfer=smpte2084";
    const std::pair<std::string, int> said[] = {
        {"", 0},
        {"|side_data|rotation=-90", 90},
        {"|side_data|rotation=90", 270},
        {"|side_data|rotation=180", 180},
        {"|side_data|rotation=-180", 180},
        {"|side_data|rotation=45", 0},
        {"|side_data|\nside_data|rotation=-90", 90},  // Dolby Vision's side data come first
        {"|side_datum/display_matrix:rotation=-90", 90}};
    for (const auto& [words, degrees] : said) {
      CAPTURE(words);
      scripts.write("ffprobe",
                    "cat << 'END'\npacket|pts_time=0.000000|flags=K__\n" + stream + words + "\nEND\n");
      const data::FilmFacts facts = data::film_facts(film, "a.mp4");
      CHECK(facts.rotation == degrees);
      CHECK(facts.width == 96);
      CHECK(facts.transfer == "smpte2084");
    }
  }

  TEST_CASE("pictures before the first one that needs no other are never shown, and have no times") {
    const Scripts scripts;
    const TempFolder folder;
    const fs::path film = folder.path() / "a.mp4";
    write_text(film, "film");
    scripts.write("ffprobe",
                  "cat << 'END'\nstream|width=96|height=64\npacket|pts_time=2.4|flags=K__\n"
                  "packet|pts_time=2.3|flags=___\npacket|pts_time=2.35|flags=___\n"
                  "packet|pts_time=2.5|flags=___\npacket|pts_time=2.6|flags=K__\n"
                  "packet|pts_time=2.55|flags=___\nEND\n");
    const data::FilmFacts facts = data::film_facts(film, "a.mp4");
    REQUIRE(facts.times.size() == 4);  // 2.4, 2.5, 2.55, 2.6
    CHECK(facts.times[1] == doctest::Approx(0.1));
    CHECK(facts.times[2] == doctest::Approx(0.15));
  }

  TEST_CASE("where ffmpeg gives out no picture, the message has its own words") {
    const Scripts scripts;
    const TempFolder folder;
    const fs::path film = folder.path() / "a.mp4";
    const auto read = [&] {
      data::read_film(
          film, {12, 8}, true, std::vector<int>{0}, [](std::size_t, Image16&&) {}, "a.mp4");
    };
    scripts.write("ffmpeg",
                  "echo \"Unrecognized option 'fps_mode'.\" >&2\n"
                  "echo 'Error splitting the argument list: Option not found' >&2\nexit 1\n");
    expect_error(read, {"a.mp4: ffmpeg cannot decode the film", "ffmpeg 5.1 or later",
                        "Unrecognized option 'fps_mode'.; Error splitting the argument list"});
    scripts.write("ffmpeg", "exit 0\n");
    expect_error(read, {"a.mp4: the film ends early", "0 that ffmpeg could decode", "copy the file again"});
  }

  TEST_CASE("EXIF: a half turn is taken as stored, with a doubt, whatever else is read") {
    const std::string stored = "test: 1 of 1 pictures are taken as stored, not turned as their EXIF says";
    for (const bool standing : {false, true})  // a quarter turn that is taken as stored, or as upright
      for (const int half : {2, 3, 4}) {
        CAPTURE(standing);
        CAPTURE(half);
        const TempFolder folder;
        write_turned_split(folder.path(), "train", {{"a", 6, standing}, {"b", 1}});
        write_turned_split(folder.path(), "test", {{"c", half}});
        const Dataset all = load_dataset(folder.str()),
                      test = load_dataset(folder.str(), {.splits = {"test"}});
        CHECK(bright_in(first_frame(all).image) == (standing ? "upper right" : "upper left"));
        for (const Dataset* data : {&all, &test}) {
          CHECK(bright_in(data->find("test")->frames.at(0).image) == "upper left");
          CHECK(notes_with(*data, stored + "; their size does not tell").size() == 1);
        }
      }
  }

  TEST_CASE("EXIF: what convert turns stays linear light where it is taken for that") {
    const TempFolder folder, out;
    write_turned_split(folder.path(), "train", {{"a", 6, true}, {"b", 1}});
    const DatasetRules rules{.transfer = "linear"};
    convert_dataset(folder.str(), out.str() + "/new", {}, {.rules = rules});
    const Dataset was = load_dataset(folder.str(), {.rules = rules}),
                  is = load_dataset(out.str() + "/new", {.rules = rules});
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(was.find("train")->frames.at(i).image == is.find("train")->frames.at(i).image);
    const PngHeader turned = read_png_header(out.path() / "new/train/a.png");
    CHECK(turned.bits == 16);
    CHECK(turned.samples == 3);
    CHECK(fs::exists(out.path() / "new/train/b.jpg"));
  }

  TEST_CASE("EXIF: a mask with a half turn lies as its picture is stored") {
    const TempFolder folder;
    write_quarter_mask(folder.path(), "a", true);
    write_quarter_mask(folder.path(), "b", false);
    write_turned_split(folder.path(), "train", {{"a", 6, true}, {"b", 3}});
    const Dataset data = load_dataset(folder.str(), {.rules = {.masks = "subject"}});
    CHECK(notes_with(data, "masks are turned as their pictures are").empty());
    const Picture& half = data.find("train")->frames.at(1).image;
    CHECK(bright_in(half) == "upper left");
    CHECK(half.pixel(3, 2)[3] == 65535);
    CHECK(half.pixel(9, 6)[3] == 0);
  }
}

}  // namespace
