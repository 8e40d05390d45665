// SPDX-License-Identifier: Apache-2.0
#include "run/support.hpp"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "core/atomic_file.hpp"
#include "core/handle.hpp"
#include "core/json_text.hpp"
#include "core/number_text.hpp"
#include "core/own_folder.hpp"
#include "core/printable.hpp"
#include "data/file_bytes.hpp"
#include "data/json_file.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {

int with_threads(int threads, const std::function<int()>& work) {
  if (threads <= 0) threads = tbb::this_task_arena::max_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
  tbb::task_arena arena(threads);
  return arena.execute(work);
}

std::vector<std::string> split_list(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::stringstream in(text);
  for (std::string part; std::getline(in, part, separator);)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

std::vector<double> numbers(const std::string& text, char separator, const std::string& option,
                            const std::string& expected) {
  std::vector<double> values;
  for (const std::string& part : split_list(text, separator)) {
    const auto v = parse_number<double>(part);
    if (!v || !std::isfinite(*v))
      fail({option, fmt::format("'{}' is not a number", part), expected, text, ""});
    values.push_back(*v);
  }
  if (values.empty()) fail({option, "there is no number", expected, text, ""});
  return values;
}

namespace {

/// Makes a folder if need be and proves that it can be written.
void make_output_folder(const std::string& path) {
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error))
    fail({path, "this is a file, so nothing can be written into it", "a folder, or a name that is free", "",
          ""});
  fs::create_directories(path, error);
  if (error) fail({path, "this folder cannot be made", "a place that can be written", error.message(), ""});
  const std::string probe = (fs::path(path) / fmt::format(".probe.{}", ::getpid())).string();
  Handle file(probe, O_CREAT | O_WRONLY | O_EXCL | O_NOFOLLOW);
  const int code = errno;
  if (!file.ok())
    fail({path, "this folder cannot be written", "a place that can be written", std::strerror(code), ""});
  const std::string block(4096, '\0');
  const bool written = write_all(file.get(), block) && retried([&] { return ::fsync(file.get()); }) == 0;
  const int why = errno;
  file.close();
  ::unlink(probe.c_str());
  if (!written) fail({path, "this folder cannot be written", "room for the results", std::strerror(why), ""});
}

}  // namespace

std::filesystem::path whole_path(const std::filesystem::path& path) {
  std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

std::string folder_name(const std::filesystem::path& path) { return whole_path(path).filename().string(); }

void probe_output_folder(const std::string& path) {
  check_own_folder(path, Depth::entries);
  make_output_folder(path);
}

void probe_output_file(const std::string& path, const std::function<bool(std::string_view start)>& is_ours) {
  constexpr std::size_t kStart = 512;
  std::error_code error;
  if (fs::is_directory(path, error)) fail({path, "this is a folder", "the name of a file to write", "", ""});
  if (fs::is_regular_file(path, error)) {
    const std::vector<std::uint8_t> start = data::read_bytes(path, path, UINTMAX_MAX, kStart);
    if (!start.empty() && !is_ours({reinterpret_cast<const char*>(start.data()), start.size()}))
      fail({path, "there is a file of that name that is no earlier output of this command",
            "a name that is free, or that of such an output", "", "another file for --out"});
  }
  const fs::path folder = fs::path(path).parent_path();
  make_output_folder(folder.empty() ? "." : folder.string());
}

std::string read_text(const std::string& path) {
  constexpr std::uint64_t kLongest = std::uint64_t(1) << 30;  // bytes
  return read_file(path, kLongest);
}

std::string read_text_if_there(const std::string& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::not_found ? "" : read_text(path);
}

Json read_json(const std::string& path) { return data::read_ordered_json(path, path); }

std::string json_text(const Json& json, int indent) {
  const std::string text = dump_json(json, indent, NotUtf8::replace);
  std::string out;
  for (std::size_t i = 0; i < text.size();) {  // valid UTF-8; beyond ASCII only within strings
    const std::size_t length = utf8_length(std::string_view(text).substr(i));
    const char32_t code = utf8_code(std::string_view(text).substr(i), length);
    if (code >= 0x7f && is_control(code))
      out += fmt::format("\\u{:04x}", std::uint32_t(code));
    else
      out.append(text, i, length);
    i += std::max<std::size_t>(length, 1);
  }
  return out;
}

Json printable_json(const Json& json) {
  if (json.is_string()) return all_printable(json.get_ref<const std::string&>());
  if (!json.is_structured()) return json;
  Json out = json.is_array() ? Json::array() : Json::object();
  for (const auto& [key, value] : json.items())
    if (json.is_array())
      out.push_back(printable_json(value));
    else
      out[all_printable(key)] = printable_json(value);
  return out;
}

std::string duration(double seconds) {
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const int s = int(std::lround(seconds));
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

}  // namespace splinevox::run
