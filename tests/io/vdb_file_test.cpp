// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/vdb_file.hpp"

#include <doctest/doctest.h>

#include <cstring>
#include <random>

#include "core/atomic_file.hpp"
#include "data/expect_error.hpp"
#include "io/scratch.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

using namespace splinevox;
using test::FileSizeLimit, test::Scratch, test::slurp, test::spit, test::refusal;

namespace {

constexpr std::size_t kSeal = 24;

/// Two grids with noise in a few leaves; the second one sparse.
VdbFile noisy_file(unsigned seed, bool half = false) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  VdbFile file;
  file.meta = {{"creator", std::string("test")}, {"fps", 24.0}, {"frame", std::int64_t(7)}};
  for (const int width : {1, 3}) {
    VdbGrid grid;
    grid.name = width == 1 ? "density" : "color";
    grid.width = width;
    grid.origin = {-1.25, 0.1, 3};
    grid.spacing = 0.05;
    grid.background = width == 1 ? Vec3{-4.5f, 0, 0} : Vec3{0.1f, 0.2f, 0.3f};
    grid.grid_class = VdbClass::fog_volume;
    grid.vector = width == 3 ? VdbVector::invariant : VdbVector::none;
    grid.half = half;
    grid.leaves = {{0, 0, 0}, {-8, 16, 8}, {4096, 0, -64}};
    grid.values.resize(grid.leaves.size() * 512 * std::size_t(width));
    for (float& v : grid.values) v = normal(random);
    if (width == 3) {
      grid.active.assign(grid.leaves.size() * 8, 0x00ff00ff12345678ull);
      // Inactive voxels hold the background, as in every grid this project writes.
      for (std::size_t v = 0; v < grid.leaves.size() * 512; ++v)
        if (!(grid.active[v >> 6] >> (v & 63) & 1)) std::memcpy(&grid.values[v * 3], &grid.background, 12);
    }
    grid.meta["role"] = std::string("noise");
    file.grids.push_back(std::move(grid));
  }
  return file;
}

/// Position of a leaf in `grid`, or -1.
int find_leaf(const VdbGrid& grid, Int3 at) {
  for (std::size_t l = 0; l < grid.leaves.size(); ++l)
    if (grid.leaves[l] == at) return int(l);
  return -1;
}

bool same_voxels(const VdbGrid& a, const VdbGrid& b) {
  if (a.leaves.size() != b.leaves.size() || a.width != b.width) return false;
  const std::size_t floats = 512 * std::size_t(a.width);
  for (std::size_t l = 0; l < a.leaves.size(); ++l) {
    const int m = find_leaf(b, a.leaves[l]);
    if (m < 0 || std::memcmp(&a.values[l * floats], &b.values[std::size_t(m) * floats], floats * 4) != 0)
      return false;
    const auto word = [](const VdbGrid& g, std::size_t w) {
      return g.active.empty() ? ~std::uint64_t(0) : g.active[w];
    };
    for (std::size_t w = 0; w < 8; ++w)
      if (word(a, l * 8 + w) != word(b, std::size_t(m) * 8 + w)) return false;
  }
  return true;
}

std::string refused_vdb(const std::string& path, const VdbLimits& limits = {}) {
  return refusal([&] { read_vdb(path, limits); });
}

}  // namespace

