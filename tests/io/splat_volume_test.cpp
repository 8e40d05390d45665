// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <random>
#include <string>

#include "io/scratch.hpp"
#include "io/splat/splat_gaussian.hpp"
#include "io/vdb/vdb_file.hpp"
#include "math/rotation.hpp"
#include "math/splat.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/import_splats.hpp"
#include "splinevox/io/inspect.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "support/blob_model.hpp"
#include "support/grid_picture.hpp"
#include "support/splat_picture.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

Splat splat_of(const Vec3d& place, const Vec3d& size, const Quaternion& rotation, double opacity) {
  Splat s;
  s.place = place;
  s.size = size;
  s.rotation = rotation;
  s.opacity = opacity;
  return s;
}

Quaternion random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Quaternion q;
  double norm = 0;
  for (double& v : q) {
    v = normal(random);
    norm += v * v;
  }
  for (double& v : q) v /= std::sqrt(norm);
  return q;
}

/// Its integral over a voxel by 24^3 midpoints.
double brute_force(const LatticeGaussian& g, Int3 v) {
  const auto& c = g.covariance;
  const double det = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[1][2]) -
                     c[0][1] * (c[0][1] * c[2][2] - c[1][2] * c[0][2]) +
                     c[0][2] * (c[0][1] * c[1][2] - c[1][1] * c[0][2]);
  double inverse[3][3];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      inverse[a][b] = (c[(a + 1) % 3][(b + 1) % 3] * c[(a + 2) % 3][(b + 2) % 3] -
                       c[(a + 1) % 3][(b + 2) % 3] * c[(a + 2) % 3][(b + 1) % 3]) /
                      det;
  const int n = 24;
  double sum = 0;
  for (int i = 0; i < n * n * n; ++i) {
    const double at[3] = {i / (n * n) + 0.5, i / n % n + 0.5, i % n + 0.5};
    double x[3], square = 0;
    for (int a = 0; a < 3; ++a) x[a] = v[a] - 0.5 + at[a] / n - g.mean[a];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) square += inverse[a][b] * x[a] * x[b];
    sum += std::exp(-square / 2);
  }
  return g.mass * sum / (n * n * n) / std::pow(2 * std::numbers::pi, 1.5) / std::sqrt(det);
}

void write_ply(const std::string& path, const std::vector<Splat>& splats) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(splats.size()) + "\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                           "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    text += std::string("property float ") + name + "\n";
  text += "end_header\n";
  for (const Splat& s : splats) {
    for (const double v : {s.place.x, s.place.y, s.place.z, s.color[0].x, s.color[0].y, s.color[0].z,
                           std::log(s.opacity / (1 - s.opacity)), std::log(s.size.x), std::log(s.size.y),
                           std::log(s.size.z), s.rotation[0], s.rotation[1], s.rotation[2], s.rotation[3]})
      text += std::to_string(v) + " ";
    text += "\n";
  }
  spit(path, text);
}

ImportOptions import_options(double voxel_size) {
  ImportOptions o;
  o.profile = "houdini";
  o.voxel_size = voxel_size;
  o.half = false;
  return o;
}

Image clamped_picture(Image image) {
  for (float& v : image.data) v = std::clamp(v, 0.0f, 1.0f);
  return image;
}

}  // namespace

