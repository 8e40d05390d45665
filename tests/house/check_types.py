#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds types of one name that two files define in one namespace. A program that links both is undefined, and
no compiler says so. Relies on clang-format: a namespace ends in a line of its own, with its name.

check_types.py ROOT    of the library and each program beside it; exit code 1 if there are any
"""
import collections
import functools
import pathlib
import re
import sys

OPENS = re.compile(r"(?:inline )?namespace ?([\w:]*) ?\{$")
CLOSES = re.compile(r"\}  // namespace")
TYPE = re.compile(r"(?:struct|class|union|enum class|enum) (\w+)(?: final)?(?: : [^{;]*)?(?: \{.*)?$")


@functools.cache  # the library is beside every program
def types_of(text):
    """Names of the types that other files could see, with their namespaces."""
    inside, found = [], []
    for line in text.splitlines():
        if m := OPENS.match(line):
            inside.append(m.group(1))
        elif CLOSES.match(line) and inside:
            inside.pop()
        elif (m := TYPE.match(line)) and "" not in inside:
            found.append("::".join([*inside, m.group(1)]))
    return found


def twice(texts):
    """{type: files} of those that more than one of {file: text} defines."""
    files = collections.defaultdict(list)
    for file, text in texts.items():
        for name in types_of(text):
            files[name].append(file)
    return {name: where for name, where in files.items() if len(set(where)) > 1}


def main():
    root = pathlib.Path(sys.argv[1])

    def texts(*folders):
        return {str(f.relative_to(root)): f.read_text(encoding="utf-8") for folder in folders
                for f in sorted((root / folder).rglob("*")) if f.suffix in (".hpp", ".cpp", ".cu", ".cuh")}

    library, found = texts("include", "src"), {}
    tests = [f"tests/{folder.name}" for folder in (root / "tests").iterdir() if folder.is_dir()]
    for program in ["bench", *tests]:
        found |= twice(library | texts("tests/support", program))
    for name, files in sorted(found.items()):
        print(f"{name} is defined in {' and in '.join(files)}: rename one, or put it in an unnamed namespace")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
