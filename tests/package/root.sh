# SPDX-License-Identifier: Apache-2.0
# Sourced by the trials that want a machine with nothing on it. Needs root, debootstrap and the network.

# make_root FOLDER : a minimal Debian of this machine's release and sources of packages, in $root from then
# on. One that is there is used as it is.
make_root() {
  root=$1
  local release
  release=$(. /etc/os-release && echo "$VERSION_CODENAME")
  [[ -x $root/bin/sh ]] || debootstrap --variant=minbase --include=ca-certificates "$release" "$root"
  [[ -d /etc/apt/sources.list.d ]] && rm -f "$root/etc/apt/sources.list"
  cp /etc/apt/sources.list "$root/etc/apt/" 2>/dev/null || true
  cp -r /etc/apt/sources.list.d /etc/apt/apt.conf.d "$root/etc/apt/" 2>/dev/null || true
  cp /etc/resolv.conf "$root/etc/"
  mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
  trap 'umount "$root/proc"' EXIT
}

# inside WORD... : a command in that Debian.
inside() { LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive chroot "$root" "$@"; }

# bring_source SOURCE FOLDER : what git knows of SOURCE, as it lies there now, to FOLDER of that Debian.
bring_source() {
  mkdir -p "$root/$2"
  git -C "$1" ls-files -z | (cd "$1" && tar -c --null -T -) | tar -x -C "$root/$2"
}
