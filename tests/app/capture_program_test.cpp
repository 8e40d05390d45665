// SPDX-License-Identifier: Apache-2.0
// `capture` as a user meets it, with the real COLMAP where there is one.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include "app/program.hpp"
#include "data/layouts.hpp"
#include "run/folder_lock.hpp"
#include "run/support.hpp"
#include "splinevox/data/scene.hpp"

namespace {

namespace fs = std::filesystem;
using namespace splinevox;
using namespace splinevox::test;

bool shell(const std::string& command) { return std::system((command + " > /dev/null 2>&1").c_str()) == 0; }

/// A COLMAP that does what the cases of its script say, and nothing otherwise. $root is the folder given, and
/// what is captured must lie in $root/out.
void write_colmap(const std::string& root, const std::string& cases) {
  write_text(root + "/bin/colmap", R"(#!/bin/sh
root=$(dirname "$0")/..
case "$*" in
*-h)
  echo 'COLMAP 3.8'
  for option in database_path image_path image_list_path output_path match_list_path match_type \
      ImageReader.camera_model ImageReader.single_camera ImageReader.single_camera_per_folder \
      ImageReader.mask_path SiftExtraction.use_gpu SiftExtraction.num_threads \
      SiftExtraction.max_num_features SiftMatching.use_gpu SiftMatching.num_threads \
      ExhaustiveMatching.block_size Mapper.num_threads Mapper.extract_colors Mapper.min_model_size \
      Mapper.init_min_tri_angle Mapper.init_min_num_inliers Mapper.abs_pose_min_num_inliers \
      Mapper.ba_global_function_tolerance Mapper.ba_refine_extra_params; do
    echo "  --$option arg"
  done ;;
)" + cases + "esac\n");
  fs::permissions(root + "/bin/colmap", fs::perms::owner_all);
}

/// Runs `splinevox capture` with that COLMAP, what it says going to $root/said.
bool captures(const std::string& root, const std::string& words, int code,
              const std::string& path = "$root/bin:$PATH") {
  return shell("root=" + root + "; PATH=" + path + " " SPLINEVOX_PROGRAM " capture " + words +
               " > $root/said 2>&1; test $? = " + std::to_string(code));
}

/// Distances between all cameras of a data set, by the pictures' names.
std::vector<double> distances(const run::Json& transforms) {
  std::vector<std::pair<std::string, Vec3d>> places;
  for (const run::Json& frame : transforms["frames"]) {
    const auto at = [&](int row) { return frame["transform_matrix"][std::size_t(row)][3].get<double>(); };
    places.emplace_back(fs::path(frame["file_path"].get<std::string>()).stem().string(),
                        Vec3d{at(0), at(1), at(2)});
  }
  std::sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> all;
  for (const auto& [name, a] : places)
    for (const auto& [other, b] : places) all.push_back(length(a - b));
  return all;
}

