# SPDX-License-Identifier: Apache-2.0
"""Memory, threads, interrupts and errors."""
import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import splinevox as sv
from conftest import SMALL, STEPS


def test_pictures_of_a_data_set_are_copies(scene):
    frame = sv.load_dataset(scene).frames("test")[0]  # nothing else holds the data set
    gc.collect()
    image = frame.image
    assert image.dtype == np.uint16 and image.shape == (32, 32, 4) and image.flags.owndata
    assert image[..., 3].max() == 65535
    image[:] = 1
    assert frame.image[..., 3].max() == 65535
    del frame
    gc.collect()
    assert image[0, 0, 0] == 1


def test_rows_are_views_that_keep_the_model(model):
    mine = model.copy()
    density, control = mine.density, mine.control_points
    assert np.shares_memory(density, mine.density) and density.strides == mine.rgb.strides[:1]
    assert control.shape[1:] == (mine.points, 3) and mine.motion_positions().shape == (control.shape[0], 3)
    places = mine.radiance_positions()
    assert places.shape == (density.size, 3) and np.isnan(places[:512]).all()
    before = density.copy()
    del mine
    gc.collect()
    assert np.array_equal(density, before)


def test_what_is_written_into_a_view_is_rendered(model, data):
    camera = data.frames("test")[0].camera
    mine = model.copy()
    mine.rgb[:] = -20  # black
    mine.sh[:] = -20  # no rescale
    if mine.light is not None:
        mine.light[:] = 0
    full, black = model.render(camera, 0.5), mine.render(camera, 0.5)
    assert np.allclose(black.alpha, full.alpha, atol=1e-6)
    assert np.allclose(black.rgb, 1 - full.alpha[..., None], atol=1e-3)


def test_layers_have_their_shapes(model, data):
    camera = sv.Camera(24, 16, data.frames("test")[0].camera.camera_to_world, angle_x=0.7)
    layers = model.render(camera, 0.3)
    shapes = [getattr(layers, n).shape for n in ("rgb", "alpha", "depth", "flow", "rigidity")]
    assert shapes == [(16, 24, 3), (16, 24), (16, 24), (16, 24, 3), (16, 24)]
    assert layers.rgb.dtype == np.float32 and layers.rgb.flags.c_contiguous
    assert np.array_equal(model.render(camera, 2).rgb, model.render(camera, 1).rgb)
    with pytest.raises(sv.InputError, match="no such time"):
        model.render(camera, float("nan"))


def test_a_camera_is_what_it_was_made_of(data):
    camera = data.frames("train")[0].camera
    again = sv.Camera(camera.width, camera.height, camera.camera_to_world, camera.fx, camera.fy, camera.cx,
                      camera.cy)
    assert np.allclose(again.camera_to_world, camera.camera_to_world, atol=1e-12)
    assert (again.fx, again.cy) == (camera.fx, camera.cy)


def test_the_callback_hears_and_stops(data, config):
    heard = []
    assert sv.Trainer(data, config).train(lambda r: heard.append((r.step, r.loss > 0)), every=25)
    assert heard == [(25, True), (50, True), (STEPS, True)]
    trainer = sv.Trainer(data, config)
    assert not trainer.train(lambda r: False, every=7)
    assert not trainer.train(lambda r: np.mean([r.loss]) < 0, every=7)  # numpy's False
    assert trainer.step().step == 15 and not trainer.done
    trainer.train(lambda r: 0 if r.step < 20 else False, every=1)
    assert trainer.step().step == 21


def test_training_stops_where_it_was_and_goes_on_in_the_same_bits(data, config, model):
    trainer = sv.Trainer(data, config)
    trainer.train(lambda r: False, every=20)
    other = sv.Trainer(data, config)
    other.restore(trainer.save())
    assert other.train()
    assert np.array_equal(other.model().density, model.density)
    assert np.array_equal(other.model().control_points, model.control_points)


def test_an_exception_of_the_callback_comes_out(data, config):
    def callback(report):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        sv.train(data, config, callback)


