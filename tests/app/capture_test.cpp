// SPDX-License-Identifier: Apache-2.0
// What `capture` decides by itself, without COLMAP: frames, their times, masks, cameras of a model, messages.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "app/program.hpp"
#include "data/expect_error.hpp"
#include "data/pictures/film_read.hpp"
#include "run/capture/capture_cameras.hpp"
#include "run/capture/capture_frames.hpp"
#include "run/capture/capture_stages.hpp"
#include "run/capture/colmap_program.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/scene.hpp"

namespace {

namespace fs = std::filesystem;
using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

bool shell(const std::string& command) { return std::system((command + " > /dev/null 2>&1").c_str()) == 0; }

bool no_ffmpeg() {
  if (shell("ffmpeg -version")) return false;
  MESSAGE("skipped: there is no ffmpeg");
  return true;
}

/// A film of 96 x 64, 30 frames at `rate` a second, every third frame sharp.
void write_film(const fs::path& path, const std::string& more = "", const std::string& rate = "10",
                const std::string& filters = "") {
  fs::create_directories(path.parent_path());
  REQUIRE(shell("ffmpeg -v error -y -f lavfi -i testsrc=s=96x64:r=" + rate +
                " -frames:v 30 -vf \"boxblur=2:enable='mod(n,3)'" + filters +
                "\" -c:v libx264 -crf 5 -pix_fmt yuv420p " + more + " " + path.string()));
}

CaptureTalk quiet_talk() { return {Talk::quiet, {}}; }

std::vector<double> even_times(int count, double rate) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(i / rate);
  return times;
}

/// A model of cameras on a bent way around points, in a world that is tilted, moved and of a unit of its own.
data::ColmapModel some_model(const std::vector<std::string>& names, double focal = 400) {
  data::ColmapModel model;
  model.where = "model";
  data::ColmapCamera camera;
  camera.kind = data::find_kind(std::string("SIMPLE_PINHOLE"));
  camera.width = 320;
  camera.height = 240;
  camera.params = {focal, 160, 120};
  model.cameras[1] = camera;
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 500; ++i)
    model.points.push_back({10 + 3 * unit(rng), 3 * unit(rng), 5 + 3 * unit(rng)});
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double a = 0.1 * double(i), h = 0.5 * a;  // world to camera: a turn about y, the world's down
    model.images.push_back({{std::cos(h), 0, std::sin(h), 0}, {0.3 * double(i), 0.1 * a, 9}, 1, names[i]});
  }
  return model;
}

std::vector<CaptureFrame> frames_named(const std::vector<std::string>& names) {
  std::vector<CaptureFrame> frames;
  for (std::size_t i = 0; i < names.size(); ++i) frames.push_back({names[i], 0, double(i), ""});
  return frames;
}

Vec3d place(const CapturedScene::Placed& p) { return {p.matrix[3], p.matrix[7], p.matrix[11]}; }

