# Run by blender_accept.sh inside Blender: blender -b ... -P blender_accept.py -- FOLDER
# FOLDER is what the blender_accept program wrote. Ends Blender with an error if anything is not as it should be.
import array
import json
import math
import os
import runpy
import sys

import bpy

FOLDER = sys.argv[sys.argv.index("--") + 1]
FRAMES, SHOWN = 5, 3


def check(ok, what):
    print(("ok      " if ok else "FAILED  ") + what, flush=True)
    if not ok:
        sys.exit(3)


def check_grids(volume):
    evaluated = volume.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    check(evaluated.grids.load(), "grids load: " + evaluated.grids.error_message)
    found = {g.name: (g.data_type, g.channels) for g in evaluated.grids}
    wanted = {"density": ("FLOAT", 1), "color": ("VECTOR_FLOAT", 3), "velocity": ("VECTOR_FLOAT", 3)}
    check(found == wanted, "three grids of the right types: %s" % found)
    return evaluated.grids.frame_filepath


def main():
    exr = os.path.join(FOLDER, "blender.exr")
    script = os.path.join(FOLDER, "export", "load_in_blender.py")
    sys.argv = ["blender", "--", "--camera", os.path.join(FOLDER, "camera.json"), "--render", exr, "--frame", str(SHOWN),
                "--samples", "64"]
    runpy.run_path(script, run_name="__main__")

    scene = bpy.context.scene
    volume = bpy.data.objects["splinevox"]
    data = volume.data
    check(data.is_sequence, "the frames are one sequence")
    check((data.frame_start, data.frame_duration) == (1, FRAMES), "it begins at scene frame 1 and has %d frames" % FRAMES)
    check((data.velocity_grid, data.velocity_unit) == ("velocity", "SECOND"), "velocity is in units per second")
    check((scene.frame_start, scene.frame_end) == (1, FRAMES), "the scene's frame range is the sequence's")
    check(abs(scene.render.fps / scene.render.fps_base - 24) < 1e-6, "24 frames per second")
    check(scene.view_settings.view_transform == "Raw", "display colours are shown as they are")
    for frame in range(1, FRAMES + 1):
        scene.frame_set(frame)
        path = check_grids(volume)
        check(os.path.basename(path) == "frame_%04d.vdb" % frame, "scene frame %d shows %s" % (frame, os.path.basename(path)))

    with open(os.path.join(FOLDER, "camera.json")) as f:
        camera = json.load(f)
    w, h = camera["w"], camera["h"]
    ours = array.array("f")
    with open(os.path.join(FOLDER, "ours.f32"), "rb") as f:
        ours.frombytes(f.read())
    image = bpy.data.images.load(exr)
    check(tuple(image.size) == (w, h), "the picture has the camera's size")
    theirs = list(image.pixels)  # premultiplied RGBA; rows begin at the bottom

    def clamp(v):
        return min(max(v, 0.0), 1.0)

    squares = alpha_error = alpha_max = 0.0
    moments = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]  # of alpha, theirs and ours: mass, along x, along y
    for y in range(h):
        for x in range(w):
            i, j = 4 * ((h - 1 - y) * w + x), 4 * (y * w + x)
            a, b = theirs[i:i + 4], ours[j:j + 4]
            squares += sum((clamp(a[c] + 1 - a[3]) - clamp(b[c])) ** 2 for c in range(3))
            alpha_error += abs(a[3] - b[3])
            alpha_max = max(alpha_max, b[3])
            for moment, alpha in zip(moments, (a[3], b[3])):
                moment[0] += alpha
                moment[1] += alpha * x
                moment[2] += alpha * y
    psnr = -10 * math.log10(squares / (3 * w * h))
    alpha_error /= w * h
    shift = [moments[0][i] / moments[0][0] - moments[1][i] / moments[1][0] for i in (1, 2)]
    check(alpha_max > 0.99, "our picture shows the blob")
    check(max(map(abs, shift)) < 0.1, "alpha is centred where ours is: off by (%.3f, %.3f) pixels" % tuple(shift))
    check(alpha_error < 0.01, "mean alpha error %.5f" % alpha_error)
    check(psnr >= 30, "Cycles equals our renderer: PSNR %.2f dB, at least 30" % psnr)


main()
