// SPDX-License-Identifier: Apache-2.0
#include "io/manifest.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/json_text.hpp"
#include "core/own_folder.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"
#include "splinevox/io/model_vdb.hpp"

namespace splinevox {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kVersion = 1, kMaxDepth = 16;
constexpr std::string_view kHashPrefix = "xxh64:";
constexpr std::uint64_t kMaxBytes = std::uint64_t(256) << 20;

std::string hash_text(std::uint64_t hash) {
  std::string text(kHashPrefix);
  for (int i = 60; i >= 0; i -= 4) text += "0123456789abcdef"[hash >> i & 15];
  return text;
}

std::uint64_t parse_hash(const std::string& text, const std::string& where) {
  std::uint64_t hash = 0;
  const char *begin = text.data() + std::min(kHashPrefix.size(), text.size()),
             *end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, hash, 16);
  if (text.compare(0, kHashPrefix.size(), kHashPrefix) != 0 || end - begin != 16 || stop != end ||
      error != std::errc())
    fail({.where = where,
          .what = "'hash' is malformed",
          .expected = std::string(kHashPrefix) + " and 16 hexadecimal digits",
          .got = text.substr(0, 60)});
  return hash;
}

/// A listed name must stay inside the folder, whoever wrote the list.
void check_name(const std::string& name, const std::string& where) {
  const std::filesystem::path path(name);
  bool inside = !name.empty() && !path.is_absolute();
  for (const auto& part : path) inside = inside && part != "..";
  if (!inside)
    fail({.where = where,
          .what = "'name' leads out of the folder",
          .expected = "a relative path without '..'",
          .got = name.substr(0, 200)});
}

std::string join(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

Manifest parse(const std::string& path, const std::string& text) {
  using Read = nlohmann::json;  // looks a field up in logarithmic time, whoever wrote the file
  const auto guard = [&](int depth, Read::parse_event_t, Read&) {
    if (depth > kMaxDepth) fail({.where = path, .what = "is nested too deeply for a manifest"});
    return true;
  };
  Manifest out;
  try {
    const Read json = parse_json(text, guard);
    const int version = json.at("version");
    if (json.at("format") != "splinevox manifest")
      fail({.where = path, .what = "is not a manifest of splinevox"});
    if (version > kVersion)
      fail({.where = path,
            .what = "was written by a newer version of splinevox",
            .expected = "manifest version " + std::to_string(kVersion) + " or older",
            .got = std::to_string(version)});
    out.kind = json.at("kind");
    for (const auto& [key, value] : json.at("info").items()) out.info[key] = value.get<std::string>();
    for (const Read& item : json.at("files")) {
      ManifestFile file;
      file.name = item.at("name");
      const std::string where = path + ", file '" + file.name.substr(0, 200) + "'";
      check_name(file.name, where);
      file.digest.size = item.at("size");
      file.digest.hash = parse_hash(item.at("hash"), where);
      if (item.contains("figures"))
        for (const auto& [key, value] : item.at("figures").items()) file.figures[key] = value.get<double>();
      out.files.push_back(std::move(file));
    }
  } catch (const Read::exception& e) {
    fail({.where = path, .what = "is malformed", .got = std::string(e.what()).substr(0, 300)});
  }
  return out;
}

FileCheck check_file(const std::string& folder, const ManifestFile& listed) {
  const std::string path = join(folder, listed.name);
  try {
    const FileDigest found = digest_file(path);
    if (found.size != listed.digest.size)
      return {listed.name, false,
              "has " + std::to_string(found.size) + " bytes, the manifest says " +
                  std::to_string(listed.digest.size)};
    if (found.hash != listed.digest.hash)
      return {listed.name, false,
              "has hash " + hash_text(found.hash) + ", the manifest says " + hash_text(listed.digest.hash)};

    if (listed.name == "model.vdb")
      load_model(path);
    else if (path.ends_with(".vdb"))
      read_vdb(path);
  } catch (const Error& e) {
    if (e.fault == Fault::memory) throw;  // which says nothing about the file
    return {listed.name, false, e.problem.what + (e.problem.got.empty() ? "" : ": " + e.problem.got)};
  }
  return {listed.name, true, ""};
}

}  // namespace

const ManifestFile* Manifest::find(const std::string& name) const {
  for (const ManifestFile& file : files)
    if (file.name == name) return &file;
  return nullptr;
}

ManifestFile manifest_entry(const std::string& folder, const std::string& name) {
  check_name(name, join(folder, kManifestName));
  return {name, digest_file(join(folder, name)), {}};
}

FileDigest write_manifest(const std::string& folder, const Manifest& manifest, const std::string& name) {
  const std::string path = join(folder, name);
  Json json;
  json["format"] = "splinevox manifest";
  json["version"] = kVersion;
  json["kind"] = manifest.kind;
  json["info"] = Json::object();
  for (const auto& [key, value] : manifest.info) json["info"][key] = value;
  json["files"] = Json::array();
  for (const ManifestFile& file : manifest.files) {
    check_name(file.name, path);
    Json item;
    item["name"] = file.name;
    item["size"] = file.digest.size;
    item["hash"] = hash_text(file.digest.hash);
    for (const auto& [key, value] : file.figures) item["figures"][key] = value;
    json["files"].push_back(std::move(item));
  }
  const std::string text = dump_json(json, 1, NotUtf8::replace) + "\n";
  if (text.size() > kMaxBytes)
    fail_output({.where = path,
                 .what = "the list of so many files could not be read again",
                 .expected = "at most " + std::to_string(kMaxBytes) + " bytes",
                 .got = std::to_string(text.size())});
  return write_file(path, {text});
}

std::vector<std::string> partial_manifests(const std::string& folder) {
  std::vector<std::string> names;
  for (const std::string& name : names_in_folder(folder))
    if (name.starts_with("manifest.partial.") && name.ends_with(".json")) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

Manifest read_manifest(const std::string& folder, const std::string& name) {
  const std::string path = join(folder, name);
  return parse(path, read_file(path, kMaxBytes));
}

std::vector<FileCheck> verify(const std::string& folder) {
  namespace fs = std::filesystem;
  if (const auto partial = partial_manifests(folder);
      !partial.empty() && !fs::exists(fs::path(folder) / kManifestName))
    fail({.where = folder,
          .what = "holds an export that was not finished",
          .expected = kManifestName,
          .got = partial.front(),
          .hint = "run the export again: the frames that are there are kept"});
  if (!fs::exists(fs::path(folder) / kManifestName))
    fail({.where = folder,
          .what = "has no list of its files to check them by",
          .expected = kManifestName,
          .got = fs::is_directory(folder) ? "none" : "no such folder",
          .hint = "a run has one once it ended or was interrupted (train ... --resume goes on), an export "
                  "once all its frames are there"});
  const Manifest manifest = read_manifest(folder);
  if (manifest.files.empty())
    fail({.where = join(folder, kManifestName),
          .what = "lists no files, so there is nothing to be whole",
          .expected = "the files of a run or an export",
          .got = "an empty list"});
  std::vector<FileCheck> checks;
  for (const ManifestFile& file : manifest.files) checks.push_back(check_file(folder, file));
  return checks;
}

}  // namespace splinevox
