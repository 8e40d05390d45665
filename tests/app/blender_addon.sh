#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# blender_addon.sh PROGRAM ZIP SCRIPT : the add-on as a user has it: installed from its zip, then each button.
# 77: skipped.
set -eu
if ! command -v blender >/dev/null 2>&1; then
  echo "skipped: there is no 'blender' on this machine (apt-get install blender)"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" synth dancer --out "$folder/scene" --frames 8 --size 32 --quiet
"$1" train "$folder/scene" --out "$folder/run" --preset draft --max-steps 60 --quiet --effects motion \
  --set sampling.rays=512 --set grid.radiance=16,24,32 --set grid.motion=4,8 --set grid.motion_start=0,0.2
mkdir "$folder/home"
export HOME="$folder/home" BLENDER_USER_RESOURCES="$folder/home" BLENDER_USER_SCRIPTS="$folder/home/scripts"
export XDG_CONFIG_HOME="$folder/home"
blender -b --factory-startup -noaudio --python-exit-code 3 -P "$3" -- "$1" "$2" "$folder"
