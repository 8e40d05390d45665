// SPDX-License-Identifier: Apache-2.0
// Paths of pictures, and of what belongs to them, as another machine wrote them.
#include <algorithm>

#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

bool has_drive(const std::string& path) {
  return path.size() > 2 && is_letter(path[0]) && path[1] == ':' && (path[2] == '/' || path[2] == '\\');
}

bool is_foreign(const std::string& path) {
  return path.find('\\') != std::string::npos || has_drive(path) || path.starts_with('/');
}

/// The folders and the name in a path of any system, without drive and ".".
std::vector<std::string> parts_of(std::string path) {
  if (has_drive(path)) path.erase(0, 2);
  std::replace(path.begin(), path.end(), '\\', '/');
  std::vector<std::string> parts;
  for (const fs::path& part : fs::path(path).relative_path().lexically_normal())
    if (!part.empty() && part != ".") parts.push_back(part.string());
  return parts;
}

/// The path without its first folders; empty if it has not as many.
std::string tail_of(const std::string& path, std::size_t leave_out) {
  const std::vector<std::string> parts = parts_of(path);
  fs::path tail;
  for (std::size_t i = leave_out; i < parts.size(); ++i) tail /= parts[i];
  return tail.generic_string();
}

/// A path that has as many folders loses its first ones.
void take_tail(std::string& path, std::size_t leave_out) {
  if (const std::string tail = tail_of(path, leave_out); !tail.empty()) path = tail;
}

bool is_found(const fs::path& root, const std::string& path) {
  try {
    return !path.empty() && find_image(root, path, "a picture").has_value();
  } catch (const Error&) {
    return false;
  }
}

/// An absolute path to something in the data set becomes the path within it.
void take_within(const fs::path& root, std::string& path) {
  const fs::path whole(path);
  if (!whole.is_absolute()) return;
  std::error_code error;
  const fs::path parent = fs::weakly_canonical(whole.parent_path(), error);
  if (error) return;
  const fs::path inside = (parent / whole.filename()).lexically_relative(root);
  if (!inside.empty() && *inside.begin() != "..") path = inside.generic_string();
}

}  // namespace

std::string take_foreign_paths(const fs::path& root, std::vector<RawSplit>& splits) {
  for (RawSplit& split : splits) {
    take_within(root, split.tracks);
    for (RawFrame& frame : split.frames)
      for (std::string* path : {&frame.file_path, &frame.mask, &frame.depth}) take_within(root, *path);
  }
  constexpr std::size_t kSamples = 64;
  std::vector<std::string*> foreign;
  for (RawSplit& split : splits)
    for (RawFrame& frame : split.frames)
      if (frame.film_frame < 0 && is_foreign(frame.file_path)) foreign.push_back(&frame.file_path);
  if (foreign.empty()) return {};
  const std::size_t step = (foreign.size() + kSamples - 1) / kSamples;
  std::size_t deepest = 0, best = 0, most = 0, as_written = 0;
  for (std::size_t i = 0; i < foreign.size(); i += step) {
    deepest = std::max(deepest, parts_of(*foreign[i]).size());
    as_written += is_found(root, *foreign[i]) ? 1 : 0;
  }
  for (std::size_t leave_out = 0; leave_out < std::min<std::size_t>(deepest, 32); ++leave_out) {
    std::size_t found = 0;
    for (std::size_t i = 0; i < foreign.size(); i += step)
      found += is_found(root, tail_of(*foreign[i], leave_out)) ? 1 : 0;
    if (found <= most) continue;
    most = found;
    best = leave_out;
  }
  if (most <= as_written) return {};
  const std::string first = *foreign[0];
  for (std::string* path : foreign) take_tail(*path, best);
  for (RawSplit& split : splits) {
    if (is_foreign(split.tracks)) take_tail(split.tracks, best);
    for (RawFrame& frame : split.frames) {
      if (is_foreign(frame.mask)) frame.mask = tail_of(frame.mask, best);
      if (is_foreign(frame.depth)) take_tail(frame.depth, best);
    }
  }
  return "paths of another machine are taken as those of this folder: " + in_quotes(first) + " is " +
         in_quotes(*foreign[0]);
}

}  // namespace splinevox::data
