// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
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

/// Makes the folder if need be and proves that files can be written there, before any work is done.
/// Throws Error (input): a place that cannot be written is a wrong argument.
void probe_output_folder(const std::string& path);
/// The folder that a file is to be written into: as probe_output_folder.
void probe_output_file(const std::string& path);

/// Throws Error (input) naming the file and what is wrong.
Json read_json(const std::string& path);
/// "" if there is none.
std::string read_text(const std::string& path);

/// What fmt::print and files get of JSON: bytes that are not UTF-8 (names of files may hold any) become
/// U+FFFD instead of an exception.
std::string json_text(const Json& json, int indent = -1);

/// "1:23" or "4.2 s".
std::string duration(double seconds);

}  // namespace splinevox::run
