// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/core/vec3.hpp"
#include "splinevox/core/version.hpp"

/// Small things that several rooms need.
namespace splinevox::run {

using splinevox::kVersion;
using Json = nlohmann::ordered_json;

/// Runs `work` on that many TBB threads (0 = every core).
int with_threads(int threads, const std::function<int()>& work);

/// The parts of a comma separated list, without empty ones.
std::vector<std::string> split_list(const std::string& text, char separator = ',');
/// Numbers of a list such as "0:1:24" or "1,1,1". Throws Error naming the option.
std::vector<double> numbers(const std::string& text, char separator, const std::string& option,
                            const std::string& expected);

/// A path without turns: absolute, and without a slash behind it.
std::filesystem::path whole_path(const std::filesystem::path& path);
/// What the last part of a path is called, however it is written: "scene" of "a/scene", "a/scene/",
/// "a/scene/.".
std::string folder_name(const std::filesystem::path& path);

/// Makes the folder if need be and proves that files can be written there, before any work is done.
/// Throws Error (input): a place that cannot be written is a wrong argument, and so is one with links that
/// lead out of it.
void probe_output_folder(const std::string& path);
/// The folder that a file is to be written into can be written. What has the file's name already is replaced
/// only if it is one of ours by its beginning, or empty. Throws Error (input).
void probe_output_file(const std::string& path, const std::function<bool(std::string_view start)>& is_ours);

/// Throws Error (input) naming the file and what is wrong.
Json read_json(const std::string& path);
/// The whole file. Throws Error (input).
std::string read_text(const std::string& path);
/// The same; "" if there is none.
std::string read_text_if_there(const std::string& path);

/// What fmt::print and files get of JSON: bytes that are not UTF-8 (names of files may hold any) become
/// U+FFFD instead of an exception, what a terminal would obey instead of show is escaped (printable.hpp).
std::string json_text(const Json& json, int indent = -1);
/// The same JSON with every text and name in it printable: to be printed as text.
Json printable_json(const Json& json);

/// A vector as JSON, an array.
template <class T>
Json triple(const Vec3T<T>& v) {
  return Json::array({v.x, v.y, v.z});
}

/// "1:23" or "4.2 s".
std::string duration(double seconds);

}  // namespace splinevox::run
