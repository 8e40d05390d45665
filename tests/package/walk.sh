#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# walk.sh FOLDER : what README and tutorial tell a new user to type, taken from their text, command by
# command in a minimal Debian in FOLDER that has git and nothing else. Prints a row per command: seconds by
# the clock and of processor time. Ends at the first one that fails. walk.sh --list says what would be done,
# and needs nothing. Else it needs root, debootstrap and the network.
set -euo pipefail
source=$(cd "$(dirname "$0")/../.." && pwd)

# What cannot be done there: a part of a command, and what stands for it or, after a #, why it is left out.
stand_ins=(
  './dev test|# CI does it'
  'data_scripts/fetch_dnerf.sh|splinevox synth dancer --out sets/data/mutant --size 200'
  'blender -P|# a window'
  'blender -b|# blender is no part of the set-up'
)
# Sections whose data nobody has who walks there.
left_out='From films|From a film of a telephone'
while IFS= read -r section; do
  grep -qxE "#+ $section" "$source/README.md" "$source/docs/tutorial.md" || {
    echo "walk.sh: no page has the section '$section', which is to be left out" >&2
    exit 1
  }
done < <(tr '|' '\n' <<<"$left_out")

commands() {  # FILE... : the lines of fences without a language, here-documents whole; a null after each
  awk -v left_out="^#+ ($left_out)\$" '
    /^#/ && !fence { out = $0 ~ left_out }
    /^```/ { fence = fence ? 0 : $0 == "```" ? 1 : 2; next }
    fence != 1 || out { next }
    { command = command $0 "\n" }
    match($0, /<<.[A-Z]+./) && !end { end = substr($0, RSTART + 3, RLENGTH - 4) }
    end && $0 != end { next }
    { printf "%s%c", command, 0; command = end = "" }' "$@"
}

walk() {  # in that Debian: commands from standard input, their times as rows of a table
  local command text stand_in seconds TIMEFORMAT='| %1R | %1U |'
  printf '| command | seconds | processor seconds |\n| --- | --- | --- |\n'
  while IFS= read -r -d '' command; do
    text=${command%%$'\n'*}
    printf '| `%s` ' "$(sed 's/ *#.*//; s/  */ /g' <<<"$text")"
    for stand_in in "${stand_ins[@]}"; do
      [[ $text != *"${stand_in%%|*}"* ]] || command=${stand_in#*|}
    done
    if [[ $command == '#'* ]]; then
      echo "| left out: ${command#'# '} | |"
    else
      printf '\n== %s\n' "$text" >>/walk.log
      { time eval "$command" >>/walk.log 2>&1 </dev/null; } 2>&1 || { tail -n 40 /walk.log; exit 1; }
    fi
  done
}

pages=("$source/README.md" "$source/docs/tutorial.md")
for stand_in in "${stand_ins[@]}"; do
  commands "${pages[@]}" | grep -qzF -e "${stand_in%%|*}" || {
    echo "walk.sh: neither README nor tutorial has '${stand_in%%|*}' any more" >&2
    exit 1
  }
done
if [[ $1 == --list ]]; then
  commands "${pages[@]}" | tr '\0' '\n'
  exit
fi
source "$source/tests/package/root.sh"
make_root "$1"
inside apt-get update -q >/dev/null
inside apt-get install -y -q --no-install-recommends git >/dev/null
bring_source "$source" splinevox
commands "${pages[@]}" >"$root/commands"
inside bash -euo pipefail -c "$(declare -p stand_ins); $(declare -f walk); cd /splinevox; walk </commands"
