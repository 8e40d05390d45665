#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# bundle.sh BUILD OUT : what is needed to run splinevox elsewhere, in one folder: the program, the parity
# tests, and the shared libraries they use, except glibc and the driver's, with what they are and their
# licences (sbom.py), and the same as OUT.tar.gz. For machines with a glibc at least as new as the one here
# and no packages.
set -euo pipefail
build=$1 out=$2
limit_mb=60
programs=("$build/src/cli/splinevox" "$build/tests/backend/test_backend")
command -v patchelf >/dev/null || { echo "bundle.sh needs patchelf" >&2; exit 1; }
if [[ -n $(ls -A "$out" 2>/dev/null) && ! -x $out/bin/splinevox ]]; then
  echo "bundle.sh: $out holds something else than a bundle: give a folder that is new or empty" >&2
  exit 2
fi
rm -rf -- "$out"
mkdir -p "$out/bin" "$out/lib"
cmake --install "$build" --component program --prefix "$(realpath "$out")" --strip >/dev/null
for program in "${programs[@]}"; do
  [[ $program == */splinevox ]] || install -s "$program" "$out/bin/"
  # An RPATH and not a RUNPATH: it also counts for what the libraries themselves ask for.
  patchelf --force-rpath --set-rpath '$ORIGIN/../lib' "$out/bin/$(basename "$program")"
done
mapfile -t libraries < <(ldd "${programs[@]}" | awk '$2 == "=>" && $3 ~ /^\// {print $3}' | sort -u |
  grep -Ev '/(ld-linux.*|libc|libm|libdl|librt|libpthread|libresolv|libutil|libanl|libnss_[a-z]*)\.so' |
  grep -Ev '/(libcuda|libnvidia-[a-z]*)\.so')
for library in "${libraries[@]}"; do
  install -m 644 "$(readlink -f "$library")" "$out/lib/$(basename "$library")"
  # One with a RUNPATH of its own would look there alone.
  patchelf --remove-rpath "$out/lib/$(basename "$library")"
done
strip --strip-unneeded "$out"/lib/*
install -m 644 "$(dirname "$0")/../LICENSE" "$out/"
"$(dirname "$0")/sbom.py" "$out" "$build" "${libraries[@]}"
cat > "$out/test-gpu" <<'END'
#!/bin/sh
# The parity tests: every kernel on the host's threads, and on a CUDA device where one is.
exec "$(dirname "$0")/bin/test_backend" "$@"
END
chmod +x "$out/test-gpu"
# awk reads to the end: head would stop ldd with a signal now and then
glibc=$(ldd --version | awk 'NR == 1 {print $NF}')
cat > "$out/README" <<END
splinevox and the libraries it needs. Runs on Linux with glibc $glibc or newer; a CUDA driver is used
where there is one. The processor must know x86-64-v3 (AVX2).
  bin/splinevox train DATASET --out RUN --device cuda
  ./test-gpu
splinevox is under Apache-2.0 (LICENSE). splinevox.spdx.json lists what else is in here, and licences has the
texts of its licences.
END
missing=$(env -i PATH=/usr/bin:/bin ldd "$out"/bin/* | awk '/not found/ {print; next}
  $2 == "=>" && $0 !~ /\/bin\/\.\.\/lib\// &&
    $0 !~ /\/(libc|libm|libdl|librt|libpthread|libresolv)\.so/ {print}')
[[ -z $missing ]] || { printf 'the bundle would still look outside itself:\n%s\n' "$missing" >&2; exit 1; }
# libopenvdb alone is 55 MB unpacked, so the limit is for the archive, which is what travels.
tar -C "$(dirname "$out")" --sort=name --owner=0 --group=0 --numeric-owner \
  -czf "$out.tar.gz" "$(basename "$out")"
size=$(du -m "$out.tar.gz" | cut -f1)
((size < limit_mb)) || { echo "$out.tar.gz is $size MB, more than $limit_mb" >&2; exit 1; }
unpacked=$(du -sm "$out" | cut -f1)
echo "$out.tar.gz: $size MB; $out: $unpacked MB, ${#libraries[@]} libraries"
