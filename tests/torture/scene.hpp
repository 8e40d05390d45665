// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "torture/trial.hpp"

namespace splinevox::torture {

/// A small data set and a run of it, made by the program itself; removed at the end.
class Scene {
 public:
  static constexpr int kSteps = 100;  ///< of training
  explicit Scene(const Options& o) : program_(o.program), folder_(folder_of(o)) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    const std::string log = o.out + "/scene.log";
    must(Process({program_, "synth", "ball", "--out", path("data"), "--size", "24", "--frames", "8"}, log),
         log);
    std::vector<std::string> words = train_words();
    words.insert(words.end(), {"--out", path("run")});
    must(Process(words, log), log);
  }
  ~Scene() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::vector<std::string> train_words() const {
    return {program_,
            "train",
            path("data"),
            "--preset",
            "draft",
            "--max-steps",
            std::to_string(kSteps),
            "--set",
            "run.checkpoint_every=0",
            "--set",
            "sampling.rays=128",
            "--set",
            "grid.radiance=8,12,16",
            "--set",
            "grid.motion=4,8",
            "--set",
            "grid.motion_start=0,0.2",
            "--set",
            "sampling.occupancy_cells=24",
            "--set",
            "motion.points=4",
            "--set",
            "effects.steps=0",
            "--quiet"};
  }
  std::vector<std::string> export_words() const {
    return {program_, "export", path("run"), "--frames", "1-4", "--quiet"};
  }

 private:
  static std::string folder_of(const Options& o) {
    const std::filesystem::path memory = "/dev/shm";
    return std::filesystem::is_directory(memory) ? "/dev/shm/splinevox_torture_" + std::to_string(::getpid())
                                                 : o.out + "/scene";
  }
  static void must(Process process, const std::string& log) {
    if (process.wait() != 0) throw std::runtime_error("the program cannot make a scene, see " + log);
  }
  std::string program_, folder_;
};

}  // namespace splinevox::torture