TEST_SUITE("io/vdb_file") {
  TEST_CASE("a round trip keeps every bit, mask, transform and entry") {
    const Scratch scratch;
    const VdbFile file = noisy_file(1);
    const FileDigest digest = write_vdb(scratch.path("a.vdb"), file);
    CHECK(digest == digest_file(scratch.path("a.vdb")));
    const VdbFile back = read_vdb(scratch.path("a.vdb"));
    CHECK(back.meta.at("creator") == VdbValue(std::string("test")));
    CHECK(back.meta.at("fps") == VdbValue(24.0));
    CHECK(back.meta.at("frame") == VdbValue(std::int64_t(7)));
    REQUIRE(back.grids.size() == 2);
    for (int g = 0; g < 2; ++g) {
      const VdbGrid &a = file.grids[g], &b = back.grids[g];
      CAPTURE(a.name);
      CHECK(same_voxels(a, b));
      CHECK(a.name == b.name);
      CHECK(a.background == b.background);
      CHECK(a.spacing == b.spacing);
      CHECK(length(a.origin - b.origin) < 1e-15);
      CHECK(b.grid_class == VdbClass::fog_volume);
      CHECK(b.vector == a.vector);
      CHECK(b.meta.at("role") == VdbValue(std::string("noise")));
    }
    CHECK(back.skipped.empty());
    CHECK(scratch.count() == 1);
  }

  TEST_CASE("half floats are rounded once, and clamped instead of becoming infinite") {
    const Scratch scratch;
    VdbFile file = noisy_file(2, true);
    file.grids[0].values[0] = 1e9f;
    file.grids[0].values[1] = -70000.0f;
    file.grids[0].values[2] = 2.4f;
    write_vdb(scratch.path("a.vdb"), file);
    VdbFile back = read_vdb(scratch.path("a.vdb"));
    const std::size_t leaf = std::size_t(find_leaf(back.grids[0], {0, 0, 0})) * 512;
    CHECK(back.grids[0].values[leaf] == 65504.0f);
    CHECK(back.grids[0].values[leaf + 1] == -65504.0f);
    CHECK(back.grids[0].values[leaf + 2] == 2.400390625f);
    CHECK(back.grids[0].half);
    write_vdb(scratch.path("b.vdb"), back);
    CHECK(same_voxels(back.grids[1], read_vdb(scratch.path("b.vdb")).grids[1]));
  }

  TEST_CASE("the same content gives the same file; other content another id") {
    const Scratch scratch;
    CHECK(write_vdb(scratch.path("a.vdb"), noisy_file(3)) == write_vdb(scratch.path("b.vdb"), noisy_file(3)));
    CHECK(slurp(scratch.path("a.vdb")) == slurp(scratch.path("b.vdb")));
    write_vdb(scratch.path("c.vdb"), noisy_file(4));
    CHECK(slurp(scratch.path("a.vdb")).substr(21, 36) != slurp(scratch.path("c.vdb")).substr(21, 36));
  }

  TEST_CASE("truncated anywhere, a file is refused by name") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    write_vdb(path, noisy_file(5));
    const std::string good = slurp(path);
    std::mt19937 random(5);
    for (int i = 0; i < 400; ++i) {
      const std::size_t n = i < 200   ? std::size_t(i) * 3
                            : i < 230 ? good.size() - std::size_t(i - 199)
                                      : random() % good.size();
      if (n == good.size() - kSeal) continue;  // a whole VDB of any other program
      CAPTURE(n);
      spit(path, good.substr(0, n));
      CHECK(refused_vdb(path).find(path) == 0);
      // Without the seal's help: as if another program had written it.
      if (n < good.size() - kSeal) CHECK_THROWS_AS(inspect_vdb(path), Error);
    }
    spit(path, good.substr(0, good.size() - kSeal));
    CHECK(same_voxels(read_vdb(path).grids[0], noisy_file(5).grids[0]));
    CHECK_FALSE(inspect_vdb(path).sealed);
  }

  TEST_CASE("any flipped byte is found before the parser sees it") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    write_vdb(path, noisy_file(6));
    const std::string good = slurp(path);
    for (std::size_t n = 0; n < good.size(); n += n < 100 || n + kSeal > good.size() ? 1 : 59) {
      CAPTURE(n);
      std::string flipped = good;
      flipped[n] = char(flipped[n] ^ (1 << n % 8));
      spit(path, flipped);
      CHECK(refused_vdb(path).find(path) == 0);
    }
  }

  TEST_CASE("wild lengths in an unsealed header are refused before anything is allocated") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    write_vdb(path, noisy_file(7));
    const std::string good = slurp(path).substr(0, slurp(path).size() - kSeal);
    int refused = 0;
    for (std::size_t n = 57; n < 700;
         n += 7) {  // any 4 bytes of metadata and grid table, as a length of 4 GB
      CAPTURE(n);
      std::string wild = good;
      for (std::size_t i = 0; i < 4; ++i) wild[n + i] = char(0xff);
      spit(path, wild);
      const std::string message = refused_vdb(path);
      refused += !message.empty();
      if (!message.empty())
        CHECK(message.find(path) == 0);  // inside a value or a name it is only another value
    }
    CHECK(refused > 20);
  }

  TEST_CASE("damaged voxels in an unsealed file may stop OpenVDB, but not this program") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    write_vdb(path, noisy_file(7));
    const std::string good = slurp(path).substr(0, slurp(path).size() - kSeal);
    std::mt19937 random(7);
    int refused = 0;
    for (int i = 0; i < 60; ++i) {
      std::string wild = good;
      for (int k = 0; k < 4; ++k) wild[700 + random() % (good.size() - 700)] = char(random());
      spit(path, wild);
      const std::string message = refused_vdb(path);
      refused += !message.empty();
      if (!message.empty()) CHECK(message.find(path) == 0);
    }
    CHECK(refused > 0);
  }

  TEST_CASE("foreign files and limits") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    CHECK(refused_vdb(path) == path + ": could not be read\n  got:      No such file or directory");
    CHECK(refused_vdb(scratch.folder()) ==
          scratch.folder() + ": could not be read\n  got:      Is a directory");
    spit(path, "\x89PNG\r\n\x1a\n and some more bytes");
    CHECK(refused_vdb(path) ==
          path + ": is not a VDB file\n  expected: the magic number of OpenVDB at the beginning");
    spit(path, "");
    CHECK(refused_vdb(path).find("the file ends inside the header") != std::string::npos);
    write_vdb(path, noisy_file(8));
    VdbLimits limits;
    limits.max_bytes = 1000;
    CHECK(refused_vdb(path, limits).find("is too large") != std::string::npos);
    limits = {};
    limits.max_grids = 1;
    CHECK(refused_vdb(path, limits).find("number of grids is out of range") != std::string::npos);
    limits = {};
    limits.max_voxels = 100;
    CHECK(refused_vdb(path, limits).find("too many active voxels") != std::string::npos);
  }

  TEST_CASE("what readers would refuse for its voxels is not written, and the old file stays") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    VdbLimits limits;
    limits.max_voxels = 6 * 512;  // two grids of three leaves
    write_vdb(path, noisy_file(12), limits);
    CHECK(read_vdb(path, limits).grids.size() == 2);
    const std::string good = slurp(path);
    --limits.max_voxels;
    CHECK(refused_vdb(path, limits).find("too many active voxels") != std::string::npos);
    try {
      write_vdb(path, noisy_file(13), limits);
      FAIL("it was written");
    } catch (const Error& e) {
      CHECK(e.fault == Fault::output);
      CHECK(std::string(e.what()).find("more voxels than can be read back") != std::string::npos);
      CHECK(std::string(e.what()).find("grid.radiance") != std::string::npos);
    }
    CHECK(slurp(path) == good);
    CHECK(scratch.count() == 1);
  }

  TEST_CASE("a disk that fills up at any byte is noticed, and the old file stays") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    write_vdb(path, noisy_file(9));
    const std::string good = slurp(path);
    for (int i = 0; i < 64; ++i) {
      const std::size_t room = i == 63 ? good.size() - 1 : good.size() * std::size_t(i) / 63;
      CAPTURE(room);
      try {
        const FileSizeLimit limit(room);
        write_vdb(path, noisy_file(10));
        FAIL("written beyond the end of the disk");
      } catch (const Error& e) {
        CHECK(e.fault == Fault::output);
        CHECK(std::string(e.what()).find(path + ": could not be written") == 0);
      }
      CHECK(slurp(path) == good);
      CHECK(scratch.count() == 1);
    }
  }

  TEST_CASE("inspection lists what is in a file") {
    const Scratch scratch;
    write_vdb(scratch.path("a.vdb"), noisy_file(11));
    const VdbInfo info = inspect_vdb(scratch.path("a.vdb"));
    CHECK(info.sealed);
    CHECK(info.file_bytes == std::filesystem::file_size(scratch.path("a.vdb")));
    CHECK(info.version.find("/224") != std::string::npos);
    CHECK(info.meta.at("creator") == "test");
    REQUIRE(info.grids.size() == 2);
    const GridInfo& density = info.grids[0];
    CHECK(density.name == "density");
    CHECK(density.type == "float");
    CHECK(density.grid_class == "fog volume");
    CHECK(density.active_voxels == 3 * 512);
    CHECK(density.leaves == 3);
    CHECK(density.memory_bytes > 3 * 512 * 4);
    CHECK(density.voxel_size.x == 0.05);
    CHECK(length(density.origin - Vec3d{-1.25, 0.1, 3}) < 1e-15);
    CHECK(density.lo == Int3{-8, 0, -64});
    CHECK(density.hi == Int3{4103, 23, 15});
    CHECK(density.meta.at("role") == "noise");
    CHECK(info.grids[1].type == "vec3s");
    CHECK(info.grids[1].active_voxels == 3 * 8 * 29);  // bits of 0x00ff00ff12345678
  }
}