TEST_SUITE("io/splat_volume") {
  TEST_CASE("voxels hold the integrals of a Gaussian, turned or not, thin or round, and all of its mass") {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-2, 2), log_size(-1.5, 1);
    for (int trial = 0; trial < 24; ++trial) {
      const Vec3d size{std::exp(log_size(random)), std::exp(log_size(random)), std::exp(log_size(random))};
      const Quaternion turn = trial % 3 == 0 ? Quaternion{1, 0, 0, 0} : random_rotation(random);
      const Splat s = splat_of({place(random), place(random), place(random)}, size, turn, 0.6);
      const LatticeGaussian g = on_lattice(s, {0.25, 0.5, 1}, 1);
      double sum = 0, red = 0, largest = 0, worst = 0;
      Vec3d middle{};
      for (int x = -3; x < 3; ++x)
        for (int y = -3; y < 3; ++y)
          for (int z = -3; z < 3; ++z) {
            const Int3 corner = kBrick * Int3{x, y, z};
            BrickSums sums;
            add_to_brick(g, corner, sums);
            for (int i = 0; i < kBrickRows; ++i) {
              const double depth = sums.depth[i];
              const Int3 v = corner + Int3{i >> 6, i >> 3 & 7, i & 7};
              sum += depth;
              red += sums.color[i][0];
              middle += depth * cast<double>(v);
              largest = std::max(largest, depth);
              if (depth > 0.3 * largest && i % 3 == 0)
                worst = std::max(worst, std::abs(depth - brute_force(g, v)));
            }
          }
      CAPTURE(trial);
      CHECK(sum == doctest::Approx(g.mass).epsilon(0.004));
      CHECK(red == doctest::Approx(0.25 * sum));
      CHECK(length(1 / sum * middle - g.mean) < 0.1);  // a thin one is taken to be where its voxel is
      CHECK(worst < 0.03 * largest);
    }
  }

  TEST_CASE("a round splat hides the same in voxels of any size; a flat one, what it hides from the front") {
    for (const double spacing : {0.5, 1.0, 2.0}) {
      const double area = spacing * spacing;
      const LatticeGaussian round =
          on_lattice(splat_of({}, {1, 1, 1}, {1, 0, 0, 0}, 0.5), {1, 1, 1}, spacing);
      CHECK(round.mass * area == doctest::Approx(splat_cross_section(0.5, 1, 1)));
      const LatticeGaussian flat =
          on_lattice(splat_of({}, {2, 0.01, 3}, {1, 0, 0, 0}, 0.5), {1, 1, 1}, spacing);
      CHECK(flat.mass * area == doctest::Approx(splat_cross_section(0.5, 2, 3)));
    }
  }

  TEST_CASE("the same bytes for any number of threads; a box leaves out what is outside of it") {
    const Scratch scratch;
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-1, 1);
    std::vector<Splat> splats;
    for (int i = 0; i < 300; ++i) {
      splats.push_back(splat_of({place(random), place(random), place(random)}, {0.05, 0.02, 0.1},
                                random_rotation(random), 0.7));
      splats.back().color[0] = {place(random), place(random), place(random)};
    }
    splats.push_back(splat_of({NAN, 0, 0}, {1, 1, 1}, {1, 0, 0, 0}, 0.5));
    write_ply(scratch.path("a.ply"), splats);
    const auto frames = splat_frames(scratch.path("a.ply"));
    std::vector<FileDigest> digests;
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 3);
    for (const int threads : {1, 3})
      tbb::task_arena(threads).execute([&] {
        const ImportResult result =
            import_splats(frames, scratch.path(std::to_string(threads)), import_options(0.03));
        digests.push_back(result.frames[0].file.digest);
        CHECK(result.frames[0].file.figures.at("splats_skipped") == 1);
      });
    CHECK(digests[0] == digests[1]);

    ImportOptions boxed = import_options(0.03);
    boxed.box = ImportOptions::Box{{-0.5, -2, -2}, {0.25, 2, 2}};
    const ImportResult result = import_splats(frames, scratch.path("boxed"), boxed);
    CHECK(result.frames[0].file.figures.at("min_x") >= -0.5);
    CHECK(result.frames[0].file.figures.at("max_x") <= 0.25);
    const VdbFile all = read_vdb(scratch.path("1/frame_0001.vdb")),
                  part = read_vdb(scratch.path("boxed/frame_0001.vdb"));
    const DenseGrid whole(all.grids[0]), inside(part.grids[0]);
    for (const Vec3d x : {Vec3d{0, 0, 0}, {-0.3, 0.6, 0.3}, {0.15, -0.9, 0.6}}) {
      double a = 0, b = 0;
      whole.at(x, &a);
      inside.at(x, &b);
      CHECK(a == b);
    }
    for (const FileCheck& check : verify(scratch.path("boxed"))) CHECK(check.ok);
  }

  TEST_CASE("a sky that reaches over too many bricks is refused with what to do") {
    const Scratch scratch;
    write_ply(scratch.path("sky.ply"), {splat_of({}, {1e4, 1e4, 1e4}, {1, 0, 0, 0}, 0.5)});
    CHECK_THROWS_WITH_AS(
        import_splats(splat_frames(scratch.path("sky.ply")), scratch.path("out"), import_options(0.01)),
        doctest::Contains("--box around what is wanted"), Error);
    // Small ones far apart fill few bricks, in a box of very many. What was in the folder stays.
    const auto ball = [](double at) { return splat_of({at, at, at}, {0.02, 0.02, 0.02}, {1, 0, 0, 0}, 0.9); };
    write_ply(scratch.path("near.ply"), {ball(0)});
    write_ply(scratch.path("apart.ply"), {ball(0), ball(1e4)});
    ImportOptions options = import_options(0.01);
    import_splats(splat_frames(scratch.path("near.ply")), scratch.path("out"), options);
    const std::string list = slurp(scratch.path("out/manifest.json"));
    options.afresh = true;
    CHECK_THROWS_WITH_AS(import_splats(splat_frames(scratch.path("apart.ply")), scratch.path("out"), options),
                         doctest::Contains("--box around what is wanted"), Error);
    CHECK(slurp(scratch.path("out/manifest.json")) == list);
    for (const FileCheck& check : verify(scratch.path("out"))) CHECK(check.ok);
    // And what is refused in a new folder claims nothing: a box, as it asks for, is taken.
    options.afresh = false;
    const auto apart = splat_frames(scratch.path("apart.ply"));
    CHECK_THROWS_AS(import_splats(apart, scratch.path("new"), options), Error);
    options.box = ImportOptions::Box{{-1, -1, -1}, {1, 1, 1}};
    CHECK(import_splats(apart, scratch.path("new"), options).finished);
  }

  TEST_CASE("frames are the numbers that names end in, else their order; what is there is not overwritten") {
    const Scratch scratch;
    const Splat s = splat_of({}, {0.1, 0.1, 0.1}, {1, 0, 0, 0}, 0.5);
    std::filesystem::create_directories(scratch.path("in"));
    for (const char* name : {"f_0012.ply", "f_0010.ply", "f_0011.ply"})
      write_ply(scratch.path("in/") + name, {s});
    const auto frames = splat_frames(scratch.path("in"));
    REQUIRE(frames.size() == 3);
    CHECK(frames[0].frame == 10);
    CHECK(frames[2].frame == 12);
    ImportOptions options = import_options(0.05);
    options.profile = "usd";
    const ImportResult result = import_splats(frames, scratch.path("out"), options);
    CHECK(result.finished);
    CHECK(std::filesystem::exists(scratch.path("out/frame_0011.vdb")));
    CHECK(slurp(scratch.path("out/sequence.usda")).find("10: @./frame_0010.vdb@") != std::string::npos);
    options.profile = "blender";
    CHECK_THROWS_WITH_AS(import_splats(frames, scratch.path("out"), options),
                         doctest::Contains("expected: profile usd"), Error);
    options.afresh = true;
    import_splats(frames, scratch.path("out"), options);
    CHECK(slurp(scratch.path("out/load_in_blender.py")).find("FIRST, LAST = 10, 12\n") != std::string::npos);
    options.profile = "spz";
    CHECK_THROWS_WITH_AS(validate(options), doctest::Contains("splats again"), Error);

    write_ply(scratch.path("in/last.ply"), {s});
    CHECK_THROWS_WITH_AS(splat_frames(scratch.path("in")), doctest::Contains("last.ply: has no number"),
                         Error);
    for (const char* name : {"f_0012.ply", "f_0010.ply", "f_0011.ply"})
      std::filesystem::remove(scratch.path("in/") + name);
    write_ply(scratch.path("in/first.ply"), {s});
    CHECK(splat_frames(scratch.path("in"))[1].frame == 2);
    for (const char* name : {"first.ply", "last.ply"}) std::filesystem::remove(scratch.path("in/") + name);
    write_ply(scratch.path("in/f_0010.ply"), {s});
    write_ply(scratch.path("in/g_10.ply"), {s});
    CHECK_THROWS_WITH_AS(splat_frames(scratch.path("in")), doctest::Contains("number of another frame"),
                         Error);
  }

  TEST_CASE("a model, its splats, and a volume of its splats look alike") {
    const Scratch scratch;
    const VoxelModel model = blob_model(48, {.moves = false}, -1);
    ExportOptions options;
    options.profile = "splats";
    options.last = 1;
    export_vdb(model, scratch.path("splats"), options);
    const double spacing = double(model.radiance.raw.topology->lattice.spacing);
    import_splats(splat_frames(scratch.path("splats")), scratch.path("vdb"), import_options(0.5 * spacing));
    const SplatFile file(scratch.path("splats/frame_0001.ply"));
    const VdbFile frame = read_vdb(scratch.path("vdb/frame_0001.vdb"));
    for (const Vec3d from : {Vec3d{2, -2, 1}, Vec3d{-1, 2.5, 0.3}}) {
      const Camera camera = looking_at(from, {0.1, -0.05, 0}, 120, 1.6);
      const Image truth = clamped_picture(render_image(model, camera, 0).rgb);
      const double by_splats = psnr(truth, clamped_picture(splat_picture(file, camera)));
      const double by_volume = psnr(truth, clamped_picture(grid_picture(frame, camera)));
      MESSAGE("splats " << by_splats << " dB, volume of them " << by_volume << " dB");
      CHECK(by_splats > 42);
      CHECK(by_volume > 39);
    }
  }
}
