#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""sbom.py BUNDLE BUILD LIBRARY... : what a bundle holds of others, as SPDX 2.3 in
BUNDLE/splinevox.spdx.json, and the licences' texts in BUNDLE/licences/PACKAGE.

LIBRARY: the files that became BUNDLE/lib, where they lay. What is compiled into the programs is told by
BUILD: every header that ninja saw being read there, and files embedded as they are. Each must be of a Debian
package, or of NVIDIA's toolkit: whose licence cannot be told is refused.
"""
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import urllib.parse
import uuid

COMMON = pathlib.Path("/usr/share/common-licenses")
# Debian's short names of licences whose SPDX names differ by more than small and capital letters.
SPDX_NAMES = {
    "expat": "MIT", "mit": "MIT", "apache-2.0": "Apache-2.0", "apache-2": "Apache-2.0", "zlib": "Zlib",
    "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause", "bsl-1.0": "BSL-1.0", "isc": "ISC",
    "mpl-2.0": "MPL-2.0", "mpl-2": "MPL-2.0", "libpng": "Libpng", "cc0-1.0": "CC0-1.0", "ntp": "NTP",
    "bsd-variant": "bzip2-1.0.6",
}
for family in ("GPL", "LGPL", "AGPL"):
    for version in ("1", "2", "2.1", "3"):
        full = version if "." in version else version + ".0"
        SPDX_NAMES[f"{family}-{version}".lower()] = f"{family}-{full}-only"
        SPDX_NAMES[f"{family}-{version}+".lower()] = f"{family}-{full}-or-later"
        SPDX_NAMES[f"{family}-{full}".lower()] = f"{family}-{full}-only"
        SPDX_NAMES[f"{family}-{full}+".lower()] = f"{family}-{full}-or-later"
# Their copyright files are prose, which no program reads; all binaries of GCC's runtime have its exception.
GCC_RUNTIME = "GPL-3.0-or-later WITH GCC-exception-3.1"
PROSE = {"gcc-12-base": GCC_RUNTIME, "gcc-13-base": GCC_RUNTIME, "gcc-14-base": GCC_RUNTIME}
CUDA = r"/usr/local/cuda[^/]*/"
# The system's own interfaces, which every program is compiled with.
SYSTEM = {"libc6-dev", "linux-libc-dev"}


def run(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def toolkit_entry(build, licences, folder):
    """Of NVIDIA's toolkit, whose runtime is linked statically into builds with CUDA kernels."""
    found = next(pathlib.Path(build).glob("CMakeFiles/*/CMakeCUDACompiler.cmake")).read_text()
    version = re.search(r'CUDA_COMPILER_VERSION "(.*)"', found).group(1)
    root = pathlib.Path(re.search(r'CUDA_COMPILER_TOOLKIT_ROOT "(.*)"', found).group(1))
    told = ("NVIDIA's End User License Agreement of the CUDA Toolkit, https://docs.nvidia.com/cuda/eula; its "
            "attachment A lists cudart as what programs may bring with them")
    licence = licences.own("cuda-toolkit", "EULA", told)
    # The toolkit has the text at its root; installed as Python packages, with each part; or not at all.
    texts = [*root.glob("EULA.txt"), *root.glob("dist-info/nvidia_cuda_runtime-*/licenses/*")]
    text = texts[0].read_text(errors="replace") if texts else told + f" (its text was not in {root})\n"
    (folder / "cuda-toolkit").write_text(text)
    return {"SPDXID": spdx_id("Package", "cuda-toolkit"), "name": "cuda-toolkit", "versionInfo": version,
            "supplier": "Organization: NVIDIA", "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
            "licenseConcluded": "NOASSERTION", "licenseDeclared": licence, "copyrightText": "NOASSERTION"}


def owners(paths):
    """{path: package}. /lib and /usr/lib are the same folder, but dpkg knows a file by one of them."""
    spellings = {}
    for path in paths:
        real = os.path.realpath(path)
        for spelling in (path, real, re.sub("^/usr/", "/", real), re.sub("^/lib", "/usr/lib", path)):
            spellings.setdefault(spelling, path)
    answer = subprocess.run(["xargs", "-0", "dpkg-query", "-S"], input="\0".join(spellings),
                            capture_output=True, text=True).stdout
    found = {}
    for line in answer.splitlines():
        package, _, path = line.partition(": ")
        if path in spellings and not package.startswith("diversion "):
            found[spellings[path]] = package.split(",")[0]
    lost = sorted(set(paths) - set(found))
    if lost:
        more = f" and {len(lost) - 1} more" if lost[1:] else ""
        sys.exit(f"sbom.py: no Debian package owns {lost[0]}{more}, "
                 "so its licence cannot be told; build with the packages that ./dev setup installs")
    return found


