// SPDX-License-Identifier: Apache-2.0
// A render that is stopped, or was killed, leaves what is whole and nothing else.
#include <doctest/doctest.h>
#include <sys/file.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "app/ball_scene.hpp"

using namespace splinevox::test;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  std::error_code none;  // no folder yet
  for (const auto& entry : fs::directory_iterator(folder, none))
    names.insert(entry.path().filename().string());
  return names;
}

/// A render of more pictures than a test waits for. It is stopped when a file is there of such a name.
Ended stopped(const SmallRun& small, const std::string& out, const std::string& format,
              const std::string& part) {
  Started render({SPLINEVOX_PROGRAM, "render", small.run, "--out", out, "--camera", "orbit", "--times",
                  "0:1:200000", "--size", "32", "--format", format, "--json"});
  const auto begun = [&] {
    const std::set<std::string> names = names_in(out);
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return contains(name, part); });
  };
  REQUIRE(comes(begun));
  ::kill(render.process(), SIGINT);
  return render.wait();
}

/// The last line of standard output.
Json last_event(const Ended& e) {
  const std::size_t end = e.out.find_last_not_of('\n'), before = e.out.rfind('\n', end);
  return Json::parse(e.out.substr(before == e.out.npos ? 0 : before + 1));
}

/// The folder of an earlier render in which it was killed, and files that only look like leftovers.
struct Killed {
  SmallRun small;
  std::string out = small.path("out");
  const std::set<std::string> left = {".rgb.mp4.0123456789abcdef.tmp", "rgb_0007.png.4194305-0.tmp",
                                      ".probe.4194305"};
  const std::set<std::string> mine = {".rgb.mp4.0123456789ABCDEF.tmp",
                                      ".rgb.mp4.0123456789abcde.tmp",
                                      "rgb.mp4.0123456789abcdef.tmp",
                                      ".mp4.0123456789abcdef.tmp",
                                      ".notes.txt.0123456789abcdef.tmp",
                                      "rgb_0007.png." + std::to_string(::getpid()) + "-0.tmp",
                                      "notes.tmp"};
  Killed() {
    for (const std::set<std::string>* names : {&left, &mine})
      for (const std::string& name : *names) write_text(out + "/" + name, "half");
    fs::create_symlink(small.run + "/config.toml", out + "/.depth.mp4.0123456789abcdef.tmp");
  }
  Ended render() const {
    return program({"render", small.run, "--out", out, "--camera", "orbit", "--times", "0", "--size", "16"});
  }
  bool all_there(const std::set<std::string>& names) const {
    const std::set<std::string> there = names_in(out);
    return std::includes(there.begin(), there.end(), names.begin(), names.end());
  }
  bool none_there(const std::set<std::string>& names) const {
    const std::set<std::string> there = names_in(out);
    return std::none_of(names.begin(), names.end(), [&](const auto& name) { return there.contains(name); });
  }
};

}  // namespace

TEST_SUITE("cli/render_stop") {
  TEST_CASE("a signal ends a render after the picture it is at; what is there is whole, and it says so") {
    const SmallRun small;
    for (const auto& [format, second] : {std::pair{"png", "rgb_0002.png"}, {"exr", "frame_0002.exr"}}) {
      CAPTURE(format);
      const std::string out = small.path(format);
      const Ended e = stopped(small, out, format, second);
      CAPTURE(e.err);
      CHECK(e.code == 130);
      CHECK(contains(e.err, "interrupted after"));
      const Json last = last_event(e);
      CHECK(last["event"] == "interrupted");
      CHECK(last["interrupted"] == true);
      const std::set<std::string> names = names_in(out);
      CHECK(last["pictures"] == names.size() - 1);  // and render.json
      for (const std::string& name : names) CHECK_FALSE(name.ends_with(".tmp"));
    }
  }

  TEST_CASE("of a film that is stopped nothing stays") {
    if (found_in_path("ffmpeg").empty()) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    const SmallRun small;
    const Ended e = stopped(small, small.path("film"), "mp4", ".mp4.");
    CAPTURE(e.err);
    CHECK(e.code == 130);
    CHECK(last_event(e)["pictures"] == 0);
    CHECK(names_in(small.path("film")) == std::set<std::string>{"render.json"});
  }

  TEST_CASE("what a killed render left half written goes with the next one, in a folder of ours alone") {
    const Killed killed;
    CHECK(killed.render().code == 2);  // a link that leads out of the folder
    CHECK(fs::remove(killed.out + "/.depth.mp4.0123456789abcdef.tmp"));
    CHECK(killed.render().code == 0);
    CHECK(killed.all_there(killed.left));  // whoever wrote these, no render had marked the folder
    CHECK(killed.all_there(killed.mine));
    fs::create_symlink("render.json", killed.out + "/.depth.mp4.0123456789abcdef.tmp");
    CHECK(killed.render().code == 0);
    CHECK(killed.none_there(killed.left));
    CHECK(killed.all_there(killed.mine));
    CHECK(killed.all_there({"rgb_0001.png", "render.json", ".depth.mp4.0123456789abcdef.tmp"}));
  }

  TEST_CASE(
      "beside another render nothing is removed, and where somebody has the folder alone it is refused") {
    const Killed killed;
    fs::remove(killed.out + "/.depth.mp4.0123456789abcdef.tmp");
    REQUIRE(killed.render().code == 0);
    const int folder = ::open(killed.out.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    REQUIRE(::flock(folder, LOCK_SH) == 0);
    CHECK(killed.render().code == 0);
    CHECK(killed.all_there(killed.left));
    REQUIRE(::flock(folder, LOCK_EX) == 0);
    const Ended busy = killed.render();
    ::close(folder);
    CHECK(busy.code == 2);
    CHECK(contains(busy.err, "another process is writing into this folder"));
    CHECK(killed.all_there(killed.left));
  }

  TEST_CASE("pictures of an earlier, longer shot in the folder are named, and the mark is the last run's") {
    const SmallRun small;
    const auto render = [&](const std::string& times) {
      return program({"render", small.run, "--out", small.path("shot"), "--camera", "orbit", "--size", "16",
                      "--times", times});
    };
    const Ended longer = render("0:1:4");
    CHECK_FALSE(contains(longer.out, "earlier render"));
    write_text(small.path("shot") + "/notes_0004.png", "mine");
    const Ended shorter = render("0:1:2");
    CAPTURE(shorter.out);
    CHECK(shorter.code == 0);
    CHECK(contains(shorter.out,
                   "left by an earlier render and not of this sequence: rgb_0003.png to "
                   "rgb_0004.png (2 files)"));
  }
}
