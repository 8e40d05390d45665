// SPDX-License-Identifier: Apache-2.0
// What a stranger may have put into a folder that this program reads and writes: links, pipes, devices.
#include "core/own_folder.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <csignal>
#include <set>

#include "core/atomic_file.hpp"
#include "core/handle.hpp"
#include "splinevox/core/error.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using test::TempFolder;
namespace fs = std::filesystem;

namespace {

std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A folder of ours and something outside of it.
struct Stage {
  TempFolder temp;
  std::string own = temp.str() + "/own", theirs = temp.str() + "/theirs";
  Stage() {
    fs::create_directories(own);
    test::write_text(theirs, "precious");
  }
  std::string in(const std::string& name) const { return own + "/" + name; }
  void check_untouched() const { CHECK(slurp(theirs) == "precious"); }
};

}  // namespace

TEST_SUITE("core/own_folder") {
  TEST_CASE("a file is never written, added to or read through a link") {
    const Stage stage;
    for (const std::string& target : {stage.theirs, std::string("../theirs"), stage.temp.str() + "/none"}) {
      const std::string link = stage.in("file");
      fs::create_symlink(target, link);
      CHECK_THROWS_WITH_AS(write_file(link, {"mine"}), doctest::Contains("a link, and it is not followed"),
                           Error);
      CHECK_FALSE(append_to_file(link, "mine"));
      CHECK_THROWS_AS(read_file(link), Error);
      CHECK_THROWS_AS(digest_file(link), Error);
      CHECK(fs::is_symlink(link));
      CHECK_FALSE(fs::exists(stage.temp.path() / "none"));
      fs::remove(link);
    }
    fs::create_directory_symlink(stage.temp.str(), stage.in("preview"));
    CHECK_FALSE(make_inner_folder(stage.in("preview")));
    CHECK(make_inner_folder(stage.in("other")));
    CHECK(make_inner_folder(stage.in("other")));
    stage.check_untouched();
  }

  TEST_CASE("a folder that the user reaches through a link is his own") {
    const Stage stage;
    fs::create_directory_symlink("own", stage.temp.path() / "scratch");
    const std::string path = stage.temp.str() + "/scratch/file";
    check_own_folder(stage.temp.str() + "/scratch", Depth::all);
    write_file(path, {"mine"});
    CHECK(append_to_file(path, ", too"));
    CHECK(read_file(path) == "mine, too");
    CHECK(slurp(stage.in("file")) == "mine, too");
  }

  TEST_CASE("what the user named may be a link, which stays one, or a device") {
    const Stage stage;
    fs::create_symlink(stage.theirs, stage.in("page.html"));
    write_file(stage.in("page.html"), {"new"}, Named::by_user);
    CHECK(fs::is_symlink(stage.in("page.html")));
    CHECK(slurp(stage.theirs) == "new");
    CHECK(read_file(stage.in("page.html"), 100, Named::by_user) == "new");
    write_file("/dev/null", {"new"}, Named::by_user);
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    write_file("/proc/self/fd/" + std::to_string(ends[1]), {"new"}, Named::by_user);  // as /dev/stdout is one
    char got[4] = {};
    CHECK(::read(ends[0], got, 3) == 3);
    CHECK(std::string(got) == "new");
    ::close(ends[0]);
    ::close(ends[1]);
    CHECK_THROWS_AS(write_file("/dev/null", {"new"}), Error);
  }

  TEST_CASE("pipes and devices are refused at once, not waited for") {
    const Stage stage;
    REQUIRE(::mkfifo(stage.in("pipe").c_str(), 0600) == 0);
    CHECK_THROWS_WITH_AS(read_file(stage.in("pipe")), doctest::Contains("is no file"), Error);
    CHECK_THROWS_AS(digest_file(stage.in("pipe")), Error);
    CHECK_THROWS_AS(write_file(stage.in("pipe"), {"mine"}), Error);
    CHECK_FALSE(append_to_file(stage.in("pipe"), "mine"));
    CHECK_THROWS_WITH_AS(check_own_folder(stage.own, Depth::all),
                         doctest::Contains("neither a file nor a folder"), Error);
    CHECK_THROWS_AS(read_file("/dev/zero", 100), Error);
  }

  TEST_CASE("links that lead out are found where they are, and those that stay within do no harm") {
    const Stage stage;
    test::write_text(stage.in("a/b/file"), "text");
    fs::create_symlink("file", stage.in("a/b/latest"));
    check_own_folder(stage.own, Depth::all);
    check_own_folder(stage.temp.str() + "/nowhere", Depth::all);
    for (const std::string& target : {stage.theirs, std::string("../../../theirs"), std::string("nothing"),
                                      std::string("../.."), std::string("/")}) {
      const fs::path link = stage.in("a/b/out");
      fs::create_symlink(target, link);
      CAPTURE(target);
      const bool within = target == "../..";  // the folder itself
      if (!within)
        CHECK_THROWS_WITH_AS(check_own_folder(stage.own, Depth::all), doctest::Contains("a/b/out"), Error);
      check_own_folder(stage.own, Depth::entries);
      fs::rename(link, stage.in("out"));
      if (!within)
        CHECK_THROWS_WITH_AS(check_own_folder(stage.own, Depth::entries), doctest::Contains("leads out"),
                             Error);
      fs::remove(stage.in("out"));
    }
    fs::create_symlink("round", stage.in("round"));
    CHECK_THROWS_AS(check_own_folder(stage.own, Depth::entries), Error);
  }

  TEST_CASE("a draft stands in nobody's way and its name cannot be foreseen") {
    const Stage stage;
    std::set<std::string> names;
    for (int i = 0; i < 100; ++i) names.insert(draft_name(stage.in("film.mp4")));
    CHECK(names.size() == 100);
    CHECK(fs::path(*names.begin()).parent_path() == stage.own);
    CHECK(fs::path(*names.begin()).filename().string().starts_with(".film.mp4."));
    // Drafts of write_file count on: every name that may come next is taken by a link.
    const std::string before = stage.in("file");
    for (int i = 0; i < 40; ++i)
      fs::create_symlink(stage.theirs,
                         before + "." + std::to_string(::getpid()) + "-" + std::to_string(i) + ".tmp");
    write_file(before, {"mine"});
    CHECK(slurp(before) == "mine");
    stage.check_untouched();
  }

  TEST_CASE("a file that cannot be read to its end is no file read") {
    // Regular by its kind, and unreadable at its beginning even for root.
    CHECK_THROWS_WITH_AS(read_file("/proc/self/mem"), doctest::Contains("could not be read"), Error);
    CHECK_THROWS_AS(read_file("/proc/self/mem", 100, Named::by_user), Error);
    CHECK_THROWS_AS(digest_file("/proc/self/mem"), Error);
  }

  TEST_CASE("a signal in the midst of a call is no error") {
    int calls = 0;
    CHECK(retried([&] {
            errno = EINTR;
            return ++calls < 3 ? -1 : 7;
          }) == 7);
    CHECK(calls == 3);
    CHECK(retried([] {
            errno = EIO;
            return -1;
          }) == -1);
  }
}
