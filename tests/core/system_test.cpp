// SPDX-License-Identifier: Apache-2.0
#include "core/system.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <set>

#include "core/process.hpp"

using namespace splinevox;
namespace fs = std::filesystem;

TEST_SUITE("core/system") {
  TEST_CASE("a program finds itself, from wherever it went") {
    const fs::path before = fs::current_path();
    name_own_program("./there");
    fs::current_path("/");
    const std::string self = own_program();
    fs::current_path(before);
    CHECK((fs::exists(self) || self == (before / "./there").string()));
    name_own_program("found-by-path");
    CHECK((own_program() == self || own_program() == "found-by-path"));
  }

  TEST_CASE("memory: where it can be told, more is left than nothing and less than all") {
    if (const auto memory = machine_memory()) {
      CHECK(memory->left > 1e6);
      CHECK(memory->left <= memory->most);
    }
    if (const auto mapped = mapped_memory()) CHECK(*mapped > 1'000'000);
    CHECK(peak_memory() > 1e6);
    CHECK(usable_memory() > 1e6);
  }

  TEST_CASE("a pipe carries bytes, and programs started from here do not have it") {
    int ends[2] = {-1, -1};
    REQUIRE(make_pipe(ends));
    CHECK(::write(ends[1], "ab", 2) == 2);
    std::array<char, 2> got{};
    CHECK(::read(ends[0], got.data(), got.size()) == 2);
    CHECK(got == std::array{'a', 'b'});
    for (const int end : ends) {
      CHECK((::fcntl(end, F_GETFD) & FD_CLOEXEC) != 0);
      ::close(end);
    }
  }

  TEST_CASE("random bytes do not come twice") {
    std::set<std::array<unsigned char, 16>> seen;
    for (int i = 0; i < 100; ++i) {
      std::array<unsigned char, 16> bytes{};
      CHECK(fill_random(bytes.data(), bytes.size()));
      seen.insert(bytes);
    }
    CHECK(seen.size() == 100);
  }

  TEST_CASE("a stream that could not write can be closed, and a file knows when it was written") {
    std::FILE* full = std::fopen("/dev/full", "w");
    if (full) {
      std::fputs("text", full);
      CHECK(std::fflush(full) != 0);
      drop_unwritten(full);
      std::fclose(full);
    }
    const std::string path =
        (fs::temp_directory_path() / ("splinevox_" + std::to_string(::getpid()))).string();
    std::FILE* file = std::fopen(path.c_str(), "w");
    REQUIRE(file);
    std::fclose(file);
    struct stat info {};
    REQUIRE(::stat(path.c_str(), &info) == 0);
    CHECK(std::difftime(std::time(nullptr), changed_at(info).tv_sec) < 60);
    fs::remove(path);
  }
}
