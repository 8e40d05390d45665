// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "run/folder_lock.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::run {

inline constexpr const char* kCheckpoint = "checkpoint.bin";
inline constexpr const char* kEffects = "effects.json";
inline constexpr const char* kAskedConfig =
    "asked.toml";  ///< configuration before effects and the box were settled, where that changed it
inline constexpr const char* kTrainingPictures = "training_pictures.txt";  ///< see training_pictures.hpp
inline constexpr const char* kEditHistory = "edit.json";  ///< only a run that `edit` made has it

/// A folder that one run lives in (docs/formats.md lists its files). While the object lives, no other process
/// can open the same folder for writing. A folder that was made here and into which nothing was written goes
/// again.
class RunFolder {
 public:
  /// Makes or opens a folder to train into and proves that it can be written. A folder that already holds
  /// something is refused unless `resume`. Throws Error (input).
  RunFolder(const std::string& path, bool resume);
  /// The folder of a run that another process writes: only to be read, and nothing is checked.
  static RunFolder of_other(const std::string& path) { return RunFolder(path); }
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }
  bool has(const std::string& name) const;
  const std::string& path() const { return path_; }

 private:
  explicit RunFolder(const std::string& path) : path_(path) {}
  void remove_unfinished();
  std::string path_;
  bool made_ = false;
  std::optional<FolderLock> lock_;
};

/// Throws Error (input) where a sequence would be written into the folder of a run. @param what  "an export"
void refuse_run_folder(const std::string& out, const std::string& what);

/// Calls act(key, rule...) for each rule of a data set, with those of all arguments side by side.
template <class Act, class... Rules>
void each_rule(const Act& act, Rules&&... of) {
  act("times", of.times...);
  act("missing", of.missing...);
  act("masks", of.masks...);
  act("transfer", of.transfer...);
  act("layer", of.layer...);
  act("depth", of.depth...);
  act("tracks", of.tracks...);
  act("between", of.between...);
  act("hold_out", of.hold_out...);
}

std::string record_text(const RunRecord& record);
/// Both tables of RUN/config.toml. Throws Error (input).
void read_run_config(const std::string& run, Config& config, RunRecord& record);
/// Keys whose values differ, as "key: saved -> asked", at most five.
std::string config_difference(const Config& saved, const Config& asked);

}  // namespace splinevox::run
