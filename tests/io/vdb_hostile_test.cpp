// SPDX-License-Identifier: Apache-2.0
// Files whose checksum is right and whose content is a stranger's.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

#include "core/hash.hpp"
#include "core/process.hpp"
#include "io/scratch.hpp"
#include "io/vdb/child.hpp"
#include "io/vdb/vdb_scan.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

using namespace splinevox;
using test::Scratch, test::slurp, test::spit;

namespace {

/// Two grids of a few leaves, of values that become much smaller when they are compressed.
VdbFile calm_file() {
  VdbFile file;
  file.meta = {{"creator", std::string("test")}};
  for (const int width : {1, 3}) {
    VdbGrid grid;
    grid.name = width == 1 ? "density" : "color";
    grid.width = width;
    grid.spacing = 0.5;
    grid.leaves = {{0, 0, 0}, {8, 0, 0}, {4096, -8, 0}};
    grid.values.resize(3 * 512 * std::size_t(width));
    for (std::size_t i = 0; i < grid.values.size(); ++i) grid.values[i] = float(i % 7);
    file.grids.push_back(std::move(grid));
  }
  return file;
}

std::string made(const Scratch& scratch, VdbFile file) {
  write_vdb(scratch.path("made.vdb"), std::move(file));
  const std::string bytes = slurp(scratch.path("made.vdb"));
  return bytes.substr(0, bytes.size() - kVdbSealBytes);
}

/// As any program may write it: without a seal.
std::string written(const openvdb::GridCPtrVec& grids) {
  openvdb::initialize();
  std::ostringstream out(std::ios::binary);
  openvdb::io::Stream(out).write(grids);
  return out.str();
}

std::string sealed(const std::string& bytes) { return bytes + vdb_seal(bytes.size(), hash64(bytes)); }

/// "" if the file is read; what is wrong with it otherwise. Anything else than an Error would end the test.
std::string verdict(const std::string& path, Fault expected = Fault::input) {
  try {
    read_vdb(path);
  } catch (const Error& e) {
    CHECK(e.fault == expected);
    CHECK(std::string(e.what()).find(path) == 0);
    return e.what();
  }
  return "";
}

/// Where the first block that Blosc made is: its length stands in the 8 bytes before.
std::size_t first_block(const std::string& bytes) {
  for (std::size_t at = 0; at + 24 < bytes.size(); ++at) {
    std::int64_t length = 0;
    std::uint32_t values = 0, block = 0;
    std::memcpy(&length, bytes.data() + at, 8);
    std::memcpy(&values, bytes.data() + at + 12, 4);
    std::memcpy(&block, bytes.data() + at + 20, 4);
    if (length > 16 && length < 10000 && block == length && values == 2048) return at;
  }
  FAIL("no block");
  return 0;
}

ChildReport in_child(const std::function<void()>& task, unsigned seconds = 20) {
  return run_in_child([&](const Sink&) { task(); }, [](const Source&) {}, {seconds, std::uint64_t(1) << 30});
}

}  // namespace

