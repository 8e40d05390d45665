#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# install.sh BUILD FOLDER COMPILER : installs a build into a folder of its own, which then moves elsewhere
# (nothing in it may know where it was), and uses it as people do who have nothing else.
set -euo pipefail
build=$1 folder=$2 compiler=$3 source=$(cd "$(dirname "$0")" && pwd)
rm -rf "$folder" && mkdir -p "$folder"
cmake --install "$build" --prefix "$folder/first" >"$folder/install.log"
mv "$folder/first" "$folder/prefix"
prefix=$folder/prefix

echo "== find_package"
cmake -S "$source/consumer" -B "$folder/consumer" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER="$compiler" -Wno-dev >"$folder/configure.log" 2>&1 || {
    cat "$folder/configure.log"
    exit 1
  }
cmake --build "$folder/consumer"
"$folder/consumer/consumer" "$folder"
sed 's/splinevox 0.1/splinevox 0.2/' "$source/consumer/CMakeLists.txt" >"$folder/CMakeLists.txt"
cp "$source/consumer/main.cpp" "$folder"
if cmake -S "$folder" -B "$folder/newer" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler" \
    >"$folder/newer.log" 2>&1; then
  echo "version 0.1 passes for 0.2"
  exit 1
fi
grep -q 'compatible with requested version "0.2"' <(tr '\n' ' ' <"$folder/newer.log" | tr -s ' ')

echo "== pkg-config"
if command -v pkg-config >/dev/null; then
  PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name splinevox.pc)")
  export PKG_CONFIG_PATH
  eval "flags=($(pkg-config --cflags --libs splinevox))"  # blanks in its paths are escaped
  "$compiler" -O1 "$source/consumer/main.cpp" -o "$folder/one_file" "${flags[@]}"
  mkdir "$folder/again"
  LD_LIBRARY_PATH=$(pkg-config --variable=libdir splinevox) "$folder/one_file" "$folder/again"
fi

echo "== every header on its own terms, for any processor"
find "$prefix/include" -name '*.hpp' | LC_ALL=C sort >"$folder/headers"
for order in cat tac; do
  "$order" "$folder/headers" | sed 's/.*/#include "&"/' >"$folder/headers.cpp"
  "$compiler" -std=c++20 -fsyntax-only -I"$prefix/include" "$folder/headers.cpp"
done

echo "== the program, its manual and completions"
"$prefix/bin/splinevox" synth ball --out "$folder/scene" --frames 6 --size 24 --quiet
"$prefix/bin/splinevox" train "$folder/scene" --out "$folder/run" --preset draft --max-steps 5 \
  --effects all --set grid.radiance=8,12,16 --set motion.points=4 --quiet
"$prefix/bin/splinevox" verify "$folder/run"
for file in man/man1/splinevox.1 bash-completion/completions/splinevox \
    zsh/vendor-completions/_splinevox fish/vendor_completions.d/splinevox.fish; do
  grep -q max-steps "$prefix/share/$file" || grep -q 'max\\-steps' "$prefix/share/$file" || {
    echo "share/$file knows no --max-steps"
    exit 1
  }
done
python3 -m zipfile -t "$prefix/share/splinevox/splinevox_blender.zip" >/dev/null
version=$(sed -n 's/.*kVersion = "\(.*\)".*/\1/p' "$prefix/include/splinevox/core/version.hpp")
[[ $("$prefix/bin/splinevox" --version) == "splinevox $version" ]]
rm -rf "$folder"
