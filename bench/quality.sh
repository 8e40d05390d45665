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
#                               tables between the marks of the latter, and the presets' means into
#                               `splinevox train --help`
#
# `write` also reads bench/results/quality_black.jsonl, lines of EXTRA="--background black".
# SEEDS ("1 2 3") are those to train, 1 by default; EXTRA are further options of `splinevox train`; RESULTS is
# another file of lines; COMMIT is that of the program where it is not the one checked out.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
splinevox=${SPLINEVOX:-$root/build/release/src/cli/splinevox}
results=${RESULTS:-$root/bench/results/quality.jsonl}

train() {
  local data=$1 out=$2 preset=$3 scene seed split
  local splits="train val test"  # there are many training views, so of the first seed alone
  shift 3
  for seed in ${SEEDS:-1}; do
    for scene in "$@"; do
      local run=$out/$preset/$scene/$seed
      rm -rf "$run" "$run.one_ray.json"
      mkdir -p "${run%/*}"
      "$splinevox" train "$data/$scene" --out "$run" --preset "$preset" --seed "$seed" ${EXTRA:-} \
        > "$run.log" 2>&1
      # with one ray a pixel too, as lines without psnr_one_ray have it
      "$splinevox" eval "$run" --data "$data/$scene" --antialias 1 --out "$run.one_ray.json" \
        >> "$run.log" 2>&1
      for split in $splits; do
        "$splinevox" eval "$run" --data "$data/$scene" --split $split >> "$run.log" 2>&1
      done
      keep "$preset" "$scene" "$seed" "$run"
      echo "$preset $scene seed $seed: $(number "$run/metrics.json" psnr) dB"
    done
    splits="val test"
  done
}

number() {  # number FILE KEY : the first value of a top-level key, indented JSON; null without the file
  [[ -f $1 ]] || { echo null; return; }
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
    printf ', "val_psnr": %s, "train_psnr": %s' "$(number "$4/metrics_val.json" psnr)" \
      "$(number "$4/metrics_train.json" psnr)"
    printf ', "psnr_one_ray": %s}\n' "$(number "$4.one_ray.json" psnr)"
  } | sort > "$results.new"
  mv "$results.new" "$results"
}

table() {  # table [FILE] : means over the seeds; behind PSNR half the way from the worst seed to the best
  awk -v exact="${exact:-}" '  # exact=1 table: digits enough to work with
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
      for (i = 1; i <= keys; ++i) {
        value = field(key[i])
        if (value == "" || value == "null" || (key[i] == "train_psnr" && field("seed") != 1)) continue
        sum[g, key[i]] += value
        ++known[g, key[i]]
      }
      if (!index(commits[g], field("commit"))) commits[g] = commits[g] " " field("commit")
    }
    function mean(key, format) {
      return known[g, key] ? sprintf(exact ? "%.9g" : format, sum[g, key] / known[g, key]) : ""
    }
    BEGIN {
      keys = split("train_seconds steps peak_memory_bytes psnr ssim ms_ssim val_psnr train_psnr", key, " ")
      print "| scene | preset | seeds | training s | steps | peak memory GB | PSNR | SSIM | MS-SSIM |" \
            " PSNR of the val split | of training views | processor | commit |"
      print "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    }
    END {
      presets = split("draft fast standard high paper nerf_atlas", preset, " ")
      for (p = 1; p <= presets; ++p)
        for (i = 1; i <= count; ++i) {
          g = groups[i]
          split(g, name, SUBSEP)
          if (name[1] != preset[p]) continue
          spread = n[g] > 1 ? sprintf(" ± %.2f", (hi[g] - lo[g]) / 2) : ""
          printf "| %s | %s | %d | %s | %s | %.2f | %s%s | %s | %s | %s | %s | %s |%s |\n",
                 name[2], name[1], n[g], mean("train_seconds", "%.0f"), mean("steps", "%d"),
                 mean("peak_memory_bytes", "%f") / 1e9, mean("psnr", "%.2f"), spread, mean("ssim", "%.4f"),
                 mean("ms_ssim", "%.4f"), mean("val_psnr", "%.2f"), mean("train_psnr", "%.2f"), name[3],
                 commits[g]
        }
    }' "${1:-$results}"
}

# Figures of one preset from several kinds of machine are no mean of anything.
twice='function twice(scene, preset) {
  print "bench/quality.sh: " scene " has lines of " preset " from several processors" > "/dev/stderr"
  exit failed = 1
}'

