// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program.hpp"

namespace splinevox::test {

/// A ball that moves, and the words that train on it for a moment.
struct BallScene {
  TempFolder temp;
  std::string data = temp.str() + "/ball";
  BallScene() { write_moving_ball(data, {12, 2, 3, 24, 0.8}); }
  std::string path(const std::string& name) const { return temp.str() + "/" + name; }
  std::vector<std::string> train(const std::string& run, const std::string& steps,
                                 std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"train",       data,
                                      "--out",       path(run),
                                      "--preset",    "draft",
                                      "--max-steps", steps,
                                      "--set",       "sampling.rays=512",
                                      "--set",       "grid.radiance=16,24,32",
                                      "--set",       "grid.motion=4,8",
                                      "--set",       "grid.motion_start=0,0.2",
                                      "--set",       "sampling.occupancy_cells=24"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

/// A sweep over a ball that moves, with preset draft. @param rest  of the description: seeds, train, settings
/// @return the description's path
inline std::string describe_sweep(const TempFolder& folder, const std::string& rest) {
  write_moving_ball(folder.path() / "ball", {8, 2, 2, 16, 0.8});
  const std::string path = folder.str() + "/sweep.toml";
  write_text(path, "datasets = [\"" + folder.str() + "/ball\"]\npresets = [\"draft\"]\n" + rest);
  return path;
}

/// The words that train a run on a few small lattices, without trials of effects.
inline std::vector<std::string> train_small(const std::string& data, const std::string& out,
                                            const std::vector<std::string>& more) {
  std::vector<std::string> words = {"train",    data,
                                    "--out",    out,
                                    "--preset", "draft",
                                    "--set",    "sampling.rays=128",
                                    "--set",    "grid.radiance=8,12,16",
                                    "--set",    "grid.motion=4,8",
                                    "--set",    "grid.motion_start=0,0.2",
                                    "--set",    "sampling.occupancy_cells=24",
                                    "--set",    "motion.points=4",
                                    "--set",    "effects.steps=0",
                                    "--quiet"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// A run that is trained on such a ball for four steps, and the words for others beside it.
struct SmallRun {
  TempFolder temp;
  std::string data = path("ball"), run = path("run");
  SmallRun() {
    write_moving_ball(data, {6, 1, 2, 12, 0.8});
    REQUIRE(program(train("run", {"--max-steps", "4"})).code == 0);
  }
  std::string path(const std::string& name) const { return temp.str() + "/" + name; }
  std::vector<std::string> train(const std::string& out, const std::vector<std::string>& more) const {
    return train_small(data, path(out), more);
  }
};

}  // namespace splinevox::test