TEST_SUITE("app/capture program") {
  TEST_CASE("films and bare pictures: every command names capture with the right path") {
    const TempFolder folder;
    const std::string root = folder.str();
    for (const char* name :
         {"film.mp4", "films/a.mp4", "films/b.mp4", "pictures/images/1.png", "outer/in/x.mov"})
      write_png(folder.path() / name, flat_png(4, 4));
    for (const auto& [given, named] : {std::pair{"film.mp4", "film.mp4"},
                                       {"films", "films"},
                                       {"pictures", "pictures"},
                                       {"pictures/images", "pictures/images"},
                                       {"outer", "outer/in"}})
      for (const char* verb : {"info", "train"}) {
        CAPTURE(given);
        CAPTURE(verb);
        std::vector<std::string> words{verb, root + "/" + given};
        if (std::string(verb) == "train") words.insert(words.end(), {"--out", root + "/run"});
        const Ended e = program(words);
        CHECK(e.code == 2);
        const std::string command = "splinevox capture " + root + "/" + named + " --out";
        CHECK(contains(e.err.substr(0, e.err.find('\n')), command));  // before what else there could be
      }
  }

  TEST_CASE("options out of range, a folder of something else, and missing programs are told") {
    const TempFolder folder;
    const std::string in = folder.str() + "/in", out = folder.str() + "/out";
    for (int i = 0; i < 4; ++i) write_png(in + "/" + std::to_string(i) + ".png", flat_png(8, 8));
    const auto said = [&](std::vector<std::string> more, const std::string& text) {
      CAPTURE(text);
      more.insert(more.begin(), {"capture", in, "--out", out});
      const Ended e = program(more);
      CHECK(e.code == 2);
      CHECK(contains(e.err, text));
      CHECK(!fs::exists(out + "/transforms.json"));
    };
    said({"--every", "2", "--frames", "3"}, "both say how many frames");
    said({"--lens", "round"}, "there is no such lens");
    said({"--fps", "0"}, "--fps");
    said({"--to", "0"}, "more seconds than --from");
    write_text(out + "/mine.txt", "keep");
    said({}, "there is something of that name already");
    said({"--fresh"}, "there is something of that name already");
    CHECK(fs::exists(out + "/mine.txt"));
    fs::remove(out + "/mine.txt");
    // While another one works there, nothing is thrown away.
    const fs::path work = fs::path(out) / "work";
    fs::create_directories(work);
    fs::create_directories(out + "/images");
    write_text(work / "state.json", "{}");
    write_text(out + "/images/a.png", "of the other");
    {
      const run::FolderLock other(out, "capturing into");
      said({"--fresh"}, "another process is capturing into this folder");
    }
    CHECK(slurp(out + "/images/a.png") == "of the other");
    fs::remove_all(work);
    fs::remove_all(out + "/images");
    const std::string bare = "PATH=" + folder.str() + " " SPLINEVOX_PROGRAM " capture ";
    CHECK(shell(bare + in + " --out " + out + " 2>" + folder.str() + "/said; test $? = 2"));
    CHECK(contains(slurp(folder.path() / "said"), "apt-get install --no-install-recommends colmap"));
    write_png(folder.path() / "film.mp4", flat_png(4, 4));
    CHECK(
        shell(bare + folder.str() + "/film.mp4 --out " + out + "2 2>" + folder.str() + "/said; test $? = 2"));
    CHECK(contains(slurp(folder.path() / "said"), "apt-get install"));
  }

  TEST_CASE("a small film becomes a data set whose cameras are the true ones but for place and size") {
    if (!shell("colmap -h") || !shell("ffmpeg -version")) {
      MESSAGE("skipped: there is no colmap, or no ffmpeg");
      return;
    }
    const TempFolder folder;
    const std::string root = folder.str(), scene = root + "/scene", out = root + "/out";
    REQUIRE(program({"synth", "static", "--out", scene, "--orbit", "0.35", "--room", "--frames", "16",
                     "--size", "240", "--quiet"})
                .code == 0);
    REQUIRE(shell("ffmpeg -v error -framerate 8 -i " + scene +
                  "/train/r_%03d.png -c:v libx264 -crf 8 -pix_fmt yuv420p " + root + "/film.mp4"));
    const std::vector<std::string> words{"capture", root + "/film.mp4", "--out", out, "--lens", "radial"};
    const Ended e = program(words);
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    CHECK(contains(e.err, "[4/5] cameras"));
    CHECK(contains(e.out, "16 of 16 pictures placed"));
    const run::Json figures = run::read_json(out + "/capture.json");
    CHECK(figures["reprojection_error"].get<double>() < 1);
    const Dataset data = load_dataset(out);
    CHECK(data.format == "nerfstudio / instant-ngp");
    CHECK(data.find("train")->frames.size() + data.find("test")->frames.size() == 16);

    const std::vector<double> found = distances(run::read_json(out + "/transforms.json")),
                              truth = distances(run::read_json(scene + "/transforms_train.json"));
    REQUIRE(found.size() == truth.size());
    double both = 0, own = 0, furthest = 0, worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      both += found[i] * truth[i];
      own += found[i] * found[i];
      furthest = std::max(furthest, truth[i]);
    }
    for (std::size_t i = 0; i < truth.size(); ++i)
      worst = std::max(worst, std::abs(both / own * found[i] - truth[i]));
    CHECK(worst < 0.02 * furthest);

    // Nothing is done twice; other options are another data set.
    const auto written = fs::last_write_time(out + "/work/database.db");
    const std::string before = slurp(out + "/transforms.json");
    CHECK(program(words).code == 0);
    CHECK(fs::last_write_time(out + "/work/database.db") == written);
    CHECK(slurp(out + "/transforms.json") == before);
    std::vector<std::string> other = words;
    other.insert(other.end(), {"--every", "2"});
    const Ended refused = program(other);
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "--fresh begins anew"));
  }

  TEST_CASE("a lens whose distortion ran away: cameras are found again without one") {
    const TempFolder folder;
    const std::string root = folder.str();
    const Cameras cameras = true_cameras();
    write_colmap_binary(root + "/models/straight", cameras, {"SIMPLE_RADIAL", 2, {11, 6, 4, 0}, "00"});
    write_colmap_binary(root + "/models/bent", cameras, {"SIMPLE_RADIAL", 2, {11, 6, 4, -40}, "00"});
    write_colmap(root, R"(
*sparse_straight*refine_extra_params\ 0*)
  cp -r "$root/models/straight/sparse/0" "$root/out/work/sparse_straight" ;;
mapper*) cp -r "$root/models/bent/sparse/0" "$root/out/work/sparse" ;;  # it may choose the distortion
)");
    const auto placed_all = [&] {
      const bool well = captures(root, "$root/models/straight/images --out $root/out", 0);
      CAPTURE(slurp(root + "/said"));
      CHECK(well);
      CHECK(contains(slurp(root + "/said"), "16 of 16 pictures placed"));
    };
    placed_all();
    CHECK(contains(slurp(root + "/said"), "cameras are found again without distortion"));
    CHECK(load_dataset(root + "/out").find("train")->frames.size() > 0);
    const auto written = fs::last_write_time(root + "/out/work/sparse_straight/0");
    placed_all();
    CHECK(fs::last_write_time(root + "/out/work/sparse_straight/0") == written);
  }

  TEST_CASE("--fresh removes nothing where it cannot begin, and never its sources") {
    const TempFolder folder;
    const std::string root = folder.str(), out = root + "/out";
    write_colmap(root, "");
    for (const char* name : {"work/state.json", "transforms.json", "capture.json"})
      write_text(out + "/" + name, "of the earlier call");
    for (const char* name : {"out/images/1.png", "out/images/2.png", "out/images/3.png", "out/masks/1.png",
                             "in/1.png", "in/2.png", "in/3.png", "two/1.png", "two/2.png"})
      write_png(root + "/" + name, flat_png(4, 4));
    write_text(root + "/film.mp4", "no film");
    fs::create_directories(root + "/links");
    for (const char* name : {"1.png", "2.png", "3.png"})
      fs::create_symlink(out + "/images/" + name, root + "/links/" + name);
    const std::map<std::string, std::string> before = files_of(out);
    const auto refused = [&](const std::string& words, const std::string& text,
                             const std::string& path = "$root/bin:$PATH") {
      CAPTURE(words);
      CHECK(captures(root, words + " --out $root/out", 2, path));
      CHECK(contains(slurp(root + "/said"), text));
      CHECK(files_of(out) == before);
    };
    refused("$root/film.mp4 --fresh --masks subject", "masks of films are not read");
    refused("$root/film.mp4 --fresh", "film.mp4");
    refused("$root/in --fresh --masks subject", "no picture has a mask");
    refused("$root/in --fresh --from 100", "no frame is between --from and --to");
    refused("$root/two --fresh", "there are too few pictures");
    refused("$root/in --fresh", "apt-get install --no-install-recommends colmap", "$root");
    for (const std::string source : {"$root/out/images", "$root/out", "$root/links", "$root/in/../out/images",
                                     "$root/in $root/two --walk $root/out/images"})
      for (const char* fresh : {"", " --fresh"})
        refused(source + fresh, "this source lies where capture writes and removes");
  }

  TEST_CASE("--fresh keeps what an earlier call made until the new data set is there") {
    const TempFolder folder;
    const std::string root = folder.str(), out = root + "/out", aside = out + "/earlier_capture";
    write_colmap_binary(root + "/model", true_cameras(), {"SIMPLE_RADIAL", 2, {11, 6, 4, 0}, "00"});
    write_colmap(root, R"(
mapper*) test -e "$root/found" && cp -r "$root/model/sparse/0" "$root/out/work/sparse" ;;
)");
    for (const char* name : {"images/a.png", "masks/a.png", "transforms.json", "capture.json"})
      write_text(out + "/" + name, "of the earlier call");
    write_text(out + "/work/state.json", "{}");
    const std::map<std::string, std::string> before = files_of(out);
    const std::string words = "$root/model/images --out $root/out";
    for (int i = 0; i < 2; ++i) {  // no model: neither the first call nor the second loses it
      CHECK(captures(root, words + " --fresh", 2));
      CHECK(contains(slurp(root + "/said"), "COLMAP could not place the pictures"));
      CHECK(files_of(aside) == before);
      CHECK(!fs::exists(out + "/transforms.json"));
    }
    // One that is stopped while it moves things: the next puts them back.
    fs::rename(out, root + "/later");
    fs::rename(root + "/later/earlier_capture", out);
    const std::string moving = aside + ".part";
    fs::create_directories(moving);
    for (const char* name : {"capture.json", "work"}) fs::rename(out + "/" + name, moving + "/" + name);
    CHECK(captures(root, words, 2));
    CHECK(contains(slurp(root + "/said"), "this is no state of a capture"));
    CHECK(files_of(out) == before);

    write_text(root + "/found", "");
    const bool made = captures(root, words + " --fresh", 0);
    CAPTURE(slurp(root + "/said"));
    CHECK(made);
    CHECK(!fs::exists(aside));
    CHECK(fs::exists(out + "/images/000000.png"));
    CHECK(!fs::exists(out + "/images/a.png"));
    CHECK(slurp(out + "/earlier_masks/a.png") == "of the earlier call");  // which no frame names
    CHECK(contains(slurp(out + "/transforms.json"), "images/000000.png"));
  }

  TEST_CASE("a walk past folders with blanks and # in their names: COLMAP knows pictures by numbers") {
    const TempFolder folder;
    const std::string root = folder.str(), work = root + "/out/work";
    for (const char* name : {"in/cam #1/a 0.png", "in/cam #1/a 1.png", "in/cam #1/a 2.png",
                             "in/cam #1/a 3.png", "in/cam #1/a 4.png", "in/#2/a 0.png", "in/#2/a 1.png",
                             "in/#2/a 3.png", "in/#2/a 4.png", "my walk/w 1.png", "my walk/w 2.png"})
      write_png(root + "/" + name, flat_png(12, 8));
    write_png(root + "/in/cam #1/a 0_mask.png", flat_png(12, 8, {255, 255, 255, 255}));
    write_colmap(root, R"(
feature_extractor*numbered/images*numbered/masks*)
  while read -r name; do
    test -f "$root/out/work/numbered/images/$name" && echo "$name" >> "$root/seen"
  done < "$root/out/work/pictures.txt"
  test -f "$root/out/work/numbered/masks/001/000004.png.png" && echo mask >> "$root/seen" ;;
)");
    const bool refused = captures(root, "$root/in --walk \"$root/my walk\" --out $root/out", 2);
    CAPTURE(slurp(root + "/said"));
    CHECK(refused);
    CHECK(contains(slurp(root + "/said"), "COLMAP could not place the cameras"));  // there is no model
    const std::string pictures = slurp(work + "/pictures.txt");
    // Folders are sorted; of a camera without the third of five moments the next is taken.
    CHECK(pictures ==
          "000/000000.png\n000/000002.png\n000/000003.png\n001/000004.png\n001/000006.png\n001/000008.png\n"
          "002/000009.png\n002/000010.png\n");
    CHECK(slurp(root + "/seen") == pictures + "mask\n");
    CHECK(!fs::exists(work + "/numbered"));
    CHECK(fs::exists(root + "/out/images/cam #1/a 0.png"));
    std::stringstream pairs(slurp(work + "/pairs.txt"));
    int lines = 0;
    for (std::string line; std::getline(pairs, line); ++lines) {
      CAPTURE(line);
      std::stringstream words(line);
      std::string a, b, more;
      words >> a >> b;
      CHECK(contains(pictures, a + "\n"));
      CHECK(contains(pictures, b + "\n"));
      CHECK(!(words >> more));
    }
    CHECK(lines == 28);  // all of eight pictures
  }

  TEST_CASE("pictures of nothing: an error that says what to film differently") {
    if (!shell("colmap -h")) {
      MESSAGE("skipped: there is no colmap");
      return;
    }
    const TempFolder folder;
    for (int i = 0; i < 4; ++i)
      write_png(folder.path() / "in" / (std::to_string(i) + ".png"), flat_png(64, 64, {90, 90, 90, 255}));
    const Ended e = program({"capture", folder.str() + "/in", "--out", folder.str() + "/out"});
    CHECK(e.code == 2);
    CHECK(contains(e.err, "COLMAP could not place the pictures"));
    CHECK(contains(e.err, "walk sideways or around"));
    CHECK(!fs::exists(folder.str() + "/out/transforms.json"));
  }
}

}  // namespace
