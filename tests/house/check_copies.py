#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds inline functions of which the library has copies at -O1 and at more, and whose sums would differ.

What only reads, writes and waits is compiled at -O1 (splinevox_unity QUICK). A function in a header that it
calls is then in its object too, and the linker keeps one copy for the whole program, whichever comes first.
Where products and sums are fused at -O3 and not at -O1, a program would compute other last bits than another
one that is linked from the same library. Such a function belongs in a source file, or is SPLINEVOX_INLINE.

check_copies.py BUILD : exit code 1 with their names; 77 where the build is not ninja's or a tool is missing.
"""
import collections
import json
import pathlib
import re
import shutil
import subprocess
import sys

FUSED = re.compile(r"\tv?fn?m(add|sub)|\tfn?m(add|sub|la|ls)\b")


def said(*words, folder="."):
    return subprocess.run(words, cwd=folder, check=True, capture_output=True, text=True).stdout


def objects(build):
    """Objects of the library, by whether they are compiled at -O1."""
    out = collections.defaultdict(list)
    for entry in json.loads(said("ninja", "-t", "compdb", folder=build)):
        path, levels = entry["output"], re.findall(r"\s-O(\w)(?=\s)", entry["command"])
        if path.startswith("src/") and path.endswith((".cpp.o", ".cxx.o")) and (build / path).exists():
            out[bool(levels) and levels[-1] == "1"].append(path)
    return out


def copies(build, paths):
    """Mangled names of our functions that every object has a copy of, and one such object."""
    out = {}
    for path in paths:
        for line in said("nm", "--defined-only", path, folder=build).splitlines():
            kind, name = line.split()[-2:]
            if kind == "W" and "9splinevox" in name:
                out[name] = path
    return out


def main():
    build = pathlib.Path(sys.argv[1])
    for tool in ("ninja", "nm", "objdump", "c++filt"):
        if not shutil.which(tool) or not (build / "build.ninja").exists():
            print(f"skipped: there is no {tool}, or no build of ninja's in {build}")
            return 77
    found = objects(build)
    quick, others = copies(build, found[True]), copies(build, found[False])
    if not quick or not others:
        print(f"no objects of both kinds under {build}/src: is the library built?")
        return 1
    bad = [name for name in sorted(quick.keys() & others.keys())
           if FUSED.search(said("objdump", "-d", "--no-show-raw-insn", f"--disassemble={name}", others[name],
                                folder=build))]
    for name in bad:
        print(f"{said('c++filt', name).strip()}\n  -O1: {quick[name]}\n  more: {others[name]}")
    both = len(quick.keys() & others.keys())
    print(f"{both} functions have copies of both kinds; of {len(bad)} the sums differ")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
