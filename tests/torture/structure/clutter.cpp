// SPDX-License-Identifier: Apache-2.0
// What lies in folders beside what was made on purpose, and what did not arrive.
#include <algorithm>

#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

namespace fs = std::filesystem;

std::string without_ending(const std::string& path) { return path.substr(0, path.find_last_of('.')); }

/// `path` in another folder, or beside itself with another name.
std::string beside(const std::string& path, const std::string& before, const std::string& behind) {
  const fs::path p(path);
  return (p.parent_path() / (before + p.stem().string() + behind)).generic_string();
}

constexpr const char* kPointer =
    "version https://git-lfs.github.com/spec/v1\noid "
    "sha256:4665a5ea423c2713d436b5ee50593a9640e0018c1550b5a0\n"
    "size 18271\n";

}  // namespace

void add_clutter(Case& c) {
  Draw& draw = c.draw;
  const bool films = c.layout.ends_with("films");
  const auto each = [&](const auto& name) {
    for (const Shot& s : c.shots)
      if (!films) place_other(c, name(s.path));
  };
  if (draw.once_in(8)) {
    c.drawn.emplace_back("masks");
    const std::size_t kind = draw.below(5);
    each([&](const std::string& path) {
      switch (kind) {
        case 0:
          return beside(path, "", "_mask.png");
        case 1:
          return beside(path, "dynamic_mask_", ".png");
        case 2:
          return path + ".png";
        case 3:
          return "masks/" + fs::path(path).filename().string();
        default:
          return without_ending(path).insert(path.find('/') == std::string::npos ? 0 : path.find('/'),
                                             "_masks") +
                 ".png";
      }
    });
  }
  if (draw.once_in(10)) {
    const std::string word = draw.one_of({"depth", "normal", "flow", "seg", "thumb", "alpha"});
    c.drawn.push_back("beside: " + word);
    const std::size_t kind = draw.below(4);
    each([&](const std::string& path) {
      switch (kind) {
        case 0:
          return beside(path, "", "_" + word + ".png");
        case 1:
          return beside(path, word + "_", ".png");
        case 2:
          return beside(path, "", "." + word + ".png");
        default:
          return word + "s/" + fs::path(path).filename().string();
      }
    });
    if (kind < 3) c.broken = true;  // counted as pictures where a layout counts
  }
  if (draw.once_in(10) && !films) {
    test::write_text(fs::path(c.folder) / ".DS_Store", "x");
    for (const Shot& s : c.shots)
      test::write_text(fs::path(c.folder) / beside(s.path, "._", fs::path(s.path).extension().string()), "x");
    c.drawn.emplace_back("._ files");
  }
  if (draw.once_in(10) && !films) {
    for (const std::size_t i :
         some_of(draw, std::size_t(draw.once_in(3) ? 1 : draw.between(1, 6)), c.shots.size())) {
      if (!c.shots[i].there) continue;
      fs::remove(fs::path(c.folder) / c.shots[i].path);
      c.shots[i].there = false;
    }
    c.broken = true;
    c.drawn.emplace_back("pictures missing");
  }
  if (draw.once_in(30) && !films) {
    Shot& s = c.shots[draw.below(c.shots.size())];
    if (!s.there) return;
    s.there = false;
    fs::remove(fs::path(c.folder) / s.path);
    test::write_text(fs::path(c.folder) / s.path, draw.once_in(2) ? kPointer : "");
    c.broken = true;
    c.drawn.emplace_back("a pointer or nothing for a picture");
  }
}

}  // namespace splinevox::torture::structure
