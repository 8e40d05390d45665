#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# arm64.sh FOLDER [PROGRAM] : cross-compiles for arm64 in a minimal Debian in FOLDER and runs what comes out
# under qemu-user: unit tests, then a scene, training and figures. PROGRAM is this machine's splinevox of
# the same sources: it does the same, and which files are the same bit by bit is told. Needs root,
# debootstrap and the network.
set -euo pipefail
source=$(cd "$(dirname "$0")/../.." && pwd)
source "$source/tests/package/root.sh"
make_root "$1"
other=${2:-}
tests=(core core_portable math field)
inside dpkg --add-architecture arm64
inside apt-get update -q
foreign=()
for package in $("$source/dev" setup --list); do
  case $package in
    *-dev) [[ $(inside apt-cache show "$package") == *$'\nArchitecture: all\n'* ]] || package+=:arm64 ;;
    g++ | ffmpeg) continue ;;
  esac
  foreign+=("$package")
done
inside apt-get install -y -q --no-install-recommends \
  crossbuild-essential-arm64 qemu-user-static "${foreign[@]}"
bring_source "$source" splinevox
inside sh -ec '
  cd /splinevox
  export PKG_CONFIG_LIBDIR=/usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig
  cmake -S . -B build/arm64 -G Ninja -DCMAKE_BUILD_TYPE=Release -DSPLINEVOX_NATIVE=OFF -Wno-dev \
    -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_C_COMPILER=aarch64-linux-gnu-gcc -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ \
    -DCMAKE_CROSSCOMPILING_EMULATOR=qemu-aarch64-static
  cmake --build build/arm64 -j "${JOBS:-$(nproc)}" --target splinevox "$@"' - "${tests[@]/#/test_}"

arm() { inside qemu-aarch64-static "/splinevox/build/arm64/$1" "${@:2}"; }
for test in "${tests[@]}"; do
  # qemu-user does not pass a limit of memory on to its guest.
  arm "tests/${test%_portable}/test_$test" --test-case-exclude="this process's own limit counts as well"
done
trial() {  # PROGRAM... : a scene, twenty steps and figures in /tmp/trial of where it is called
  rm -rf /tmp/trial && mkdir /tmp/trial && cd /tmp/trial
  "$@" synth dancer --out scene --frames 10 --size 48 --quiet
  "$@" train scene --out run --preset draft --max-time 0 --max-steps 20 --effects all --quiet
  "$@" eval run | tail -n 1
  "$@" verify run
}
echo "== arm64"
inside bash -ec "$(declare -f trial); trial qemu-aarch64-static /splinevox/build/arm64/src/cli/splinevox"
[[ -n $other ]] || exit 0
echo "== $(uname -m)"
bash -ec "$(declare -f trial); trial '$(realpath "$other")'"
for file in scene/train/r_000.png scene/transforms_train.json run/model.vdb; do
  cmp -s "/tmp/trial/$file" "$root/tmp/trial/$file" && echo "$file: the same bits" || echo "$file: other bits"
done
