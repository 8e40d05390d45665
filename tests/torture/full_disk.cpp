// SPDX-License-Identifier: Apache-2.0
#include <sys/mount.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "torture/folder_files.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace fs = std::filesystem;

namespace {

struct Writer {
  std::string name;
  std::vector<std::string> words;  ///< without --out OUT
  std::string file{};              ///< of the folder that OUT is within; empty: OUT is the folder
  const char* option = "--out";
  bool listed = false;  ///< `verify` can tell whether it is whole
};

/// A file system of so many bytes over a folder, while it lives. `mounted` is false where this process may
/// not mount one.
class SmallDisk {
 public:
  SmallDisk(const std::string& folder, std::uint64_t bytes) : folder_(folder) {
    fs::create_directories(folder);
    mounted = ::mount("tmpfs", folder.c_str(), "tmpfs", 0, ("size=" + std::to_string(bytes)).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted = false;

 private:
  std::string folder_;
};

/// From no room at all to nearly enough, geometrically from 64 bytes on.
std::vector<std::int64_t> limits_up_to(std::uint64_t largest, int count) {
  std::vector<std::int64_t> out{0};
  for (int i = 0; i < count; ++i)
    out.push_back(
        std::int64_t(64 * std::pow(double(std::max<std::uint64_t>(largest, 65)) / 64, double(i) / count)));
  out.push_back(std::int64_t(largest) - 1);
  return out;
}

}  // namespace

std::vector<Line> try_full_disk(const Options& o, double seconds) {
  const Scene scene(o);
  const std::string log = o.out + "/disk.log", points = scene.path("points.csv");
  std::ofstream(points) << "x,y,z\n0.1,0.2,0.3\n0,0,0\n";
  const std::string run = scene.path("run"), tasks = scene.path("sweep.toml");
  std::ofstream(tasks) << "datasets = [\"" << scene.path("data")
                       << "\"]\npresets = [\"draft\"]\ntrain = [\"--max-steps\", \"5\"]\n"
                       << "[settings]\nsmall = [\"sampling.rays=128\", \"grid.radiance=8,12,16\", "
                          "\"grid.motion=4,8\", \"grid.motion_start=0,0.2\", "
                          "\"motion.points=4\", \"effects.steps=0\"]\n";
  const auto frames = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = scene.export_words();
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const std::vector<Writer> writers = {
      {.name = "train", .words = scene.train_words(), .listed = true},
      {.name = "sweep", .words = {o.program, "sweep", tasks, "--quiet"}},
      {.name = "edit", .words = {o.program, "edit", run, "--reverse", "--quiet"}, .listed = true},
      {.name = "export", .words = scene.export_words(), .listed = true},
      {.name = "export, mesh and rig", .words = frames({"--mesh", "--controls"}), .listed = true},
      {.name = "export, parts and obj",
       .words = frames({"--clusters", "2", "--mesh", "--mesh-format", "obj"}),
       .listed = true},
      {.name = "export usd", .words = frames({"--profile", "usd"}), .listed = true},
      {.name = "export nanovdb", .words = frames({"--profile", "nanovdb"}), .listed = true},
      {.name = "render png",
       .words = {o.program, "render", run, "--camera", "orbit", "--times", "0:1:3", "--size", "24",
                 "--layers", "rgb,depth", "--format", "png"}},
      {.name = "render exr",
       .words = {o.program, "render", run, "--camera", "orbit", "--times", "0:1:2", "--size", "24",
                 "--format", "exr"}},
      {.name = "render mp4",  // a film of several pages of a disk
       .words = {o.program, "render", run, "--camera", "orbit", "--times", "0:1:12", "--size", "160",
                 "--layers", "depth", "--format", "mp4"}},
      {.name = "render mp4, long",  // larger than any of the disks but the last
       .words = {o.program, "render", run, "--camera", "orbit", "--times", "0:1:48", "--size", "256",
                 "--layers", "rgb", "--format", "mp4"}},
      {.name = "eval", .words = {o.program, "eval", run}, .option = "--images"},
      {.name = "track csv",
       .words = {o.program, "track", run, "--points", points, "--to", "0,0.5,1", "--quiet"},
       .file = "tracks.csv"},
      {.name = "track json",
       .words = {o.program, "track", run, "--points", points, "--to", "0,0.5,1", "--quiet"},
       .file = "tracks.json"},
      {.name = "view", .words = {o.program, "view", run}, .file = "page.html"},
      {.name = "report", .words = {o.program, "report", run}, .file = "page.html"},
      {.name = "synth", .words = {o.program, "synth", "ball", "--size", "12", "--frames", "3"}},
      {.name = "convert", .words = {o.program, "convert", scene.path("data"), "--quiet"}},
  };
  std::vector<Line> lines;
  for (const Writer& w : writers) {
    const Clock::time_point begin = Clock::now();
    Line line{"full disk", w.name};
    const auto execute = [&](const std::string& folder, std::int64_t limit) {
      fs::create_directories(folder);
      std::vector<std::string> words = w.words;
      words.insert(words.end(), {w.option, w.file.empty() ? folder + "/out" : folder + "/" + w.file});
      return Process(words, log, limit).wait();
    };
    const std::string reference = scene.path("reference"), out = scene.path("out");
    fs::remove_all(reference);
    if (execute(reference, -1) != 0)
      throw std::runtime_error(w.name + " fails with all the room there is, see " + log);
    const auto good = files_of(reference);
    std::uint64_t largest = 0;
    for (const auto& [name, digest] : good) largest = std::max(largest, digest.size);
    const double each = since(begin), share = seconds / double(writers.size());
    int full = 0;  // of them on a full disk
    const auto trial = [&](std::int64_t file_limit, const std::string& room) {
      const int code = execute(out, file_limit);
      ++line.tried;
      std::string wrong;
      if (code > 128 || code < 0) {
        wrong = "ended by a signal or not at all";
        ++(code < 0 ? line.hangs : line.crashes);
      }
      if (const std::string left = what_is_wrong(files_of(out), good); !left.empty()) {
        wrong = left;
        ++line.lost;
      }
      if (code == 0 && (files_of(out).size() != good.size() ||
                        (w.listed && Process({o.program, "verify", out + "/out"}, log).wait() != 0))) {
        wrong = "said that all was well and it was not";
        ++line.lost;
      }
      if (wrong.empty()) return;
      line.note = wrong + " with " + room;
      fs::copy_file(log, o.out + "/disk_" + std::to_string(lines.size()) + ".log",
                    fs::copy_options::overwrite_existing);
    };
    const int tries = std::clamp(int(share / std::max(each, 0.01)) / 2, 2, 128);
    for (const std::int64_t limit : limits_up_to(largest, tries)) {
      fs::remove_all(out);
      trial(limit, std::to_string(limit) + " bytes for a file");
    }
    for (const std::int64_t limit : limits_up_to(total(good), tries)) {
      fs::remove_all(out);
      const SmallDisk disk(out, std::uint64_t(std::max<std::int64_t>(limit, 1)));  // 0 would be no limit
      if (!disk.mounted) break;
      trial(-1, std::to_string(limit) + " bytes for all files");
      ++full;
    }
    line.seconds = since(begin);
    if (line.note.empty())
      line.note = full > 0 ? std::to_string(full) + " of them on a small disk"
                           : "by limits on the size of a file: no disk may be mounted here";
    lines.push_back(line);
  }
  return lines;
}

}  // namespace splinevox::torture
