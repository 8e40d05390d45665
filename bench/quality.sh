#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Trains and evaluates scenes and keeps one line per run in bench/results/quality.jsonl, with its commit and
# processor. The tables of README.md and docs/benchmarks.md are written from those lines alone.
#
#   bench/quality.sh train DATA OUT PRESET SCENE...
#       one run per scene and seed: OUT/PRESET/SCENE/SEED, log beside it; its line takes the place of an
#       earlier one of the same preset, scene and seed
#   bench/quality.sh table      a Markdown table of every scene and preset
#   bench/quality.sh summary    a Markdown table of the means of every preset that has all six D-NeRF scenes
#   bench/quality.sh write      puts the summary between the marks of README.md and docs/benchmarks.md, the
#                               table between the marks at the end of the latter, and the presets' means into
#                               `splinevox train --help`
#
# SEEDS ("1 2 3") are those to train, 1 by default; EXTRA are further options of `splinevox train`; RESULTS is
# another file of lines; COMMIT is that of the program where it is not the one checked out.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
splinevox=${SPLINEVOX:-$root/build/release/src/cli/splinevox}
results=${RESULTS:-$root/bench/results/quality.jsonl}

train() {
  local data=$1 out=$2 preset=$3 scene seed
  shift 3
  for seed in ${SEEDS:-1}; do
    for scene in "$@"; do
      local run=$out/$preset/$scene/$seed
      rm -rf "$run"
      mkdir -p "${run%/*}"
      "$splinevox" train "$data/$scene" --out "$run" --preset "$preset" --seed "$seed" ${EXTRA:-} \
        > "$run.log" 2>&1
      "$splinevox" eval "$run" --data "$data/$scene" --split val >> "$run.log" 2>&1
      "$splinevox" eval "$run" --data "$data/$scene" --split test >> "$run.log" 2>&1
      keep "$preset" "$scene" "$seed" "$run"
      echo "$preset $scene seed $seed: $(number "$run/metrics.json" psnr) dB"
    done
  done
}

number() {  # number FILE KEY : the first value of a top-level key, indented JSON
  awk -v key="\"$2\"" '$1 == key ":" { gsub(/[",]/, "", $2); print $2; exit }' "$1"
}

keep() {  # keep PRESET SCENE SEED RUN : its line among the results; no seconds for runs of given steps
  local key seconds cpu name
  printf -v key '{"preset": "%s", "scene": "%s", "seed": %d,' "$1" "$2" "$3"
  seconds=$(number "$4/metrics.json" train_seconds)
  grep -qE '^max_time = 0( |$)' "$4/config.toml" && seconds=null
  cpu=$(awk -F ': ' '/^model name/ { print $2; exit }' /proc/cpuinfo)
  mkdir -p "${results%/*}"
  touch "$results"
  {
    grep -vF "$key" "$results" || true
    printf '%s "commit": "%s", "cpu": "%s", "cores": %d, "train_seconds": %s' \
      "$key" "${COMMIT:-$(git -C "$root" rev-parse --short HEAD)}" "$cpu" "$(nproc)" "$seconds"
    for name in steps peak_memory_bytes psnr ssim ms_ssim; do
      printf ', "%s": %s' $name "$(number "$4/metrics.json" $name)"
    done
    printf ', "val_psnr": %s}\n' "$(number "$4/metrics_val.json" psnr)"
  } | sort > "$results.new"
  mv "$results.new" "$results"
}

