#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The main job on a built-in scene: demo.sh SPLINEVOX FOLDER SECONDS. What FOLDER held is removed. The
# program was compiled before, as step 1.
set -euo pipefail
splinevox=$1 folder=$2 seconds=$3
say() { printf '\033[1m== %s\033[0m\n' "$*"; }

# How long the steps are beside each other, in seconds of two idle cores of an EPYC. The first step tells how
# much slower this machine is. Training goes by the clock.
usual=(4 0 1 9 4 6)
step=0 training=0
next() {  # TEXT... : says which step begins, and the time left if this machine goes on as it did
  local i past=0 left=0
  for i in "${!usual[@]}"; do
    ((i < step)) && past=$((past + usual[i])) || left=$((left + usual[i]))
  done
  ((step == 0)) || left=$((left * (SECONDS - training) / past))
  ((step > 1)) || left=$((left + seconds))
  step=$((step + 1))
  say "step $((step + 1)) of 7, about $((left / 60)):$(printf %02d $((left % 60))) left: $*"
}

rm -rf "$folder" && mkdir "$folder" && cd "$folder"
SECONDS=0
next "a procedural scene: pictures, cameras and times of a dancer"
"$splinevox" synth dancer --out scene --size 200 --frames 60
next "reconstructing it: $seconds seconds"
training=-$SECONDS
"$splinevox" train scene --out run --preset fast --max-time "$seconds"
training=$((training + SECONDS))
next "evaluating it on the views held back"
"$splinevox" eval run --images run/test
next "an animated VDB sequence"
"$splinevox" export run --out vdb --profile blender --frames 1-24 --fps 24
next "a film"
format=mp4
command -v ffmpeg >/dev/null || format=png
"$splinevox" render run --out film --camera orbit --times 0:1:48 --format "$format"
next "two pages: the scene itself, and about the run"
"$splinevox" view run --out view.html
"$splinevox" report run --out report.html
say "PSNR against seconds of training"
"$splinevox" info run
cat <<END

The scene     $folder/scene
The model     $folder/run/model.vdb        (OpenVDB: any VDB program opens it)
The sequence  $folder/vdb                  ($folder/vdb/load_in_blender.py brings it into Blender)
The film      $folder/film
The report    $folder/report.html          (curves, pictures, tables)
The viewer    $folder/view.html            (the scene itself, to turn and play)
END
