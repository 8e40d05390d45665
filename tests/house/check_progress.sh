#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Whether cmake/progress.sh passes on all that ninja says: steps, a step 0, what is no step.
set -euo pipefail
progress=$1/cmake/progress.sh
left() { sed -E 's/^(\[1\/4), [0-9]+:[0-9]{2} left/\1, T left/'; }  # a second may pass meanwhile
expect() {  # expect WHAT WANTED GOT
  [[ $3 == "$2" ]] || { printf '%s: wanted\n%s\ngot\n%s\n' "$@"; exit 1; }
}
expect "steps" $'[1/4, T left] one\n[4/4, 0:00 left] last' \
  "$(printf '[1/4] one\n[4/4] last\n' | "$progress" | left)"
expect "a step 0" $'[0/1] Re-running CMake...\n[1/1, 0:00 left] linked' \
  "$(printf '[0/1] Re-running CMake...\n[1/1] linked\n' | "$progress")"
expect "other lines" $'FAILED: a.o\n  error: a [0/0] in it' \
  "$(printf 'FAILED: a.o\n  error: a [0/0] in it\n' | "$progress")"
expect "no steps at all" '[0/0] nothing to do' "$(printf '[0/0] nothing to do\n' | "$progress")"
expect "nothing" '' "$("$progress" < /dev/null)"
