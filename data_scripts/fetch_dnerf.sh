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
whole() { unzip -t -q "$folder/data.zip" > /dev/null 2>&1; }
# Of a whole file there is nothing to continue.
whole || curl --location --fail --continue-at - --output "$folder/data.zip" "$address"
whole || { echo "$folder/data.zip is damaged: delete it and try again" >&2; exit 1; }
unzip -n -q "$folder/data.zip" -d "$folder"
find "$folder" -name transforms_train.json -printf '%h\n' | sort