table() {  # means over the seeds; behind PSNR half the distance between the best and the worst seed
  awk '
    function field(key, from) {
      from = index($0, "\"" key "\": ")
      if (!from) return ""
      from = substr($0, from + length(key) + 4)
      sub(/[,}].*/, "", from)
      gsub(/"/, "", from)
      return from
    }
    {
      g = field("preset") SUBSEP field("scene") SUBSEP field("cores") " x " field("cpu")
      if (!(g in n)) groups[++count] = g
      psnr = field("psnr") + 0
      if (!n[g]++) lo[g] = hi[g] = psnr
      if (psnr < lo[g]) lo[g] = psnr
      if (psnr > hi[g]) hi[g] = psnr
      for (i = 1; i <= keys; ++i) sum[g, key[i]] += field(key[i])
    }
    function mean(key) { return sum[g, key] / n[g] }
    BEGIN {
      keys = split("train_seconds steps peak_memory_bytes psnr ssim ms_ssim val_psnr", key, " ")
      print "| scene | preset | seeds | training s | steps | peak memory GB | PSNR | SSIM | MS-SSIM |" \
            " PSNR of the val split | processor |"
      print "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    }
    END {
      presets = split("draft fast standard high paper nerf_atlas", preset, " ")
      for (p = 1; p <= presets; ++p)
        for (i = 1; i <= count; ++i) {
          g = groups[i]
          split(g, name, SUBSEP)
          if (name[1] != preset[p]) continue
          seconds = mean("train_seconds") ? sprintf("%.0f", mean("train_seconds")) : ""
          spread = n[g] > 1 ? sprintf(" ± %.2f", (hi[g] - lo[g]) / 2) : ""
          printf "| %s | %s | %d | %s | %d | %.2f | %.2f%s | %.4f | %.4f | %.2f | %s |\n",
                 name[2], name[1], n[g], seconds, mean("steps"), mean("peak_memory_bytes") / 1e9,
                 mean("psnr"), spread, mean("ssim"), mean("ms_ssim"), mean("val_psnr"), name[3]
        }
    }' "$results"
}

means() {  # means FILE : PRESET SECONDS MEMORY PSNR SSIM of each preset with all six D-NeRF scenes in a table
  awk -F ' *\\| *' '
    $2 ~ /^dnerf_/ { n[$3]++; seconds[$3] += $5; memory[$3] += $7; psnr[$3] += $8; ssim[$3] += $9 }
    END {
      presets = split("draft fast standard high", preset, " ")
      for (i = 1; i <= presets; ++i) {
        p = preset[i]
        if (n[p] != 6) continue
        printf "%s %.0f %.2f %.2f %.4f\n", p, seconds[p] / 6, memory[p] / 6, psnr[p] / 6, ssim[p] / 6
      }
    }' "$1"
}

summary() {
  echo "| preset | training s | PSNR, dB | SSIM | peak memory GB |"
  echo "| --- | --- | --- | --- | --- |"
  means <(table) | while read -r preset seconds memory psnr ssim; do
    echo "| \`$preset\` | $seconds | $psnr | $ssim | $memory |"
  done
}

beside() {  # PSNR of our presets on the six scenes beside a published method's
  awk -F ' *\\| *' '
    BEGIN {
      scenes = split("bouncingballs hellwarrior jumpingjacks lego mutant trex", scene, " ")
      for (i = 1; i <= scenes; ++i) { head = head " " scene[i] " |"; line = line " --- |" }
      print "| |" head " mean | time |"
      print "| --- |" line " --- | --- |"
      # TiNeuVox-B: Fang et al. 2022, table of the D-NeRF scenes
      split("40.73 28.17 34.23 25.02 33.61 32.70", theirs, " ")
    }
    function row(name, values, time, sum, i, out) {
      for (i = 1; i <= scenes; ++i) { sum += values[i]; out = out sprintf(" %.2f |", values[i]) }
      printf "| %s |%s %.2f | %s |\n", name, out, sum / scenes, time
    }
    $2 ~ /^dnerf_/ { sub(/^dnerf_/, "", $2); psnr[$3, $2] = $8; seconds[$3] = $5; ++n[$3] }
    END {
      presets = split("fast standard high", preset, " ")
      for (p = 1; p <= presets; ++p) {
        if (n[preset[p]] != scenes) continue
        for (i = 1; i <= scenes; ++i) ours[i] = psnr[preset[p], scene[i]] + 0
        row("`" preset[p] "`", ours, seconds[preset[p]] " s, two CPU cores")
      }
      row("TiNeuVox-B", theirs, "28 min, GPU")
      for (i = 1; i <= scenes; ++i) ours[i] = psnr["standard", scene[i]] - theirs[i]
      if (n["standard"] == scenes) row("`standard` above it by", ours, "")
    }' "$1"
}

insert() {  # insert FILE MARK LINES : between <!-- MARK --> and <!-- end of MARK -->
  awk -v mark="$2" -v lines="$3" '
    $0 == "<!-- " mark " -->" { print; while ((getline line < lines) > 0) print line; skip = 1; next }
    $0 == "<!-- end of " mark " -->" { skip = 0 }
    !skip' "$1" > "$1.new" && mv "$1.new" "$1"
}

write() {
  local rows means peers file
  rows=$(mktemp) means=$(mktemp) peers=$(mktemp)
  table > "$rows"
  summary > "$means"
  beside "$rows" > "$peers"
  for file in "$root/README.md" "$root/docs/benchmarks.md"; do insert "$file" results "$means"; done
  insert "$root/docs/benchmarks.md" "results by scene" "$rows"
  insert "$root/docs/benchmarks.md" peers "$peers"
  means "$rows" | awk '{ printf "{\"%s\", %s, %s},\n", $1, $4, $3 }' | sort \
    > "$root/src/cli/preset_figures.inc"
  rm -f "$rows" "$means" "$peers"
}

"$@"