TEST_SUITE("app/capture") {
  TEST_CASE("groups of frames hold every frame of the time asked for once, in order") {
    const std::vector<double> times = even_times(101, 25);
    for (const auto& [every, most] : {std::pair{0, 0}, {1, 0}, {7, 0}, {0, 10}, {0, 33}, {0, 1000}}) {
      CAPTURE(every);
      CAPTURE(most);
      const std::vector<FrameGroup> groups = frame_groups(times, 1, 3, every, most);
      REQUIRE(!groups.empty());
      CHECK(groups.front().first == 25);
      CHECK(groups.back().second == 76);
      for (std::size_t g = 0; g < groups.size(); ++g) {
        CHECK(groups[g].first < groups[g].second);
        if (g > 0) CHECK(groups[g].first == groups[g - 1].second);
        if (every > 0 && g + 1 < groups.size()) CHECK(groups[g].second - groups[g].first == every);
      }
      if (every == 0) CHECK(groups.size() == std::size_t(most == 0 ? 51 : std::min(most, 51)));
    }
    CHECK(frame_groups(times, 5, 9, 0, 10).empty());
  }

  TEST_CASE("at every moment the nearest frame, and none twice") {
    const std::vector<FrameGroup> at = frames_at({0, 0.1, 0.2, 0.35, 0.5}, {0, 0.04, 0.14, 0.3, 0.9});
    CHECK(at == std::vector<FrameGroup>{{0, 1}, {1, 2}, {3, 4}, {4, 5}});
  }

  TEST_CASE("sharpness: none of one colour, less after a blur, four times as much at twice the contrast") {
    constexpr int kSide = 32;
    std::vector<std::uint8_t> flat(3 * kSide * kSide, 90), fine = flat, soft = flat, strong = flat;
    const auto value = [](int x) { return x / 2 % 2 ? 20 : 0; };
    for (int p = 0; p < kSide * kSide; ++p)
      for (int c = 0; c < 3; ++c) {
        const std::size_t i = std::size_t(3 * p + c);
        const int x = p % kSide;
        fine[i] = std::uint8_t(90 + value(x));
        strong[i] = std::uint8_t(90 + 2 * value(x));
        soft[i] = std::uint8_t(90 + (value(x) + value(x + 1) + value(x + 2)) / 3);
      }
    CHECK(sharpness(flat, kSide, kSide) == doctest::Approx(0));
    CHECK(sharpness(soft, kSide, kSide) < 0.5 * sharpness(fine, kSide, kSide));
    CHECK(sharpness(strong, kSide, kSide) == doctest::Approx(4 * sharpness(fine, kSide, kSide)));
  }

  TEST_CASE("of a film the sharpest frames are written, with their own times and as a player shows them") {
    if (no_ffmpeg()) return;
    const TempFolder folder;
    const fs::path film = folder.path() / "film.mp4", turned = folder.path() / "turned.mp4";
    write_film(film);
    REQUIRE(
        shell("ffmpeg -v error -i " + film.string() + " -c copy -metadata:s:v rotate=90 " + turned.string()));
    for (const fs::path& source : {film, turned}) {
      CAPTURE(source);
      CaptureOptions options;
      options.every = 3;
      options.max_size = 64;
      CaptureTalk talk = quiet_talk();
      const auto plans = plan_capture(find_capture_input({source.string()}), options, talk);
      const fs::path out = folder.path() / source.stem();
      const std::vector<CaptureFrame> frames = write_capture_frames(plans, out, talk);
      REQUIRE(frames.size() == 10);
      for (std::size_t i = 0; i < 10; ++i) {
        CHECK(frames[i].name == "0000" + std::string(3 * i < 10 ? "0" : "") + std::to_string(3 * i) + ".png");
        CHECK(frames[i].time == doctest::Approx(0.3 * double(i)));
        const PictureSize size = read_picture_size(out / "images" / frames[i].name);
        CHECK(size == (source == film ? PictureSize{64, 42} : PictureSize{42, 64}));
      }
      CHECK(talk.notes().empty());
    }
  }

  TEST_CASE("frames that come unevenly keep their times; HDR is said; --from and --to are seconds") {
    if (no_ffmpeg()) return;
    const TempFolder folder;
    const fs::path film = folder.path() / "film.mkv";
    write_film(film, "-fps_mode passthrough -color_trc smpte2084", "1000", ",setpts='(N+0.25*N*N/30)/10/TB'");
    CaptureOptions options;
    options.from = 1;
    options.to = 2;
    CaptureTalk talk = quiet_talk();
    const auto plans = plan_capture(find_capture_input({film.string()}), options, talk);
    REQUIRE(plans.size() == 1);
    for (int i = 0; i < 30; ++i)
      CHECK(plans[0].times.at(std::size_t(i)) == doctest::Approx((i + 0.25 * i * i / 30) / 10).epsilon(0.01));
    CHECK(plans[0].times[std::size_t(plans[0].groups.front().first)] >= 1);
    CHECK(plans[0].times[std::size_t(plans[0].groups.back().first)] <= 2);
    REQUIRE(talk.notes().size() == 1);
    CHECK(contains(talk.notes()[0], "an HDR film (PQ)"));
    options.from = 20;
    options.to = 30;
    expect_error([&] { plan_capture(find_capture_input({film.string()}), options, talk); },
                 {"no frame is between --from and --to"});
  }

  TEST_CASE("a film has the frames that ffmpeg gives out, in every container and however it was cut") {
    if (no_ffmpeg()) return;
    const TempFolder folder;
    const std::string source = "ffmpeg -v error -y -f lavfi -i testsrc=s=64x48:r=25:d=3 -pix_fmt yuv420p ",
                      root = folder.str() + "/";
    const auto count = [](const data::FilmFacts& facts, const fs::path& film) {
      const auto last = [&](int i) {
        data::read_film(
            film, {64, 48}, true, {i}, [](std::size_t, Image16&&) {}, "film");
      };
      CHECK_NOTHROW(last(facts.frames() - 1));
      CHECK_THROWS_AS(last(facts.frames()), Error);
    };
    for (const std::string words : {"-c:v mpeg2video -bf 2 ;a.mpg", "-c:v mpeg4 -bf 2 ;b.avi",
                                    "-c:v libx264 -bf 2 ;c.avi", "-c:v libx264 -bf 2 -g 12 ;d.mp4"}) {
      CAPTURE(words);
      const std::string film = root + words.substr(words.find(';') + 1);
      REQUIRE(shell(source + words.substr(0, words.find(';')) + film));
      const data::FilmFacts facts = data::film_facts(film, "film");
      CHECK(facts.frames() == 75);
      CHECK(facts.times.back() == doctest::Approx(74 / 25.0));
      count(facts, film);
    }
    REQUIRE(shell("ffmpeg -v error -y -ss 1.1 -i " + root + "d.mp4 -c copy " + root + "cut.mp4"));
    const data::FilmFacts cut = data::film_facts(root + "cut.mp4", "film");
    CHECK(cut.frames() > 44);
    count(cut, root + "cut.mp4");
  }

  TEST_CASE("pixels that are not square become square, and interlaced films are named") {
    if (no_ffmpeg()) return;
    const TempFolder folder;
    const fs::path film = folder.path() / "film.mp4";
    write_film(film, "", "10", ",setsar=4/3");
    CaptureTalk talk = quiet_talk();
    const auto plans = plan_capture(find_capture_input({film.string()}), {}, talk);
    CHECK(plans.at(0).width == 128);
    CHECK(plans.at(0).height == 64);
    const fs::path rows = folder.path() / "rows.mpg";
    REQUIRE(
        shell("ffmpeg -v error -y -f lavfi -i testsrc=s=64x48:r=25:d=1 -vf setfield=tff -c:v mpeg2video "
              "-flags +ilme+ildct " +
              rows.string()));
    plan_capture(find_capture_input({rows.string()}), {}, talk);
    CHECK(contains(talk.notes().back(), "an interlaced film"));
  }

  TEST_CASE("cameras that stand still get the same moments, in films of different rates too") {
    if (no_ffmpeg()) return;
    const TempFolder folder;
    write_film(folder.path() / "rig/cam0.mp4");
    write_film(folder.path() / "rig/cam1.mp4", "-r 20");
    CaptureOptions options;
    options.frames = 5;
    CaptureTalk talk = quiet_talk();
    const auto plans = plan_capture(find_capture_input({(folder.path() / "rig").string()}), options, talk);
    REQUIRE(plans.size() == 2);
    REQUIRE(plans[0].groups.size() == 5);
    REQUIRE(plans[1].groups.size() == 5);
    for (std::size_t i = 0; i < 5; ++i)
      CHECK(std::abs(plans[0].times[std::size_t(plans[0].groups[i].first)] -
                     plans[1].times[std::size_t(plans[1].groups[i].first)]) < 0.051);
  }

  TEST_CASE("a long film gives few frames a second, which a note says; a film of few has no more") {
    if (no_ffmpeg()) return;
    const TempFolder folder;
    const auto notes_of = [&](const std::string& rate, const CaptureOptions& options) {
      const std::string film = (folder.path() / ("film" + rate + ".mp4")).string();
      REQUIRE(shell("ffmpeg -v error -y -f lavfi -i testsrc=s=32x32:r=" + rate +
                    " -frames:v 400 -pix_fmt yuv420p " + film));
      CaptureTalk talk = quiet_talk();
      plan_capture(find_capture_input({film}), options, talk);
      return talk.notes();
    };
    const std::vector<std::string> notes = notes_of("10", {});
    REQUIRE(notes.size() == 1);
    CHECK(contains(notes[0], "3.8 frames a second are taken"));
    CHECK(notes_of("60", {}).empty());
    CaptureOptions asked;
    asked.every = 20;
    CHECK(notes_of("10", asked).empty());
  }

  TEST_CASE("cameras of a rig that found no place: a walk is advised, unless there was one") {
    CaptureState state;
    state.rig = {"a", "b"};
    state.frames = {{"a/0.png", 0, 0, ""}, {"b/0.png", 1, 0, ""}};
    expect_error([&] { fail_placing(state, "0 of 2"); }, {"could not place the cameras", "--walk FILM"});
    state.frames.push_back({"walk/0.png", 2, 0, ""});
    expect_error([&] { fail_placing(state, "0 of 2"); },
                 {"could not place the cameras", "a walk that is slower"});
  }

  TEST_CASE("what sources stand for, and what is refused by name") {
    const TempFolder folder;
    const std::string root = folder.str();
    for (const char* name : {"one/a_1.png", "one/a_2.png", "one/a_1_mask.png", "deep/images/1.png",
                             "rig/c1/1.png", "rig/c2/1.png", "rig/masks/1.png", "both/1.png", "both/film.mp4",
                             "films/x.mp4", "films/y.MOV", "tiff/1.tif", "heic/1.heic"})
      write_png(folder.path() / name, flat_png(4, 4));
    const auto cameras = [&](const std::vector<std::string>& names) {
      std::vector<std::string> sources;
      for (const std::string& name : names) sources.push_back(root + "/" + name);
      return find_capture_input(sources);
    };
    CHECK(cameras({"one"}).at(0).pictures.size() == 2);
    CHECK(cameras({"one"}).at(0).name.empty());
    CHECK(cameras({"deep"}).at(0).pictures.size() == 1);
    REQUIRE(cameras({"rig"}).size() == 2);
    CHECK(cameras({"rig"})[1].name == "c2");
    CHECK(cameras({"films"}).size() == 2);
    CHECK(cameras({"films/x.mp4", "films/y.MOV"})[1].name == "y");
    CHECK(cameras({"rig/c1", "rig/c2"})[0].name == "c1");
    expect_error([&] { cameras({"both"}); }, {"there are films and pictures in this folder"});
    expect_error([&] { cameras({"none"}); }, {"there is no such film or folder"});
    expect_error([&] { cameras({"one/a_1.png"}); }, {"this is no film", "give the folder of the pictures"});
    expect_error([&] { cameras({"tiff"}); }, {"PNG and JPEG alone", "mogrify"});
    expect_error([&] { cameras({"heic"}); }, {"no films and no pictures", "mogrify"});
    expect_error([&] { cameras({"one", "films/x.mp4"}); }, {"some cameras have films and others pictures"});
    expect_error([&] { cameras({"films/x.mp4", "films/x.mp4"}); }, {"two cameras have this name"});
    for (const char* film : {"cards/a/GX01.MP4", "cards/b/GX01.MP4"})
      write_text(folder.path() / film, "film");
    for (const auto& found : {cameras({"cards"}), cameras({"cards/a", "cards/b"})}) {
      REQUIRE(found.size() == 2);
      CHECK(found[0].name == "a");
      CHECK(found[1].name == "b");
      CHECK(found[1].film.filename() == "GX01.MP4");
    }
    write_text(folder.path() / "cards/b/GX02.MP4", "film");
    expect_error([&] { cameras({"cards"}); }, {"cards/b", "several films", "ffmpeg -f concat"});
  }

  TEST_CASE("masks: no features where they ignore, none on a subject") {
    const TempFolder folder;
    write_png(folder.path() / "in/1.png", flat_png(4, 4));
    write_png(folder.path() / "in/masks/1.png", flat_png(4, 4, {255, 255, 255, 255}));
    const auto camera = find_capture_input({(folder.path() / "in").string()}).at(0);
    const auto share = [&](const char* use) {
      const data::MaskPlan masks = find_capture_masks(camera, use);
      REQUIRE(masks.files.size() == 1);
      return feature_mask(masks, 0).data[0];
    };
    CHECK(share("") == 1);
    CHECK(share("ignore") == 1);
    CHECK(share("ignore-white") == 0);
    CHECK(share("subject") == 0);
    CHECK(share("subject-black") == 1);
    CHECK(find_capture_masks(camera, "none").files.empty());
  }

  TEST_CASE("COLMAP's progress and options, as its versions write them") {
    CHECK(colmap_progress("Processed file [3/60]") == std::pair{3, 60});
    CHECK(colmap_progress("I20240801 12:00:00.1 99 feature_extraction.cc:258] Processed file [3/60]") ==
          std::pair{3, 60});
    CHECK(colmap_progress("Matching block [2/3, 1/3] in 0.2s") == std::pair{4, 9});
    CHECK(colmap_progress("Matching image [7/86] in 0.1s") == std::pair{7, 86});
    CHECK(colmap_progress("Registering image #41 (12)") == std::pair{12, 0});
    CHECK(!colmap_progress("  => Image sees 64 / 233 points"));
    const char* names = "SiftExtraction.use_gpu|FeatureExtraction.use_gpu";
    CHECK(colmap_option_name(names, "  --SiftExtraction.use_gpu arg (=1)\n") == "SiftExtraction.use_gpu");
    CHECK(colmap_option_name(names, "  --FeatureExtraction.use_gpu arg (=1)\n") ==
          "FeatureExtraction.use_gpu");
    CHECK(colmap_option_name(names, "  --SiftExtraction.use_gpus arg\n").empty());
  }

  TEST_CASE("a model becomes upright, around the origin and two units long, and stays the same scene") {
    const std::vector<std::string> names{"a.png", "b.png", "c.png", "d.png", "e.png"};
    const data::ColmapModel model = some_model({"a.png", "b.png", "d.png", "e.png"});
    const CapturedScene scene = place_frames(model, frames_named(names), {});
    REQUIRE(scene.frames.size() == 4);
    CHECK(scene.left_out == std::vector<std::string>{"c.png"});
    CHECK(scene.placed == 4);
    CHECK(scene.asked == 5);
    CHECK(contains(models_note(2, scene, "4 of 5 pictures"), "the largest is taken, 4 of 5 pictures"));
    CHECK(models_note(1, scene, "").empty());
    CHECK(models_note(2, place_frames(model, frames_named({"a.png", "b.png", "d.png", "e.png"}), {}), "")
              .empty());
    CHECK(scene.box.longest_edge() == doctest::Approx(2));
    CHECK(length(scene.box.center()) < 1e-6f);
    double up = 0;
    for (const auto& placed : scene.frames) up += placed.matrix[9] / 4;  // z of the camera's y axis
    CHECK(up > 0.99);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const Vec3d a = data::frame_of(model, model.images[i]).pose.position,
                    b = data::frame_of(model, model.images[k]).pose.position;
        CHECK(length(place(scene.frames[i]) - place(scene.frames[k])) ==
              doctest::Approx(scene.scale * length(a - b)));
      }
  }

  TEST_CASE("a camera that stands still has one pose for all its frames; a lens that is none has no place") {
    const std::vector<std::string> names{"x/1.png", "x/2.png", "y/1.png", "y/2.png", "z/1.png", "z/2.png"};
    data::ColmapModel model = some_model({"x/1.png", "y/1.png", "y/2.png"});
    model.images[2].rotation = model.images[1].rotation;
    model.images[2].translation = model.images[1].translation;
    const CapturedScene scene = place_frames(model, frames_named(names), {"x", "y", "z"});
    CHECK(scene.frames.size() == 4);
    CHECK(scene.left_out == std::vector<std::string>{"z"});
    CHECK(scene.unrest == doctest::Approx(0));
    CHECK(scene.frames[0].matrix == scene.frames[1].matrix);
    CHECK(scene.frames[1].matrix != scene.frames[2].matrix);
    model.images[2].translation.x += 1;
    CHECK(place_frames(model, frames_named(names), {"x", "y", "z"}).unrest > 0.05);
    for (const double focal : {20.0, 4000.0})
      CHECK(place_frames(some_model({"x/1.png", "y/1.png"}, focal), frames_named(names), {"x", "y"}).placed ==
            0);
  }
}

}  // namespace
