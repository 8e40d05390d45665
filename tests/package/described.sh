#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# described.sh PROGRAM : the manual has no errors, and each shell that is here completes what its user would
# expect.
set -euo pipefail
program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
absent=()
same() { [[ $2 == "$3" ]] || { echo "$1: expected '$2', got '$3'"; exit 1; }; }

"$program" man >"$folder/splinevox.1"
# Images of Ubuntu have a program of this name that only says that they are minimised.
if man --version 2>/dev/null | grep '^man [0-9]' >/dev/null; then
  LC_ALL=C.UTF-8 MANWIDTH=100 man --warnings -E UTF-8 -l -Tutf8 -Z "$folder/splinevox.1" \
    >"$folder/out" 2>"$folder/warnings"
  same "warnings of man" "" "$(cat "$folder/warnings")"
  LC_ALL=C.UTF-8 MANWIDTH=100 man -P cat -l "$folder/splinevox.1" | sed 's/.\x08//g' >"$folder/text"
  for words in 'splinevox export RUN --out' 'nerf_atlas' 'INT in \[0 - 4096\]' 'one of test, val, train'; do
    grep -q -e "$words" "$folder/text" || { echo "the manual does not say '$words'"; exit 1; }
  done
else
  absent+=(man-db)
fi
for verb in $("$program" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p'); do
  grep -q "^.SS ${verb}$" "$folder/splinevox.1" || { echo "the manual lacks the verb $verb"; exit 1; }
done

"$program" completion bash >"$folder/bash"
complete_bash() {  # WORD... : what comes after them, the last word being typed
  bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
    _splinevox; echo "${COMPREPLY[*]}"' - "$folder/bash" splinevox "$@"
}
same "bash, verbs" "track train" "$(complete_bash tra | tr ' ' '\n' | sort | xargs)"
same "bash, options" "--max-time --max-steps" "$(complete_bash train data --max-)"
same "bash, choices" "draft" "$(complete_bash train data --preset dr)"
same "bash, a positional" "dancer" "$(complete_bash synth da)"
same "bash, a file" "" "$(complete_bash train --config x)"
same "bash, another verb's option" "" "$(complete_bash verify --max-)"

if command -v fish >/dev/null; then
  "$program" completion fish >"$folder/fish"
  complete_fish() {
    HOME=$folder fish --no-config -c "source $folder/fish; complete -C '$1'" | cut -f1 | sort | xargs;
  }
  same "fish, verbs" "track train" "$(complete_fish 'splinevox tra')"
  same "fish, options" "--max-steps --max-time" "$(complete_fish 'splinevox train data --max-')"
  same "fish, choices" "draft" "$(complete_fish 'splinevox train data --preset dr')"
  same "fish, a positional" "dancer" "$(complete_fish 'splinevox synth danc')"
else
  absent+=(fish)
fi

if command -v zsh >/dev/null; then
  "$program" completion zsh >"$folder/_splinevox"
  cat >"$folder/ask.zsh" <<'END'
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "PS1=; unset zle_bracketed_paste; fpath=($1 \$fpath); autoload -Uz compinit; compinit -D -u"
zpty -w shell "LISTMAX=0; zstyle ':completion:*' list-prompt ''"
zpty -w shell "zstyle ':completion:*' menu no; bindkey '^I' complete-word"
zpty -n -w shell "$2"$'\t'
text= part=
for i in {1..400}; do  # a slow machine takes many of these
  sleep 0.1
  while zpty -rt shell part; do text+=$part; done
  [[ $text == *$3* ]] && { zpty -d shell; exit 0; }
done
zpty -d shell
print -r -- "zsh: no '$3' after '$2' and the tabulator; saw: $text"
exit 1
END
  zsh -f "$folder/ask.zsh" "$folder" "splinevox tra" "carry points of one time"
  zsh -f "$folder/ask.zsh" "$folder" "splinevox train data --max-st" "--max-steps"
  zsh -f "$folder/ask.zsh" "$folder" "splinevox train data --preset dr" "--preset draft"
else
  absent+=(zsh)
fi
((${#absent[@]} == 0)) || echo "not looked at, for they are not on this machine: ${absent[*]}"
