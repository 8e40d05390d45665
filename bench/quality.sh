#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Trains and evaluates scenes and writes the tables of README.md and docs/benchmarks.md.
#
#   bench/quality.sh train DATA OUT PRESET SCENE...   one run per scene: OUT/PRESET_SCENE, log beside it
#   bench/quality.sh table OUT                        a Markdown table of every finished run in OUT
#   bench/quality.sh write OUT                        puts that table between the markers of README.md and docs/benchmarks.md, and the
#                                                     presets' means into `splinevox train --help`
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
splinevox=${SPLINEVOX:-$root/build/release/src/app/splinevox}

train() {
  local data=$1 out=$2 preset=$3 scene
  shift 3
  mkdir -p "$out"
  for scene in "$@"; do
    local run=$out/${preset}_$scene
    rm -rf "$run"
    "$splinevox" train "$data/$scene" --out "$run" --preset "$preset" ${EXTRA:-} > "$run.log" 2>&1
    "$splinevox" eval "$run" --data "$data/$scene" --split test >> "$run.log" 2>&1
    echo "$preset $scene $(number "$run/metrics.json" psnr) dB"
  done
}

number() {  # number FILE KEY : the first value of a top-level key, indented JSON
  awk -v key="\"$2\"" '$1 == key ":" { gsub(/[",]/, "", $2); print $2; exit }' "$1"
}

table() {
  local out=$1 run name preset scene
  echo "| scene | preset | training s | steps | peak memory GB | PSNR | SSIM | MS-SSIM |"
  echo "| --- | --- | --- | --- | --- | --- | --- | --- |"
  for run in "$out"/*/; do
    [[ -f $run/metrics.json ]] || continue
    name=$(basename "$run")
    preset=${name%%_*} scene=${name#*_}
    awk -v scene="$scene" -v preset="$preset" '
      { key = $1; gsub(/[":]/, "", key); value = $2; gsub(/[",]/, "", value); if (!(key in v)) v[key] = value }
      END { printf "| %s | %s | %.0f | %d | %.2f | %.2f | %.4f | %.4f |\n", scene, preset, v["train_seconds"], v["steps"],
                   v["peak_memory_bytes"] / 1e9, v["psnr"], v["ssim"], v["ms_ssim"] }' "$run/metrics.json"
  done
}

write() {
  local rows file
  rows=$(mktemp)
  table "$1" > "$rows"
  for file in "$root/README.md" "$root/docs/benchmarks.md"; do
    awk -v rows="$rows" '
      /<!-- results -->/ { print; while ((getline line < rows) > 0) print line; skip = 1; next }
      /<!-- end of results -->/ { skip = 0 }
      !skip' "$file" > "$file.new" && mv "$file.new" "$file"
  done
  # Means of the presets that have all six scenes.
  awk -F ' *\\| *' '$2 ~ /^dnerf_/ { n[$3]++; psnr[$3] += $7; memory[$3] += $6 }
    END { for (p in n) if (n[p] == 6) printf "{\"%s\", %.2f, %.2f},\n", p, psnr[p] / 6, memory[p] / 6 }' "$rows" | sort > "$root/src/app/preset_figures.inc"
  rm -f "$rows"
}

"$@"
