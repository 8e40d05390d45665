// SPDX-License-Identifier: Apache-2.0
#include "io/checkpoint.hpp"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <random>
#include <string_view>

#include "data/expect_error.hpp"
#include "io/scratch.hpp"
#include "splinevox/core/error.hpp"

using namespace splinevox;
using test::FileSizeLimit, test::Scratch, test::slurp, test::spit, test::refusal;

namespace {

std::vector<char> noise(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<char> bytes(n);
  for (char& b : bytes) b = char(random());
  return bytes;
}

const CheckpointHeader kHeader{3, 0x0123456789abcdefull, 42, 1700, "trainer"};

std::string refused_checkpoint(const std::string& path) {
  return refusal([&] { read_checkpoint(path); });
}

}  // namespace

TEST_SUITE("io/checkpoint") {
  TEST_CASE("what is written is read back bit for bit, and the one before is kept") {
    const Scratch scratch;
    const std::string path = scratch.path("checkpoint.bin");
    for (const std::size_t size : {std::size_t(0), std::size_t(1), std::size_t(100003)}) {
      CAPTURE(size);
      const auto bytes = noise(size, 7);
      const FileDigest digest = write_checkpoint(path, kHeader, bytes);
      CHECK(digest == digest_file(path));
      const Checkpoint back = read_checkpoint(path);
      CHECK(back.header == kHeader);
      CHECK(back.bytes == bytes);
      CHECK(back.note.empty());
    }
    CHECK(read_checkpoint(path + ".prev").bytes == noise(1, 7));
    CHECK(scratch.count() == 2);  // no temporary file stays
  }

  TEST_CASE("after a kill that left one file under both names the next one leaves no temporary file") {
    const Scratch scratch;
    const std::string path = scratch.path("checkpoint.bin");
    write_checkpoint(path, kHeader, noise(9, 1));
    std::filesystem::create_hard_link(path, path + ".prev");
    write_checkpoint(path, kHeader, noise(9, 2));
    CHECK(read_checkpoint(path).bytes == noise(9, 2));
    CHECK(read_checkpoint(path + ".prev").bytes == noise(9, 1));
    CHECK(scratch.count() == 2);
  }

  TEST_CASE("in pieces it is the same file, and until it is committed the one before stays") {
    const Scratch scratch;
    const std::string path = scratch.path("checkpoint.bin");
    const auto bytes = noise(1000, 7);
    const FileDigest whole = write_checkpoint(path, kHeader, bytes);
    write_checkpoint(path, kHeader, noise(9, 1));
    auto changing = bytes;
    const std::string_view view(changing.data(), changing.size());
    const std::string_view pieces[] = {view.substr(0, 10), view.substr(10, 0), view.substr(10)};
    {
      const PendingCheckpoint given_up(path, kHeader, pieces);
      CHECK(scratch.count() == 3);  // the one, the one before, and what is on its way
    }
    CHECK(scratch.count() == 2);
    PendingCheckpoint file(path, kHeader, pieces);
    std::fill(changing.begin(), changing.end(), char(0));  // training goes on
    CHECK(read_checkpoint(path).bytes == noise(9, 1));
    CHECK(file.commit() == whole);
    CHECK(read_checkpoint(path).bytes == bytes);
    CHECK(read_checkpoint(path + ".prev").bytes == noise(9, 1));
  }

  TEST_CASE("every truncation and every flipped byte is found") {
    const Scratch scratch;
    const std::string path = scratch.path("c");
    write_checkpoint(path, kHeader, noise(300, 1));
    const std::string good = slurp(path);
    for (std::size_t n = 0; n < good.size(); ++n) {
      CAPTURE(n);
      spit(path, good.substr(0, n));
      CHECK_THROWS_AS(read_checkpoint(path), Error);
      std::string flipped = good;
      flipped[n] = char(flipped[n] ^ (1 << n % 8));
      spit(path, flipped);
      CHECK_THROWS_AS(read_checkpoint(path), Error);
    }
    spit(path, good + "x");
    CHECK_THROWS_AS(read_checkpoint(path), Error);
  }

  TEST_CASE("a damaged checkpoint is replaced by the one before, which is said") {
    const Scratch scratch;
    const std::string path = scratch.path("c");
    CheckpointHeader later = kHeader;
    later.step = 1800;
    write_checkpoint(path, kHeader, noise(50, 1));
    write_checkpoint(path, later, noise(50, 2));
    spit(path, slurp(path).substr(0, 60));
    const Checkpoint back = read_checkpoint(path);
    CHECK(back.header == kHeader);
    CHECK(back.bytes == noise(50, 1));
    CHECK(back.note == path + " is damaged or not complete (another one); the one before it, " + path +
                           ".prev at step 1700, is used instead");
    std::filesystem::remove(path);
    CHECK(read_checkpoint(path).note.find("could not be read (No such file or directory)") !=
          std::string::npos);
  }

  TEST_CASE("messages name the file and what is wrong") {
    const Scratch scratch;
    const std::string path = scratch.path("c");
    CHECK(refused_checkpoint(path) == path + ": could not be read\n  got:      No such file or directory");
    spit(path, "PK\3\4 something else entirely, long enough for a header of ours, which this is not at all");
    CHECK(refused_checkpoint(path) ==
          path +
              ": is not a checkpoint of splinevox\n  expected: a file that begins with SPVXCKPT\n"
              "  got:      other bytes");
  }

  TEST_CASE("a newer version is refused, even with an older one beside it") {
    const Scratch scratch;
    const std::string path = scratch.path("c"), inner = scratch.path("inner");
    write_checkpoint(path, kHeader, noise(9, 1));
    write_checkpoint(path, kHeader, noise(9, 2));
    // A whole file of version 9: the same frame with another number, sealed by its own checksum. The checksum
    // of a checkpoint is that of its bytes, so the digest of a file with those bytes gives it.
    std::string newer = slurp(path);
    newer.resize(newer.size() - 8);
    newer[8] = 9;
    spit(inner, newer);
    const std::uint64_t hash = digest_file(inner).hash;
    newer.append(reinterpret_cast<const char*>(&hash), 8);
    spit(path, newer);
    CHECK(refused_checkpoint(path) ==
          path +
              ": was written by a newer version of splinevox\n"
              "  expected: checkpoint version 1 or older\n  got:      9\n"
              "  try:      resume with the version that wrote it, or train into another folder");
  }

  TEST_CASE("a disk that fills up at any byte leaves the old checkpoint and no rubbish") {
    const Scratch scratch;
    const std::string path = scratch.path("c");
    write_checkpoint(path, kHeader, noise(4000, 1));
    const std::string good = slurp(path);
    for (std::size_t room = 0; room < good.size(); room += 61) {
      CAPTURE(room);
      {
        const FileSizeLimit limit(room);
        CHECK_THROWS_AS(write_checkpoint(path, kHeader, noise(4000, 2)), Error);
      }
      CHECK(slurp(path) == good);
      CHECK(scratch.count() == 1);
    }
  }

  TEST_CASE("killed at any moment of writing, the checkpoint is the old one or the new one") {
    const Scratch scratch;
    const std::string path = scratch.path("c");
    CheckpointHeader header = kHeader;
    header.step = 0;
    write_checkpoint(path, header, noise(200000, 0));
    std::mt19937 random(3);
    std::uint64_t last = 0;
    for (int i = 0; i < 40 || (last == 0 && i < 400); ++i) {  // none of 40 had time on a loaded machine
      CAPTURE(i);
      const pid_t pid = ::fork();
      if (pid == 0) {  // writes step after step until it is killed
        for (std::uint64_t step = last + 1;; ++step) {
          header.step = step;
          write_checkpoint(path, header, noise(200000, unsigned(step)));
        }
      }
      REQUIRE(pid > 0);
      ::usleep(unsigned(1 + i / 40) * unsigned(2000 + random() % 8000));
      ::kill(pid, SIGKILL);
      ::waitpid(pid, nullptr, 0);
      const Checkpoint back = read_checkpoint(path);
      CHECK(back.note.empty());
      CHECK(back.header.step >= last);
      CHECK(back.bytes == noise(200000, unsigned(back.header.step)));
      last = back.header.step;
    }
    CHECK(last > 0);
  }

  TEST_CASE("an output folder that is missing or not a folder is named") {
    const Scratch scratch;
    const std::string path = scratch.path("missing/c");
    try {
      write_checkpoint(path, kHeader, {});
      FAIL("written into a missing folder");
    } catch (const Error& e) {
      CHECK(e.fault == Fault::output);
      CHECK(std::string(e.what()).find(path + ": could not be written") == 0);
      CHECK(e.problem.got == "No such file or directory");
    }
  }
}