def compiled_in(build):
    """Foreign files that are part of the programs: headers that were read, and embedded scripts."""
    files, own = set(), (str(pathlib.Path(__file__).resolve().parents[1]) + "/",
                        str(pathlib.Path(build).resolve()) + "/")
    for line in run("ninja", "-C", build, "-t", "deps").splitlines():
        path = line.strip()
        if line.startswith("    /") and not os.path.realpath(path).startswith(own):
            files.add(path)
    cache = pathlib.Path(build, "CMakeCache.txt").read_text()
    files |= set(re.findall(r"^SPLINEVOX_CHART_JS:\w+=(.+)$", cache, re.M))
    files |= set(re.findall(r"^CUDA_cudart_static_LIBRARY:\w+=(.+\.a)$", cache, re.M))
    return files


def paragraphs(text):
    """Those of a copyright file that a program can read: [{field: value}]."""
    out = []
    for block in re.split(r"\n\s*\n", text):
        fields = re.findall(r"^([A-Za-z-]+):(.*(?:\n[ \t].*)*)", block, re.M)
        if fields:
            out.append({name: value.strip() for name, value in fields})
    return out


class Licences:
    """Licences that SPDX has no name for, and their texts."""

    def __init__(self):
        self.extracted = {}

    def own(self, package, name, text):
        key = "LicenseRef-" + re.sub(r"[^A-Za-z0-9.-]+", "-", f"{package}-{name}").strip("-")
        self.extracted[key] = text or f"see licences/{package}"
        return key

    def expression(self, package, short, texts):
        """An SPDX expression of Debian's, such as "GPL-2+ or Expat, and Zlib"."""
        words = re.split(r"\s*,?\s+(and|or)\s+", " ".join(short.split()), flags=re.I)
        names = [SPDX_NAMES.get(w.lower()) or self.own(package, w, texts.get(w.lower())) for w in words[::2]]
        out = names[0]
        for joint, name in zip(words[1::2], names[1:]):
            out += f" {joint.upper()} {name}"
        return f"({out})" if len(set(map(str.upper, words[1::2]))) > 1 else out

    def of_package(self, package, text, folder):
        """(expression of the package's own licence, its copyright, what the file names beside)"""
        if not re.match(r"Format(-Specification)?:", text):
            return PROSE.get(folder) or self.own(package, "copyright", text), "NOASSERTION", ""
        parts = paragraphs(text)
        texts = {p["License"].split("\n")[0].strip().lower(): p["License"].partition("\n")[2] for p in parts
                 if "License" in p}
        stanzas = [p for p in parts if "Files" in p and "License" in p]
        shorts = [p["License"].split("\n")[0].strip() for p in stanzas]
        main = next((i for i, p in enumerate(stanzas) if p["Files"].split()[0] == "*"), 0)
        others = {s for p, s in zip(stanzas, shorts) if not p["Files"].startswith("debian/")} - {shorts[main]}
        return (self.expression(package, shorts[main], texts), stanzas[main].get("Copyright", "NOASSERTION"),
                "parts of its sources are under: " + "; ".join(sorted(others)) if others else "")


def spdx_id(kind, name):
    return f"SPDXRef-{kind}-" + re.sub(r"[^A-Za-z0-9.-]+", "-", name.replace("+", "plus"))


def package_entry(name, licences, folder):
    """Of a Debian package; its copyright file goes to `folder`."""
    bare = name.split(":")[0]
    version, arch, source = run("dpkg-query", "-W", "-f", "${Version}\t${Architecture}\t${source:Package}",
                                name).split("\t")
    about = pathlib.Path("/usr/share/doc", bare, "copyright")
    if not about.exists():
        sys.exit(f"sbom.py: {about} is missing, so the licence of {bare} cannot be told; reinstall {bare} "
                 "(minimal images leave documents out: see path-exclude in /etc/dpkg/dpkg.cfg.d)")
    text = about.read_text(errors="replace")
    (folder / bare).write_text(text)
    for common in sorted(set(re.findall(r"common-licenses/([A-Za-z0-9.-]*[A-Za-z0-9])", text))):
        if (COMMON / common).exists():
            (folder / "common").mkdir(exist_ok=True)
            (folder / "common" / common).write_text((COMMON / common).read_text(errors="replace"))
    declared, holders, comment = licences.of_package(bare, text, about.resolve().parent.name)
    entry = {"SPDXID": spdx_id("Package", bare), "name": bare, "versionInfo": version,
             "supplier": "Organization: Debian", "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
             "sourceInfo": f"binary of the source package {source}", "licenseConcluded": "NOASSERTION",
             "licenseDeclared": declared, "copyrightText": holders,
             "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                               "referenceLocator": "pkg:deb/debian/%s@%s?arch=%s" % tuple(
                                   urllib.parse.quote(part, safe="") for part in (bare, version, arch))}]}
    return entry | ({"licenseComments": comment} if comment else {})


