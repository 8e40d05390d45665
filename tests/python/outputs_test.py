# SPDX-License-Identifier: Apache-2.0
"""What comes out: exports, edits, pages and OpenEXR, the same as those of the command line; pickles."""
import copy
import json
import pathlib
import pickle
import signal
import threading
import time

import numpy as np
import pytest

import splinevox as sv
from conftest import program


def test_an_export_is_the_same_files(run, tmp_path):
    told = []
    frames = sv.export(sv.open_run(run), str(tmp_path / "py"), frames=(1, 3), fps=12, flame=True,
                       callback=told.append)
    program("export", run, "--out", tmp_path / "cli", "--frames", "1-3", "--fps", 12, "--flame", "--quiet")
    assert [f["frame"] for f in frames] == [1, 2, 3] and frames == told
    assert frames[2]["time"] == 1 and frames[0]["density_voxels"] > 0
    for f in frames:
        (name,) = f["files"]
        assert (tmp_path / "py" / name).read_bytes() == (tmp_path / "cli" / name).read_bytes()
    manifests = [json.loads((tmp_path / k / "manifest.json").read_text()) for k in ("py", "cli")]
    assert manifests[0] == manifests[1]


def test_points_of_an_export_are_chosen_or_given(model, tmp_path):
    for points in (2, np.int64(2), [[0, 0, 0], [0.1, 0, 0]]):
        sv.export(model, str(tmp_path), profile="usd", frames=(1, 1), points=points, afresh=True)
        assert "int64[] ids = [0, 1]" in (tmp_path / "points.usda").read_text()


def test_an_export_that_is_stopped_goes_on(model, tmp_path):
    first = sv.export(model, str(tmp_path), frames=(1, 4), callback=lambda f: False)
    assert 1 <= len(first) < 4 and not (tmp_path / "manifest.json").exists()
    again = sv.export(model, str(tmp_path), frames=(1, 4))
    assert [f["kept"] for f in again].count(True) == len(first) and (tmp_path / "manifest.json").exists()
    with pytest.raises(sv.InputError, match="profile"):
        sv.export(model, str(tmp_path / "other"), profile="maya")


def test_control_c_ends_an_export_which_goes_on(model, tmp_path):
    told, heard = [], threading.Event()

    def on_signal(*_):
        heard.set()
        raise KeyboardInterrupt

    def interrupt(frame):
        told.append((frame["frame"], threading.current_thread() is threading.main_thread()))
        signal.raise_signal(signal.SIGINT)
        assert heard.wait(60)  # by the main thread
        time.sleep(0.1)  # in which it asks for the end

    before = signal.signal(signal.SIGINT, on_signal)

    try:
        with pytest.raises(KeyboardInterrupt):
            sv.export(model, str(tmp_path), frames=(1, 6), callback=interrupt)
    finally:
        signal.signal(signal.SIGINT, before)
    assert told == [(1, False)] and not (tmp_path / "manifest.json").exists()
    frames = sv.export(model, str(tmp_path), frames=(1, 6))
    assert [f["kept"] for f in frames] == [True] + 5 * [False]


def test_an_exception_in_the_callback_of_an_export_comes_out(model, tmp_path):
    def wrong(frame):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        sv.export(model, str(tmp_path), frames=(1, 4), callback=wrong)
    assert len(sv.export(model, str(tmp_path), frames=(1, 4))) == 4


def test_an_edit_is_the_same_file(run, tmp_path):
    edited = sv.edit(run, str(tmp_path / "py"), ["reverse", ("speed", 0.5)])
    program("edit", run, "--out", tmp_path / "cli", "--reverse", "--speed", 0.5, "--quiet")
    assert (tmp_path / "py/model.vdb").read_bytes() == (tmp_path / "cli/model.vdb").read_bytes()
    assert edited.path == str(tmp_path / "py")
    with pytest.raises(sv.InputError, match="another folder"):
        sv.edit(edited, str(tmp_path / "py"), ["reverse"])
    for wrong in (["spin"], [("speed", 1, 2)], []):
        with pytest.raises(sv.InputError):
            sv.edit(edited, str(tmp_path / "other"), wrong)


def test_pages_are_those_of_the_command_line(run, tmp_path):
    opened = sv.open_run(run)
    assert sv.view(opened, str(tmp_path / "py.html"), views=2) == []
    program("view", run, "--out", tmp_path / "cli.html", "--views", 2)
    assert (tmp_path / "py.html").read_bytes() == (tmp_path / "cli.html").read_bytes()
    sv.report(pathlib.Path(run), str(tmp_path / "py_report.html"), views=1)
    program("report", run, "--out", tmp_path / "cli_report.html", "--views", 1)
    assert (tmp_path / "py_report.html").read_bytes() == (tmp_path / "cli_report.html").read_bytes()
    assert sv.view(opened, str(tmp_path / "without.html"), data=str(tmp_path))  # says what it lacks
    with pytest.raises(sv.InputError, match="does not fit"):
        sv.view(run, str(tmp_path / "small.html"), max_mb=0.001)


def test_exr_layers_come_back(model, data, tmp_path):
    camera = data.frames("test")[0].camera
    r = model.render(camera, 0.5)
    path = str(tmp_path / "layers.exr")
    sv.write_exr(path, {"": np.dstack([r.rgb, r.alpha]), "depth": r.depth}, camera, fps=24, frame=7, time=0.5)
    again = sv.read_exr(path)
    assert again.keys() == {"", "depth"}
    assert np.array_equal(again[""], np.dstack([r.rgb, r.alpha])) and np.array_equal(again["depth"], r.depth)
    for wrong in ({}, {"a": np.zeros((2, 2)), "b": np.zeros((3, 2))}, {"a": np.zeros((2, 2, 5))}):
        with pytest.raises(sv.InputError):
            sv.write_exr(path, wrong)


def test_pickles_are_the_same_things(run, model, data, config):
    camera = data.frames("test")[0].camera
    again = pickle.loads(pickle.dumps(camera))
    assert np.array_equal(again.camera_to_world, camera.camera_to_world)
    assert (again.fx, again.cy, again.width) == (camera.fx, camera.cy, camera.width)
    assert np.array_equal(model.render(again, 0.3).rgb, model.render(camera, 0.3).rgb)
    for c in (config, sv.Config("high"), sv.Config("paper", settings={"grid.box": [-1, -1, -1, 1, 1, 1]})):
        assert pickle.loads(pickle.dumps(c)) == c == copy.deepcopy(c) and c != sv.Config("fast", seed=99)
    twin = pickle.loads(pickle.dumps(model))
    assert np.array_equal(twin.render(camera, 0.3).rgb, model.render(camera, 0.3).rgb)
    opened = pickle.loads(pickle.dumps(sv.open_run(run)))
    assert opened.path == run and opened.config == sv.open_run(run).config


def test_things_say_what_they_are(run, model, data, config):
    assert eval(repr(config), {"splinevox": sv}) == config
    frame = data.frames("test")[0]
    for thing, says in ((data, "test"), (frame, frame.name), (frame.camera, "32x32"), (model, "points"),
                        (sv.open_run(run), "preset draft"), (sv.Trainer(data, config), "not done"),
                        (sv.prepare(config, data, choose=False), "motion")):
        assert says in repr(thing) and repr(thing).startswith("<splinevox.")
