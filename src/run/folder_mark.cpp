// SPDX-License-Identifier: Apache-2.0
#include "run/folder_mark.hpp"

#include <filesystem>

#include "core/atomic_file.hpp"

namespace splinevox::run {
namespace {

std::string path_of(const std::string& folder, const FolderMark& mark) {
  return (std::filesystem::path(folder) / mark.name).string();
}

}  // namespace

bool has_mark(const std::string& folder, const FolderMark& mark) {
  const std::string path = path_of(folder, mark);
  std::error_code ignored;
  if (!std::filesystem::exists(std::filesystem::symlink_status(path, ignored))) return false;
  const Json j = read_json(path);
  return j.is_object() && j.contains("format") && j["format"] == mark.format;
}

void write_mark(const std::string& folder, const FolderMark& mark, const Json& more) {
  Json j{{"format", mark.format}};
  j.update(more);
  write_file(path_of(folder, mark), {json_text(j, 2) + "\n"});
}

}  // namespace splinevox::run
