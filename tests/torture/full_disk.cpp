// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "splinevox/core/atomic_file.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace fs = std::filesystem;

namespace {

/// Hash of every file below a folder, by relative path.
std::map<std::string, FileDigest> files_of(const std::string& folder) {
  std::map<std::string, FileDigest> out;
  if (!fs::exists(folder)) return out;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) out[fs::relative(entry.path(), folder)] = digest_file(entry.path());
  return out;
}

/// Files whose bytes hold the time of day or the clock: only those of other names are compared.
bool tells_time(const std::string& path) {
  const std::string name = fs::path(path).filename();
  return name.starts_with("metrics.json") || name.starts_with("checkpoint.bin") || name.ends_with("manifest.json") ||
         name.ends_with(".partial.json") || name.ends_with(".html");
}

struct Writer {
  std::string name;
  std::vector<std::string> words;  ///< without --out OUT
  std::string file;                ///< of the folder that OUT is within; empty: OUT is the folder
};

/// From no room at all to nearly enough, geometrically from 64 bytes on.
std::vector<std::int64_t> limits_up_to(std::uint64_t largest, int count) {
  std::vector<std::int64_t> out{0};
  for (int i = 0; i < count; ++i)
    out.push_back(std::int64_t(64 * std::pow(double(std::max<std::uint64_t>(largest, 65)) / 64, double(i) / count)));
  out.push_back(std::int64_t(largest) - 1);
  return out;
}

}  // namespace

std::vector<Line> try_full_disk(const Options& o, double seconds) {
  const Scene scene(o);
  const std::string log = o.out + "/disk.log", points = scene.path("points.csv");
  std::ofstream(points) << "x,y,z\n0.1,0.2,0.3\n0,0,0\n";
  const std::string run = scene.path("run");
  const std::vector<Writer> writers = {
      {"train", scene.train_words(), ""},
      {"export", scene.export_words(), ""},
      {"render png",
       {o.program, "render", run, "--camera", "orbit", "--times", "0:1:3", "--size", "24", "--layers", "rgb,depth",
        "--format", "png"},
       ""},
      {"render exr",
       {o.program, "render", run, "--camera", "orbit", "--times", "0:1:2", "--size", "24", "--format", "exr"},
       ""},
      {"track csv", {o.program, "track", run, "--points", points, "--to", "0,0.5,1", "--quiet"}, "tracks.csv"},
      {"track json", {o.program, "track", run, "--points", points, "--to", "0,0.5,1", "--quiet"}, "tracks.json"},
      {"synth", {o.program, "synth", "ball", "--size", "12", "--frames", "3"}, ""},
      {"report", {o.program, "report", run}, "page.html"},
  };
  std::vector<Line> lines;
  for (const Writer& w : writers) {
    const Clock::time_point begin = Clock::now();
    Line line{"full disk", w.name};
    const auto execute = [&](const std::string& folder, std::int64_t limit) {
      fs::create_directories(folder);
      std::vector<std::string> words = w.words;
      words.insert(words.end(), {"--out", w.file.empty() ? folder + "/out" : folder + "/" + w.file});
      return Process(words, log, limit).wait();
    };
    const std::string reference = scene.path("reference"), out = scene.path("out");
    fs::remove_all(reference);
    if (execute(reference, -1) != 0) throw std::runtime_error(w.name + " fails with all the room there is, see " + log);
    const auto good = files_of(reference);
    std::uint64_t largest = 0;
    for (const auto& [name, digest] : good) largest = std::max(largest, digest.size);
    const double each = since(begin), share = seconds / double(writers.size());
    for (const std::int64_t limit : limits_up_to(largest, std::clamp(int(share / std::max(each, 0.01)), 4, 256))) {
      fs::remove_all(out);
      const int code = execute(out, limit);
      ++line.tried;
      std::string wrong;
      if (code > 128 || code < 0) wrong = "ended by a signal or not at all", ++(code < 0 ? line.hangs : line.crashes);
      for (const auto& [name, digest] : files_of(out)) {
        const auto same = good.find(name);
        if (name.ends_with(".tmp"))
          wrong = "left " + name, ++line.lost;
        else if (!tells_time(name) && same != good.end() && !(same->second == digest))
          wrong = "left " + name + " damaged", ++line.lost;
      }
      if (code == 0 && files_of(out).size() != good.size())
        wrong = "said that all was well and it was not", ++line.lost;
      if (wrong.empty()) continue;
      line.note = wrong + " at " + std::to_string(limit) + " bytes";
      fs::copy_file(log, o.out + "/disk_" + std::to_string(lines.size()) + ".log",
                    fs::copy_options::overwrite_existing);
    }
    line.seconds = since(begin);
    lines.push_back(line);
  }
  return lines;
}

}  // namespace splinevox::torture
