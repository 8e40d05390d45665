// SPDX-License-Identifier: Apache-2.0
#include "torture/folder_files.hpp"

#include <filesystem>

namespace splinevox::torture {
namespace fs = std::filesystem;
namespace {

/// Files that a run of the same words may or may not have: pictures of the way, and the checkpoint before the
/// last.
bool by_chance(const std::string& path) {
  return (path.find("/preview/") != std::string::npos && path.ends_with(".png")) || path.ends_with(".prev");
}

}  // namespace

std::map<std::string, FileDigest> files_of(const std::string& folder) {
  std::map<std::string, FileDigest> out;
  if (!fs::exists(folder)) return out;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && !by_chance(entry.path()))
      out[fs::relative(entry.path(), folder)] = digest_file(entry.path());
  return out;
}

bool differs_anyway(const std::string& path) {
  const std::string name = fs::path(path).filename();
  for (const char* of_sweep : {"tasks.txt", "array.sh", "table.csv", "table.md", "table.tex", "settings.csv"})
    if (name == of_sweep) return true;
  return name.starts_with("metrics.json") || name.starts_with("checkpoint.bin") ||
         name.ends_with("manifest.json") || name.ends_with(".partial.json") || name.ends_with(".html") ||
         name.ends_with(".log") || name.ends_with(".words");
}

std::uint64_t total(const std::map<std::string, FileDigest>& files) {
  std::uint64_t sum = 0;
  for (const auto& [name, digest] : files) sum += digest.size;
  return sum;
}

std::string what_is_wrong(const std::map<std::string, FileDigest>& found,
                          const std::map<std::string, FileDigest>& good) {
  for (const auto& [name, digest] : found) {
    const auto same = good.find(name);
    if (name.ends_with(".tmp")) return "left " + name;
    if (!differs_anyway(name) && same != good.end() && !(same->second == digest))
      return "left " + name + " damaged";
  }
  return "";
}

}  // namespace splinevox::torture
