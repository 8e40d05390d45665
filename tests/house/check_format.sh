#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Whether every source file is as clang-format leaves it. Versions differ in their taste, so only the one
# that wrote the files is asked; elsewhere the check is skipped with a clear line.
set -euo pipefail
cd "$1"
command -v clang-format >/dev/null || { echo "skipped: no clang-format here"; exit 77; }
version=$(clang-format --version | grep -oE 'version [0-9]+' | grep -oE '[0-9]+')
[[ $version == 14 ]] || { echo "skipped: clang-format 14 is asked, here is $version"; exit 77; }
find include src tests bench \( -name '*.cpp' -o -name '*.hpp' -o -name '*.cu' -o -name '*.cuh' \) -print0 |
  xargs -0 -n 40 clang-format --dry-run --Werror || { echo "./dev format mends it"; exit 1; }
