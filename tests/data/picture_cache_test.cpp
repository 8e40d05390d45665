// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/picture_cache.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <thread>

#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "support/file_size_limit.hpp"
#include "support/tiny_dataset.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;

/// A ball with alpha, filmed in many pictures, and a folder for the cache.
struct Filmed {
  TempFolder folder;
  std::string data = folder.str() + "/ball", cache = folder.str() + "/cache";
  Filmed() { write_moving_ball(data, {.train = 60, .val = 0, .test = 3, .size = 24}); }

  /// Two threads, so that what is decoded at once is less than all.
  Dataset load(bool in_file, int downscale = 1, const std::string& at = "") const {
    LoadOptions options;
    options.splits = {"train"};
    options.downscale = downscale;
    options.cache = at.empty() ? cache : at;
    if (in_file) options.room = [](const Dataset&) { return 50e3; };
    Dataset out;
    tbb::task_arena(2).execute([&] { out = load_dataset(data, options); });
    return out;
  }
  std::vector<std::string> files() const {
    std::vector<std::string> out;
    for (const fs::directory_entry& e : fs::directory_iterator(cache)) out.push_back(e.path().string());
    return out;
  }
  /// Of the one file that there is: another number means that it was made anew.
  std::uint64_t number() const {
    REQUIRE(files().size() == 1);
    struct stat info {};
    REQUIRE(::stat(files()[0].c_str(), &info) == 0);
    return info.st_ino;
  }
  std::string bytes() const {
    std::ifstream in(files().at(0), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// In the place of the one file, as another file.
  void put(const std::string& bytes) const {
    const std::string path = files().at(0);
    fs::remove(path);
    std::ofstream(path, std::ios::binary) << bytes;
  }
};

bool notes_have(const Dataset& data, const std::string& part) {
  for (const std::string& note : data.notes)
    if (note.find(part) != note.npos) return true;
  return false;
}

void check_same(const Dataset& a, const Dataset& b) {
  CHECK(a.fingerprint == b.fingerprint);
  CHECK(a.has_alpha == b.has_alpha);
  REQUIRE(a.find("train")->frames.size() == b.find("train")->frames.size());
  for (std::size_t f = 0; f < a.find("train")->frames.size(); ++f)
    CHECK(a.find("train")->frames[f].image == b.find("train")->frames[f].image);
}

void expect_output_error(const std::function<void()>& action, const std::vector<std::string>& parts) {
  try {
    action();
    FAIL_CHECK("no error was thrown");
  } catch (const Error& error) {
    const std::string message = error.what();
    CAPTURE(message);
    CHECK(error.fault == Fault::output);
    for (const std::string& part : parts) CHECK(message.find(part) != std::string::npos);
  }
}

TEST_SUITE("data/picture_cache") {
  TEST_CASE("what does not fit lives in one file, is the same, and is used again") {
    const Filmed filmed;
    const Dataset memory = filmed.load(false);
    CHECK_FALSE(fs::exists(filmed.cache));
    const Dataset file = filmed.load(true);
    CHECK(memory.pictures_in_files == 0);
    CHECK(file.pictures_in_memory == 0);
    CHECK(file.pictures_in_files == memory.pictures_in_memory);
    check_same(memory, file);
    const std::uint64_t number = filmed.number();
    CHECK(notes_have(file, filmed.files()[0]));
    CHECK(notes_have(file, "may be deleted"));
    check_same(memory, filmed.load(true));
    CHECK(filmed.number() == number);
    fs::remove(filmed.files()[0]);  // whoever has it open keeps it
    check_same(memory, file);
    for (const Frame& f : file.find("train")->frames) {
      const auto before = f.image.pixel(12, 12);
      f.image.give_back();
      f.image.fetch();
      CHECK(f.image.pixel(12, 12) == before);
    }
  }

  TEST_CASE("a picture that changed, and another downscale, are decoded again") {
    const Filmed filmed;
    filmed.load(true);
    const std::uint64_t number = filmed.number();
    write_png(filmed.data + "/train/r_7.png", ball_png(24, 0.8, orbit_matrix(1), 0.3));
    const Dataset changed = filmed.load(true);
    CHECK(filmed.number() != number);
    CHECK(notes_have(changed, "is of other pictures: made anew"));
    check_same(changed, filmed.load(false));
    check_same(filmed.load(true, 2), filmed.load(false, 2));
    CHECK(filmed.files().size() == 2);
  }

  TEST_CASE("a file that is damaged or cut off anywhere is made anew") {
    const Filmed filmed;
    const Dataset memory = filmed.load(false);
    filmed.load(true);
    const std::string good = filmed.bytes();
    std::vector<std::string> bad = {"",
                                    "x",
                                    good.substr(0, good.size() - 1),
                                    good.substr(0, good.size() / 2),
                                    good.substr(0, 4096),
                                    good + "x"};
    for (const std::size_t at : {std::size_t(4100), good.size() - 1, good.size() - 30, good.size() - 100}) {
      bad.push_back(good);
      bad.back()[at] = char(bad.back()[at] ^ 0x10);
    }
    for (const std::string& bytes : bad) {
      filmed.put(bytes);
      const std::uint64_t number = filmed.number();
      const Dataset data = filmed.load(true);
      check_same(memory, data);
      CHECK(filmed.number() != number);
      CHECK(filmed.bytes() == good);
      CHECK((bytes.empty() || notes_have(data, "is damaged: made anew")));
    }
  }

  TEST_CASE("of two that want it at once one makes it, and what a killed one left goes") {
    const Filmed filmed;
    const Dataset memory = filmed.load(false);
    filmed.load(true);
    const std::string path = filmed.files()[0];
    std::ofstream(path + ".123-0.tmp") << "half a file";
    fs::remove(path);
    Dataset found[3];
    std::vector<std::thread> threads;
    for (Dataset& data : found) threads.emplace_back([&] { data = filmed.load(true); });
    for (std::thread& t : threads) t.join();
    for (const Dataset& data : found) check_same(memory, data);
    CHECK(filmed.files() == std::vector<std::string>{path});
  }

  TEST_CASE("a full disk, and a folder that cannot be: said with what to do, and nothing is left") {
    const Filmed filmed;
    {
      const FileSizeLimit full(20'000);
      expect_output_error([&] { filmed.load(true); }, {"could not be written", "--cache", "--downscale"});
    }
    CHECK(filmed.files().empty());
    const std::string file = filmed.folder.str() + "/file";
    std::ofstream(file) << "x";
    expect_output_error([&] { filmed.load(true, 1, file + "/cache"); }, {file + "/cache", "--cache"});
  }

  TEST_CASE("a file that is there serves from a folder that may not be written to") {
    const Filmed filmed;
    const Dataset memory = filmed.load(false);
    filmed.load(true);
    const std::uint64_t number = filmed.number();
    fs::permissions(filmed.cache, fs::perms::owner_read | fs::perms::owner_exec);
    check_same(memory, filmed.load(true));
    CHECK(filmed.number() == number);
    if (::geteuid() != 0) {
      write_png(filmed.data + "/train/r_7.png", ball_png(24, 0.8, orbit_matrix(1), 0.3));
      expect_output_error([&] { filmed.load(true); }, {"could not be written", "--cache"});
    }
    fs::permissions(filmed.cache, fs::perms::owner_all);
  }

  TEST_CASE("pictures are small: 3 bytes for opaque ones of 8 bits, 8 only for alpha of 16") {
    const auto layout_of = [](std::uint16_t colour, std::uint16_t alpha) {
      return Picture(Image16{1, 1, {colour, 257, 514, alpha}}).layout().size(1);
    };
    CHECK(layout_of(257, 65535) == 3);
    CHECK(layout_of(257, 0) == 4);
    CHECK(layout_of(258, 65535) == 6);
    CHECK(layout_of(257, 65534) == 8);
  }
}

}  // namespace