means() {  # means FILE : PRESET SECONDS MEMORY PSNR SSIM of each preset with all six D-NeRF scenes in a table
  awk -F ' *\\| *' "$twice"'
    $2 ~ /^dnerf_/ {
      if (($3, $2) in there) twice($2, $3)
      there[$3, $2]
    }
    $2 ~ /^dnerf_/ { n[$3]++; seconds[$3] += $5; memory[$3] += $7; psnr[$3] += $8; ssim[$3] += $9 }
    END {
      if (failed) exit 1
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
  means <(exact=1 table) | while read -r preset seconds memory psnr ssim; do
    echo "| \`$preset\` | $seconds | $psnr | $ssim | $memory |"
  done
}

# Published rows: name, size of their pictures, time; then PSNR of bouncingballs, hellwarrior, jumpingjacks,
# lego, mutant and trex, "-" where the scene is left out of all (test split, last checkpoint).
# docs/benchmarks.md names their sources.
white="TiNeuVox-B;400;28 min, GPU;40.73 28.17 34.23 25.02 33.61 32.70
V4D;400;6.9 h, GPU;42.67 27.03 35.36 25.62 36.27 34.53
4D-GS;800;8 min, GPU;40.87 28.83 35.23 25.02 37.87 34.29
Deformable-3DGS;800;GPU;43.30 32.17 37.21 25.08 40.53 38.38"
black="4D-GS;800;13 to 38 min, GPU;37.12 38.65 36.00 - 38.83 33.40
Deformable-3DGS;400;GPU;41.46 42.11 39.10 - 43.73 38.40
Deformable-3DGS;800;19 to 59 min, GPU;40.66 41.07 37.21 - 41.86 37.67"

beside() {  # beside ROWS PUBLISHED : PSNR beside published methods', of presets that have all their scenes
  awk -F ' *[|;] *' "$twice"'
    BEGIN {
      scenes = split("bouncingballs hellwarrior jumpingjacks lego mutant trex", scene, " ")
      presets = split("fast standard high", preset, " ")
      head = "| | pixels |"; line = "| --- | --- |"
      for (i = 1; i <= scenes; ++i) { head = head " " scene[i] " |"; line = line " --- |" }
      print head " mean | time |"
      print line " --- | --- |"
    }
    function row(name, pixels, values, time, sum, count, i, out) {
      for (i = 1; i <= scenes; ++i) {
        if (there[i] && !values[i]) return
        sum += there[i] ? values[i] : 0
        count += there[i]
        out = out (there[i] ? sprintf(" %.2f |", values[i]) : " |")
      }
      printf "| %s | %s |%s %.2f | %s |\n", name, pixels, out, sum / count, time
    }
    FNR == NR {
      published[NR] = $0
      split($4, theirs, " ")
      for (i in theirs) there[i] = theirs[i] != "-"
      next
    }
    $2 ~ /^dnerf_/ {
      sub(/^dnerf_/, "", $2)
      if (($3, $2) in psnr) twice($2, $3)
      psnr[$3, $2] = $8
      seconds[$3] = sprintf("%.0f", $5)
    }
    END {
      if (failed) exit 1
      for (p = 1; p <= presets; ++p) {
        for (i = 1; i <= scenes; ++i) ours[i] = psnr[preset[p], scene[i]] + 0
        row("`" preset[p] "`", 400, ours, seconds[preset[p]] " s, two CPU cores")
      }
      for (k = 1; k in published; ++k) {
        split(published[k], part, ";")
        split(part[4], theirs, " ")
        row(part[1], part[2], theirs, part[3])
      }
    }' <(echo "$2") "$1"
}

insert() {  # insert FILE MARK LINES : between <!-- MARK --> and <!-- end of MARK -->
  awk -v mark="$2" -v lines="$3" '
    $0 == "<!-- " mark " -->" { print; while ((getline line < lines) > 0) print line; skip = 1; next }
    $0 == "<!-- end of " mark " -->" { skip = 0 }
    !skip' "$1" > "$1.new" && mv "$1.new" "$1"
}

write() {
  local rows black_rows lines file
  rows=$(mktemp) black_rows=$(mktemp) lines=$(mktemp)
  table > "$rows"
  table "$root/bench/results/quality_black.jsonl" > "$black_rows"
  summary > "$lines"
  for file in "$root/README.md" "$root/docs/benchmarks.md"; do insert "$file" results "$lines"; done
  insert "$root/docs/benchmarks.md" "results by scene" "$rows"
  insert "$root/docs/benchmarks.md" "results by scene, black" "$black_rows"
  exact=1 table > "$rows"
  exact=1 table "$root/bench/results/quality_black.jsonl" > "$black_rows"
  beside "$rows" "$white" > "$lines"
  insert "$root/docs/benchmarks.md" peers "$lines"
  beside "$black_rows" "$black" > "$lines"
  insert "$root/docs/benchmarks.md" "peers, black" "$lines"
  means "$rows" | awk '{ printf "{\"%s\", %s, %s},\n", $1, $4, $3 }' | sort \
    > "$root/src/cli/preset_figures.inc"
  rm -f "$rows" "$black_rows" "$lines"
}

"$@"
