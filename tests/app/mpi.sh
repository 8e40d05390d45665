#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# mpi.sh PROGRAM FOLDER : two ranks against one, and against themselves. 77: skipped.
set -euo pipefail
program=$1 folder=$2
if ! command -v mpirun >/dev/null; then
  echo "skipped: there is no 'mpirun' on this machine (apt-get install openmpi-bin)"
  exit 77
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_btl_vader_single_copy_mechanism=none
ranks() { local n=$1; shift; mpirun -n "$n" "$program" "$@"; }
figure() { sed -n "s/^ *\"$2\": \([-0-9.e]*\),*$/\1/p" "$1/metrics.json" | head -n 1; }
check() { echo "$1"; shift; "$@" || { echo "  that is not so: $*"; exit 1; }; }
rm -rf "$folder" && mkdir -p "$folder"
cd "$folder"
"$program" synth dancer --out scene --frames 12 --size 48 --quiet
common=(train scene --device cpu --preset draft --max-steps 80 --effects all --set sampling.rays=1024
  --set sampling.occupancy_cells=24 --set grid.motion=4,8 --set grid.motion_start=0,0.2
  --set grid.radiance=12,20 --set grid.radiance_start=0,0.5 --threads 1 --quiet)

"$program" "${common[@]}" --out one
ranks 2 "${common[@]}" --out two
ranks 2 "${common[@]}" --out again
check "two ranks give the same bits again" cmp two/model.vdb again/model.vdb
"$program" verify two >/dev/null
for run in one two; do "$program" eval $run --threads 1 >/dev/null; done
echo "PSNR with one rank $(figure one psnr), with two $(figure two psnr);" \
  "bytes a step and rank $(figure two bytes_per_step)"
check "PSNR within 0.5 dB" awk -v a="$(figure one psnr)" -v b="$(figure two psnr)" \
  'BEGIN {exit !(a - b < 0.5 && b - a < 0.5)}'
check "something was sent" awk -v b="$(figure two bytes_per_step)" 'BEGIN {exit !(b > 1000)}'

"$program" synth dancer --out other --frames 12 --size 48 --seed 2 --quiet
sizes=("${common[@]:2}")
code=0
mpirun -n 1 "$program" train scene "${sizes[@]}" --out apart : \
  -n 1 "$program" train other "${sizes[@]}" --out apart 2>told || code=$?
check "ranks with other pictures are refused" test $code -ne 0
check "and it says so" grep -q "has other training pictures than the first" told

echo "stopped by a signal to one rank, and gone on with"
mpirun -n 2 "$program" "${common[@]}" --out half &
launcher=$!
for _ in $(seq 600); do
  [[ -e half/metrics.jsonl ]] && break
  sleep 0.05
done
kill -TERM "$(pgrep -P $launcher | tail -n 1)"
wait $launcher || true
check "it had not finished" grep -q '"finished": false' half/metrics.json
ranks 2 train scene --device cpu --out half --resume --threads 1 --quiet
check "the same bits" cmp two/model.vdb half/model.vdb

echo "frames and pictures in shares"
"$program" export two --out frames --frames 1-5 --threads 1 --quiet
ranks 2 export two --out frames2 --frames 1-5 --threads 1 >told
check "two ranks export the same files" diff -r frames frames2
check "and one of them tells so" test "$(grep -c 'made by 2 processes' told)" = 1
"$program" render two --out views --camera dataset:test --threads 1 --quiet
ranks 2 render two --out views2 --camera dataset:test --threads 1 --quiet
check "two ranks render the same pictures" diff -r views views2

echo "an error ends all ranks, with its exit code"
code=0
ranks 2 train nowhere --out none --quiet 2>errors || code=$?
check "exit code 2" test $code = 2
grep -q nowhere errors
