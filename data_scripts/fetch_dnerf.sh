#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches the published D-NeRF scenes (800x800) into a folder: data_scripts/fetch_dnerf.sh FOLDER
# Train on them with --downscale 2, the setting of their own evaluation. A download that was cut off is
# continued. DNERF_URL is another address.
# Source: the address in the README of github.com/albertpumarola/D-NeRF (Pumarola et al. 2020).
set -euo pipefail
folder=${1:?usage: fetch_dnerf.sh FOLDER}
exec "$(dirname "${BASH_SOURCE[0]}")/fetch.sh" \
  "${DNERF_URL:-https://www.dropbox.com/s/0bf6fl0ye2vz3vr/data.zip?dl=1}" "$folder"
