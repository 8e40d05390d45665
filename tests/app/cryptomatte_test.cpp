// SPDX-License-Identifier: Apache-2.0
// Mattes of parts. What another program reads of them is skipped with a clear line where there is no oiiotool
// (Debian: openimageio-tools).
#include "run/cryptomatte.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "ball_scene.hpp"
#include "math/camera.hpp"
#include "run/support.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"
#include "support/blob_parts.hpp"
#include "support/splat_picture.hpp"

using namespace splinevox;
using namespace splinevox::test;
using run::Json;

namespace {

constexpr double kTime = 0.5;

/// Along one ray in fine steps, with the slow sampler: each part's share of the pixel.
std::vector<double> marched(const VoxelModel& model, const FrameSampler& sampler,
                            const MotionClusters& clusters, const Ray& ray) {
  std::vector<double> shares(clusters.clusters.size(), 0);
  constexpr double kStep = 0.004;
  double through = 1;
  for (double t = kStep / 2; t < 6; t += kStep) {
    const Vec3 x = cast<float>(ray.origin + t * ray.direction);
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside &= x[a] >= model.box.lo[a] && x[a] <= model.box.hi[a];
    if (!inside) continue;
    const double weight = through * (1 - std::exp(-double(sampler.density(x)) * kStep));
    if (weight > 0) shares[std::size_t(std::max(0, clusters.at(sampler.canonical(x))))] += weight;
    through -= weight;
  }
  return shares;
}

}  // namespace

