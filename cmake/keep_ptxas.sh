#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# keep_ptxas.sh NVCC ARGUMENT... : runs nvcc and keeps what ptxas says about registers and spills in
# OBJECT.ptxas, for cuda_resources.sh.
set -uo pipefail
object=
for ((i = 1; i < $#; ++i)); do
  [[ ${!i} == -o ]] && { next=$((i + 1)); object=${!next}; }
done
log=$("$@" -Xptxas -v 2>&1)
code=$?
if [[ -n $object && $object == *.o && $code == 0 ]]; then
  printf '%s\n' "$log" | grep '^ptxas info\|^    [0-9]* bytes stack' > "$object.ptxas"
fi
printf '%s\n' "$log" | grep -v '^ptxas info\|^    [0-9]* bytes stack\|^$' >&2
exit $code
