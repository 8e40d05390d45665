# SPDX-License-Identifier: Apache-2.0
"""The module and the command line give the same numbers."""
import csv
import json
import re

import numpy as np
import pytest

import splinevox as sv
from conftest import BOX, SMALL, STEPS, program, sets

ROWS = ["density", "rgb", "sh", "control_points", "light", "presence", "rigidity"]


def rows(model):
    return {name: getattr(model, name) for name in ROWS if getattr(model, name) is not None}


def same_values(a, b):
    """Every stored value that either has: files keep only bricks with something in them, so rows are matched
    by place."""
    radiance, motion = "radiance_positions", "motion_positions"
    columns = [("density", radiance), ("rgb", radiance), ("sh", radiance), ("control_points", motion),
               ("light", motion), ("presence", motion), ("rigidity", motion)]
    assert {name for name, _ in columns} == set(ROWS)
    assert rows(a).keys() == rows(b).keys()
    for name, where in columns:
        if name not in rows(a):
            continue
        tables = []
        for m in (a, b):
            places, values = getattr(m, where)()[512:], np.ascontiguousarray(getattr(m, name)[512:])
            tables.append(dict(zip(map(bytes, places), map(bytes, values))))
        shared = tables[0].keys() & tables[1].keys()
        assert len(shared) >= 0.9 * min(map(len, tables)) > 0
        assert all(tables[0][key] == tables[1][key] for key in shared)


def test_every_grid_of_a_file_is_an_array_of_its_name(model, run):
    grids = {g["name"] for g in json.loads(program("info", run + "/model.vdb", "--json"))["grids"]}
    about = {name: getattr(sv.Model, name).__doc__ or "" for name in vars(sv.Model)}
    arrays = {name for name, text in about.items() if text.startswith("float32 (rows")}
    arrays -= {"radiance_positions", "motion_positions"}
    assert set(ROWS) == arrays
    families = {re.sub("_?[0-9]+$", "", g) for g in grids}
    found = {family: [a for a in arrays if a.startswith(family)] for family in families}
    assert all(len(names) == 1 for names in found.values()), found
    assert {names[0] for names in found.values()} == rows(sv.load_model(run + "/model.vdb")).keys()


def test_training_gives_the_same_bits(model, run):
    same_values(model, sv.load_model(run + "/model.vdb"))


@pytest.mark.parametrize("effects,ground", [("all", False), ("auto", False), ("auto", True)])
def test_opaque_pictures_train_to_the_same_file(opaque_scene, tmp_path, effects, ground):
    # few enough for 60 steps to try effects out
    settings = {**SMALL, "effects.steps": 6, "run.find_ground": str(ground).lower()}
    run = tmp_path / "run"
    words = ["--out", run, "--preset", "draft", "--max-steps", STEPS, "--effects", effects, "--quiet",
             *sets(settings)]
    program("train", opaque_scene, *words)
    data = sv.load_dataset(opaque_scene)
    assert not data.has_alpha and data.box == BOX
    config = sv.Config("draft", settings=settings, max_steps=STEPS, effects=effects)
    ready = sv.prepare(config, data, choose=effects == "auto")
    flat_box = sum(BOX, [])
    if ground:
        assert ready.config["grid.box"] == [] and "plain ground" in ready.notes[0]
        assert data.has_alpha and ready.config["sampling.background"] == "ground"
    else:
        assert ready.config["grid.box"] == flat_box and "the box is the data's own" in ready.notes[0]
    model = sv.train(data, ready.config)
    opened = sv.open_run(str(run))
    assert opened.config.to_toml() == ready.config.to_toml() and opened.notes["preset"] == "draft"
    sv.save_model(str(tmp_path / "py.vdb"), model, opened.notes)
    assert (tmp_path / "py.vdb").read_bytes() == (run / "model.vdb").read_bytes()
    told = json.loads((run / "effects.json").read_text())
    assert ready.effects["used"] == told["used"] and ready.effects["forced"] == told["forced"]
    if effects == "auto":
        assert [fit["psnr"] for fit in ready.effects["fits"]] == [fit["psnr"] for fit in told["fits"]] != []
        assert sv.choose_effects(config, data).to_toml() == ready.config.to_toml()
    else:  # train and Trainer settle the box by themselves
        by_itself, trainer = sv.train(data, config), sv.Trainer(data, config)
        trainer.train()
        for other in (by_itself, trainer.model()):
            sv.save_model(str(tmp_path / "other.vdb"), other, opened.notes)
            assert (tmp_path / "other.vdb").read_bytes() == (run / "model.vdb").read_bytes()


def test_a_saved_model_is_the_same_file(model, run, tmp_path):
    sv.save_model(str(tmp_path / "a.vdb"), model)
    again = sv.load_model(str(tmp_path / "a.vdb"))
    same_values(model, again)
    sv.save_model(str(tmp_path / "b.vdb"), again)
    assert rows(again).keys() == rows(sv.load_model(str(tmp_path / "b.vdb"))).keys()


def test_pictures_are_the_same_files(run, tmp_path):
    program("render", run, "--out", tmp_path / "cli", "--camera", "orbit", "--times", "0:1:3", "--size", "40",
            "--quiet")
    opened = sv.open_run(run)
    renderer = sv.Renderer(opened.model)
    for i, (camera, time) in enumerate(opened.shots("orbit", times="0:1:3", size=40), start=1):
        picture = renderer.render(camera, time).rgb
        assert np.array_equal(picture, opened.model.render(camera, time).rgb)
        sv.write_png(str(tmp_path / "py.png"), picture)
        assert (tmp_path / "py.png").read_bytes() == (tmp_path / "cli" / f"rgb_{i:04}.png").read_bytes()


def test_eval_has_the_same_figures(run, data):
    told = json.loads(program("eval", run, "--json"))
    opened = sv.open_run(run)
    found = opened.evaluate()
    assert found == {key: told[key] for key in found}
    assert found == opened.model.evaluate(data, "test")


def test_tracks_are_the_same(run, tmp_path):
    opened = sv.open_run(run)
    lo, hi = np.array(opened.model.box)
    points = (lo + (hi - lo) * np.random.default_rng(3).random((20, 3))).astype(np.float32)
    with open(tmp_path / "in.csv", "w") as f:
        print("x,y,z", *("%.9g,%.9g,%.9g" % tuple(p) for p in points), sep="\n", file=f)
    program("track", run, "--points", tmp_path / "in.csv", "--from", 0.25, "--to", "0,0.75",
            "--out", tmp_path / "out.csv", "--quiet")
    place, folded = opened.model.track(points, 0.25, [0, 0.75])
    with open(tmp_path / "out.csv") as f:
        table = list(csv.DictReader(f))
    told = np.array([[np.float32(row["to_" + axis]) for axis in "xyz"] for row in table])
    told = told.reshape(20, 2, 3).swapaxes(0, 1)
    assert np.array_equal(told, place)
    assert np.array_equal(np.array([row["folded"] == "1" for row in table]).reshape(20, 2).T, folded)
    canonical, flagged = opened.model.warp(points, 0.25)
    program("track", run, "--points", tmp_path / "in.csv", "--from", 0.25, "--to", "canonical",
            "--out", tmp_path / "out.csv", "--quiet")
    with open(tmp_path / "out.csv") as f:
        places = [[np.float32(row["to_" + axis]) for axis in "xyz"] for row in csv.DictReader(f)]
    assert np.array_equal(np.array(places), canonical)
    assert flagged.dtype == bool and flagged.shape == (20,)
