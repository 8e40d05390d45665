# SPDX-License-Identifier: Apache-2.0
"""How pip makes a wheel of this repository (PEP 517): CMake builds the module and installs it into the wheel.

It needs no package of Python's. `--config-settings cmake="-DSPLINEVOX_NATIVE=OFF"` gives CMake more words.
"""
import base64
import hashlib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).parents[2]
BUILD = ROOT / "build" / "wheel"


def _project():
    table = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    version = re.search(r"^project\(splinevox VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)
    return table, version.group(1)


def _metadata():
    table, version = _project()
    lines = ["Metadata-Version: 2.1", "Name: " + table["name"], "Version: " + version,
             "Summary: " + table["description"], "License: " + table["license"]["text"],
             "Requires-Python: " + table["requires-python"], "Description-Content-Type: text/markdown"]
    lines += ["Requires-Dist: " + name for name in table["dependencies"]]
    return "\n".join(lines) + "\n\n" + (ROOT / table["readme"]).read_text()


def _tag():
    python = "cp%d%d" % sys.version_info[:2]
    return f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def _cmake(*words):
    try:
        subprocess.run(["cmake", *map(str, words)], check=True)
    except FileNotFoundError:
        sys.exit("there is no cmake: CMake 3.25 and the packages of `./dev setup` are needed")
    except subprocess.CalledProcessError:
        sys.exit("splinevox was not built, see above; `./dev python` installs what it needs")


def _install(folder, words):
    """Builds the module for the Python that pip runs and puts it into a folder."""
    _cmake("-S", ROOT, "-B", BUILD, "-DSPLINEVOX_PYTHON=ON", "-DSPLINEVOX_TESTS=OFF",
           "-DPython_EXECUTABLE=" + sys.executable, "-DSPLINEVOX_PYTHON_FOLDER=.", "-Wno-dev", *words)
    jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", os.cpu_count())
    _cmake("--build", BUILD, "--target", "splinevox_python", "--parallel", jobs)
    _cmake("--install", BUILD, "--component", "python", "--prefix", folder)


def _record(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    table, version = _project()
    stem = f"{table['name']}-{version}"
    info, record = f"{stem}.dist-info/", ""
    with tempfile.TemporaryDirectory() as staging:
        _install(staging, shlex.split((config_settings or {}).get("cmake", "")))
        # The module alone: the copyright beside it is where Debian wants it.
        files = {str(path.relative_to(staging)): path.read_bytes()
                 for path in sorted(pathlib.Path(staging, "splinevox").rglob("*")) if path.is_file()}
    files[info + "licenses/LICENSE"] = pathlib.Path(ROOT, "LICENSE").read_bytes()
    files[info + "METADATA"] = _metadata().encode()
    files[info + "WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: splinevox\nRoot-Is-Purelib: false\n"
                             f"Tag: {_tag()}\n").encode()
    name = f"{stem}-{_tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(path, data)
            record += _record(path, data)
        wheel.writestr(info + "RECORD", record + info + "RECORD,,\n")
    return name


def build_sdist(sdist_directory, config_settings=None):
    """What git has of the tree."""
    table, version = _project()
    stem = f"{table['name']}-{version}"
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], check=True, capture_output=True)
    path = pathlib.Path(sdist_directory) / f"{stem}.tar.gz"
    with tarfile.open(path, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for name in filter(None, listed.stdout.decode().split("\0")):
            archive.add(ROOT / name, f"{stem}/{name}", recursive=False)
        with tempfile.NamedTemporaryFile("w", suffix="PKG-INFO") as info:
            info.write(_metadata())
            info.flush()
            archive.add(info.name, f"{stem}/PKG-INFO")
    return path.name
