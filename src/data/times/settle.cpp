// SPDX-License-Identifier: Apache-2.0
#include "data/times/settle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <tuple>

#include "core/byte_order_mark.hpp"
#include "core/number_text.hpp"
#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "data/times/digits.hpp"
#include "data/times/names.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using Source = TimesChoice::Source;
constexpr const char* kChoices =
    "--times none (all of one moment), order (evenly, in the order of names), name:GROUP (a group of digits) "
    "or FILE (a name and a number per line)";

/// Where a comment begins: at a # that no name holds. The line's length where there is none.
std::size_t comment_in(const std::string& line) {
  for (std::size_t at = line.find('#'); at != std::string::npos; at = line.find('#', at + 1))
    if (at == 0 || line[at - 1] == ' ' || line[at - 1] == '\t') return at;
  return line.size();
}

std::map<std::string, double> read_times_file(const fs::path& path, const std::string& where) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, 64u << 20);
  std::istringstream text(std::string(bytes.begin(), bytes.end()));
  std::map<std::string, double> times;
  std::string line;
  for (int number_of_line = 1; std::getline(text, line); ++number_of_line) {
    if (number_of_line == 1) line.erase(0, byte_order_mark(line));
    line.resize(comment_in(line));
    const std::size_t last = line.find_last_not_of(" \t\r,");
    if (last == std::string::npos) continue;
    line.resize(last + 1);
    const std::size_t gap = line.find_last_of(" \t,");
    const auto time = parse_number<double>(std::string_view(line).substr(gap + 1));  // npos + 1 is 0
    const std::size_t name_end =
        gap == std::string::npos ? std::string::npos : line.find_last_not_of(" \t,", gap);
    if (!time || name_end == std::string::npos || !(std::abs(*time) <= 1e12))
      fail({where + ", line " + std::to_string(number_of_line), "this is no time",
            "a picture's name and a number, as in 'frame_0007.png 0.25'", in_quotes(line), ""});
    const std::string name = line.substr(0, name_end + 1);
    if (!times.emplace(name, *time).second)
      fail({where + ", line " + std::to_string(number_of_line), "this picture has a time already",
            "each picture once", in_quotes(name), ""});
  }
  return times;
}

/// A name without ending and "./".
std::string bare(const std::string& name) {
  return std::string(bare_name(fs::path(name).lexically_normal().generic_string()));
}

/// A picture is named by its path or its file's name, each with or without ending.
void times_from_file(const fs::path& file, std::vector<RawSplit>& splits) {
  const std::string where = printable(file.string());
  std::map<std::string, double> times = read_times_file(file, where);
  for (const auto& [name, time] : std::map(times)) times.try_emplace(bare(name), time);
  for (RawSplit& split : splits)
    for (RawFrame& frame : split.frames) {
      const fs::path path(frame.file_path);
      auto found = times.end();
      for (const std::string& name :
           {frame.file_path, path.lexically_normal().generic_string(), path.filename().string(),
            bare(frame.file_path), bare(path.filename().string())})
        if (found == times.end()) found = times.find(name);
      if (found == times.end())
        fail({where, "a picture has no time", "a line for each picture",
              "none for " + in_quotes(frame.file_path), ""});
      frame.time = found->second;
    }
}

/// All frames of all splits, in one list.
std::vector<RawFrame*> all_frames(std::vector<RawSplit>& splits) {
  std::vector<RawFrame*> frames;
  for (RawSplit& split : splits)
    for (RawFrame& frame : split.frames) frames.push_back(&frame);
  return frames;
}

std::vector<NamedPicture> names_of(const std::vector<RawSplit>& splits) {
  std::map<std::array<double, 12>, std::size_t> places;
  std::vector<NamedPicture> names;
  for (std::size_t s = 0; s < splits.size(); ++s)
    for (const RawFrame& frame : splits[s].frames) {
      std::array<double, 12> pose{};
      for (std::size_t i = 0; i < 12; ++i) {  // a rounding apart is the same camera
        const double m = frame.matrix[i], unit = i % 4 == 3 ? 1e-5 * std::max(1.0, std::abs(m)) : 1e-5;
        pose[i] = std::round(m / unit) * unit + 0.0;
      }
      names.push_back({frame.file_path, places.try_emplace(pose, places.size()).first->second, s});
    }
  return names;
}

