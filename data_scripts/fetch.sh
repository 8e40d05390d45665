#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches a public data set and unpacks it: data_scripts/fetch.sh NAME FOLDER, or
# fetch.sh ADDRESS FOLDER [SHA256]. Without arguments: the names. A download that was cut off is continued.
# The SHA-256 is that of sets.txt or the third argument. Where nobody has written one down, it is noted in
# FOLDER/ARCHIVE.sha256 and every later fetch must agree with it.
set -euo pipefail
sets=$(dirname "${BASH_SOURCE[0]}")/sets.txt
if (($# < 2)); then
  echo "usage: fetch.sh NAME|ADDRESS FOLDER [SHA256]; names:" >&2
  awk '!/^#/ {print "  " $1 "  " $2}' "$sets" >&2
  exit 2
fi
folder=$2 address=$1 expected=${3:--}
if [[ $1 != *://* ]]; then
  read -r _ address expected < <(awk -v name="$1" '$1 == name' "$sets") || {
    echo "fetch.sh: there is no set '$1'; fetch.sh without arguments lists them" >&2
    exit 2
  }
fi
for tool in curl unzip sha256sum; do
  command -v "$tool" >/dev/null || { echo "fetch.sh: please install $tool" >&2; exit 1; }
done
mkdir -p "$folder"
archive=$folder/$(basename "${address%%\?*}")
[[ $expected == - && -f $archive.sha256 ]] && expected=$(<"$archive.sha256")
if [[ -f $archive && -f $archive.address && $(<"$archive.address") != "$address" ]]; then
  echo "fetch.sh: $archive is of another set, $(<"$archive.address"): take another FOLDER" >&2
  exit 1
fi
echo "$address" >"$archive.address"

sum() { sha256sum "$archive" | cut -d' ' -f1; }

# What is whole already is not asked for again; what is longer than it should be is no beginning of anything.
if [[ ! -f $archive || $expected == - || $(sum) != "$expected" ]]; then
  code=0
  status=$(curl --location --fail --show-error --continue-at - --output "$archive" \
    --write-out '%{http_code}' "$address") || code=$?
  case $code/$status in
    # A server that has nothing to add to a whole file says so with an error.
    0/* | 22/416 | 33/* | 36/*) [[ -f $archive ]] || exit 1 ;;
    *) echo "fetch.sh: curl ended with $code; the same command goes on where it stopped" >&2; exit 1 ;;
  esac
fi
got=$(sum)
if [[ $expected != - && $got != "$expected" ]]; then
  echo "fetch.sh: $archive has SHA-256 $got, expected $expected: delete it and try again" >&2
  exit 1
fi
unzip -t -q "$archive" >/dev/null || {
  echo "fetch.sh: $archive is damaged: delete it and try again" >&2
  exit 1
}
if [[ $expected == - ]]; then
  echo "$got" >"$archive.sha256"
  echo "fetch.sh: nobody has written down a checksum of this set; noted $got" >&2
fi
if [[ ! -f $archive.unpacked ]]; then  # over what an earlier try left half unpacked, and never again
  unzip -o -q "$archive" -d "$folder"
  : >"$archive.unpacked"
fi
found=$(find "$folder" \( -name transforms_train.json -o -name transforms.json -o -name dataset.json \
  -o -name poses_bounds.npy -o -name precomputed.json -o -name cameras.bin -o -name cameras.txt \
  -o -name train_meta.json -o -name info.json -o -name extri.yml \) \
  -printf '%h\n' | sort -u)
[[ $found ]] || {
  echo "fetch.sh: no data set in $folder; to unpack it once more delete $archive.unpacked" >&2
  exit 1
}
echo "$found"
