# SPDX-License-Identifier: Apache-2.0
import json
import os
import subprocess

import pytest

import splinevox as sv

SMALL = {"grid.radiance": [12, 16], "grid.radiance_start": [0, 0.5], "grid.motion": [4, 8],
         "grid.motion_start": [0, 0.2], "sampling.rays": 512, "sampling.occupancy_cells": 24}
STEPS = 60
BOX = [[-1.25, -1.5, -0.5], [1.5, 1.25, 2.0]]


def sets(settings):
    """Settings as words of the command line."""
    def text(value):
        return ",".join(map(str, value)) if isinstance(value, list) else str(value)

    return [word for key, value in settings.items() for word in ("--set", key + "=" + text(value))]


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
    program("train", scene, "--out", folder, "--preset", "draft", "--max-steps", STEPS, "--effects", "all",
            "--quiet", *sets(SMALL))
    return folder


@pytest.fixture(scope="session")
def opaque_scene(tmp_path_factory):
    """Opaque pictures, and a box that says where the scene lies."""
    folder = tmp_path_factory.mktemp("opaque")
    sv.write_synth("ball", str(folder), frames=10, size=32)
    data = sv.load_dataset(str(folder))
    for split in data.splits:
        for frame in data.frames(split):
            sv.write_png(str(folder / split / (frame.name + ".png")), frame.composited([0.4, 0.5, 0.6]))
    train = folder / "transforms_train.json"
    train.write_text(json.dumps({**json.loads(train.read_text()), "scene_box": BOX}))
    return str(folder)
