// SPDX-License-Identifier: Apache-2.0
#include "run/capture/colmap_program.hpp"

#include <fmt/format.h>

#include <charconv>

#include "core/child.hpp"
#include "core/own_folder.hpp"
#include "core/printable.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

ChildWords colmap_words(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "colmap");
  // Without a display Qt, which some commands use, would end the program.
  return {std::move(arguments),
          "splinevox capture",
          "cameras are found with it",
          "apt-get install --no-install-recommends colmap, or a build from https://colmap.github.io",
          true,
          {"QT_QPA_PLATFORM=offscreen"}};
}

/// The numbers in a text, in their order.
std::vector<int> numbers_in(std::string_view text) {
  std::vector<int> found;
  for (const char *at = text.data(), *end = at + text.size(); at < end; ++at) {
    int value = 0;
    if (const auto r = std::from_chars(at, end, value); *at >= '0' && *at <= '9' && r.ec == std::errc()) {
      found.push_back(value);
      at = r.ptr - 1;
    }
  }
  return found;
}

}  // namespace

std::string colmap_option_name(std::string_view names, std::string_view help) {
  while (!names.empty()) {
    const std::string_view name = names.substr(0, names.find('|'));
    names.remove_prefix(std::min(names.size(), name.size() + 1));
    const std::string word = fmt::format("--{} ", name);
    if (help.find(word) != std::string_view::npos) return std::string(name);
  }
  return {};
}

std::optional<std::pair<int, int>> colmap_progress(std::string_view line) {
  const auto after = [&](std::string_view words) -> std::vector<int> {
    const std::size_t at = line.find(words);
    return at == std::string_view::npos ? std::vector<int>{} : numbers_in(line.substr(at + words.size()));
  };
  if (const auto n = after("Processed file ["); n.size() >= 2) return {{n[0], n[1]}};
  if (const auto n = after("Matching image ["); n.size() >= 2) return {{n[0], n[1]}};
  if (const auto n = after("Matching block ["); n.size() >= 4)
    return {{(n[0] - 1) * n[1] + n[2], n[1] * n[3]}};
  if (const auto n = after("Registering image #"); n.size() >= 2) return {{n[1], 0}};
  return {};
}

ColmapProgram::ColmapProgram(std::filesystem::path log, CaptureTalk& talk)
    : log_(std::move(log)), talk_(talk) {
  const std::string help = help_of("");
  const std::size_t at = help.find("COLMAP ");
  if (at != std::string::npos) version_ = help.substr(at + 7, help.find_first_of(" \n", at + 7) - at - 7);
}

std::string ColmapProgram::help_of(const std::string& command) {
  std::vector<std::string> words{"-h"};
  if (!command.empty()) words.insert(words.begin(), command);
  Child program(colmap_words(std::move(words)));
  std::string help;
  for (std::string line; program.read_line(line, [&] { return talk_.stop_asked(); });) help += line + " \n";
  if (talk_.stop_asked()) throw CaptureStopped{};
  return help;
}

bool ColmapProgram::run(const std::string& command, const std::vector<ColmapOption>& options, int total) {
  const std::string help = help_of(command);
  std::vector<std::string> words{command};
  for (const ColmapOption& option : options) {
    const std::string name = colmap_option_name(option.name, help);
    if (name.empty())
      fail({"colmap " + command, fmt::format("COLMAP {} has no option --{}", version_, option.name),
            "a version from 3.7 to 3.12", version_, "install one of those"});
    words.push_back("--" + name);
    words.push_back(option.value);
  }
  append_to_file(log_.string(), fmt::format("\n$ colmap {}\n", fmt::join(words, " ")));
  Child program(colmap_words(std::move(words)));
  for (std::string line; program.read_line(line, [&] { return talk_.stop_asked(); });) {
    append_to_file(log_.string(), line + "\n");
    if (line.find_first_not_of(" \t=") != std::string::npos) last_ = line;
    if (const auto now = colmap_progress(line))
      talk_.progress(now->first, now->second > 0 ? now->second : total);
  }
  const bool well = program.finish();
  if (talk_.stop_asked()) throw CaptureStopped{};
  return well;
}

std::string ColmapProgram::last_lines() const {
  return fmt::format("its last line was \"{}\"; all of them: {}", printable(last_), printable(log_.string()));
}

}  // namespace splinevox::run
