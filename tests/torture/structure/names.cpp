// SPDX-License-Identifier: Apache-2.0
// Names as people and programs give them to pictures.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

std::string padded(long long value, int width) { return fmt::format("{:0{}}", value, width); }

/// A camera's or a moment's part of a name.
struct Token {
  std::string word;
  int first = 0, step = 1, width = 0;
  enum class Style { count, serial, letters, date, decimal, milli, micro, nano, none } style = Style::count;

  std::string operator()(int value) const {
    constexpr long long kEpoch = 1'700'000'000;
    constexpr long long kSerials[] = {23117042, 19837261, 40021988, 887,      20250114, 31337002,
                                      50000001, 12345678, 77120009, 18000044, 64523311, 90210001};
    constexpr const char* kLetters[] = {"left",  "right", "top",   "front", "back",  "bottom",
                                        "north", "east",  "south", "west",  "under", "over"};
    switch (style) {
      case Style::count:
        return word + padded(first + step * value, width);
      case Style::serial:
        return word +
               (value < 12 ? std::to_string(kSerials[value]) : std::to_string(30000000 + 7919 * value));
      case Style::letters:
        return value < 12 ? std::string(kLetters[value]) : fmt::format("x{}", char('a' + value % 26));
      case Style::date: {
        const int second = 10 * 3600 + 59 * 60 + 50 + first + value;
        return word + fmt::format("20240229_{:02}{:02}{:02}", second / 3600, second / 60 % 60, second % 60);
      }
      case Style::decimal:
        return word + fmt::format("{:.3f}", first + 0.25 * value);
      case Style::milli:
        return word + std::to_string(kEpoch * 1000 + 40LL * value);
      case Style::micro:
        return word + std::to_string(kEpoch * 1000'000 + 33'333LL * value);
      case Style::nano:
        return word + std::to_string(kEpoch * 1000'000'000 + 33'333'333LL * value);
      case Style::none:
        return word;
    }
    return {};
  }
};

Token draw_camera(Draw& draw) {
  Token t{draw.one_of({"cam", "camera", "Cam_", "c", "view", "view_", "kinect", "", "", "s", "pos"}),
          draw.one_of({0, 0, 1, 1, 5}), draw.one_of({1, 1, 1, 5}), draw.one_of({0, 1, 2, 2, 3})};
  t.style = draw.one_of({Token::Style::count, Token::Style::count, Token::Style::count, Token::Style::count,
                         Token::Style::count, Token::Style::serial, Token::Style::letters, Token::Style::date,
                         Token::Style::decimal});
  return t;
}

Token draw_moment(Draw& draw) {
  Token t{draw.one_of({"frame", "frame_", "f", "t", "time", "", "", "", "img", "image", "r_"}),
          draw.one_of({0, 0, 1, 1, 137, 1000}), draw.one_of({1, 1, 1, 3, 10}), draw.one_of({0, 3, 4, 5, 6})};
  t.style = draw.one_of({Token::Style::count, Token::Style::count, Token::Style::count, Token::Style::count,
                         Token::Style::count, Token::Style::count, Token::Style::date, Token::Style::decimal,
                         Token::Style::milli, Token::Style::micro, Token::Style::nano});
  return t;
}

std::string identifier(Draw& draw, std::size_t style) {
  const std::string hex = fmt::format("{:016x}{:016x}", draw.bits(), draw.bits());
  return style == 0 ? hex.substr(0, 8) + '-' + hex.substr(8, 4) + "-4" + hex.substr(13, 3) + "-a" +
                          hex.substr(17, 3) + '-' + hex.substr(20)
                    : hex.substr(0, style == 1 ? 24 : 16);
}

bool ends_in_digit(const std::string& s) { return !s.empty() && s.back() >= '0' && s.back() <= '9'; }
bool begins_with_digit(const std::string& s) { return !s.empty() && s[0] >= '0' && s[0] <= '9'; }

std::string joined(const std::string& a, const std::string& between, const std::string& b) {
  if (a.empty() || b.empty()) return a + b;
  return a + (between.empty() && ends_in_digit(a) && begins_with_digit(b) ? "_" : between) + b;
}

/// How the parts of a name are put together.
enum class Form { both, running, camera_and_running, identifiers, shuffled, parentheses };

