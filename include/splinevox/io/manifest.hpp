// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "splinevox/core/file_digest.hpp"

namespace splinevox {

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr const char* kPartialManifestName =
    "manifest.partial.json";  ///< of an export that has not ended

/// One file that a manifest vouches for.
struct ManifestFile {
  std::string name;  ///< relative to the manifest's folder, '/' between parts, never upwards
  FileDigest digest;
  std::map<std::string, double> figures;  ///< anything countable about it: active voxels, time, frame
};

/// Contents of manifest.json: what a run or an export consists of.
struct Manifest {
  std::string kind;                         ///< "run" or "export"
  std::map<std::string, std::string> info;  ///< anything else worth keeping, e.g. the export's settings
  std::vector<ManifestFile> files;

  const ManifestFile* find(const std::string& name) const;
};

/// An entry for `folder`/`name` as it is on disk. Throws Error if it cannot be read.
ManifestFile manifest_entry(const std::string& folder, const std::string& name);

/// Writes `folder`/`name` atomically. Write it last: it is what says that everything else is there.
FileDigest write_manifest(const std::string& folder, const Manifest& manifest,
                          const std::string& name = kManifestName);

/// Names of the lists that exports which have not ended left in a folder: kPartialManifestName, and
/// manifest.partial.1of4.json of the first of four shares. Empty also where there is no such folder.
std::vector<std::string> partial_manifests(const std::string& folder);

/// Throws Error (Fault::input) naming file and field if it is missing, malformed, newer, or lists a path
/// outside the folder.
Manifest read_manifest(const std::string& folder, const std::string& name = kManifestName);

struct FileCheck {
  std::string file;
  bool ok = false;
  std::string problem;  ///< empty if ok
};

/// Checks size and hash of every listed file; a .vdb whose bytes are right is also parsed. One entry per
/// listed file, in the manifest's order. Throws Error (Fault::input) if there is no usable manifest; a file's
/// own problem is in the list.
std::vector<FileCheck> verify(const std::string& folder);

}  // namespace splinevox
