// SPDX-License-Identifier: Apache-2.0
#include "core/group_memory.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>

namespace splinevox {
namespace {

/// Names of the files of one version of groups, which say the same.
struct Files {
  const char *most, *used, *cache;
};
constexpr Files kSecond{"/memory.max", "/memory.current", "inactive_file"},
    kFirst{"/memory.limit_in_bytes", "/memory.usage_in_bytes", "total_inactive_file"};

/// The first number of a file; nothing for "max", and where there is no such file.
std::optional<double> number_in(const std::string& path) {
  double n = 0;
  std::ifstream file(path);
  if (file >> n) return n;
  return {};
}

/// A figure of memory.stat; 0 if it is not there.
double figure_in(const std::string& path, const std::string& wanted) {
  std::ifstream file(path);
  double value = 0;
  for (std::string key; file >> key >> value;)
    if (key == wanted) return value;
  return 0;
}

void tighten(GroupMemory& all, const std::string& folder, const Files& files) {
  const std::optional<double> most = number_in(folder + files.most);
  if (!most) return;
  const double used =
      number_in(folder + files.used).value_or(0) - figure_in(folder + "/memory.stat", files.cache);
  all.most = std::min(all.most, *most);
  all.left = std::min(all.left, std::max(0.0, *most - std::max(0.0, used)));
}

}  // namespace

GroupMemory group_memory(const std::string& membership, const std::string& root) {
  GroupMemory all;
  std::istringstream lines(membership);
  for (std::string line; std::getline(lines, line);) {  // number:controllers:path
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    std::string controllers(1,
                            ',');  // appends, because g++ 12 sees an overlap in "," + text that is not there
    controllers.append(line, first + 1, second - first - 1);
    controllers += ',';
    const bool newer = line.starts_with("0::");
    if (!newer && controllers.find(",memory,") == std::string::npos) continue;
    const std::string base = newer ? root : root + std::string("/memory");
    // Groups lie within each other. A container may see its own as the root, whatever its path is outside.
    std::string path = line.substr(second + 1);
    for (; path.size() > 1 && path.find('/') != std::string::npos; path.resize(path.rfind('/')))
      tighten(all, base + path, newer ? kSecond : kFirst);
    tighten(all, base, newer ? kSecond : kFirst);
  }
  return all;
}

}  // namespace splinevox