def file_entry(bundle, path):
    data, name = path.read_bytes(), str(path.relative_to(bundle))
    return {"SPDXID": spdx_id("File", name), "fileName": f"./{name}",
            "checksums": [{"algorithm": kind, "checksumValue": hashlib.new(kind.lower(), data).hexdigest()}
                          for kind in ("SHA1", "SHA256")],
            "licenseConcluded": "NOASSERTION", "copyrightText": "NOASSERTION"}


def moment():
    """Of the sources, so that the same sources make the same document; else now."""
    stamp = os.environ.get("SOURCE_DATE_EPOCH") or subprocess.run(
        ["git", "log", "-1", "--format=%ct"], capture_output=True, text=True).stdout.strip()
    when = datetime.datetime.now(datetime.timezone.utc)
    if stamp:
        when = datetime.datetime.fromtimestamp(int(stamp), datetime.timezone.utc)
    return when.strftime("%Y-%m-%dT%H:%M:%SZ")


def main(bundle, build, *libraries):
    bundle = pathlib.Path(bundle)
    version = run(bundle / "bin/splinevox", "--version").split()[-1]
    embedded = compiled_in(build)
    library_of = owners(libraries)
    inside = owners({path for path in embedded if not re.match(CUDA, path)})
    folder = bundle / "licences"
    folder.mkdir(exist_ok=True)
    licences = Licences()
    linked, static = set(library_of.values()), set(inside.values())
    static = {package for package in static if package.split(":")[0] not in SYSTEM}
    packages = {name: package_entry(name, licences, folder) for name in sorted(linked | static)}
    if any(re.match(CUDA, path) for path in embedded):
        packages["cuda-toolkit"] = toolkit_entry(build, licences, folder)
        static.add("cuda-toolkit")
    files = [file_entry(bundle, p) for p in sorted(bundle.rglob("*")) if p.is_file()
             and p.relative_to(bundle).parts[0] in ("bin", "lib")]
    sums = sorted(f["checksums"][0]["checksumValue"] for f in files)
    own = {"SPDXID": "SPDXRef-Package-splinevox", "name": "splinevox", "versionInfo": version,
           "downloadLocation": "NOASSERTION", "filesAnalyzed": True, "licenseConcluded": "Apache-2.0",
           "licenseDeclared": "Apache-2.0", "licenseInfoFromFiles": ["NOASSERTION"],
           "copyrightText": "NOASSERTION", "hasFiles": [f["SPDXID"] for f in files],
           "packageVerificationCode": {
               "packageVerificationCodeValue": hashlib.sha1("".join(sums).encode()).hexdigest()}}
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", own["SPDXID"])]
    relations += [(own["SPDXID"], "DYNAMIC_LINK", packages[p]["SPDXID"]) for p in sorted(linked)]
    relations += [(own["SPDXID"], "STATIC_LINK", packages[p]["SPDXID"]) for p in sorted(static)]
    relations += [(spdx_id("File", f"lib/{os.path.basename(path)}"), "GENERATED_FROM", packages[p]["SPDXID"])
                  for path, p in sorted(library_of.items())]
    document = {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"splinevox-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/splinevox-{version}-"
                             f"{uuid.uuid5(uuid.NAMESPACE_OID, ' '.join(sums))}",
        "creationInfo": {"created": moment(), "creators": ["Tool: splinevox-sbom"]},
        "packages": [own, *packages.values()], "files": files,
        "hasExtractedLicensingInfos": [{"licenseId": key, "extractedText": text}
                                       for key, text in sorted(licences.extracted.items())],
        "relationships": [dict(zip(("spdxElementId", "relationshipType", "relatedSpdxElement"), r))
                          for r in relations]}
    (bundle / "splinevox.spdx.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
