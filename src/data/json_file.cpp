// SPDX-License-Identifier: Apache-2.0
#include "data/json_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "core/json_text.hpp"
#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

using nlohmann::json;
constexpr std::uintmax_t kLargestFile = 64u << 20;
constexpr std::size_t kDeepest = 64;
constexpr std::size_t kMostKeys = 4096;  ///< of an object whose fields are looked for one by one

/// Watches the parser: remembers where it is, refuses depth and repeated keys.
class Guard {
 public:
  Guard(std::string where, std::size_t most_keys) : where_(std::move(where)), most_keys_(most_keys) {}

  template <class J>
  void operator()(typename J::parse_event_t event, const J& parsed) {
    using Event = typename J::parse_event_t;
    if (event == Event::object_start) open(false);
    if (event == Event::array_start) open(true);
    if (event == Event::key) key(parsed.template get_ref<const std::string&>());
    if (event == Event::value) element_done();
    if (event == Event::object_end || event == Event::array_end) {
      levels_.pop_back();
      element_done();
    }
  }

  /// The field being read, such as "frames[12].time"; empty at the top.
  std::string path() const {
    std::string text;
    for (const Level& level : levels_) {
      if (level.array) text += fmt::format("[{}]", level.done);
      if (level.array || level.key.empty()) continue;
      if (!text.empty()) text += '.';
      text += printable(level.key);
    }
    return text;
  }

 private:
  struct Level {
    bool array = false;
    std::size_t done = 0;  ///< elements of the array that are complete
    std::string key;       ///< the object's field whose value is being read
    std::set<std::string> keys;
  };

  void open(bool array) {
    if (levels_.size() >= kDeepest)
      fail({where_, "the JSON is nested too deeply", "at most " + std::to_string(kDeepest) + " levels",
            "more", ""});
    levels_.push_back({array, 0, "", {}});
  }
  void key(const std::string& name) {
    levels_.back().key = name;
    if (!levels_.back().keys.insert(name).second)
      fail({where_, "the field " + path() + " is there twice", "each key once in an object",
            in_quotes(name) + " again", "remove one of the two"});
    if (levels_.back().keys.size() > most_keys_)
      fail({where_, "an object has too many fields", "at most " + std::to_string(most_keys_), "more", ""});
  }
  void element_done() {
    if (levels_.empty()) return;
    ++levels_.back().done;
    levels_.back().key.clear();
  }

  std::string where_;
  std::size_t most_keys_;
  std::vector<Level> levels_;
};

/// "line 3, column 7" of the byte at which the parser stopped (counted from 1).
std::string position(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t last = before.rfind('\n');
  const std::size_t column = before.size() - (last == std::string_view::npos ? 0 : last + 1) + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

/// The parser's own words without its prefix of exception numbers and positions.
std::string reason(std::string_view message) {
  for (const std::string_view mark : {"] ", "parse error at line "}) {
    if (const auto at = message.find(mark); at != std::string_view::npos && at < 60)
      message.remove_prefix(mark.front() == ']' ? at + mark.size()
                                                : std::min(message.find(": ", at) + 2, message.size()));
  }
  return printable(message);
}

[[noreturn]] void fail_malformed(const std::string& where, const std::string& at, const Guard& guard,
                                 const char* message) {
  const std::string field = guard.path();
  fail({where, "malformed JSON" + (at.empty() ? "" : " at " + at) + (field.empty() ? "" : ", in " + field),
        "standard JSON (no comments, no trailing commas, no NaN or Infinity)", reason(message), ""});
}

template <class J>
auto heard_by(Guard& guard) {
  return [&guard](int, typename J::parse_event_t event, J& parsed) {
    guard(event, parsed);
    return true;
  };
}

template <class J>
J read(J (*parse)(std::string_view, const typename J::parser_callback_t&), const std::filesystem::path& path,
       const std::string& where, std::size_t most_keys) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, kLargestFile);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Guard guard(where, most_keys);
  try {
    return parse(text, heard_by<J>(guard));
  } catch (const json::parse_error& error) {
    fail_malformed(where, position(text, error.byte), guard, error.what());
  } catch (const json::exception& error) {
    fail_malformed(where, "", guard, error.what());
  }
}

}  // namespace

json read_json(const std::filesystem::path& path, const std::string& where) {
  return read(parse_json, path, where, std::size_t(-1));
}

nlohmann::ordered_json read_ordered_json(const std::filesystem::path& path, const std::string& where) {
  return read(parse_ordered_json, path, where, kMostKeys);
}

std::optional<nlohmann::ordered_json> read_json_line(std::string_view line, const std::string& where) {
  Guard guard(where, kMostKeys);
  try {
    return parse_ordered_json(line, heard_by<nlohmann::ordered_json>(guard));
  } catch (const json::exception&) {
    return {};
  }
}

}  // namespace splinevox::data
