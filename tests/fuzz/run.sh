#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run.sh PROGRAMS OUT SECONDS [PARSER...] : libFuzzer on every parser or those named, as rows of a table.
set -euo pipefail
programs=$1 out=$2 seconds=$3 parsers=("${@:4}") failed=0
rm -rf "$out/seeds"  # of parsers that are no more
"$programs/fuzz_corpus" "$out/seeds"
((${#parsers[@]})) || mapfile -t parsers < <(ls "$out/seeds")
for parser in "${parsers[@]}"; do
  mkdir -p "$out/corpus/$parser"
  if "$programs/fuzz_$parser" "$out/corpus/$parser" "$out/seeds/$parser" \
      -max_total_time="$seconds" -timeout=2 -rss_limit_mb=6000 \
      -artifact_prefix="$out/${parser}_" > "$out/$parser.log" 2>&1; then
    runs=$(sed -n 's/^Done \([0-9]*\) runs.*/\1/p' "$out/$parser.log")
    printf '| %s | %s | none |\n' "$parser" "$runs"
  else
    failed=1
    fault=$(grep -m1 -E 'ERROR|SUMMARY|runtime error' "$out/$parser.log") || fault="see $out/$parser.log"
    printf '| %s | | %s |\n' "$parser" "$fault"
  fi
done
exit $failed
