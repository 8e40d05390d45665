#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# progress.sh : passes on what ninja says on standard input, and the time left by what its steps took so
# far. On a terminal steps share one line.
set -euo pipefail
width=0
[[ ! -t 1 ]] || width=$(tput cols 2>/dev/null || echo 80)
SECONDS=0 open=
while IFS= read -r line; do
  if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\ (.*) ]]; then
    done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
    if ((done > 0)); then
      left=$((SECONDS * (all - done) / done))
      printf -v left ', %d:%02d left' $((left / 60)) $((left % 60))
    else  # ninja counts from 0 where it asks CMake again
      left=
    fi
    text="[$done/$all$left] ${BASH_REMATCH[3]}"
    if ((width)); then
      printf '\r\033[K%s' "${text:0:width - 1}"
      open=yes
    else
      echo "$text"
    fi
  else
    printf '%s%s\n' "${open:+$'\n'}" "$line"
    open=
  fi
done
[[ -z $open ]] || echo
