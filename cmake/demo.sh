#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The main job on a built-in scene: demo.sh SPLINEVOX FOLDER SECONDS. What FOLDER held is removed.
set -euo pipefail
splinevox=$1 folder=$2 seconds=$3
say() { printf '\033[1m== %s\033[0m\n' "$*"; }

rm -rf "$folder" && mkdir "$folder" && cd "$folder"
say "1/6 a procedural scene: pictures, cameras and times of a dancer"
"$splinevox" synth dancer --out scene --size 200 --frames 60
say "2/6 reconstructing it: $seconds seconds"
"$splinevox" train scene --out run --preset fast --max-time "$seconds"
say "3/6 evaluating it on the views held back"
"$splinevox" eval run --images run/test
say "4/6 an animated VDB sequence"
"$splinevox" export run --out vdb --profile blender --frames 1-24 --fps 24
say "5/6 a film"
format=mp4
command -v ffmpeg >/dev/null || format=png
"$splinevox" render run --out film --camera orbit --times 0:1:48 --format "$format"
say "6/6 two pages: about the run, and the scene itself"
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
