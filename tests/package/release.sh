#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# release.sh BUILD FOLDER : a bundle and a release of a build that is there: the list of licences names all
# that is in it, the sums are those of the files, and what nobody knows the licence of is refused.
set -euo pipefail
build=$1 folder=$2 source=$(cd "$(dirname "$0")/../.." && pwd)
for program in patchelf dpkg-query ninja git; do
  command -v "$program" >/dev/null || { echo "skipped: no $program here"; exit 77; }
done
git -C "$source" rev-parse HEAD >/dev/null 2>&1 || { echo "skipped: no clone of the project"; exit 77; }
rm -rf "$folder" && mkdir -p "$folder/packages"
version=$("$build/src/cli/splinevox" --version)
name=splinevox-${version#splinevox } bundle=$folder/$name-$(uname -m)
"$source/cmake/bundle.sh" "$build" "$bundle"
env -i "$bundle/bin/splinevox" --version

echo "== the list of licences"
python3 - "$bundle" <<'END'
import hashlib, json, os, pathlib, re, subprocess, sys
bundle = pathlib.Path(sys.argv[1])
listed = json.loads((bundle / "splinevox.spdx.json").read_text())
packages = {p["SPDXID"]: p for p in listed["packages"]}
files = {f["fileName"]: f for f in listed["files"]}
relations = [tuple(r[k] for k in ("spdxElementId", "relationshipType", "relatedSpdxElement"))
             for r in listed["relationships"]]
there = {f"./{p.relative_to(bundle)}": p for part in ("bin", "lib") for p in (bundle / part).iterdir()}
assert set(files) == set(there), set(files) ^ set(there)
for name, path in there.items():
    sums = {c["algorithm"]: c["checksumValue"] for c in files[name]["checksums"]}
    assert sums["SHA256"] == hashlib.sha256(path.read_bytes()).hexdigest(), name
    origins = [packages[to] for of, kind, to in relations
               if of == files[name]["SPDXID"] and kind == "GENERATED_FROM"]
    assert len(origins) == (name.startswith("./lib/")), (name, origins)
known = {*packages, *(f["SPDXID"] for f in listed["files"]), "SPDXRef-DOCUMENT"}
assert len(known) == len(packages) + len(files) + 1
for of, kind, to in relations:
    assert of in known and to in known, (of, kind, to)
defined = {e["licenseId"] for e in listed["hasExtractedLicensingInfos"]}
used = set()
for package in packages.values():
    assert package["licenseDeclared"] not in ("", "NOASSERTION"), package["name"]
    used |= set(re.findall(r"LicenseRef-[A-Za-z0-9.-]+", package["licenseDeclared"]))
    if package["name"] == "splinevox":
        continue
    assert (bundle / "licences" / package["name"]).stat().st_size > 0
    if package["supplier"] != "Organization: Debian":
        assert package["name"] == "cuda-toolkit" and package["versionInfo"], package
        continue
    version = subprocess.run(["dpkg-query", "-W", "-f", "${Version}\n", package["name"]], check=True,
                             capture_output=True, text=True).stdout.splitlines()
    assert package["versionInfo"] in version, package
assert used == defined, used ^ defined
names = {p["name"]: p["licenseDeclared"] for p in packages.values()}
for name, licence in {"libjs-chart.js": "MIT", "libcli11-dev": "BSD-3-Clause", "nlohmann-json3-dev": "MIT",
                      "libtomlplusplus-dev": "MIT", "doctest-dev": None, "zlib1g": "Zlib"}.items():
    assert name in names and licence in (None, names[name]), (name, names.get(name))
print(len(files), "files,", len(packages) - 1, "packages of others")
END
cp "$build/src/cli/splinevox" "$folder/foreign.so"
if "$source/cmake/sbom.py" "$bundle" "$build" "$folder/foreign.so" 2>"$folder/said"; then
  echo "a library that no package owns passes"
  exit 1
fi
grep -q "no Debian package owns $folder/foreign.so" "$folder/said"

echo "== the release"
echo package >"$folder/packages/splinevox_${version#splinevox }_amd64.deb"
"$source/cmake/release.sh" "$bundle.tar.gz" "$folder/packages" "$folder/release"
cd "$folder/release"
sha256sum --quiet --strict -c SHA256SUMS
diff <(cut -c67- SHA256SUMS) <(LC_ALL=C ls | grep -v SHA256SUMS)
tar -tzf "$name.tar.gz" "$name/src/cli/main.cpp" >/dev/null
echo other >>"splinevox_${version#splinevox }_amd64.deb"
! sha256sum --quiet -c SHA256SUMS 2>/dev/null || { echo "a changed file passes"; exit 1; }
mkdir "$folder/else" && touch "$folder/else/mine"
! "$source/cmake/release.sh" "$bundle.tar.gz" "$folder/packages" "$folder/else" 2>/dev/null ||
  { echo "a folder with other files is emptied"; exit 1; }
[[ -f $folder/else/mine ]]
rm -rf "$folder"
