#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# blender_accept.sh FIXTURE_PROGRAM BLENDER_SCRIPT : does Blender see in our files what we put there?
# 77: skipped.
set -eu
if ! command -v blender >/dev/null 2>&1; then
  echo "skipped: there is no 'blender' on this machine (apt-get install blender)"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" "$folder"
blender -b --factory-startup -noaudio --python-exit-code 3 -P "$2" -- "$folder"
