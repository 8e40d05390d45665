#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Trains and evaluates scenes and writes the tables of README.md and docs/benchmarks.md.
#
#   bench/quality.sh train DATA OUT PRESET SCENE...   one run per scene and seed: OUT/PRESET/SCENE/SEED, log beside it
#   bench/quality.sh table OUT                        a Markdown table of every finished run in OUT
#   bench/quality.sh write OUT                        puts that table between the markers of README.md and docs/benchmarks.md, and the
#                                                     presets' means into `splinevox train --help`
#
# SEEDS ("1 2 3") are those to train, 1 by default; EXTRA are further options of `splinevox train`.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
splinevox=${SPLINEVOX:-$root/build/release/src/app/splinevox}

train() {
  local data=$1 out=$2 preset=$3 scene seed
  shift 3
  for seed in ${SEEDS:-1}; do
    for scene in "$@"; do
      local run=$out/$preset/$scene/$seed
      rm -rf "$run"
      mkdir -p "${run%/*}"
      "$splinevox" train "$data/$scene" --out "$run" --preset "$preset" --seed "$seed" ${EXTRA:-} > "$run.log" 2>&1
      "$splinevox" eval "$run" --data "$data/$scene" --split test >> "$run.log" 2>&1
      echo "$preset $scene seed $seed: $(number "$run/metrics.json" psnr) dB"
    done
  done
}

number() {  # number FILE KEY : the first value of a top-level key, indented JSON
  awk -v key="\"$2\"" '$1 == key ":" { gsub(/[",]/, "", $2); print $2; exit }' "$1"
}

table() {  # means over the seeds; behind PSNR half the distance between the best and the worst seed; no seconds for runs of given steps
  local out=$1 group run preset
  echo "| scene | preset | seeds | training s | steps | peak memory GB | PSNR | SSIM | MS-SSIM |"
  echo "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
  for preset in draft fast standard high paper nerf_atlas; do
    for group in "$out/$preset"/*/; do
      for run in "$group"*/metrics.json; do
        if [[ -f $run ]]; then
          grep -qE '^max_time = 0( |$)' "${run%/*}/config.toml" && echo 0 || number "$run" train_seconds
          for key in steps peak_memory_bytes psnr ssim ms_ssim; do number "$run" $key; done
        fi | xargs
      done | awk -v scene="$(basename "$group")" -v preset="$preset" '
        NF { ++n; for (i = 1; i <= 6; ++i) sum[i] += $i; if (n == 1 || $4 < lo) lo = $4; if (n == 1 || $4 > hi) hi = $4 }
        END { if (n) printf "| %s | %s | %d | %s | %d | %.2f | %.2f%s | %.4f | %.4f |\n", scene, preset, n, (sum[1] ? sprintf("%.0f", sum[1] / n) : ""), sum[2] / n,
                            sum[3] / n / 1e9, sum[4] / n, (n > 1 ? sprintf(" ± %.2f", (hi - lo) / 2) : ""), sum[5] / n, sum[6] / n }'
    done
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
  awk -F ' *\\| *' '$2 ~ /^dnerf_/ { n[$3]++; psnr[$3] += $8; memory[$3] += $7 }
    END { for (p in n) if (n[p] == 6 && p != "paper" && p != "nerf_atlas") printf "{\"%s\", %.2f, %.2f},\n", p, psnr[p] / 6, memory[p] / 6 }' "$rows" | sort > "$root/src/app/preset_figures.inc"
  rm -f "$rows"
}

"$@"
