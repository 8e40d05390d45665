// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/opencv_yaml.hpp"

#include <cmath>
#include <limits>
#include <string_view>

#include "core/number_text.hpp"
#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr std::size_t kMostNumbers = 1 << 16;  // of a matrix; lenses have a dozen
constexpr const char* kExpected = "YAML as OpenCV's FileStorage writes it";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

/// The line without its comment: # at its beginning or behind a blank, outside of quotes.
std::string_view without_comment(std::string_view line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0)
      quote = c == quote ? char(0) : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (c == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t'))
      return line.substr(0, i);
  }
  return line;
}

/// Reads line by line; what does not end on its line takes those that follow.
class StorageReader {
 public:
  StorageReader(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  std::map<std::string, StorageValue> read() {
    std::map<std::string, StorageValue> values;
    while (next()) {
      if (indent_ > 0) refuse("a line is indented without a key above it");
      std::string_view key, rest;
      if (!split_key(key, rest)) refuse("this is no key with a value");
      const int at = line_;
      StorageValue value = read_value(rest);
      value.line = at;
      if (!values.emplace(std::string(key), std::move(value)).second)
        fail({place(at), "the key " + in_quotes(key) + " is there twice", "each key once", "",
              "remove one of the two"});
    }
    return values;
  }

 private:
  std::string place(int line) const { return where_ + ", line " + std::to_string(line); }

  [[noreturn]] void refuse(const std::string& what) const {
    fail({place(line_), what, kExpected, in_quotes(content_), ""});
  }

  /// The next line that says something; false at the end. A line can be given back once.
  bool next() {
    if (again_) {
      again_ = false;
      return true;
    }
    while (!text_.empty()) {
      const std::size_t end = std::min(text_.find('\n'), text_.size());
      const std::string_view line = without_comment(text_.substr(0, end));
      text_.remove_prefix(std::min(end + 1, text_.size()));
      ++line_;
      content_ = trimmed(line);
      indent_ = content_.empty() ? 0 : line.find_first_not_of(" \t");
      const bool marker = content_ == "---" || content_ == "..." || content_.starts_with("%YAML");
      if (!content_.empty() && !(marker && indent_ == 0)) return true;
    }
    return false;
  }
  void give_back() { again_ = true; }

  bool split_key(std::string_view& key, std::string_view& rest) const {
    const std::size_t colon = content_.find(':');
    if (colon == std::string_view::npos || colon == 0) return false;
    if (colon + 1 < content_.size() && content_[colon + 1] != ' ' && content_[colon + 1] != '\t')
      return false;
    key = trimmed(content_.substr(0, colon));
    if (key.size() > 1 && key.front() == '"' && key.back() == '"') key = key.substr(1, key.size() - 2);
    rest = trimmed(content_.substr(colon + 1));
    return !key.empty() && key.find_first_of("\"'[]{}&*!|>") == std::string_view::npos;
  }

  StorageValue read_value(std::string_view rest) {
    if (rest == "!!opencv-matrix") return read_matrix();
    StorageValue value;
    if (rest.starts_with("[")) {
      value.kind = StorageValue::Kind::list;
      value.texts = read_flow(rest);
      return value;
    }
    if (!rest.empty()) {
      value.texts = {read_text(rest)};
      return value;
    }
    value.kind = StorageValue::Kind::list;
    while (next()) {
      if (content_ != "-" && !content_.starts_with("- ")) {
        give_back();
        break;
      }
      value.texts.push_back(read_text(trimmed(content_.substr(1))));
    }
    return value;
  }

  /// A number or a word, or a text in quotes.
  std::string read_text(std::string_view text) const {
    if (text.empty()) refuse("a value is missing");
    if (text.front() == '"' || text.front() == '\'') {
      if (text.size() < 2 || text.find(text.front(), 1) != text.size() - 1)
        refuse("a text in quotes does not end with its line");
      return std::string(text.substr(1, text.size() - 2));
    }
    if (text.find_first_of("[]{}&*!|>\"'`,") != std::string_view::npos) refuse("this is no plain value");
    return std::string(text);
  }

  /// What stands between [ and ], over several lines if need be.
  std::vector<std::string> read_flow(std::string_view rest) {
    std::vector<std::string> texts;
    rest.remove_prefix(1);
    bool open = true;  // an element may follow
    for (;;) {
      rest = trimmed(rest);
      if (rest.empty()) {
        if (!next()) refuse("a list has no end");
        rest = content_;
      } else if (rest.front() == ']') {
        if (!trimmed(rest.substr(1)).empty()) refuse("there is something behind a list");
        return texts;
      } else {
        if (!open) refuse("a comma is missing");
        if (texts.size() >= kMostNumbers) refuse("a list is too long");
        const bool quoted = rest.front() == '"' || rest.front() == '\'';
        const std::size_t from = quoted ? rest.find(rest.front(), 1) : 0;
        const std::size_t end = std::min(rest.find_first_of(",]", from), rest.size());
        texts.push_back(read_text(trimmed(rest.substr(0, end))));
        rest.remove_prefix(end);
        open = !rest.empty() && rest.front() == ',';
        if (open) rest.remove_prefix(1);
        if (!open && rest.empty()) {  // the comma may begin the next line
          if (!next()) refuse("a list has no end");
          rest = content_;
          open = rest.front() == ',';
          if (open) rest.remove_prefix(1);
        }
      }
    }
  }

  int read_size(const std::string& key, const std::string& text) const {
    const int size = parse_number<int>(text).value_or(0);
    if (size < 1 || size > int(kMostNumbers)) refuse("'" + key + "' of a matrix is no number of them");
    return size;
  }

  /// rows, cols, dt and data, indented below the key.
  StorageValue read_matrix() {
    StorageValue value;
    value.kind = StorageValue::Kind::matrix;
    const int begin = line_;
    bool data = false;
    while (next()) {
      if (indent_ == 0) {
        give_back();
        break;
      }
      std::string_view key, rest;
      if (!split_key(key, rest)) refuse("this is no field of a matrix");
      if (key == "rows")
        value.rows = read_size("rows", read_text(rest));
      else if (key == "cols")
        value.columns = read_size("cols", read_text(rest));
      else if (key == "data" && rest.starts_with("[") && !data)
        value.numbers = numbers_of(read_flow(rest), begin);
      else if (key != "dt" || read_text(rest).find_first_not_of("ucswifd") != std::string::npos)
        refuse("this is no field of a matrix: rows, cols, dt and data once");
      data |= key == "data";
    }
    if (!data || std::size_t(value.rows) * std::size_t(value.columns) != value.numbers.size())
      fail({place(begin), "a matrix has not as many numbers as rows and columns ask for",
            std::to_string(value.rows) + " x " + std::to_string(value.columns),
            std::to_string(value.numbers.size()), ""});
    return value;
  }

  std::vector<double> numbers_of(const std::vector<std::string>& texts, int begin) const {
    std::vector<double> numbers;
    for (const std::string& text : texts) {
      numbers.push_back(storage_number(text));
      if (std::isnan(numbers.back()) && text != ".Nan" && text != ".NaN" && text != ".nan")
        fail({place(begin), "a matrix holds something else than numbers", kExpected, in_quotes(text), ""});
    }
    return numbers;
  }

  std::string_view text_;
  const std::string& where_;
  std::string_view content_;  ///< of the line, without blanks at its ends and comment
  std::size_t indent_ = 0;
  int line_ = 0;
  bool again_ = false;
};

}  // namespace

double storage_number(const std::string& text) {
  if (text == ".Inf" || text == "-.Inf")
    return (text[0] == '-' ? -1 : 1) * std::numeric_limits<double>::infinity();
  return parse_number<double>(std::string_view(text).substr(text.starts_with("+") ? 1 : 0))
      .value_or(std::numeric_limits<double>::quiet_NaN());
}

std::map<std::string, StorageValue> read_opencv_yaml(const std::filesystem::path& path,
                                                     const std::string& where) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, 16u << 20);
  return StorageReader({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, where).read();
}

}  // namespace splinevox::data
