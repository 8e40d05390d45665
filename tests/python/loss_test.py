# SPDX-License-Identifier: Apache-2.0
"""Losses in Python: what they are given, what they ask for, and what goes wrong."""
import numpy as np
import pytest

import splinevox as sv


def test_the_usual_loss_in_python_gives_the_same_bits(data, config, model):
    rays = []

    def loss(r):
        rays.append(r)
        return r.photometric

    mine = sv.train(data, config, loss=loss)
    assert np.array_equal(mine.density, model.density)
    assert np.array_equal(mine.control_points, model.control_points)
    last = rays[-1]  # lives on after its step
    assert last.colours.shape == last.targets.shape == last.origins.shape == (len(last), 3)
    assert last.colours.dtype == np.float32 and last.pixels.dtype == np.int32
    assert np.allclose(np.linalg.norm(last.directions, axis=1), 1, atol=1e-5)
    error = 2 * last.weights[:, None] * (last.colours - last.targets)
    clipped = last.targets >= 1
    assert np.allclose(np.where(clipped, 0, error), np.where(clipped, 0, last.photometric), atol=1e-6)
    frame, x, y = last.pixels[np.flatnonzero(last.pixels[:, 0] >= 0)[0]]
    assert 0 <= x < 32 and 0 <= y < 32 and 0 <= frame < len(data.frames("train"))


def test_a_loss_of_ones_own_is_learned_and_reported(data, config):
    solid = np.stack([frame.image[..., 3] for frame in data.frames("train")]) > 0.9 * 65535
    there = []  # mean error where something stands: the random colours behind it are never grey

    def grey(r):
        error = r.colours - r.targets.mean(axis=1, keepdims=True)
        frame, x, y = r.pixels.T
        there.append((error[(frame >= 0) & solid[frame, y, x]] ** 2).sum(axis=1).mean())
        return float((error**2).sum()), 2 * error

    trainer, losses = sv.Trainer(data, config), []
    trainer.set_loss(grey)
    trainer.train(lambda r: losses.append(r.loss), every=1)
    picture = trainer.model().render(data.frames("test")[0].camera, 0.5)
    seen = picture.rgb[picture.alpha > 0.9]
    assert there[-1] < 0.2 * there[0] and losses[-1] < 0.5 * losses[0]
    assert np.ptp(seen, axis=1).mean() < 0.1 and len(seen) > 20


def test_what_goes_wrong_leaves_the_trainer_as_it_was(data, config, model):
    trainer = sv.Trainer(data, config)
    trainer.train(lambda r: False, every=10)
    before = trainer.save()
    for wrong, says in ((lambda r: r.colours[:5], r"shape \("), (lambda r: r.colours * np.nan, "not finite"),
                        (lambda r: None, "no gradient"), (lambda r: (1, 2, 3), "tuple of 3"),
                        (lambda r: trainer.model(), "in the midst of a step")):
        trainer.set_loss(wrong)
        with pytest.raises(sv.InputError, match=says):
            trainer.step()
    trainer.set_loss(lambda r: {}["mine"])
    with pytest.raises(KeyError, match="mine"):
        trainer.train()
    with pytest.raises(sv.InputError, match="cannot be called"):
        trainer.set_loss(3)
    trainer.set_loss(None)
    other = sv.Trainer(data, config)
    other.restore(before)
    trainer.train()
    other.train()
    assert np.array_equal(trainer.model().density, other.model().density)
    assert np.array_equal(trainer.model().density, model.density)
