#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches the published D-NeRF scenes (800x800) into a folder: data_scripts/fetch_dnerf.sh FOLDER
# Train on them with --downscale 2, the setting of their own evaluation. A download that was cut off is
# continued.
# Source: the address in the README of github.com/albertpumarola/D-NeRF (Pumarola et al. 2020).
set -euo pipefail
folder=${1:?usage: fetch_dnerf.sh FOLDER}
address=${DNERF_URL:-https://www.dropbox.com/s/0bf6fl0ye2vz3vr/data.zip?dl=1}
command -v curl >/dev/null && command -v unzip >/dev/null || {
  echo "please install curl and unzip" >&2
  exit 1
}
mkdir -p "$folder"
if [[ -f $folder/data.zip.address && $(<"$folder/data.zip.address") != "$address" ]]; then
  echo "fetch_dnerf.sh: $folder/data.zip is of another set: take another folder" >&2
  exit 1
fi
echo "$address" >"$folder/data.zip.address"
whole() { unzip -t -q "$folder/data.zip" > /dev/null 2>&1; }
if ! whole; then  # of a whole file there is nothing to continue
  code=0
  status=$(curl --location --fail --continue-at - --output "$folder/data.zip" --write-out '%{http_code}' \
    "$address") || code=$?
  case $code/$status in
    # A server that has nothing to add to a file of full length says so with an error.
    0/* | 22/416 | 33/* | 36/*) [[ -f $folder/data.zip ]] || exit 1 ;;
    *) echo "fetch_dnerf.sh: curl ended with $code; the same command goes on where it stopped" >&2; exit 1 ;;
  esac
fi
whole || { echo "$folder/data.zip is damaged: delete it and try again" >&2; exit 1; }
if [[ ! -f $folder/data.zip.unpacked ]]; then  # over what an earlier try left half unpacked, and never again
  unzip -o -q "$folder/data.zip" -d "$folder"
  : >"$folder/data.zip.unpacked"
fi
found=$(find "$folder" -name transforms_train.json -printf '%h\n' | sort)
[[ $found ]] || {
  echo "no scene in $folder; to unpack them once more delete $folder/data.zip.unpacked" >&2
  exit 1
}
echo "$found"