TEST_SUITE("io/vdb_hostile") {
  TEST_CASE("a block of a length that its node does not need is refused, however well it is sealed") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb"), good = made(scratch, calm_file());
    const std::size_t at = first_block(good);
    for (const std::int64_t length : {std::int64_t(-1), std::int64_t(-100'000), std::int64_t(-4096),
                                      std::numeric_limits<std::int64_t>::min(), std::int64_t(1) << 40,
                                      std::int64_t(0), std::int64_t(1)}) {
      CAPTURE(length);
      std::string bad = good;
      std::memcpy(bad.data() + at, &length, 8);
      bad.insert(at + 8, 100'000, 'A');  // what would go over the end of the node's buffer
      spit(path, sealed(bad));
      CHECK_FALSE(verdict(path).empty());
      spit(path, bad);
      CHECK_FALSE(verdict(path).empty());
    }
    for (const std::size_t field : {std::size_t(12), std::size_t(16), std::size_t(20)}) {  // Blosc's own
      std::string bad = good;
      const std::uint32_t wild = 0x7fffff00;
      std::memcpy(bad.data() + at + field, &wild, 4);
      spit(path, sealed(bad));
      CAPTURE(field);
      const std::string what = verdict(path);
      CAPTURE(what);
      CHECK(what.find("lengths of a compressed block") != std::string::npos);
    }
  }

  TEST_CASE("sealed damage anywhere is an input error or other values, never a signal") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb"), good = made(scratch, calm_file());
    std::mt19937 random(41);
    int refused = 0;
    for (int i = 0; i < 650; ++i) {
      std::string bad = good;
      for (unsigned k = 0; k < 1 + random() % 4; ++k) {
        const std::size_t at = random() % bad.size();
        if (random() % 3 == 0) {
          const std::uint64_t edge[] = {0, 1, 0x7fffffff, 0x80000000, ~std::uint64_t(0), 1ull << 63};
          std::memcpy(bad.data() + at, &edge[random() % 6], std::min<std::size_t>(8, bad.size() - at));
        } else {
          bad[at] = char(random());
        }
      }
      if (i % 5 == 0) bad.resize(random() % bad.size());
      spit(path, sealed(bad));
      refused += !verdict(path).empty();
    }
    CHECK(refused > 100);
  }

  TEST_CASE("metadata that is shorter than its type would shift all that follows") {
    const Scratch scratch;
    VdbFile file = calm_file();
    file.meta["fps"] = 24.0;
    std::string bad = made(scratch, file);
    const std::size_t at = bad.find("double") + 6;
    REQUIRE(at < bad.size());
    const std::uint32_t four = 4;
    std::memcpy(bad.data() + at, &four, 4);
    bad.erase(at + 4, 4);
    spit(scratch.path("a.vdb"), sealed(bad));
    CHECK(verdict(scratch.path("a.vdb")).find("not as long as its type") != std::string::npos);
  }

  TEST_CASE("tiles and many grids are counted together before anything is expanded") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    const auto cube = [](int edge, const std::string& name) {
      auto grid = openvdb::FloatGrid::create();
      grid->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(edge - 1)), 1.0f, true);
      grid->setName(name);
      return grid;
    };
    openvdb::initialize();
    spit(path, written({cube(4096, "density")}));
    CHECK(std::filesystem::file_size(path) < 10'000);
    const double before = peak_memory();
    CHECK(verdict(path).find("too many active voxels") != std::string::npos);
    openvdb::GridCPtrVec grids;
    for (int g = 0; g < 12; ++g) grids.push_back(cube(128, "g" + std::to_string(g)));  // 2^21 voxels each
    spit(path, written(grids));
    CHECK(verdict(path).find("voxels in tiles, in the file's grids together") != std::string::npos);
    CHECK_THROWS_AS(inspect_vdb(path), Error);
    CHECK(peak_memory() - before < 100e6);
    grids.resize(2);
    spit(path, written(grids));
    const VdbFile back = read_vdb(path);
    REQUIRE(back.grids.size() == 2);
    CHECK(back.grids[1].leaves.size() == 4096);
    CHECK(back.grids[1].values == std::vector<float>(4096 * 512, 1.0f));
  }

  TEST_CASE("grids that share a tree are counted as what they become: each has voxels of its own") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    openvdb::initialize();
    auto density = openvdb::FloatGrid::create(0.5f);
    density->setName("density");
    for (int i = 0; i < 20; ++i) density->tree().setValue(openvdb::Coord(8 * i, 0, 0), float(i));
    openvdb::GridCPtrVec grids{density};
    for (const char* name : {"heat", "smoke"}) {
      const openvdb::FloatGrid::Ptr shares = density->copy();
      shares->setName(name);
      grids.push_back(shares);
    }
    spit(path, written(grids));
    VdbLimits limits;
    limits.max_voxels = 3 * 20 * 512;
    const VdbFile back = read_vdb(path, limits);
    REQUIRE(back.grids.size() == 3);
    for (const VdbGrid& grid : back.grids) CHECK(grid.values == back.grids[0].values);
    --limits.max_voxels;
    CHECK_THROWS_WITH_AS(read_vdb(path, limits), doctest::Contains("too many active voxels"), Error);
  }

  TEST_CASE("a file that is longer than the memory is not begun") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    const std::uintmax_t bytes = VdbLimits().max_bytes;
    if (const double room = free_memory(); room == 0 || room > double(bytes)) {
      MESSAGE("skipped: it is not known how much memory there is, or there is a terabyte");
      return;
    }
    spit(path, made(scratch, calm_file()));
    std::filesystem::resize_file(path, bytes);  // a hole: no disk is used
    CHECK(verdict(path, Fault::memory).find("not enough memory to read it") != std::string::npos);
  }

  TEST_CASE("files of other programs are read as before: other types, compressions, transforms") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    openvdb::initialize();
    auto density = openvdb::FloatGrid::create(0.5f);
    density->setName("density");
    for (int i = 0; i < 300; ++i) density->tree().setValue(openvdb::Coord(i * 7, -i * 5, i), float(i));
    auto flags = openvdb::BoolGrid::create();
    flags->setName("flags");
    flags->tree().setValue(openvdb::Coord(1, 2, 3), true);
    auto ids = openvdb::Int32Grid::create(-1);
    ids->setName("ids");
    ids->tree().setValue(openvdb::Coord(1, 2, 3), 7);
    for (const std::uint32_t how :
         std::vector<std::uint32_t>{openvdb::io::COMPRESS_NONE, openvdb::io::COMPRESS_ZIP,
                                    openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_ZIP,
                                    openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC}) {
      for (const bool half : {false, true}) {
        CAPTURE(how);
        CAPTURE(half);
        density->setSaveFloatAsHalf(half);
        std::ostringstream out(std::ios::binary);
        openvdb::io::Stream stream(out);
        stream.setCompression(how);
        stream.write({density, flags, ids});
        spit(path, out.str());
        const VdbFile back = read_vdb(path);
        REQUIRE(back.grids.size() == 1);
        CHECK(back.skipped == std::vector<std::string>{"flags", "ids"});
        CHECK(back.grids[0].leaves.size() == density->tree().leafCount());
        const VdbInfo info = inspect_vdb(path);
        REQUIRE(info.grids.size() == 3);
        CHECK(info.grids[0].active_voxels == 300);
        CHECK(info.grids[2].type == "int32");
      }
    }
    density->transform().postRotate(0.3);
    spit(path, written({density}));
    CHECK(verdict(path).find("cubic voxels along the axes") != std::string::npos);
  }

  TEST_CASE("the child has no files, no network, no other processes") {
    const Scratch scratch;
    spit(scratch.path("there"), "secret");
    const int open_before = ::open(scratch.path("there").c_str(), O_RDWR | O_APPEND);
    const pid_t parent = ::getpid();
    std::vector<int> results(7, 0);
    const ChildReport report = run_in_child(
        [&](const Sink& sink) {
          const bool filtered = ::prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0) < 0;
          const std::vector<int> done = {filtered,
                                         ::open(scratch.path("there").c_str(), O_RDONLY) >= 0,
                                         ::write(open_before, "x", 1) > 0,
                                         ::socket(AF_INET, SOCK_STREAM, 0) >= 0,
                                         filtered && ::unlink(scratch.path("there").c_str()) == 0,
                                         filtered && ::kill(parent, 0) == 0,
                                         filtered && ::fork() >= 0};
          sink(done.data(), done.size() * sizeof(int));
        },
        [&](const Source& source) { source(results.data(), results.size() * sizeof(int)); },
        {20, std::uint64_t(1) << 28});
    ::close(open_before);
    CHECK(report.end == ChildEnd::done);
    INFO("a kernel without seccomp leaves only the limits on files and descriptors");
    WARN(results[0] == 1);
    for (std::size_t i = 1; i < results.size(); ++i) CHECK(results[i] == 0);
    CHECK(slurp(scratch.path("there")) == "secret");
  }

  TEST_CASE("how a child ends is told apart") {
    CHECK(in_child([] {}).end == ChildEnd::done);
    const ChildReport refused = in_child([] { throw std::runtime_error("no"); });
    CHECK(refused.end == ChildEnd::refused);
    CHECK(refused.text == "no");
    CHECK(in_child([] { throw std::bad_alloc(); }).end == ChildEnd::no_memory);
    CHECK(in_child([] { ::raise(SIGABRT); }).end == ChildEnd::crashed);
    CHECK(in_child([] { ::_exit(77); }).end == ChildEnd::crashed);
    CHECK(in_child(
              [] {
                for (std::atomic<int> i{0};; ++i) continue;
              },
              1)
              .text == "reading takes forever");
    const ChildReport silent = run_in_child([](const Sink&) {},
                                            [](const Source& source) {
                                              char byte = 0;
                                              source(&byte, 1);
                                            },
                                            {20, 1 << 28});
    CHECK(silent.end == ChildEnd::crashed);
#ifndef __SANITIZE_ADDRESS__
    volatile std::uintptr_t null = 8, wild = std::uintptr_t(1) << 40;  // the compiler must not know them
    const auto at = [](std::uintptr_t address) { *reinterpret_cast<volatile char*>(address) = 1; };
    CHECK(in_child([&] { at(null); }).end == ChildEnd::null);
    CHECK(in_child([&] { at(wild); }).end == ChildEnd::crashed);
#endif
  }

