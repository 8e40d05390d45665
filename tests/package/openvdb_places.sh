#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# openvdb_places.sh FOLDER : OpenVDB is found where systems put it: its find module under lib/ARCHITECTURE,
# lib64 or lib of a prefix, also one that conda's environment names; and without a module, by header and
# library.
set -euo pipefail
folder=$1 project=$(cd "$(dirname "$0")" && pwd)/openvdb
rm -rf "$folder" && mkdir -p "$folder"
module='add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
get_filename_component(prefix ${CMAKE_CURRENT_LIST_DIR} ABSOLUTE)
set_target_properties(OpenVDB::openvdb PROPERTIES IMPORTED_LOCATION ${prefix}
                      INTERFACE_INCLUDE_DIRECTORIES by-module)
set(OpenVDB_FOUND ON)'
found() { cmake -S "$project" -B "$folder/build" --fresh "$@" 2>&1 | sed -n 's/^-- found: //p'; }
same() { [[ $2 == "$3" ]] || { echo "$1: expected '$2', got '$3'"; exit 1; }; }

for place in lib/x86_64-linux-gnu lib64 lib; do
  prefix=$folder/$place-prefix
  mkdir -p "$prefix/$place/cmake/OpenVDB"
  echo "$module" >"$prefix/$place/cmake/OpenVDB/FindOpenVDB.cmake"
  same "$place" "$prefix/$place/cmake/OpenVDB by-module" "$(found -DPREFIX="$prefix")"
  same "$place of conda" "$prefix/$place/cmake/OpenVDB by-module" \
    "$(CONDA_PREFIX=$prefix found -DPREFIX="$folder/none")"
done
prefix=$folder/bare
mkdir -p "$prefix/include/openvdb" "$prefix/lib"
touch "$prefix/include/openvdb/openvdb.h" "$prefix/lib/libopenvdb.dylib"
same "without a module" "$prefix/lib/libopenvdb.dylib $prefix/include" "$(found -DPREFIX="$prefix")"
same "nowhere" "" "$(found -DPREFIX="$folder/none" -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF || true)"
rm -rf "$folder"
