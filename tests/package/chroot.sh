#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# chroot.sh FOLDER PACKAGE... : a minimal Debian in FOLDER, the packages installed there with what they
# depend on, and the program used. Needs root, debootstrap and the network.
set -euo pipefail
source "$(dirname "$0")/root.sh"
make_root "$1"
shift
mkdir -p "$root/packages"
cp "$@" "$root/packages"
inside apt-get update -q
inside sh -c 'apt-get install -y -q --no-install-recommends /packages/*.deb'
inside sh -ec '
  cd /tmp && rm -rf scene run vdb
  splinevox --version
  splinevox synth dancer --out scene --frames 20 --size 64 --quiet
  splinevox train scene --out run --preset draft --max-steps 200 --quiet
  splinevox eval run | tail -n 1
  splinevox export run --out vdb --frames 1-2 --quiet
  splinevox verify vdb
  ls /usr/share/man/man1/splinevox.1*
'
if inside sh -c 'command -v python3 >/dev/null && python3 -c "import splinevox" 2>/dev/null'; then
  inside python3 -c 'import splinevox as sv
r = sv.open_run("/tmp/run")
print("python", sv.__version__, "PSNR %.3f dB" % r.evaluate()["psnr"])'
fi