def test_other_threads_run_while_it_trains(data, config):
    ticks, done = [0], threading.Event()

    def tick():
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    while not ticks[0]:
        time.sleep(0.001)
    before = ticks[0]
    sv.train(data, config)  # no callback: nothing gives the lock back but its release
    after = ticks[0]
    done.set()
    thread.join()
    assert after > before + 3


def test_control_c_interrupts_training(data):
    endless = sv.Config("draft", max_steps=10**8, effects="all")
    trainer = sv.Trainer(data, endless)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        trainer.train()
    assert trainer.step().step > 1  # as it was after its last step


def test_control_c_ends_trials_after_the_fit_under_way(scene):
    data = sv.load_dataset(scene)
    config = sv.Config("draft", settings={**SMALL, "effects.steps": 3000}, max_steps=10**6)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        sv.prepare(config, data)


def test_errors_are_those_of_the_command_line(data, config, model, tmp_path):
    with pytest.raises(sv.InputError) as caught:
        sv.load_dataset(str(tmp_path / "none"))
    error = caught.value
    assert isinstance(error, (sv.Error, ValueError)) and "none" in error.where
    assert error.where in str(error) and error.what in str(error)
    with pytest.raises(sv.InputError, match="tv_control"):
        sv.Config(settings={"loss.tv_contrl": 1})
    with pytest.raises(sv.InputError, match="out of range"):
        config.copy()["sampling.rays"] = -1
    with pytest.raises(sv.InputError, match="shape"):
        model.track(np.zeros((4, 2)), 0, [1])
    with pytest.raises(sv.InputError, match="such time"):
        model.warp(np.zeros((1, 3)), 1.5)
    with pytest.raises(sv.InputError, match="no split 'val2'"):
        data.frames("val2")
    with pytest.raises(sv.InputError, match="Camera"):
        sv.Camera(8, 8, np.zeros((4, 4)), angle_x=0.7)
    with pytest.raises(sv.OutputError):
        sv.save_model("/proc/none/model.vdb", model)
    assert issubclass(sv.OutputError, OSError) and issubclass(sv.NumericError, ArithmeticError)
    assert issubclass(sv.OutOfMemoryError, MemoryError) and issubclass(sv.OutOfMemoryError, sv.Error)


def test_lack_of_memory_is_no_fault_of_the_numbers(tmp_path, model):
    """In a process of its own, whose limit the reader's child passes once it is there."""
    path = str(tmp_path / "model.vdb")
    sv.save_model(path, model)
    code = """
import resource, sys
import splinevox as sv
pages = int(open("/proc/self/statm").read().split()[0])
refused = 0
for megabytes in (0, 1, 4, 16, 64):
    resource.setrlimit(resource.RLIMIT_AS, (4096 * pages + (megabytes << 20), resource.RLIM_INFINITY))
    try:
        sv.load_model(sys.argv[1])
    except MemoryError:
        refused += 1
sys.exit(0 if refused else "never refused")
"""
    subprocess.run([sys.executable, "-c", code, path], check=True)


def test_settings_go_in_and_come_out(config):
    mine = config.copy()
    mine["grid.motion"] = [8, 16]
    mine["motion.rigidity"] = np.bool_(False)
    mine["motion.points"] = np.int64(9)
    mine["motion.basis"] = "bezier"
    assert mine["grid.motion"] == [8, 16] and mine["motion.points"] == 9
    assert mine is not None and mine != None and mine not in [1, "a"]  # noqa: E711
    assert mine["motion.rigidity"] is False and mine["motion.basis"] == "bezier"
    assert config["motion.rigidity"] is True and config["run.max_steps"] == STEPS
    assert "basis = \"bezier\"" in mine.to_toml()


def test_draft_tries_no_effects_and_keeps_motion(data):
    chosen = sv.choose_effects(sv.Config("draft", max_steps=40), data)
    assert chosen["motion.enabled"] is True


def test_rows_are_views_of_one_memory(model):
    assert np.shares_memory(model.density, model.density)