void times_in_order(std::vector<RawSplit>& splits) {
  std::vector<RawFrame*> frames = all_frames(splits);
  std::sort(frames.begin(), frames.end(), [](const RawFrame* a, const RawFrame* b) {
    if (a->file_path == b->file_path) return a->film_frame < b->film_frame;
    return natural_less(a->file_path, b->file_path);
  });
  std::size_t rank = 0;  // a picture that is listed twice is one
  for (std::size_t i = 0; i < frames.size(); ++i) {
    rank += i > 0 && std::tie(frames[i]->file_path, frames[i]->film_frame) !=
                         std::tie(frames[i - 1]->file_path, frames[i - 1]->film_frame);
    frames[i]->time = double(rank);
  }
  for (RawFrame* frame : frames) frame->time /= double(std::max<std::size_t>(rank, 1));
}

void assign(std::vector<RawSplit>& splits, const std::vector<double>& times) {
  const std::vector<RawFrame*> frames = all_frames(splits);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i]->time = times[i];
}

void times_from_names(const fs::path& folder, std::vector<RawSplit>& splits,
                      std::vector<std::string>& notes) {
  const NamesRead read = read_names(names_of(splits));
  switch (read.verdict) {
    case NamesRead::Verdict::unclear:
      fail({printable(folder.string()), "the times of the pictures cannot be told from their names",
            "times in the data, a times.txt, or one number that counts up", read.reason, kChoices});
    case NamesRead::Verdict::one_moment:
      for (RawFrame* frame : all_frames(splits)) frame->time = 0;
      notes.push_back(
          fmt::format("the data has no times, and all pictures are taken as of one moment: {}{}", read.reason,
                      read.sure ? "" : " (a guess: --times order, name:GROUP or FILE otherwise)"));
      return;
    case NamesRead::Verdict::times:
      assign(splits, read.times);
      notes.push_back(fmt::format("the data has no times, so they are those in the names: {}{}", read.reason,
                                  read.sure ? "" : " (a guess: --times none if they are of one moment)"));
  }
}

void check_all_timed(const std::vector<RawSplit>& splits) {
  const auto timed = std::find_if(splits.begin(), splits.end(), [](const RawSplit& s) { return s.timed; });
  for (const RawSplit& split : splits)
    if (timed != splits.end() && !split.timed)
      fail({split.file, "no frame of this split has a time", "times in every split, as in " + timed->file,
            "none", "add them, or give --times"});
}

}  // namespace

TimesChoice parse_times(const std::string& text) {
  if (text.empty()) return {};
  if (text == "none") return {Source::none, 0, {}};
  if (text == "order") return {Source::order, 0, {}};
  if (text.starts_with("name:")) {
    const TimesChoice choice{
        Source::name, parse_number<int>(std::string_view(text).substr(5)).value_or(0), {}};
    if (choice.group == 0)
      fail({"--times", "this is no group of digits", "name:1 for the first at the left, name:-1 for the last",
            in_quotes(text), ""});
    return choice;
  }
  return {Source::file, 0, text};
}

void settle_times(const fs::path& folder, const TimesChoice& choice, std::vector<RawSplit>& splits,
                  std::vector<std::string>& notes) {
  std::error_code ignored;
  const fs::path beside = folder / "times.txt";
  switch (choice.source) {
    case Source::automatic:
      check_all_timed(splits);
      if (!splits.empty() && splits[0].timed) return;
      if (fs::exists(beside, ignored)) {
        times_from_file(beside, splits);
        notes.emplace_back("times are those of times.txt");
      } else {
        times_from_names(folder, splits, notes);
      }
      return;
    case Source::none:
      for (RawFrame* frame : all_frames(splits)) frame->time = 0;
      notes.emplace_back("all pictures are of one moment (--times none)");
      return;
    case Source::order:
      times_in_order(splits);
      notes.emplace_back("pictures follow each other evenly in the order of their names (--times order)");
      return;
    case Source::name:
      assign(splits, times_of_group(names_of(splits), choice.group));
      notes.push_back(fmt::format("times are group {} of the digits in the names: {} is at {} (--times)",
                                  choice.group, in_quotes(splits[0].frames[0].file_path),
                                  number(splits[0].frames[0].time)));
      return;
    case Source::file:
      if (!fs::exists(choice.file, ignored))
        fail({"--times", "there is no such file, and no such source of times",
              "name:GROUP, order, none, or a file of times", in_quotes(choice.file.string()),
              "--times order"});
      times_from_file(choice.file, splits);
      notes.push_back("times are those of " + printable(choice.file.string()) + " (--times)");
  }
}

}  // namespace splinevox::data
