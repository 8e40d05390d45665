#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# data_scripts/fetch.sh on files of this machine: fetch, continue, checksums. fetch_test.sh REPOSITORY
set -euo pipefail
for tool in curl unzip; do
  command -v "$tool" >/dev/null || { echo "skipped: there is no $tool"; exit 77; }
done
fetch=$1/data_scripts/fetch.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/served/scene"
head -c 100000 /dev/urandom >"$work/served/scene/picture.bin"
echo '{}' >"$work/served/scene/transforms.json"
(cd "$work/served" && cmake -E tar cf scene.zip --format=zip scene)
address=file://$work/served/scene.zip
sum=$(sha256sum "$work/served/scene.zip" | cut -d' ' -f1)

fail() { echo "FAILED: $*" >&2; exit 1; }

out=$("$fetch" "$address" "$work/a" "$sum" 2>/dev/null)
[[ $out == "$work/a/scene" ]] || fail "the folder of the set is not printed: $out"
cmp "$work/a/scene/picture.bin" "$work/served/scene/picture.bin" || fail "another picture"
mkdir "$work/b" && head -c 5000 "$work/served/scene.zip" >"$work/b/scene.zip"
"$fetch" "$address" "$work/b" >/dev/null 2>&1 || fail "a cut download is not continued"
cmp "$work/b/scene.zip" "$work/served/scene.zip" || fail "continued wrongly"
[[ $(<"$work/b/scene.zip.sha256") == "$sum" ]] || fail "no checksum is noted"
echo mine >"$work/b/scene/transforms.json"
"$fetch" "$address" "$work/b" >/dev/null 2>&1 || fail "a second fetch fails"
[[ $(<"$work/b/scene/transforms.json") == mine ]] || fail "what is there is unpacked again"
rm "$work/b/scene.zip.unpacked" && truncate -s 100 "$work/b/scene/picture.bin"  # unpacking was interrupted
"$fetch" "$address" "$work/b" >/dev/null 2>&1 || fail "a fetch behind half an unpacking fails"
cmp "$work/b/scene/picture.bin" "$work/served/scene/picture.bin" || fail "half a picture is kept"
printf 'x' | dd of="$work/b/scene.zip" bs=1 seek=200 conv=notrunc status=none
if "$fetch" "$address" "$work/b" >/dev/null 2>"$work/log"; then fail "damage is not noticed"; fi
grep -q "expected $sum" "$work/log" || fail "the checksum is not named: $(<"$work/log")"
if "$fetch" "$address" "$work/c" 0000 >/dev/null 2>"$work/log"; then fail "a wrong checksum is taken"; fi
grep -q 'expected 0000' "$work/log" || fail "the wrong checksum is not named"
mkdir -p "$work/other/scene" && echo '{}' >"$work/other/scene/transforms.json"
(cd "$work/other" && cmake -E tar cf scene.zip --format=zip scene)
if "$fetch" "file://$work/other/scene.zip" "$work/a" >/dev/null 2>"$work/log"; then
  fail "two sets are one"
fi
grep -q "of another set, $address" "$work/log" || fail "the other set is not named: $(<"$work/log")"
rm -r "$work/a/scene"
if "$fetch" "$address" "$work/a" "$sum" >/dev/null 2>"$work/log"; then fail "nothing is taken for a set"; fi
grep -q "delete $work/a/scene.zip.unpacked" "$work/log" || fail "what to delete is not named"
out=$(DNERF_URL=$address "${fetch%.sh}_dnerf.sh" "$work/e" 2>/dev/null)
[[ $out == "$work/e/scene" ]] || fail "fetch_dnerf.sh fetches something else: $out"
if "$fetch" "file://$work/typo/scene.zip" "$work/f" >/dev/null 2>&1; then fail "a typo is fetched"; fi
"$fetch" "$address" "$work/f" >/dev/null 2>&1 || fail "a typo locks the folder"
if "$fetch" "file://$work/none.zip" "$work/d" >/dev/null 2>&1; then fail "a missing file is fetched"; fi
if "$fetch" no_such_set "$work/d" >/dev/null 2>"$work/log"; then fail "an unknown name is taken"; fi
grep -q "there is no set 'no_such_set'" "$work/log" || fail "the unknown name is not named"
echo "fetch.sh: all well"
