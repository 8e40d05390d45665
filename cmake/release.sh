#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# release.sh BUNDLE.tar.gz PACKAGES OUT : what a release page holds, in OUT: the bundle (bundle.sh) and its
# list of licences, the Debian packages in PACKAGES, the sources of this commit, the recipe of an image,
# SHA256SUMS.
set -euo pipefail
archive=$1 packages=$2 out=$3 source=$(cd "$(dirname "$0")/.." && pwd)
if [[ -n $(ls -A "$out" 2>/dev/null) && ! -f $out/SHA256SUMS ]]; then
  echo "release.sh: $out holds something else than a release: give a folder that is new or empty" >&2
  exit 2
fi
name=$(basename "$archive" "-$(uname -m).tar.gz")
version=${name#splinevox-}
rm -rf -- "$out"
mkdir -p "$out"
cp "$archive" "$out"
tar -xzOf "$archive" "$(basename "$archive" .tar.gz)/splinevox.spdx.json" >"$out/$name.spdx.json"
cp "$packages"/*_"$version"_*.deb "$out"
git -C "$source" archive --format=tar.gz --prefix="$name/" -o "$(realpath "$out")/$name.tar.gz" HEAD
cp "$source/Containerfile" "$out"
(cd "$out" && sha256sum -- * >SHA256SUMS)
du -h "$out"/*
