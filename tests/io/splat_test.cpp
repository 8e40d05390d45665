// SPDX-License-Identifier: Apache-2.0
#include "math/splat.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "io/scratch.hpp"
#include "io/splat/splat_file.hpp"
#include "io/splat/spz.hpp"
#include "io/splat/voxel_splats.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

ExportOptions splat_options(const std::string& profile, bool sh) {
  ExportOptions o;
  o.profile = profile;
  o.last = 1;
  o.sh = sh;
  return o;
}

std::string gunzip(const std::string& bytes) {
  std::string out(std::size_t(1) << 26, '\0');
  z_stream stream{};
  REQUIRE(::inflateInit2(&stream, 15 + 16) == Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(out.size());
  CHECK(::inflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(stream.total_out);
  ::inflateEnd(&stream);
  return out;
}

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T v;
  std::memcpy(&v, bytes.data() + offset, sizeof v);
  return v;
}

const Vec3d kDirections[] = {{0, 0, 1}, {0.6, -0.8, 0}, {-0.48, 0.6, -0.64}};

/// Colour of a splat along a direction, by the basis as renderers of splats have it.
Vec3d color_along(const Splat& s, const Vec3d& d) {
  const double x = d.x, y = d.y, z = d.z;
  const double basis[9] = {0.28209479177387814,
                           -0.4886025119029199 * y,
                           0.4886025119029199 * z,
                           -0.4886025119029199 * x,
                           1.0925484305920792 * x * y,
                           -1.0925484305920792 * y * z,
                           0.31539156525252005 * (2 * z * z - x * x - y * y),
                           -1.0925484305920792 * x * z,
                           0.5462742152960396 * (x * x - y * y)};
  Vec3d color{0.5, 0.5, 0.5};
  for (int j = 0; j < std::min(9, s.harmonics); ++j) color += basis[j] * s.color[j];
  return color;
}

}  // namespace