#ifndef __SANITIZE_ADDRESS__
  TEST_CASE("with little memory a sound file is not called damaged") {
    const Scratch scratch;
    const std::string path = scratch.path("a.vdb");
    VdbFile file = calm_file();
    for (int i = 0; i < 40'000; ++i) file.grids[0].leaves.push_back({8 * (i % 200), 16, 8 * (i / 200)});
    file.grids[0].values.resize(file.grids[0].leaves.size() * 512, 0.25f);
    write_vdb(path, file);
    file = {};
    std::uint64_t pages = 0;
    rlimit before{};
    ::getrlimit(RLIMIT_AS, &before);
    int refused = 0;
    for (const std::uint64_t megabytes : {30, 60, 90, 120, 160, 200, 250}) {
      std::ifstream("/proc/self/statm") >> pages;
      const rlimit little{pages * 4096 + (megabytes << 20), before.rlim_max};
      ::setrlimit(RLIMIT_AS, &little);
      std::string what;
      try {
        read_vdb(path);
      } catch (const Error& e) {
        what = e.what();
        CHECK(e.fault == Fault::memory);
        CHECK(what.find("not enough memory") != std::string::npos);
      } catch (const std::bad_alloc&) {  // before the child: the file's own bytes
        what = "bytes";
      }
      ::setrlimit(RLIMIT_AS, &before);
      refused += !what.empty();
    }
    CHECK(refused > 2);
    CHECK(read_vdb(path).grids[0].leaves.size() == 40'003);
  }
#endif

  TEST_CASE("a pipe or a device in the place of a VDB is refused at once") {
    const Scratch scratch;
    REQUIRE(::mkfifo(scratch.path("pipe.vdb").c_str(), 0600) == 0);
    CHECK(verdict(scratch.path("pipe.vdb")).find("is no file") != std::string::npos);
    CHECK(verdict("/dev/zero").find("is no file") != std::string::npos);
  }
}
