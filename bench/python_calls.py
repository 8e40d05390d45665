# SPDX-License-Identifier: Apache-2.0
# What one call from Python costs, in processor time:
# PYTHONPATH=build/release/src/python python3 bench/python_calls.py
import statistics
import time

import numpy as np

import splinevox as sv

sv.set_threads(1)
data = sv.make_synth("dancer", frames=10, size=32)
small = {"grid.radiance": [12, 16], "grid.radiance_start": [0, 0.5], "sampling.rays": 256}
config = sv.Config("draft", settings=small, max_steps=20, effects="all")
model = sv.train(data, config)
frame = data.frames("test")[0]
renderer = sv.Renderer(model)
pixel = sv.Camera(1, 1, frame.camera.camera_to_world, angle_x=0.7)
point = np.zeros((1, 3), np.float32)
picture = frame.composited()


def cost(name, work, count):
    times = []
    for _ in range(count):
        start = time.thread_time_ns()
        work()
        times.append((time.thread_time_ns() - start) / 1e3)
    print(f"{name:<45} {statistics.median(times):8.1f} us")


cost("copy of a picture of 32x32", lambda: frame.image, 2000)
cost("view of rows", lambda: model.density, 2000)
cost("picture of one pixel, same Renderer and time", lambda: renderer.render(pixel, 0.5), 500)
cost("picture of 32x32", lambda: renderer.render(frame.camera, 0.5), 50)
cost("warp of one point", lambda: model.warp(point, 0.5), 200)
cost("psnr of 32x32", lambda: sv.psnr(picture, picture), 200)
