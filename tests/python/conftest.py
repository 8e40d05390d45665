# SPDX-License-Identifier: Apache-2.0
import os
import subprocess

import pytest

import splinevox as sv

SMALL = {"grid.radiance": [12, 16], "grid.radiance_start": [0, 0.5], "sampling.rays": 512}
STEPS = 60


def program(*words):
    """Runs `splinevox WORDS...`, gives what it prints."""
    command = [os.environ["SPLINEVOX_PROGRAM"], *map(str, words)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="session")
def scene(tmp_path_factory):
    folder = str(tmp_path_factory.mktemp("scene"))
    sv.write_synth("dancer", folder, frames=10, size=32)
    return folder


@pytest.fixture(scope="session")
def data(scene):
    return sv.load_dataset(scene)


@pytest.fixture(scope="session")
def config():
    return sv.Config("draft", settings=SMALL, max_steps=STEPS, effects="all")


@pytest.fixture(scope="session")
def model(data, config):
    return sv.train(data, config)


@pytest.fixture(scope="session")
def run(scene, tmp_path_factory):
    """The same by the command line."""
    folder = str(tmp_path_factory.mktemp("runs") / "run")
    sets = []
    for key, value in SMALL.items():
        sets += ["--set", key + "=" + (",".join(map(str, value)) if isinstance(value, list) else str(value))]
    program("train", scene, "--out", folder, "--preset", "draft", "--max-steps", STEPS, "--effects", "all",
            "--quiet", *sets)
    return folder
