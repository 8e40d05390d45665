// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "ball_scene.hpp"
#include "data/pictures/exr.hpp"
#include "run/support.hpp"
#include "splinevox/data/image_io.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;
using Scene = BallScene;

TEST_SUITE("app/run") {
  TEST_CASE("train leaves the files of a run; eval, info, verify, render, export and report read them") {
    const Scene scene;
    const Ended train = program(scene.train("run", "60", {"--threads", "2"}));
    CAPTURE(train.err);
    REQUIRE(train.code == 0);
    CHECK(contains(train.out, "peak memory"));
    const fs::path run = scene.path("run");
    for (const char* file :
         {"config.toml", "model.vdb", "checkpoint.bin", "metrics.jsonl", "metrics.json", "preview"})
      CHECK_MESSAGE(fs::exists(run / file), file);
    const std::string config = slurp(run / "config.toml");
    for (const char* part :
         {"preset = \"draft\"", "seed = 1", "[record]", "fingerprint = \"", "time_scale = ", "rays = 512"})
      CHECK_MESSAGE(contains(config, part), part);
    const Json trained = Json::parse(slurp(run / "metrics.json"));
    CHECK(trained["steps"] == 60);
    CHECK(trained["peak_memory_bytes"] > 1e6);
    CHECK(trained["phases"].size() >= 7);

    const Ended eval = program({"eval", run.string(), "--images", scene.path("pictures"), "--json"});
    CAPTURE(eval.err);
    REQUIRE(eval.code == 0);
    const Json printed = Json::parse(eval.out), saved = Json::parse(slurp(run / "metrics.json"));
    CHECK(printed["split"] == "test");
    CHECK(printed["frames"].size() == 3);
    CHECK(printed["psnr"] > 5);
    CHECK(saved["psnr"] == printed["psnr"]);
    CHECK(saved["steps"] == 60);
    CHECK(fs::exists(scene.path("pictures") + "/r_0.png"));
    CHECK(program({"eval", run.string(), "--split", "val"}).code == 0);
    CHECK(Json::parse(slurp(run / "metrics.json"))["split"] == "test");

    const Ended info = program({"info", run.string()});
    CHECK(info.code == 0);
    for (const char* part : {"density", "rgb", "PSNR"}) CHECK_MESSAGE(contains(info.out, part), part);
    CHECK(Json::parse(program({"info", run.string() + "/model.vdb", "--json"}).out)["grids"].size() >= 2);
    CHECK(contains(program({"info", scene.data}).out, "12 frames of 24x24"));
    const Ended verify = program({"verify", run.string()});
    CAPTURE(verify.out);
    CHECK(verify.code == 0);

    const Ended render = program({"render", run.string(), "--out", scene.path("views"), "--camera",
                                  "dataset:test", "--layers", "all"});
    CAPTURE(render.err);
    CHECK(render.code == 0);
    for (const char* file : {"rgb_0001.png", "alpha_0002.png", "depth_0003.png", "flow_0001.png",
                             "rigidity_0001.png", "cluster_0001.png"})
      CHECK_MESSAGE(fs::exists(scene.path("views") + "/" + file), file);
    CHECK(program({"render", run.string(), "--out", scene.path("exr"), "--camera", "orbit", "--times",
                   "0:1:2", "--size", "16", "--format", "exr", "--layers", "rgb,depth"})
              .code == 0);
    CHECK(fs::exists(scene.path("exr") + "/frame_0002.exr"));
    CHECK(program({"render", run.string(), "--out", scene.path("own"), "--camera",
                   scene.data + "/transforms_val.json", "--size", "20"})
              .code == 0);
    CHECK(fs::exists(scene.path("own") + "/rgb_0002.png"));
    CHECK(program({"render", run.string(), "--out", scene.path("shared"), "--camera", "dataset:test",
                   "--share", "2/2"})
              .code == 0);
    CHECK_FALSE(fs::exists(scene.path("shared") + "/rgb_0001.png"));
    CHECK(slurp(scene.path("shared") + "/rgb_0002.png") == slurp(scene.path("views") + "/rgb_0002.png"));

    const Ended exported =
        program({"export", run.string(), "--out", scene.path("vdb"), "--frames", "1-2", "--fps", "24"});
    CAPTURE(exported.err);
    CHECK(exported.code == 0);
    CHECK(program({"verify", scene.path("vdb")}).code == 0);
    for (const char* share : {"1/2", "2/2"})
      CHECK(program(
                {"export", run.string(), "--out", scene.path("shares"), "--frames", "1-2", "--share", share})
                .code == 0);
    CHECK(program({"verify", scene.path("shares")}).code == 2);
    CHECK(contains(program({"export", run.string(), "--out", scene.path("shares"), "--frames", "1-2"}).out,
                   "2 of them were there already"));
    CHECK(slurp(scene.path("shares") + "/manifest.json") == slurp(scene.path("vdb") + "/manifest.json"));

    write_text(scene.path("points.csv"), "id, x,y, z\na,0.1,0.2,0.3\nb, -0.1, 0, 0.5\n");
    const Ended track = program({"track", run.string(), "--points", scene.path("points.csv"), "--from", "0.5",
                                 "--to", "0,0.5,1", "--out", scene.path("tracks.csv")});
    CAPTURE(track.err);
    CHECK(track.code == 0);
    const std::string tracks = slurp(scene.path("tracks.csv"));
    CHECK(contains(tracks, "id,x,y,z,time,to_time,to_x,to_y,to_z,folded,density\n"));
    CHECK(contains(tracks, "b,-0.1,0,0.5,0.5,0.5,-0.1,0,0.5,"));
    CHECK(std::count(tracks.begin(), tracks.end(), '\n') == 7);
    CHECK(program({"track", run.string(), "--points", scene.path("points.csv"), "--to", "canonical", "--out",
                   scene.path("tracks.json"), "--quiet"})
              .code == 0);
    CHECK(Json::parse(slurp(scene.path("tracks.json")))["points"].size() == 2);

    const Ended truth = program({"eval", run.string(), "--truth", "--json"});
    CAPTURE(truth.err);
    CHECK(truth.code == 2);  // the data has none

    const Ended report = program({"report", run.string(), "--out", scene.path("page.html"), "--views", "2"});
    CAPTURE(report.err);
    CHECK(report.code == 0);
    const std::string page = slurp(scene.path("page.html"));
    for (const char* part :
         {"<canvas", "new Chart(", "data:image/png;base64,", "PSNR", "[record]", "</html>"})
      CHECK_MESSAGE(contains(page, part), part);
    for (const char* part : {"src=\"http", "href=\"http", "import(", "<script src"})
      CHECK_FALSE_MESSAGE(contains(page, part), part);

    std::string model = slurp(run / "model.vdb");
    model[model.size() / 2] ^= 1;
    write_text(run / "model.vdb", model);
    CHECK(program({"verify", run.string()}).code == 2);
    CHECK(program({"eval", run.string()}).code == 2);
  }

  TEST_CASE("effects are tried out, written down and reported; what is listed is used") {
    const Scene scene;
    const std::vector<std::string> trying{"--set", "effects.steps=50", "--set", "effects.min_gain=90"};
    const Ended chosen = program(scene.train("auto", "400", trying));
    CAPTURE(chosen.err);
    REQUIRE(chosen.code == 0);
    const Json effects = Json::parse(slurp(fs::path(scene.path("auto")) / "effects.json"));
    CHECK(effects["forced"] == false);
    CHECK(effects["effects"].size() == 5);
    CHECK(effects["fits"].size() == 4);
    // Nothing gains 90 dB: neither motion nor light nor presence is in the model.
    for (const Json& e : effects["effects"]) CHECK(e["used"] == (e["effect"] == "view"));
    CHECK(contains(slurp(fs::path(scene.path("auto")) / "config.toml"), "enabled = false"));
    CHECK(program({"report", scene.path("auto"), "--out", scene.path("auto.html")}).code == 0);
    CHECK(contains(slurp(scene.path("auto.html")), "<h3>Effects</h3>"));
    CHECK(program({"verify", scene.path("auto")}).code == 0);

    REQUIRE(program(scene.train("lit", "20", {"--effects", "light"})).code == 0);
    const Json forced = Json::parse(slurp(fs::path(scene.path("lit")) / "effects.json"));
    CHECK(forced["forced"] == true);
    CHECK(forced["used"]["light"] == true);
    CHECK(forced["used"]["motion"] == false);
    CHECK(program({"eval", scene.path("lit")}).code == 0);
  }

  TEST_CASE("behind opaque pictures a background is learned, unless a colour is asked for") {
    const Scene scene;
    REQUIRE(
        program({"synth", "ball", "--out", scene.path("wall"), "--frames", "12", "--size", "24", "--opaque"})
            .code == 0);
    const auto train = [&](const std::string& run, std::vector<std::string> more) {
      std::vector<std::string> words = scene.train(run, "20", {"--quiet", "--effects", "all"});
      words[1] = scene.path("wall");  // plain, and here it shall be learned
      words.insert(words.end(), {"--set", "run.find_ground=false"});
      words.insert(words.end(), more.begin(), more.end());
      const Ended e = program(words);
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      return Json::parse(program({"info", scene.path(run) + "/model.vdb", "--json"}).out)["meta"];
    };
    const Json learned = train("learned", {}), white = train("white", {"--background", "white"});
    CHECK(learned["splinevox_model"] == "6");  // all effects: presence too
    CHECK(learned.contains("background_harmonics"));
    CHECK(white["splinevox_model"] == "6");
    CHECK_FALSE(white.contains("background_harmonics"));
    CHECK(Json::parse(slurp(scene.path("learned") + "/effects.json"))["used"]["background"] == 2);
    CHECK(program({"eval", scene.path("learned")}).code == 0);
    // Pictures with alpha have none, and such a run is resumed with the words it was begun with.
    REQUIRE(program(scene.train("cut_out", "20", {"--quiet", "--effects", "all"})).code == 0);
    CHECK(Json::parse(slurp(scene.path("cut_out") + "/effects.json"))["used"]["background"] == -1);
    CHECK(program(scene.train("cut_out", "20", {"--quiet", "--effects", "all", "--resume"})).code == 0);
  }

  TEST_CASE("the psnr of a report is that of its rays' mean squared error per channel") {
    const Scene scene;
    REQUIRE(program(scene.train("run", "60", {"--quiet"})).code == 0);
    std::stringstream lines(slurp(scene.path("run") + "/metrics.jsonl"));
    int reports = 0;
    for (std::string line; std::getline(lines, line);) {
      const Json j = Json::parse(line);
      if (!j.contains("loss")) continue;
      ++reports;
      // The loss sums three channels and adds what motion costs; rays of different steps weigh a little
      // differently.
      const double of_loss = -10 * std::log10(j["loss"].get<double>() / 3);
      CHECK(j["psnr"].get<double>() > of_loss - 0.5);
      CHECK(j["psnr"].get<double>() < of_loss + 3);
    }
    CHECK(reports > 0);
  }

  TEST_CASE("eval and render take another downscale and background, and the run keeps its own figures") {
    const Scene scene;
    REQUIRE(program(scene.train("run", "20", {"--quiet"})).code == 0);
    const std::string metrics = slurp(scene.path("run") + "/metrics.json"),
                      manifest = slurp(scene.path("run") + "/manifest.json");
    CHECK(program({"render", scene.path("run"), "--out", scene.path("none"), "--camera", "dataset:test:,"})
              .code == 2);
    CHECK(program({"render", scene.path("run"), "--out", scene.path("none"), "--times", "0:2:2"}).code == 2);
    CHECK(program(
              {"track", scene.path("run"), "--points", "none.csv", "--to", ",", "--out", scene.path("t.csv")})
              .code == 2);
    CHECK(program({"synth", "ball", "--out", scene.data, "--frames", "2"}).code == 2);
    CHECK(program({"export", scene.path("run"), "--out", scene.path("run")}).code == 2);
    CHECK(slurp(scene.path("run") + "/manifest.json") == manifest);
    const Ended half =
        program({"eval", scene.path("run"), "--downscale", "2", "--background", "black", "--json"});
    CAPTURE(half.err);
    REQUIRE(half.code == 0);
    CHECK(Json::parse(half.out)["frames"].size() == 3);
    CHECK(slurp(scene.path("run") + "/metrics.json") == metrics);
    const Ended render = program({"render", scene.path("run"), "--out", scene.path("small"), "--camera",
                                  "dataset:test:0", "--downscale", "3"});
    CHECK(contains(render.out, "of 8x8"));
    CHECK(program({"eval", scene.path("run"), "--background", "mauve"}).code == 2);
  }

  TEST_CASE(
      "OpenEXR layers are the numbers behind the pictures, a film has every one of them, and cameras may "
      "come from a file of one") {
    const Scene scene;
    REQUIRE(program(scene.train("run", "30", {"--quiet"})).code == 0);
    const std::string run = scene.path("run");
    const auto render = [&](const std::string& out, std::vector<std::string> more) {
      std::vector<std::string> words{"render", run, "--out", scene.path(out), "--quiet"};
      words.insert(words.end(), more.begin(), more.end());
      const Ended e = program(words);
      CAPTURE(e.err);
      CHECK(e.code == 0);
    };
    render("png", {"--camera", "dataset:test"});
    render("exr", {"--camera", "dataset:test", "--format", "exr", "--layers", "rgb,alpha,depth,flow"});
    const std::string path = scene.path("exr") + "/frame_0002.exr";
    const std::vector<ExrLayer> layers = read_exr_layers(path);
    const Image& rgb = find_exr_layer(layers, "", path).image;
    const Image16 png = read_png(scene.path("png") + "/rgb_0002.png");
    REQUIRE(rgb.width == png.width);
    double apart = 0;
    for (std::size_t p = 0; p < rgb.pixels(); ++p)
      for (std::size_t c = 0; c < 3; ++c)
        apart = std::max(apart, std::abs(double(std::clamp(rgb.data[3 * p + c], 0.0f, 1.0f)) -
                                         png.rgba[4 * p + c] / 65535.0));
    CHECK(apart <= 0.501 / 255);
    float opaque = 0, deepest = 0;
    for (const float a : find_exr_layer(layers, "alpha", path).image.data) opaque = std::max(opaque, a);
    for (const float d : find_exr_layer(layers, "depth", path).image.data)
      deepest = std::max(deepest, std::isfinite(d) ? d : INFINITY);
    CHECK(std::isfinite(deepest));
    CHECK(opaque > 0.5f);
    CHECK(deepest > 0);
    CHECK(find_exr_layer(layers, "flow", path).channels == std::vector<std::string>{"X", "Y", "Z"});

    render("film", {"--camera", "orbit", "--times", "0:1:5", "--size", "32", "--format", "mp4"});
    const Ended probe =
        Started({"ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-show_entries",
                 "stream=width,height,nb_read_frames", "-of", "csv=p=0", scene.path("film") + "/rgb.mp4"})
            .wait();
    CHECK(probe.out == "32,32,5\n");

    Json camera = Json::parse(slurp(scene.data + "/transforms_test.json"));
    Json alone = camera["frames"][1];
    if (camera.contains("camera_angle_x")) alone["camera_angle_x"] = camera["camera_angle_x"];
    alone["w"] = png.width;
    alone["h"] = png.height;
    test::write_text(scene.path("camera.json"), alone.dump());
    render("alone", {"--camera", scene.path("camera.json")});
    CHECK(slurp(scene.path("alone") + "/rgb_0001.png") == slurp(scene.path("png") + "/rgb_0002.png"));
    // As data sets may have them: three rows, or a last row that all others are to be divided by.
    Json& matrix = alone["transform_matrix"];
    matrix.erase(3);
    test::write_text(scene.path("camera.json"), alone.dump());
    render("three", {"--camera", scene.path("camera.json")});
    CHECK(slurp(scene.path("three") + "/rgb_0001.png") == slurp(scene.path("png") + "/rgb_0002.png"));
    for (Json& row : matrix)
      for (Json& number : row) number = 2 * number.get<double>();
    matrix.push_back(Json::array({0, 0, 0, 2}));
    test::write_text(scene.path("camera.json"), alone.dump());
    const Ended divided =
        program({"render", run, "--out", scene.path("divided"), "--camera", scene.path("camera.json")});
    CAPTURE(divided.err);
    CHECK(divided.code == 0);
    CHECK(contains(divided.out, "the last row of every matrix is 0 0 0 2: all were divided by it"));
    CHECK(slurp(scene.path("divided") + "/rgb_0001.png") == slurp(scene.path("png") + "/rgb_0002.png"));
    matrix.push_back(Json::array({0, 0, 0, 1}));
    test::write_text(scene.path("camera.json"), alone.dump());
    CHECK(contains(
        program({"render", run, "--out", scene.path("none"), "--camera", scene.path("camera.json")}).err,
        "frame 0: 'transform_matrix' has the wrong shape"));
    test::write_text(scene.path("camera.json"), "{\"camera_angle_x\": 0.7}");
    CHECK(contains(
        program({"render", run, "--out", scene.path("none"), "--camera", scene.path("camera.json")}).err,
        "there are no frames in this file"));
  }
}
