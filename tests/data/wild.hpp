// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "data/layouts.hpp"
#include "splinevox/data/scene.hpp"

/// What tests of folders as people have them share.
namespace splinevox::test {

inline std::size_t frames_of(const Dataset& data) {
  std::size_t count = 0;
  for (const Split& split : data.splits) count += split.frames.size();
  return count;
}

/// The notes that hold a text.
inline std::vector<std::string> notes_with(const Dataset& data, const std::string& text) {
  std::vector<std::string> found;
  for (const std::string& note : data.notes)
    if (note.find(text) != std::string::npos) found.push_back(note);
  return found;
}

inline std::string text_in(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

/// Every `from` becomes `to`.
inline void replace_in(const fs::path& path, const std::string& from, const std::string& to) {
  std::string text = text_in(path);
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  write_text(path, text);
}

/// A rig of LLFF's rows whose camera c shows moment k in the file `name(c, k)`, in a colour of its own.
template <class Name>
void write_rig(const fs::path& folder, int cameras, int moments, const Name& name) {
  write_bytes(folder / "poses_bounds.npy",
              npy_bytes(std::size_t(cameras), 17, llff_rows(true_cameras({}, cameras))));
  for (int c = 0; c < cameras; ++c)
    for (int k = 0; k < moments; ++k)
      write_png(folder / name(c, k),
                flat_png(kWide, kHigh, {std::uint8_t(10 * c), std::uint8_t(20 * k), 90, 255}));
}

}  // namespace splinevox::test
