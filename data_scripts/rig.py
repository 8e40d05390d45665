# SPDX-License-Identifier: Apache-2.0
"""The pictures of a rig for render_scene.py: cameras that stand still, their gains and clocks."""
import json
import math
import os
import random

TEST_CAMERAS, LATE_EVERY = 2, 8


def gains(draw, count, spread):
    """Per camera and channel; their geometric mean is 1 in every channel."""
    logs = [[math.log(1 + spread * draw.uniform(-1, 1)) for _ in range(3)] for _ in range(count)]
    return [[math.exp(one[c] - sum(other[c] for other in logs) / count) for c in range(3)] for one in logs]


def plan(args, place):
    """Cameras in a ring at two heights in turn; those of val and test stand between two of them.

    place: the matrix of a camera in a direction (x, y, z) from the scene, of length 1.
    """
    draw, step = random.Random(args.seed), 2 * math.pi / args.rig
    start = draw.random()

    def at(turn, height):
        flat = math.sqrt(1 - height * height)
        return place((flat * math.cos(step * turn), flat * math.sin(step * turn), height))

    cameras = []
    for k in range(args.rig):
        turn, height = k + start + draw.uniform(0, 0.3), (0.56 if k % 2 else 0.2) + draw.uniform(0, 0.1)
        late = args.offsets / (args.frames - 1) if k % LATE_EVERY == 1 else 0.0
        cameras.append({"matrix": at(turn, height), "late": late})
    for camera, gain in zip(cameras, gains(draw, args.rig, args.exposures)):
        camera["gain"] = gain
    for share in [0.25] + [k / TEST_CAMERAS for k in range(TEST_CAMERAS)]:
        cameras.append({"matrix": at(math.floor(share * args.rig) + start + 0.65, 0.39), "late": 0.0,
                        "gain": [1.0, 1.0, 1.0]})
    for k, camera in enumerate(cameras):
        camera["camera_id"] = f"cam{k:02d}"

    def shots(split, chosen, moments, turns=False):
        return [dict(camera, split=split, name=f"{camera['camera_id']}_{i:04d}", time=i / (moments - 1))
                for i in range(moments) for k, camera in enumerate(chosen)
                if not turns or i % len(chosen) == k]

    return (shots("train", cameras[:args.rig], args.frames, args.turns)
            + shots("val", cameras[args.rig:args.rig + 1], max(2, args.frames // 10))
            + shots("test", cameras[args.rig + 1:], max(2, args.frames // 5)))


def write_truth(args, shots, box):
    """truth.json: gains, clocks and the corners of the box of all there is."""
    cameras = {shot["camera_id"]: shot for shot in shots}
    interval = 1 / (args.frames - 1)
    late = {name: shot["late"] for name, shot in cameras.items()}
    truth = {"what": "picture = plain picture (8-bit display values) * gain per channel, clipped at 255; "
                     "a camera shows the moment time + time_offset",
             "gains": {name: shot["gain"] for name, shot in cameras.items()},
             "interval": interval,
             "time_offset": late,
             "time_offset_intervals": {name: value / interval for name, value in late.items()},
             "scene_box": [list(corner) for corner in box]}
    with open(os.path.join(args.out, "truth.json"), "w", encoding="utf-8") as text:
        json.dump(truth, text, indent=1)
