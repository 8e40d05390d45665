// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr const char* kPartialManifestName =
    "manifest.partial.json";  ///< of an export that has not ended

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

}  // namespace splinevox
