# SPDX-License-Identifier: Apache-2.0
"""What pip is given: a wheel that it installs and checks, and the sources. CMake's build is not repeated."""
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tarfile

import pytest

import splinevox as sv

ROOT = pathlib.Path(__file__).parents[2]


@pytest.fixture
def backend(monkeypatch):
    spec = importlib.util.spec_from_file_location("cmake_wheel", ROOT / "src/python/cmake_wheel.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)

    def install(folder, words):
        shutil.copytree(pathlib.Path(sv.__file__).parent, folder + "/splinevox")
        pathlib.Path(folder, "share").mkdir()
        pathlib.Path(folder, "share/copyright").touch()  # Debian's

    monkeypatch.setattr(module, "_install", install)
    return module


@pytest.mark.skipif(importlib.util.find_spec("pip") is None, reason="there is no pip")
def test_pip_installs_the_wheel(backend, tmp_path):
    name = backend.build_wheel(str(tmp_path))
    assert name.startswith(f"splinevox-{sv.__version__}-cp3") and "linux" in name
    into = tmp_path / "site"
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-index", "--no-deps", "--target", into,
                    tmp_path / name], check=True)
    code = "import splinevox, sys; print(splinevox.__file__, splinevox.__version__)"
    told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True,
                          cwd=tmp_path, env={"PYTHONPATH": str(into)}).stdout.split()
    assert told == [str(into / "splinevox/__init__.py"), sv.__version__]
    info = next(into.glob("*.dist-info"))
    assert {path.name for path in into.iterdir()} == {"splinevox", info.name}
    assert "Apache License" in (info / "licenses/LICENSE").read_text()
    assert "Requires-Dist: numpy" in (info / "METADATA").read_text()
    assert "splinevox/__init__.pyi,sha256=" in (info / "RECORD").read_text()


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="the sources are not git's")
def test_the_sources_are_what_git_has(backend, tmp_path):
    with tarfile.open(tmp_path / backend.build_sdist(str(tmp_path))) as archive:
        names = archive.getnames()
    wanted = ["PKG-INFO", "pyproject.toml", "CMakeLists.txt", "src/python/cmake_wheel.py"]
    assert {f"splinevox-{sv.__version__}/{name}" for name in wanted} <= set(names)
    assert not any("/build/" in n for n in names)
