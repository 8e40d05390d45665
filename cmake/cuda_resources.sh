#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# cuda_resources.sh FOLDER [--check] : what every kernel that was compiled under FOLDER uses, as a table.
# With --check: fails if a kernel keeps anything in local memory (spills, or arrays with an index known only
# when it runs).
set -euo pipefail
mapfile -t logs < <(find "$1" -name '*.ptxas' | sort)
((${#logs[@]})) || { echo "there are no *.ptxas files under $1: were the CUDA kernels built?" >&2; exit 1; }
cat "${logs[@]}" | c++filt | awk -v check="${2:-}" '
  BEGIN {
    printf "%-30s %-7s %9s %6s %7s %6s\n", "kernel", "device", "registers", "stack", "stores", "loads"
    fflush()
  }
  /Compiling entry function/ {
    name = $0
    sub(/^[^\x27]*\x27/, "", name); arch = name
    sub(/.*for \x27/, "", arch); sub(/\x27.*/, "", arch)
    sub(/\x27 for .*/, "", name); gsub(/^void |splinevox::|cuda::|\(anonymous namespace\)::/, "", name)
    sub(/^(each|team)_kernel</, "", name); sub(/ ?>?\(.*$/, "", name)
  }
  /bytes stack frame/ { stack = $1; stores = $5; loads = $9 }
  / Used [0-9]+ registers/ {
    registers = $0; sub(/.*Used /, "", registers); sub(/ .*/, "", registers)
    printf "%-30s %-7s %9s %6s %7s %6s\n", name, arch, registers, stack, stores, loads | "sort"
    if (stack + stores + loads > 0) bad = bad "\n  " name " (" arch ")"
    ++count
  }
  END {
    close("sort")
    printf "%d kernels; stack, spill stores and spill loads in bytes a thread\n", count
    if (check == "--check" && !count) { print "no kernel was found in what ptxas said"; exit 1 }
    if (check == "--check" && bad != "") { print "these keep something in local memory:" bad; exit 1 }
  }'
