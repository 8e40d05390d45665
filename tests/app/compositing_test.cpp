// SPDX-License-Identifier: Apache-2.0
// Pictures for compositing programs. What another program reads of them is skipped with a clear line where
// there is no oiiotool (Debian: openimageio-tools).
#include "run/compositing.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "ball_scene.hpp"
#include "data/pictures/exr.hpp"
#include "math/camera.hpp"
#include "math/srgb.hpp"
#include "support/blob_model.hpp"
#include "support/splat_picture.hpp"

using namespace splinevox;
using namespace splinevox::test;
using run::Shot;
namespace fs = std::filesystem;

namespace {

Camera camera_at(double angle) {
  return looking_at({3 * std::cos(angle), 3 * std::sin(angle), 0.7}, {0.1, -0.05, 0}, 64, 1.6);
}

}  // namespace

TEST_SUITE("app/compositing") {
  TEST_CASE(
      "light times alpha over the background is the picture again, and empty pixels are 0 and far away") {
    const VoxelModel model = blob_model(24, {.moves = false}, 1, 6);
    const Camera camera = camera_at(0.3);
    const Rendered r = render_image(model, camera, 0),
                   clear = render_image(run::nothing_behind(model), camera, 0);
    const Image rgba = run::premultiplied(clear), z = run::depth_layer(r);
    double worst = 0;
    int soft = 0;
    for (std::size_t p = 0; p < rgba.pixels(); ++p) {
      const float alpha = rgba.data[4 * p + 3];
      soft += alpha > 0.2f && alpha < 0.8f;
      if (alpha == 0) CHECK(z.data[p] == run::kEmptyDepth);
      for (std::size_t c = 0; c < 3; ++c) {
        const float light = rgba.data[4 * p + c];
        if (alpha == 0) CHECK(light == 0);
        const float display = alpha > 0 ? linear_to_srgb(light / alpha) : 0;
        worst = std::max(worst, std::abs(double(alpha * display + (1 - alpha) * 1 - r.rgb.data[3 * p + c])));
      }
    }
    CHECK(soft > 20);
    CHECK(worst < 2e-3);
  }

  TEST_CASE("what is next to nothing has no depth, as what is nothing") {
    Rendered r;
    r.alpha = Image(3, 1, 1);
    r.depth = Image(3, 1, 1);
    r.alpha.data = {0, 5e-5f, 1};
    r.depth.data = {0, 0, 3};
    const Image z = run::depth_layer(r);
    CHECK(z.data == std::vector<float>{run::kEmptyDepth, run::kEmptyDepth, 3});
  }

  TEST_CASE("vectors of what stands still are the camera's own motion, and the way there is the way back") {
    const VoxelModel model = blob_model(24, {.moves = false});
    const Shot now{camera_at(0.3), 0.2}, next{camera_at(0.33), 0.4};
    const Rendered r = render_image(model, now.camera, now.time);
    const Image forward = run::motion_vectors(model, r, now, next);
    double worst = 0, longest = 0;
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        const std::size_t p = std::size_t(64 * y + x);
        const Vec3d seen{(x + 0.5 - 32) / now.camera.fx, -(y + 0.5 - 32) / now.camera.fy, -1};
        Vec3d place = now.camera.position;
        for (int a = 0; a < 3; ++a)
          place += double(r.depth.data[p]) * seen[a] * now.camera.axes[std::size_t(a)];
        const Projection then = project(next.camera, place);
        const float* v = forward.data.data() + 2 * p;
        longest = std::max(longest, std::abs(double(v[0])));
        if (r.alpha.data[p] < 0.05f) {
          CHECK(v[0] == 0);
          continue;
        }
        worst = std::max(
            {worst, std::abs(x + 0.5 + double(v[0]) - then.u), std::abs(y + 0.5 - double(v[1]) - then.v)});
      }
    CHECK(worst < 1e-3);
    CHECK(longest > 0.2);
    for (const float v : run::motion_vectors(model, r, now, now).data) CHECK(std::abs(v) < 1e-3f);
  }

  TEST_CASE("vectors of matter lead to where it is on the next picture") {
    const VoxelModel model = blob_model(48, {.points = 2, .shift = {-0.5f, 0.1f, 0.2f}});
    const Shot now{camera_at(1.2), 0.3}, next{camera_at(1.2), 0.4};
    const Rendered r = render_image(model, now.camera, now.time);
    const Image forward = run::motion_vectors(model, r, now, next);
    const Vec3d moved = 0.1 * Vec3d{0.5, -0.1, -0.2};  // the blob moves at -shift
    double worst = 0;
    int seen = 0;
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        const std::size_t p = std::size_t(64 * y + x);
        if (r.alpha.data[p] < 0.9f) continue;
        ++seen;
        Vec3d place = now.camera.position;
        const Vec3d at{(x + 0.5 - 32) / now.camera.fx, -(y + 0.5 - 32) / now.camera.fy, -1};
        for (int a = 0; a < 3; ++a)
          place += double(r.depth.data[p]) * at[a] * now.camera.axes[std::size_t(a)];
        const Projection then = project(now.camera, place + moved);
        worst = std::max({worst, std::abs(double(forward.data[2 * p]) - (then.u - x - 0.5)),
                          std::abs(double(forward.data[2 * p + 1]) - (y + 0.5 - then.v))});
      }
    CHECK(seen > 100);
    CHECK(worst < 0.05);
  }

  TEST_CASE("a part of a shot has the pictures of the whole, and another program reads what they say") {
    const SmallRun small;
    const auto render = [&](const std::string& out, const std::vector<std::string>& more) {
      std::vector<std::string> words{
          "render", small.run, "--out", small.path(out), "--camera", "orbit",    "--size",
          "24",     "--fps",   "25",    "--format",      "exr",      "--layers", "RGBA,Z,forward,backward"};
      words.insert(words.end(), more.begin(), more.end());
      return program(words);
    };
    const Ended whole = render("whole", {"--frames", "1001-1006"});
    CAPTURE(whole.err);
    REQUIRE(whole.code == 0);
    CHECK(contains(whole.out, "frame 1001 shows time 0, frame 1006 time 1"));
    REQUIRE(render("part", {"--frames", "1003-1004", "--at", "1001-1006"}).code == 0);
    for (const char* frame : {"1003", "1004"}) {
      const std::string name = std::string("/frame_") + frame + ".exr";
      CHECK(slurp(small.path("part") + name) == slurp(small.path("whole") + name));
    }
    CHECK_FALSE(fs::exists(small.path("part") + "/frame_1002.exr"));
    // Before the motion begins nothing moves.
    REQUIRE(render("before", {"--frames", "1000-1001", "--at", "1001-1006"}).code == 0);
    const auto longest = [&](const std::string& frame, const std::string& layer) {
      const std::string file = small.path("before") + "/frame_" + frame + ".exr";
      const std::vector<ExrLayer> all = read_exr_layers(file);
      const std::vector<float>& v = find_exr_layer(all, layer, file).image.data;
      return std::max(*std::max_element(v.begin(), v.end()), -*std::min_element(v.begin(), v.end()));
    };
    CHECK(longest("1001", "forward") > 0.01f);
    for (const char* layer : {"forward", "backward"}) CHECK(longest("1000", layer) == 0);

    const std::string path = small.path("part") + "/frame_1003.exr";
    const std::vector<ExrLayer> layers = read_exr_layers(path);
    CHECK(find_exr_layer(layers, "", path).channels == std::vector<std::string>{"R", "G", "B", "A", "Z"});
    CHECK(find_exr_layer(layers, "forward", path).image.channels == 2);
    if (found_in_path("oiiotool").empty()) {
      MESSAGE("skipped: no oiiotool, which would read the header as another program");
      return;
    }
    const Ended info = Started({"oiiotool", "--info", "-v", path}).wait();
    CAPTURE(info.out);
    CHECK(info.code == 0);
    for (const char* part :
         {"R (half), G (half), B (half), A (half), Z (float)", "forward.u (float), forward.v (float)",
          "chromaticities: 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329", "framesPerSecond: 25/1",
          "imageCounter: 1003", "worldToCamera: ", "worldToNDC: ", "lin_rec709_scene"})
      CHECK_MESSAGE(contains(info.out, part), part);
  }

  TEST_CASE("layers that a format has no room for, and times that are given twice, are refused by name") {
    const SmallRun small;
    const auto refusal = [&](const std::vector<std::string>& more) {
      std::vector<std::string> words{"render", small.run, "--out", small.path("out")};
      words.insert(words.end(), more.begin(), more.end());
      const Ended e = program(words);
      CHECK(e.code == 2);
      return e.err;
    };
    CHECK(contains(refusal({"--layers", "rgb,Z"}), "Z is a layer of numbers, not a picture"));
    CHECK(
        contains(refusal({"--layers", "rgb,RGBA", "--format", "exr"}), "rgb and RGBA are the same channels"));
    CHECK(contains(refusal({"--layers", "foward", "--format", "exr"}), "forward"));
    CHECK(contains(refusal({"--frames", "1-3", "--times", "0:1:3"}), "--times: the times are given twice"));
    CHECK(contains(refusal({"--at", "3"}), "--at: says where frames are in a shot"));
  }
}