TEST_SUITE("app/cryptomatte") {
  TEST_CASE("the hash has its author's check value, and names the floats of the specification") {
    CHECK(run::murmur3("") == 0);
    CHECK(run::murmur3("", 1) == 0x514e28b7);
    CHECK(run::murmur3("test") == 0xba6bd213);
    CHECK(run::murmur3("Hello, world!", 0x9747b28c) == 0x24884cba);
    CHECK(run::murmur3("The quick brown fox jumps over the lazy dog") == 0x2e4ff723);
    // SMHasher: keys of 0 to 255 bytes 0, 1, 2, ... by seeds from 256 downwards, and the hash of all hashes.
    std::string key, hashes;
    for (std::uint32_t i = 0; i < 256; ++i) {
      const std::uint32_t hash = run::murmur3(key, 256 - i);
      for (int b = 0; b < 4; ++b) hashes += char(hash >> 8 * b & 255);
      key += char(i);
    }
    CHECK(run::murmur3(hashes) == 0xb0f57ee3);
    const auto value = [](const char* name) { return double(std::bit_cast<float>(run::crypto_id(name))); };
    CHECK(value("hello") == doctest::Approx(6.0705627102400005616e-17).epsilon(1e-9));
    CHECK(value("cube") == doctest::Approx(-4.08461912519e+15).epsilon(1e-9));
    CHECK(value("sphere") == doctest::Approx(2.79018604383e+15).epsilon(1e-9));
    CHECK(value("plane") == doctest::Approx(3.66557617593e-11).epsilon(1e-9));
  }

  TEST_CASE("an identifier is a float that is a number and not too small, whatever the name") {
    int turned = 0;
    for (int i = 0; i < 2000; ++i) {
      const std::string name = "part " + std::to_string(i);
      const std::uint32_t id = run::crypto_id(name), hash = run::murmur3(name);
      CHECK(std::isnormal(std::bit_cast<float>(id)));
      turned += id != hash;
      CHECK((id ^ hash) % (1u << 23) == 0);
    }
    CHECK(turned > 3);  // 2 of 256 exponents
    CHECK(turned < 40);
  }

  TEST_CASE("coverage is the sum of the shares of a part's samples, and of all parts it is alpha") {
    const VoxelModel model = blob_model(24, {.light = 3}, 1, 6);
    const MotionClusters clusters = quarters(model);
    const Camera camera = looking_at({2.2, -2, 1.6}, {0.3, -0.1, -0.1}, 48, 1.6);
    const Rendered r = render_image(model, camera, kTime);
    run::PartMattes mattes(model, clusters, Device::cpu);
    const std::vector<Image> parts = mattes.coverage(camera, kTime, r.alpha);
    REQUIRE(parts.size() == 4);
    const FrameSampler sampler(model, kTime);
    double worst = 0, mean = 0, beside = 0;
    int mixed = 0;
    for (std::size_t p = 0; p < r.alpha.pixels(); ++p) {
      const std::size_t x = p % std::size_t(camera.width), y = p / std::size_t(camera.width);
      const std::vector<double> truth =
          marched(model, sampler, clusters, camera_ray(camera, double(x) + 0.5, double(y) + 0.5));
      double sum = 0;
      for (std::size_t c = 0; c < 4; ++c) {
        const double off = std::abs(parts[c].data[p] - truth[c]);
        worst = std::max(worst, off);
        mean += off / double(4 * r.alpha.pixels());
        mixed += truth[c] > 0.2 && truth[c] < 0.8;
        sum += parts[c].data[p];
      }
      beside = std::max(beside, std::abs(sum - r.alpha.data[p]));
    }
    CHECK(mixed > 100);
    CHECK(beside < 1e-6);
    CHECK(mean < 1e-3);
    CHECK(worst < 0.1);  // where a border runs along the ray

    const std::vector<ExrLayer> layers = mattes.layers(camera, kTime, r.alpha);
    REQUIRE(layers.size() == 2);
    CHECK(layers[1].name == "crypto_part01");
    int found = 0;
    for (std::size_t p = 0; p < r.alpha.pixels(); ++p) {
      float before = 2;
      for (std::size_t rank = 0; rank < 4; ++rank) {
        const float* pair = layers[rank / 2].image.data.data() + 4 * p + 2 * (rank % 2);
        REQUIRE(pair[1] <= before);
        before = pair[1];
        if (pair[1] == 0) REQUIRE(pair[0] == 0);
        for (std::size_t c = 0; c < 4; ++c)
          if (std::bit_cast<std::uint32_t>(pair[0]) == run::crypto_id("cluster_" + std::to_string(c))) {
            REQUIRE(pair[1] == parts[c].data[p]);
            ++found;
          }
      }
    }
    CHECK(found > 1000);
  }

  TEST_CASE("render writes them with names that other programs find, and pictures have no room for them") {
    const SmallRun small;
    const std::string out = small.path("out"), exr = out + "/frame_0001.exr";
    const Ended e = program({"render", small.run, "--out", out, "--format", "exr", "--layers", "RGBA,crypto",
                             "--camera", "dataset:test:0", "--frames", "1-1"});
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    const std::vector<ExrLayer> layers = read_exr_layers(exr);
    const Image& rgba = find_exr_layer(layers, "", exr).image;
    std::vector<double> sums(rgba.pixels(), 0);
    for (const ExrLayer& layer : layers)
      for (std::size_t p = 0; layer.name.starts_with("crypto_part") && p < sums.size(); ++p)
        sums[p] += double(layer.image.data[4 * p + 1]) + double(layer.image.data[4 * p + 3]);
    for (std::size_t p = 0; p < sums.size(); ++p) CHECK(std::abs(sums[p] - rgba.data[4 * p + 3]) < 1e-3);

    const Ended refused = program({"render", small.run, "--out", small.path("png"), "--layers", "crypto"});
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "crypto is a layer of numbers, not a picture"));

    if (found_in_path("oiiotool").empty()) {
      MESSAGE("skipped: no oiiotool, which would read the header as another program");
      return;
    }
    const Ended info = Started({"oiiotool", "--info", "-v", exr}).wait();
    CAPTURE(info.out);
    for (const char* part : {"crypto_part00.R (float)", "/name: \"crypto_part\"", "/hash: \"MurmurHash3_32\"",
                             "/conversion: \"uint32_to_float32\"", "/manifest: \"{\"cluster_0\":"})
      CHECK_MESSAGE(contains(info.out, part), part);
  }
}
