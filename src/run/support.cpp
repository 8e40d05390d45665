// SPDX-License-Identifier: Apache-2.0
#include "run/support.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/json_text.hpp"
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
    double v = 0;
    const auto r = std::from_chars(part.data(), part.data() + part.size(), v);
    if (r.ec != std::errc() || r.ptr != part.data() + part.size() || !std::isfinite(v))
      fail({option, fmt::format("'{}' is not a number", part), expected, text, ""});
    values.push_back(v);
  }
  if (values.empty()) fail({option, "there is no number", expected, text, ""});
  return values;
}

void probe_output_folder(const std::string& path) {
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error))
    fail({path, "this is a file, so nothing can be written into it", "a folder, or a name that is free", "",
          ""});
  fs::create_directories(path, error);
  if (error) fail({path, "this folder cannot be made", "a place that can be written", error.message(), ""});
  const std::string probe = (fs::path(path) / fmt::format(".probe.{}", ::getpid())).string();
  const int file = ::open(probe.c_str(), O_CREAT | O_WRONLY | O_EXCL, 0666);
  const int code = errno;
  if (file < 0)
    fail({path, "this folder cannot be written", "a place that can be written", std::strerror(code), ""});
  char block[4096] = {};
  const bool written = ::write(file, block, sizeof block) == ssize_t(sizeof block) && ::fsync(file) == 0;
  const int why = errno;
  ::close(file);
  ::unlink(probe.c_str());
  if (!written) fail({path, "this folder cannot be written", "room for the results", std::strerror(why), ""});
}

void probe_output_file(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) fail({path, "this is a folder", "the name of a file to write", "", ""});
  const fs::path folder = fs::path(path).parent_path();
  probe_output_folder(folder.empty() ? "." : folder.string());
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

Json read_json(const std::string& path) { return data::read_ordered_json(path, path); }

std::string json_text(const Json& json, int indent) { return dump_json(json, indent, NotUtf8::replace); }

std::string duration(double seconds) {
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const int s = int(std::lround(seconds));
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

}  // namespace splinevox::run
