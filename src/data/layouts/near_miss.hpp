// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace splinevox::data {

/// How many letters must be added, left out, replaced or swapped with their neighbour to make one of the
/// other.
std::size_t edits(std::string_view a, std::string_view b);

/// What a transforms file has beside what is read, counted over the file and all its frames.
class UnreadFields {
 public:
  /// @param time  the field that is read as a frame's time
  explicit UnreadFields(std::string time = "time") : time_(std::move(time)) {}
  /// @param object  the file or one of its frames
  void look_at(const nlohmann::json& object);
  /// A known field that one of the unread ones may be meant for, as "'f1_x', which may be meant for 'fl_x'";
  /// empty if there is none. @param wanted  the known fields in question
  std::string meant_for(const std::vector<std::string>& wanted) const;
  /// One note per field that is likely to matter.
  std::vector<std::string> notes(const std::string& where) const;

 private:
  struct Field {
    std::string name, meant, advice;
    std::size_t count = 0;
  };
  std::string time_;
  std::vector<Field> fields_;
};

/// What a folder of no known kind holds, and the likeliest way to make it a known one.
struct NearMiss {
  std::string found, hint;
  bool bare = false;  ///< films or pictures without cameras: the hint is the command that finds them
};
NearMiss near_miss(const std::filesystem::path& folder);

/// The command that finds cameras for films or bare pictures.
std::string how_to_capture(const std::filesystem::path& source);

}  // namespace splinevox::data
