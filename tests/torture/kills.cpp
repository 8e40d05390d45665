// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <random>

#include "splinevox/core/atomic_file.hpp"
#include "splinevox/core/error.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace fs = std::filesystem;

namespace {

constexpr int kMostKills = 4;  // of one run before it is let to its end

/// Whether a folder's files are all there and whole, by the program's own word.
bool whole(const Options& o, const std::string& folder, const std::string& log) {
  return Process({o.program, "verify", folder}, log).wait() == 0;
}

std::string bytes_of(const std::string& path) {
  try {
    return read_file(path);
  } catch (const Error&) {
    return "";
  }
}

int drafts_in(const std::string& folder) {
  int n = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) n += entry.path().extension() == ".tmp";
  return n;
}

/// What is killed, how it is begun and gone on with, and the files that must come out as if it never had been.
struct Job {
  const char* name;
  std::vector<std::string> words;
  std::vector<std::string> files;
};

Line kill_again_and_again(const Options& o, const Job& job, const std::string& folder, double seconds) {
  const Clock::time_point begin = Clock::now();
  const std::string log = o.out + "/kills.log", reference = folder + "_reference", out = folder + "_out";
  const auto words = [&](const std::string& to) {
    std::vector<std::string> all = job.words;
    all.insert(all.end(), {"--out", to});
    return all;
  };
  Line line{"kills", job.name};
  const Clock::time_point first = Clock::now();
  if (Process(words(reference), log).wait() != 0) throw std::runtime_error("the program cannot do it without being killed, see " + log);
  const double length = since(first);
  std::mt19937_64 random(o.seed);
  std::uint64_t drafts = 0, ends = 0;
  while (since(begin) < seconds) {
    fs::remove_all(out);
    bool good = true;
    const int kills = 1 + int(random() % kMostKills);
    for (int k = 0; k < kills; ++k) {
      Process process(words(out), log);
      std::uniform_real_distribution<double> moment(0, 1.1 * length);
      const int code = process.wait(moment(random));  // kills it
      if (code == -1) ++line.tried;
      good = good && (code == -1 || code == 0);
      drafts += std::uint64_t(drafts_in(out));
    }
    good = good && Process(words(out), log).wait() == 0;
    good = good && whole(o, out, log) && drafts_in(out) == 0;
    for (const std::string& file : job.files) good = good && !bytes_of(reference + "/" + file).empty() && bytes_of(out + "/" + file) == bytes_of(reference + "/" + file);
    ++ends;
    if (good) continue;
    ++line.lost;
    fs::rename(out, o.out + "/lost_" + job.name + "_" + std::to_string(line.lost));
    fs::copy_file(log, o.out + "/lost_" + job.name + "_" + std::to_string(line.lost) + ".log", fs::copy_options::overwrite_existing);
  }
  line.seconds = since(begin);
  line.note = std::to_string(ends) + " runs ended as one that was left alone, bit for bit, but for those lost; " + std::to_string(drafts) + " kills hit a file half written";
  return line;
}

}  // namespace

std::vector<Line> try_kills(const Options& o, double seconds) {
  const Scene scene(o);
  std::vector<std::string> train = scene.train_words();
  train.push_back("--resume");
  const std::vector<Job> jobs = {{"train", train, {"model.vdb", "config.toml", "effects.json"}},
                                 {"export", scene.export_words(), {"manifest.json", "frame_0001.vdb", "frame_0004.vdb", "load_in_blender.py"}}};
  std::vector<Line> lines;
  for (const Job& job : jobs) lines.push_back(kill_again_and_again(o, job, scene.path(job.name), seconds / double(jobs.size())));
  return lines;
}

}  // namespace splinevox::torture
