# SPDX-License-Identifier: Apache-2.0
# A first look from Python, cell by cell: opens as a notebook in VS Code, Spyder or Jupyter (jupytext), or
# runs as it is:
#   PYTHONPATH=build/release/src/python python3 docs/python_example.py
# %% A scene: pictures, cameras and times. load_dataset("FOLDER") reads your own.
import sys
import tempfile

import numpy as np

import splinevox as sv

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
data = sv.make_synth("dancer", frames=40, size=100)
frame = data.frames("test")[0]
size = f"{frame.camera.width}x{frame.camera.height}"
print(f"{len(data.frames('train'))} training views of {size}; first test view at time {frame.time:.2f}")

# %% Training. The callback sees every 200th step; returning False would end it, Ctrl-C interrupts it.
config = sv.Config("draft", max_steps=steps, seed=1)
config["loss.tv_control"] = 0.02
ready = sv.prepare(config, data)  # the scene's box, and effects that it calls for; draft tries none
print("effects:", ready.effects["used"], *ready.notes)
trainer = sv.Trainer(data, ready.config)
trainer.train(lambda r: print(f"step {r.step}: PSNR of the batch {r.psnr:.1f} dB"), every=max(1, steps // 5))
model = trainer.model()

# %% How good is it? The figures of `splinevox eval`.
scores = model.evaluate(data, "test")
print(f"PSNR {scores['psnr']:.2f} dB, SSIM {scores['ssim']:.4f}")

# %% Pictures: colour, alpha, depth, displacement and rigidity at any camera and time, as arrays.
layers = sv.Renderer(model).render(frame.camera, 0.5)
print("rgb", layers.rgb.shape, "depth from", layers.depth[layers.alpha > 0.5].min(), "to", layers.depth.max())

# %% Points through time: where is at times 0 and 1 what is seen at time 0.5?
seen = layers.alpha > 0.5
rows, columns = np.nonzero(seen)
camera = frame.camera
x = (columns + 0.5 - camera.cx) / camera.fx
y = -(rows + 0.5 - camera.cy) / camera.fy
local = np.stack([x, y, -np.ones_like(x)], -1) * layers.depth[seen][:, None]
points = local @ camera.camera_to_world[:3, :3].T + camera.camera_to_world[:3, 3]
places, folded = model.track(points[::50], 0.5, [0.0, 1.0])
moved = np.linalg.norm(places[1] - places[0], axis=-1)
print(f"{len(moved)} points move by {moved.mean():.3f} scene units on average, {folded.mean():.0%} flagged")

# %% Parameters are arrays of the model's own memory: this makes everything red without a copy.
red = model.copy()
red.rgb[512:] += np.array([2, -2, -2], np.float32)
with tempfile.TemporaryDirectory() as folder:
    sv.write_png(folder + "/red.png", red.render(camera, 0.5).rgb)
    sv.save_model(folder + "/red.vdb", red, {"made": "by docs/python_example.py"})
    again = sv.load_model(folder + "/red.vdb")
rows = len(model.control_points) if model.moves else 0
print("motion of", rows, "rows,", model.points, "control points each")
