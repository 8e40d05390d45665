# SPDX-License-Identifier: Apache-2.0
"""Data sets of arrays: the same as those on disk, and errors that name what is wrong."""
import numpy as np
import pytest

import splinevox as sv


def arguments(data, splits=("train", "test")):
    """What a data set is made of."""
    frames = [(split, f) for split in splits for f in data.frames(split)]
    k = []
    for _, f in frames:
        c = f.camera
        k.append([[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1]])
    return dict(images=[f.image for _, f in frames],
                camera_to_world=np.array([f.camera.camera_to_world for _, f in frames]),
                intrinsics=np.array(k), times=[f.time for _, f in frames],
                splits=[split for split, _ in frames],
                names=[split + "_" + f.name for split, f in frames])


def test_a_data_set_of_arrays_trains_alike(data, config, model):
    mine = sv.Dataset(**arguments(data))
    assert mine.splits == ["train", "test"] and mine.has_alpha == data.has_alpha
    for split in mine.splits:
        for a, b in zip(mine.frames(split), data.frames(split), strict=True):
            assert np.array_equal(a.image, b.image) and a.time == b.time
            assert np.allclose(a.camera.camera_to_world, b.camera.camera_to_world, atol=1e-14)
    trained = sv.train(mine, config)
    assert np.allclose(trained.density, model.density, atol=1e-4)
    assert trained.evaluate(mine)["psnr"] == pytest.approx(model.evaluate(data)["psnr"], abs=0.05)


def test_values_are_those_of_the_array_whatever_its_type(data):
    a = arguments(data, ["train"])
    del a["splits"]
    whole = [image.astype(np.float64) / 65535 for image in a["images"]]
    rgb8 = np.stack([np.uint8(image // 257)[..., :3] for image in a["images"]])
    of_floats = sv.Dataset(**{**a, "images": whole})
    assert of_floats.splits == ["train", "test"] and "every eighth" in " ".join(of_floats.notes)
    by_name = {f.name: f for s in of_floats.splits for f in of_floats.frames(s)}
    for name, image in zip(a["names"], a["images"]):
        assert np.array_equal(by_name[name].image, image)
    opaque = sv.Dataset(**{**a, "images": rgb8, "intrinsics": a["intrinsics"][0]})
    assert not opaque.has_alpha
    assert np.array_equal(opaque.frames("train")[0].image[..., 3], np.full((32, 32), 65535))
    bright = sv.Dataset(**{**a, "images": [2 * w for w in whole]})  # light beyond white stays
    assert bright.frames("train")[0].image[..., :3].max() == 65535
    with pytest.raises(sv.InputError, match="divide by 255"):  # bytes as floats
        sv.Dataset(**{**a, "images": rgb8.astype(np.float32)})


def test_times_cameras_masks_and_box_are_understood(data):
    a = arguments(data, ["train"])
    del a["splits"]
    n = len(a["times"])
    pose = a["camera_to_world"][:2]
    ignored = [None] * n
    ignored[3] = np.zeros((32, 32), bool)
    ignored[3][:5] = True
    a.update(camera_to_world=pose[np.arange(n) % 2], times=[1990 + i // 2 for i in range(n)], ignored=ignored,
             cameras=["left" if i % 2 == 0 else "right" for i in range(n)], box=[[-1, -1, -1], [1, 1, 2]])
    rig = sv.Dataset(**a)
    assert rig.cameras == [("left", True), ("right", True)] and rig.box[1] == [1, 1, 2]
    origin, scale = rig.time_map
    assert origin == 1990 and scale == pytest.approx(2 / (n - 2))
    frames = {f.name: f for s in rig.splits for f in rig.frames(s)}
    assert frames[a["names"][3]].ignored.sum() == 5 * 32 and frames[a["names"][3]].camera_id == 1
    assert "32x32" in repr(rig) and all(f"{len(rig.frames(s))} {s}" in repr(rig) for s in rig.splits)


@pytest.mark.parametrize("change,says", [
    ({"images": []}, "images: there are none"),
    ({"times": [0.0]}, "times: there is not one for each"),
    ({"camera_to_world": np.eye(4)}, "these are not matrices"),
    ({"intrinsics": np.eye(3) * 2}, "pinhole"),
    ({"box": [[1, 1, 1], [0, 2, 2]]}, "corners"),
])
def test_what_is_wrong_is_named(data, change, says):
    with pytest.raises(sv.InputError, match=says):
        sv.Dataset(**{**arguments(data), **change})


def test_the_picture_that_is_wrong_is_named(data):
    a = arguments(data)
    for bad, says in ((np.zeros((4, 4)), "not a picture"), (np.zeros((4, 4, 3), np.int32), "no values of a"),
                      (np.full((4, 4, 3), np.nan), "not finite")):
        with pytest.raises(sv.InputError, match=says) as caught:
            sv.Dataset(**{**a, "images": a["images"][:2] + [bad] + a["images"][3:]})
        assert caught.value.where == "images[2]"
    poses = a["camera_to_world"].copy()
    poses[1, :3, 0] *= -1
    with pytest.raises(sv.InputError, match="mirrors the camera") as caught:
        sv.Dataset(**{**a, "camera_to_world": poses})
    assert a["names"][1] in caught.value.where
    with pytest.raises(sv.InputError, match="one name"):
        sv.Dataset(**{**a, "names": ["same"] * len(a["times"])})
    with pytest.raises(sv.InputError, match="no such split"):
        sv.Dataset(**{**a, "splits": ["training"] * len(a["times"])})


def test_integer_pictures_are_shares_of_their_largest_value():
    rng = np.random.default_rng(1)
    a, b = (rng.integers(0, 256, (16, 16, 3)).astype(np.uint8) for _ in range(2))
    right = sv.psnr(a / 255.0, b / 255.0)
    assert sv.psnr(a, b) == pytest.approx(right, abs=1e-4)
    assert sv.psnr((a / 255.0).tolist(), b) == pytest.approx(right, abs=1e-4)
    assert sv.psnr(a.astype(np.uint16) * 257, b) == pytest.approx(right, abs=1e-4)
    with pytest.raises(sv.InputError, match="no values of a picture"):
        sv.psnr(a.astype(np.int64), b)