TEST_SUITE("io/splat") {
  TEST_CASE("the dilogarithm has its known values, and its inverse is the inverse") {
    const double pi2 = std::numbers::pi * std::numbers::pi, ln2 = std::numbers::ln2;
    CHECK(dilogarithm(0) == 0);
    CHECK(dilogarithm(0.5) == doctest::Approx(pi2 / 12 - ln2 * ln2 / 2).epsilon(1e-12));
    CHECK(dilogarithm(1) == doctest::Approx(pi2 / 6).epsilon(1e-12));
    for (const double x : {1e-6, 0.01, 0.3, 0.5, 0.7, 0.98})
      CHECK(inverse_dilogarithm(dilogarithm(x)) == doctest::Approx(x).epsilon(1e-9));
    CHECK(inverse_dilogarithm(9) == kMostOpacity);
  }

  TEST_CASE("what a splat hides in all is the integral of its optical depth over the plane") {
    for (const double opacity : {0.1, 0.6, 0.95}) {
      double sum = 0;
      const double step = 1e-3;
      for (double r = step / 2; r < 8; r += step)
        sum -= 2 * std::numbers::pi * r * step * std::log1p(-opacity * std::exp(-r * r / 2));
      CHECK(splat_cross_section(opacity, 1, 1) == doctest::Approx(sum).epsilon(1e-5));
      CHECK(splat_cross_section(opacity, 2, 3) == doctest::Approx(6 * sum).epsilon(1e-5));
    }
  }

  TEST_CASE("a splat in every voxel hides as much as the medium, along any direction") {
    const double spacing = 0.02, size = 0.4 * spacing;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(0, spacing);
    for (const double tau : {0.05, 0.4, 1.0}) {
      const double opacity = voxel_splat_opacity(tau / spacing, spacing, size);
      for (Vec3d d : {Vec3d{1, 0, 0}, normalize(Vec3d{3, 1, 2})}) {
        double sum = 0;
        const double length = 40 * spacing;
        const int rays = 400;
        for (int r = 0; r < rays; ++r) {
          const Vec3d origin{place(random), place(random), place(random)};
          for (int i = -4; i < 46; ++i)
            for (int j = -4; j < 46; ++j)
              for (int k = -4; k < 46; ++k) {
                const Vec3d to = spacing * Vec3d{double(i), double(j), double(k)} - origin;
                const double along = dot(to, d);
                if (along < 0 || along >= length) continue;
                const double square = (dot(to, to) - along * along) / (size * size);
                if (square < 40) sum -= std::log1p(-opacity * std::exp(-square / 2));
              }
        }
        CHECK(sum / rays == doctest::Approx(tau * 40).epsilon(0.03));
      }
    }
  }

  TEST_CASE("the splats of a frame are its voxels: place, colour along any direction, opacity") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.moves = false}, 2);
    for (const bool sh : {false, true}) {
      CAPTURE(sh);
      ExportOptions options = splat_options("splats", sh);
      const std::string name = sh ? "sh" : "mean";
      const ExportResult result = export_vdb(model, scratch.path(name), options);
      options.profile = "houdini";
      options.half = false;
      export_vdb(model, scratch.path("vdb" + name), options);
      const VdbFile frame = read_vdb(scratch.path("vdb" + name + "/frame_0001.vdb"));
      const SplatFile file(scratch.path(name + "/frame_0001.ply"));
      CHECK(file.size() == std::size_t(result.frames[0].file.figures.at("splats")));
      CHECK(file.degree() == (sh ? 2 : 0));
      std::map<std::array<int, 3>, std::array<double, 4>> voxels;
      std::map<std::array<int, 3>, std::array<float, 9>> harmonics;
      const VdbGrid& density = frame.grids[0];
      const auto each = [](const VdbGrid& grid, auto visit) {
        for (std::size_t l = 0; l < grid.leaves.size(); ++l)
          for (int i = 0; i < 512; ++i)
            visit(std::array<int, 3>{grid.leaves[l].x + (i >> 6), grid.leaves[l].y + (i >> 3 & 7),
                                     grid.leaves[l].z + (i & 7)},
                  grid.values.data() + (l * 512 + std::size_t(i)) * std::size_t(grid.width));
      };
      each(density, [&](auto v, const float* value) { voxels[v][3] = double(value[0]); });
      each(frame.grids[1], [&](auto v, const float* value) {
        for (std::size_t c = 0; c < 3; ++c) voxels[v][c] = double(value[c]);
      });
      for (std::size_t k = 2; k < frame.grids.size(); ++k)
        each(frame.grids[k], [&](auto v, const float* value) {
          for (std::size_t c = 0; c < 3; ++c) harmonics[v][3 * (k - 2) + c] = value[c];
        });
      double worst_place = 0, worst_opacity = 0, worst_color = 0;
      for (std::size_t i = 0; i < file.size(); i += 7) {
        Splat s;
        REQUIRE(file.read(i, s));
        std::array<int, 3> v{};
        for (int a = 0; a < 3; ++a) {
          const double u = (s.place[a] - density.origin[a]) / density.spacing;
          v[std::size_t(a)] = int(std::lround(u));
          worst_place = std::max(worst_place, std::abs(u - std::round(u)));
        }
        CHECK(std::abs(s.size.x / density.spacing - 0.4) < 0.02);
        const auto& voxel = voxels.at(v);
        worst_opacity = std::max(
            worst_opacity, std::abs(s.opacity - voxel_splat_opacity(voxel[3], density.spacing, s.size.x)));
        for (const Vec3d& d : kDirections) {
          const Vec3d seen = color_along(s, d);
          double factor = 1;
          if (sh) {
            double q = 0;
            Splat basis = s;
            for (int j = 0; j < 9; ++j) {  // the model's basis has no phase
              for (Vec3d& c : basis.color) c = {};
              basis.color[j] = {1, 0, 0};
              q += double(harmonics.at(v)[std::size_t(j)]) * splat_harmonic_sign(j) *
                   (color_along(basis, d).x - 0.5);
            }
            factor = 1 - 0.5 / (1 + std::exp(-q));
          }
          for (int c = 0; c < 3; ++c)
            worst_color = std::max(worst_color, std::abs(seen[c] - voxel[std::size_t(c)] * factor));
        }
      }
      CHECK(worst_place < 1e-3);
      CHECK(worst_opacity < 1e-5);
      CHECK(worst_color < (sh ? 0.01 : 1e-5));
      for (const FileCheck& check : verify(scratch.path(name))) CHECK(check.ok);
    }
  }

  TEST_CASE("an spz has sizes from some five hundred-thousandths of a unit on, each to 3%") {
    for (double size = 5e-5; size < 300; size *= 1.01) CHECK(spz_has(size));
    for (const double size : {1e-6, 4e-5, 400.0}) CHECK_FALSE(spz_has(size));
    CHECK_THROWS_AS(check_spz_size(5e-5), Error);
    check_spz_size(0.01);
  }

  TEST_CASE("an spz holds the same splats, to what it can tell apart, with y upwards") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.moves = false}, 1);
    export_vdb(model, scratch.path("ply"), splat_options("splats", true));
    export_vdb(model, scratch.path("spz"), splat_options("spz", true));
    const SplatFile file(scratch.path("ply/frame_0001.ply"));
    const std::string bytes = gunzip(slurp(scratch.path("spz/frame_0001.spz")));
    const std::size_t n = file.size();
    CHECK(at<std::uint32_t>(bytes, 0) == 0x5053474e);
    CHECK(at<std::uint32_t>(bytes, 4) == 2);
    CHECK(at<std::uint32_t>(bytes, 8) == n);
    CHECK(at<std::uint8_t>(bytes, 12) == 1);
    const int bits = at<std::uint8_t>(bytes, 13);
    REQUIRE(bytes.size() == 16 + n * (9 + 1 + 3 + 3 + 3 + 9));
    const auto byte = [&](std::size_t offset) { return double(at<std::uint8_t>(bytes, offset)); };
    double place = 0, opacity = 0, color = 0, size = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Splat s;
      file.read(i, s);
      Vec3d x;
      for (std::size_t a = 0; a < 3; ++a) {
        std::int32_t fixed = 0;
        std::memcpy(&fixed, bytes.data() + 16 + 9 * i + 3 * a, 3);
        x[int(a)] = std::ldexp(double(fixed << 8 >> 8), -bits);
      }
      place = std::max(place, length(x - Vec3d{s.place.x, s.place.z, -s.place.y}));
      opacity = std::max(opacity, std::abs(byte(16 + 9 * n + i) / 255 - s.opacity));
      Splat held = s;
      for (std::size_t c = 0; c < 3; ++c) {
        held.color[0][int(c)] = (byte(16 + 10 * n + 3 * i + c) / 255 - 0.5) / 0.15;
        size = std::max(size, std::abs(std::exp(byte(16 + 13 * n + 3 * i + c) / 16 - 10) / s.size.x - 1));
        for (std::size_t j = 0; j < 3; ++j)
          held.color[j + 1][int(c)] = (byte(16 + 19 * n + 9 * i + 3 * j + c) - 128) / 128;
      }
      for (const Vec3d& d : kDirections) {
        const Vec3d off = color_along(held, {d.x, d.z, -d.y}) - color_along(s, d);
        color = std::max({color, std::abs(off.x), std::abs(off.y), std::abs(off.z)});
      }
    }
    CHECK(place < 1e-5);
    CHECK(opacity < 0.003);
    CHECK(size < 1e-6);
    CHECK(color < 0.01);
  }

  TEST_CASE("files that hold no splats are refused by name, and say what they are") {
    const Scratch scratch;
    export_vdb(blob_model(16, {.moves = false}), scratch.folder(), splat_options("splats", false));
    const std::string good = slurp(scratch.path("frame_0001.ply")), path = scratch.path("bad.ply");
    const auto says = [&](const std::string& bytes) {
      spit(path, bytes);
      try {
        const SplatFile file(path);
      } catch (const Error& e) {
        CHECK(e.fault == Fault::input);
        CHECK(std::string(e.what()).find(path) == 0);
        return std::string(e.what());
      }
      return std::string("nothing");
    };
    const auto with = [&](const std::string& from, const std::string& to) {
      std::string out = good;
      out.replace(out.find(from), from.size(), to);
      return out;
    };
    const auto check = [](const std::string& text, const char* part) {
      CHECK_MESSAGE(text.find(part) != text.npos, text);
    };
    check(says(good), "nothing");
    check(says(""), "there is no such file, or it is empty");
    check(says("PK\3\4"), "is no PLY");
    check(says("ply\nformat ascii 1.0\n"), "a header without an end");
    check(says(good.substr(0, good.size() - 1)), "ends before its last splat");
    check(says(with("binary_little_endian", "binary_big_endian")), "'binary_big_endian'");
    check(says(with("property float opacity", "property float alpha")), "has no property 'opacity'");
    check(says(with("property float nx", "property list uchar int nx")), "a property that is no number");
    check(says(with("property float nx", "property float f_rest_0")), "harmonics of no degree from 0 to 3");
    check(says(with("element vertex", "element chunk 9\nelement vertex")), "is a compressed PLY of splats");
    check(says(with("element vertex ", "element vertex 9")), "ends before its last splat");
    check(says(with("element vertex ", "element vertex x")), "a malformed number of splats");
    check(says("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
               "z\nproperty uchar red\nend_header\n0 0 0 9\n"),
          "a mesh or a cloud of points");
  }

  TEST_CASE("a text and doubles are read as the binary file of the same splats; harmonics of every degree") {
    const Scratch scratch;
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (const int degree : {0, 1, 2, 3}) {
      const int rest = 3 * ((degree + 1) * (degree + 1) - 1);
      std::vector<std::string> names{"x",     "y",     "z",     "opacity", "scale_0", "scale_1", "scale_2",
                                     "rot_0", "rot_1", "rot_2", "rot_3",   "f_dc_0",  "f_dc_1",  "f_dc_2"};
      for (int j = 0; j < rest; ++j) names.push_back("f_rest_" + std::to_string(j));
      std::string head = "element vertex 5\n", text, floats, doubles;
      for (int i = 0; i < 5; ++i) {
        for (std::size_t k = 0; k < names.size(); ++k) {
          const float v = normal(random);
          const double d = double(v);
          text += std::to_string(d) + (k + 1 < names.size() ? " " : "\n");
          floats.append(reinterpret_cast<const char*>(&v), sizeof v);
          doubles.append(reinterpret_cast<const char*>(&d), sizeof d);
        }
      }
      const auto file = [&](const char* format, const char* type, const std::string& body) {
        std::string out = std::string("ply\r\nformat ") + format + " 1.0\ncomment x\n" + head;
        for (const std::string& name : names) out += std::string("property ") + type + " " + name + "\n";
        const std::string path = scratch.path(format + std::string(type));
        spit(path, out + "end_header\n" + body);
        return SplatFile(path);
      };
      const SplatFile a = file("binary_little_endian", "float", floats);
      const SplatFile b = file("binary_little_endian", "float64", doubles);
      const SplatFile c = file("ascii", "float32", text);
      CHECK_THROWS_WITH_AS(file("ascii", "float", text.substr(0, text.size() - 12)),
                           doctest::Contains("ends before its last splat"), Error);
      CHECK_THROWS_WITH_AS(file("ascii", "float", "four" + text), doctest::Contains("'four"), Error);
      for (std::size_t i = 0; i < 5; ++i) {
        Splat s[3];
        REQUIRE(a.read(i, s[0]));
        REQUIRE(b.read(i, s[1]));
        REQUIRE(c.read(i, s[2]));
        CHECK(s[0].harmonics == (degree + 1) * (degree + 1));
        for (const int k : {1, 2}) {
          CHECK(length(s[0].place - s[k].place) < 1e-5);
          CHECK(length(s[0].size - s[k].size) < 1e-4);
          CHECK(s[0].opacity == doctest::Approx(s[k].opacity).epsilon(1e-5));
          for (int j = 0; j < s[0].harmonics; ++j) CHECK(length(s[0].color[j] - s[k].color[j]) < 1e-5);
        }
      }
    }
  }

  TEST_CASE("options that splats have no room for are refused") {
    const VoxelModel model = blob_model(16);
    const Scratch scratch;
    for (const char* profile : {"splats", "spz"}) {
      ExportOptions flame = splat_options(profile, false), linear = flame;
      flame.flame = true;
      linear.colorspace = "linear";
      CHECK_THROWS_WITH_AS(validate(flame), doctest::Contains("--flame"), Error);
      CHECK_THROWS_WITH_AS(validate(linear), doctest::Contains("--colorspace"), Error);
    }
  }
}