/// The stems and folders of all shots, without ending.
std::vector<std::string> draw_stems(Case& c, bool flat) {
  Draw& draw = c.draw;
  Token camera = draw_camera(draw), moment = draw_moment(draw);
  const std::size_t kind = draw.below(20);
  Form form = kind < 11   ? Form::both
              : kind < 14 ? Form::running
              : kind < 15 ? Form::camera_and_running
              : kind < 16 ? Form::identifiers
              : kind < 17 ? Form::parentheses
              : kind < 18 ? Form::shuffled
                          : Form::both;
  if (form == Form::shuffled && c.still)
    form = Form::running;  // numbers of a camera that stands still are believed
  if (c.cameras == 1 && !draw.once_in(3)) camera.style = Token::Style::none;
  if (camera.style == Token::Style::none && draw.once_in(2)) camera.word = "";
  if (c.moments == 1 && !draw.once_in(3)) moment.style = Token::Style::none;
  if (moment.style == Token::Style::none) moment.word = draw.one_of({"", "img", "image", "r_"});
  if (c.moments == 1 && moment.style == Token::Style::none && camera.style == Token::Style::count &&
      draw.once_in(2))
    camera.word = draw.one_of({"frame_", "IMG_", "DSC0", "r_", "image", "", "photo_", "frame"});
  if (c.moments == 1 && camera.style == Token::Style::date)
    camera.style = Token::Style::serial;  // that is a time
  if (c.cameras == 1 && camera.style == Token::Style::none && moment.style == Token::Style::count &&
      draw.once_in(3))
    moment.word = draw.one_of({"cam_", "view_", "IMG_", "DSC0", "camera", "photo_"});
  const bool moment_first = draw.once_in(2);
  const std::string between = draw.one_of({"_", "-", "/", "/", ".", "", "__", " "});
  const bool repeat = between == "/" && draw.once_in(4);  // cam01/cam01_0001
  const std::string before =
      draw.one_of({"", "", "", "", "scene12_", "take2-", "2024-05-01_", "GX010137_", "1920x1080_"});
  const std::string behind =
      draw.one_of({"", "", "", "", "", "_1080p", "_2x", "_rgb", "_v2", "_undist", "_60fps"});
  const bool copies = draw.once_in(12), by_camera = draw.once_in(2);
  const std::size_t identifiers = draw.below(3);
  const Token counter{draw.one_of({"", "frame_", "IMG_", "image", "r_", "photo "}), draw.between(0, 1), 1,
                      draw.one_of({0, 4, 5})};
  std::vector<int> order(c.shots.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = int(i);
  if (form == Form::shuffled) draw.shuffle(order);
  constexpr const char* kForms[] = {"camera and moment", "running",          "camera and running",
                                    "identifiers",       "shuffled numbers", "number in ()"};
  c.drawn.push_back(std::string("names: ") + kForms[int(form)]);
  if (form == Form::shuffled || form == Form::identifiers) c.broken = true;
  std::vector<std::string> stems;
  for (std::size_t i = 0; i < c.shots.size(); ++i) {
    const Shot& s = c.shots[i];
    const int tick = int(s.time);
    // the number of a picture over all: by camera or by moment, with the ticks that are there
    const int running =
        by_camera ? s.camera * (int(c.shots.back().time) + 1) + tick : tick * c.cameras + s.camera;
    const std::string at_camera = camera(s.camera), at_moment = moment(tick);
    std::string stem;
    switch (form) {
      case Form::both:
        stem = moment_first ? joined(at_moment, between, at_camera) : joined(at_camera, between, at_moment);
        if (repeat && !moment_first) stem = at_camera + "/" + joined(at_camera, "_", at_moment);
        break;
      case Form::running:
        stem = counter(running);
        break;
      case Form::camera_and_running:
        stem = joined(at_camera, between, counter(running));
        break;
      case Form::identifiers:
        stem = identifier(draw, identifiers);
        break;
      case Form::shuffled:
        stem = counter(order[i]);
        break;
      case Form::parentheses:
        stem = fmt::format("scene ({})", running + 1);
        break;
    }
    const std::size_t slash = stem.find_last_of('/');
    const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
    stem = stem.substr(0, name) + joined(before, "", stem.substr(name)) + behind;
    if (copies && draw.once_in(5)) stem += " (1)";
    if (flat) std::replace(stem.begin(), stem.end(), '/', '_');
    stems.push_back(stem);
  }
  return stems;
}

}  // namespace

void draw_names(Case& c, bool flat) {
  Draw& draw = c.draw;
  const std::vector<std::string> stems = draw_stems(c, flat);
  const std::string ending =
      c.turn != 1 ? draw.one_of({".jpg", ".JPG", ".jpeg"}) : draw.one_of({".png", ".png", ".PNG"});
  std::set<std::string> taken;
  for (std::size_t i = 0; i < stems.size(); ++i) {
    std::string stem = stems[i].empty() ? "picture" : stems[i];
    if (stem.starts_with("/")) stem.erase(0, 1);
    for (int k = 0; !taken.insert(stem).second; ++k) stem += std::string(1, char('a' + k));
    c.shots[i].path = stem + ending;
  }
  c.drawn.push_back(c.shots[0].path);
}

void draw_rig_names(Case& c, bool films) {
  Draw& draw = c.draw;
  Token camera = draw_camera(draw);
  const Token moment = draw_moment(draw);
  const std::string inside = draw.once_in(3) ? "/images/" : "/";
  const std::string ending = c.turn != 1 ? ".jpg" : ".png";
  const bool repeat = draw.once_in(5);
  const std::string film = draw.one_of({".mp4", ".mkv", ".MP4", ".mov"});
  for (Shot& s : c.shots) {
    std::string name = camera(s.camera);
    if (name.empty()) name.push_back('x');
    s.path = films ? name + film : name + inside + (repeat ? name + "_" : "") + moment(int(s.time)) + ending;
  }
  c.drawn.push_back(c.shots[0].path);
}

}  // namespace splinevox::torture::structure
