// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "run/capture/capture_talk.hpp"

namespace splinevox::run {

/// An option of COLMAP. `name` may hold several, parted by '|', for versions that call it differently.
struct ColmapOption {
  std::string name, value;
};

/// The one of an option's names that a command's own help lists; empty if none.
std::string colmap_option_name(std::string_view names, std::string_view help);

/// What a line that COLMAP prints says of its progress: done and total; a total of 0 is not told.
std::optional<std::pair<int, int>> colmap_progress(std::string_view line);

/// COLMAP as it is installed; a process per command.
class ColmapProgram {
 public:
  /// Throws Error (Fault::input) saying what to install where there is none. @param log  takes what it prints
  ColmapProgram(std::filesystem::path log, CaptureTalk& talk);
  const std::string& version() const { return version_; }  ///< "3.8"

  /// Runs a command to its end. @param total  of progress, where its lines do not tell
  /// @return whether it ended well. Throws CaptureStopped; Error (Fault::input) for an option that this
  /// version does not have.
  bool run(const std::string& command, const std::vector<ColmapOption>& options, int total = 0);
  /// The last lines of the log, for a message.
  std::string last_lines() const;

 private:
  std::string help_of(const std::string& command);
  std::filesystem::path log_;
  CaptureTalk& talk_;
  std::string version_, last_;
};

}  // namespace splinevox::run
