# SPDX-License-Identifier: Apache-2.0
# Run by blender_accept.sh inside Blender: blender -b ... -P blender_accept.py -- FOLDER
# FOLDER is what the blender_accept program wrote. Ends Blender with an error if anything is not as it should
# be.
import array
import json
import math
import os
import runpy
import sys

import bpy
from mathutils import Matrix

FOLDER = sys.argv[sys.argv.index("--") + 1]
FRAMES, SHOWN = 5, 3


def check(ok, what):
    print(("ok      " if ok else "FAILED  ") + what, flush=True)
    if not ok:
        sys.exit(3)


def path(name):
    return os.path.join(FOLDER, name)


def load(sequence, picture, frame, samples=8, *more):
    """Runs load_in_blender.py as a user does. @return the picture that it rendered"""
    sys.argv = ["blender", "--", "--camera", path("camera.json"), "--write-cameras", path("cameras.json"),
                "--render", path(picture), "--frame", str(frame),
                "--samples", str(samples), *more]
    runpy.run_path(path(os.path.join(sequence, "load_in_blender.py")), run_name="__main__")
    return pixels(picture)


def pixels(picture):
    """RGBA, premultiplied, rows from the top."""
    image = bpy.data.images.load(path(picture), check_existing=False)
    w, h = image.size
    data = list(image.pixels)
    return w, h, [data[i:i + 4] for y in range(h) for i in range(4 * (h - 1 - y) * w, 4 * (h - y) * w, 4)]


def ours(name):
    data = array.array("f")
    with open(path(name), "rb") as f:
        data.frombytes(f.read())
    return [data[i:i + 4] for i in range(0, len(data), 4)]


def clamp(v):
    return min(max(v, 0.0), 1.0)


def decibels(theirs, mine):
    """Over white, where our pictures are already."""
    squares = sum((clamp(a[c] + 1 - a[3]) - clamp(b[c])) ** 2
                  for a, b in zip(theirs[2], mine) for c in range(3))
    return -10 * math.log10(squares / (3 * len(mine)))


def spread(width, rgba, direction=(1.0, 0.0)):
    """Mean of alpha's place, x and y, and its variance along a direction, pixels."""
    mass = sum(p[3] for p in rgba)
    places = [(i % width, i // width) for i in range(len(rgba))]
    mean = [sum(p[3] * place[a] for p, place in zip(rgba, places)) / mass for a in (0, 1)]
    along = [(x - mean[0]) * direction[0] + (y - mean[1]) * direction[1] for x, y in places]
    return mean, sum(p[3] * s * s for p, s in zip(rgba, along)) / mass


def check_grids(volume, wanted):
    evaluated = volume.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    check(evaluated.grids.load(), "grids load: " + evaluated.grids.error_message)
    found = {g.name: (g.data_type, g.channels) for g in evaluated.grids}
    check(found == wanted, "grids of the right types: %s" % found)
    return evaluated.grids.frame_filepath


def check_sequence():
    theirs = load("export", "blender.exr", SHOWN, 32)
    scene = bpy.context.scene
    volume = bpy.data.objects["splinevox"]
    data = volume.data
    check(data.is_sequence, "the frames are one sequence")
    check((data.frame_start, data.frame_duration) == (1, FRAMES),
          "it begins at scene frame 1 and has %d frames" % FRAMES)
    check((data.velocity_grid, data.velocity_unit) == ("velocity", "SECOND"),
          "velocity is in units per second")
    check((scene.frame_start, scene.frame_end) == (1, FRAMES), "the scene's frame range is the sequence's")
    check(abs(scene.render.fps / scene.render.fps_base - 24) < 1e-6, "24 frames per second")
    check(scene.view_settings.view_transform == "Raw", "display colours are shown as they are")
    for frame in range(1, FRAMES + 1):
        scene.frame_set(frame)
        shown = check_grids(volume, {"density": ("FLOAT", 1), "color": ("VECTOR_FLOAT", 3),
                                     "velocity": ("VECTOR_FLOAT", 3)})
        check(os.path.basename(shown) == "frame_%04d.vdb" % frame,
              "scene frame %d shows %s" % (frame, os.path.basename(shown)))

    with open(path("camera.json")) as f:
        camera = json.load(f)
    with open(path("cameras.json")) as f:
        written = json.load(f)["frames"]
    check(len(written) == FRAMES, "the camera is written for every frame")
    lens = max(abs(written[1][k] / camera[k] - 1) for k in ("w", "h", "fl_x", "fl_y", "cx", "cy"))
    rows = zip(written[1]["transform_matrix"], camera["transform_matrix"])
    pose = max(abs(a - b) for r, s in rows for a, b in zip(r, s))
    check(max(lens, pose) < 1e-5,
          "and is the one that was read: lens within %.1g, pose within %.1g" % (lens, pose))
    w, h = camera["w"], camera["h"]
    check(theirs[:2] == (w, h), "the picture has the camera's size")
    mine = ours("ours.f32")
    (there, _), (here, _) = spread(w, theirs[2]), spread(w, mine)
    shift = [there[i] - here[i] for i in (0, 1)]
    check(max(p[3] for p in mine) > 0.99, "our picture shows the blob")
    check(max(map(abs, shift)) < 0.1,
          "alpha is centred where ours is: off by (%.3f, %.3f) pixels" % tuple(shift))
    alpha_error = sum(abs(a[3] - b[3]) for a, b in zip(theirs[2], mine)) / len(mine)
    check(alpha_error < 0.01, "mean alpha error %.5f" % alpha_error)
    psnr = decibels(theirs, mine)
    check(psnr >= 30, "Cycles equals our renderer: PSNR %.2f dB, at least 30" % psnr)


def check_open_scene():
    """What a user has set in a scene that is open stays."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps, scene.render.fps_base = 1001, 1003, 25, 1
    scene.render.film_transparent, scene.cycles.volume_bounces = False, 2
    bpy.ops.wm.save_as_mainfile(filepath=path("scene.blend"))
    load("export", "open.png", SHOWN, 1)
    scene = bpy.context.scene
    check((scene.frame_start, scene.frame_end) == (1001, 1003), "an open scene keeps its frames")
    check((scene.render.fps, scene.render.fps_base) == (25, 1), "and its rate")
    check(not scene.render.film_transparent and scene.cycles.volume_bounces == 2, "film and bounces")
    with open(path("cameras.json")) as f:
        written = [c["frame"] for c in json.load(f)["frames"]]
    check(written == [1001, 1002, 1003], "cameras are written for its frames: %s" % written)
    script = runpy.run_path(path("export/load_in_blender.py"))
    sequence = script["Sequence"]("", 1, FRAMES, 24, True, False, ("", ), -1)
    said = script["differences"](scene, sequence)
    check(len(said) == 2 and "1001 to 1003" in said[1], "what does not go with it is said: %s" % said)
    for kind in ("ORTHO", "PANO"):
        check_no_pinhole(script["write_cameras"], scene, kind)
    bpy.ops.wm.read_factory_settings(use_empty=True)


def check_no_pinhole(write_cameras, scene, kind):
    """A camera that our renderer cannot have is refused by name, and nothing is written."""
    scene.camera.data.type = kind
    try:
        write_cameras(scene, path("no_pinhole.json"))
    except SystemExit as e:
        said = str(e.code)
        check(kind in said and scene.camera.name in said and "Perspective" in said, "refused: " + said)
        check(not os.path.exists(path("no_pinhole.json")), "and nothing is written")
        return
    check(False, "a camera of type %s should have been refused" % kind)


def check_clusters():
    theirs = load("clusters", "clusters.exr", SHOWN)
    names = sorted(o.name for o in bpy.data.objects if o.type == "VOLUME")
    check(names == ["splinevox cluster 0", "splinevox cluster 1"], "every cluster is an object: %s" % names)
    psnr = decibels(theirs, ours("ours.f32"))
    check(psnr >= 30, "the clusters together are the whole: PSNR %.2f dB, at least 30" % psnr)


def check_view():
    mine = ours("view.f32")
    mean = decibels(load("mean", "mean.exr", 1), mine)
    with_sh = decibels(load("sh", "sh.exr", 1), mine)
    vectors = ("color", "sh0", "sh1", "sh2", "sh3", "sh4", "sh5")
    check_grids(bpy.data.objects["splinevox"],
                dict({"density": ("FLOAT", 1)}, **{n: ("VECTOR_FLOAT", 3) for n in vectors}))
    check(with_sh >= 30, "the colours of the view, harmonics to order 3: PSNR %.2f dB, at least 30" % with_sh)
    check(with_sh > mean + 3, "their mean over all directions alone: %.2f dB" % mean)
    # The harmonics belong to the object's axes: turned together with the camera it looks the same.
    turn = Matrix.Translation((0.3, -0.2, 0.1)) @ Matrix.Rotation(2.0, 4, (1, 2, -1))
    for name in ("splinevox", "splinevox camera"):
        bpy.data.objects[name].matrix_world = turn @ bpy.data.objects[name].matrix_world
    bpy.context.scene.render.filepath = path("turned.exr")
    bpy.ops.render.render(write_still=True)
    turned = decibels(pixels("turned.exr"), mine)
    check(turned >= 30, "turned together with the camera: %.2f dB" % turned)


def check_blur():
    with open(path("blur.json")) as f:
        streak = json.load(f)
    expected = math.hypot(*streak)
    direction = [v / expected for v in streak]
    sharp = load("blur", "sharp.exr", 2)
    render = bpy.context.scene.render
    render.use_motion_blur, render.motion_blur_shutter = True, 0.5
    render.filepath = path("blurred.exr")
    bpy.context.scene.cycles.motion_blur_position, bpy.context.scene.cycles.samples = "CENTER", 16
    bpy.ops.render.render(write_still=True)
    blurred = pixels("blurred.exr")

    def width(still, moving):  # of the box that alpha was smeared with
        more = spread(sharp[0], moving, direction)[1] - spread(sharp[0], still, direction)[1]
        return math.sqrt(12 * max(0.0, more))

    theirs, mine = width(sharp[2], blurred[2]), width(ours("sharp.f32"), ours("blurred.f32"))
    check(expected > 8, "the known velocity draws a streak of %.2f pixels" % expected)
    check(abs(mine - expected) < 0.1 * expected,
          "the mean of our pictures while the shutter is open is smeared by %.2f" % mine)
    check(abs(theirs - expected) < 0.15 * expected, "Cycles smears by %.2f pixels" % theirs)
    psnr, still = decibels(blurred, ours("blurred.f32")), decibels(sharp, ours("blurred.f32"))
    check(psnr >= 30 and psnr > still,
          "motion blur: PSNR %.2f dB, at least 30; without it %.2f" % (psnr, still))


def check_mesh():
    """The moving mesh, by Blender's own importer: where its vertices are at each frame, and its colours."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 24
    import numpy
    numpy.bool = bool  # Blender 3.4's importer asks for this name, which numpy has dropped since
    bpy.ops.import_scene.gltf(filepath=path("blur/mesh.glb"))
    ob = bpy.data.objects["mesh"]
    colors = ob.data.color_attributes
    check(len(colors) == 1 and len(colors[0].data) > 0, "the mesh has a colour per vertex")
    materials = [n.type for n in ob.data.materials[0].node_tree.nodes]
    check("BSDF_PRINCIPLED" not in materials, "its material is unlit: %s" % materials)
    means = []
    for frame in range(3):
        bpy.context.scene.frame_set(frame)
        mesh = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        places = [ob.matrix_world @ v.co for v in mesh.vertices]
        means.append([sum(p[a] for p in places) / len(places) for a in range(3)])
    moved = [[m[a] - means[0][a] for a in range(3)] for m in means]
    off = max(abs(moved[f][a] - f / 2 * (0.4, 0.3, -0.1)[a]) for f in range(3) for a in range(3))
    check(off < 2e-3, "it moves as the matter does: off by %.5f" % off)


def check_mattes():
    """The parts, by the compositor's Cryptomatte node, which finds them by name."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    with open(path("camera.json")) as f:
        camera = json.load(f)
    w, h = camera["w"], camera["h"]
    scene.render.resolution_x, scene.render.resolution_y = w, h
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.use_nodes = True
    nodes, links = scene.node_tree.nodes, scene.node_tree.links
    nodes.clear()
    matte, out = nodes.new("CompositorNodeCryptomatteV2"), nodes.new("CompositorNodeOutputFile")
    matte.source, matte.image = "IMAGE", bpy.data.images.load(path("mattes.exr"))
    out.base_path, out.format.file_format, out.format.color_depth = path("mattes"), "OPEN_EXR", "32"
    links.new(matte.outputs["Matte"], out.inputs[0])
    links.new(matte.outputs["Image"], nodes.new("CompositorNodeComposite").inputs[0])
    check(matte.layer_name == "crypto_part", "Blender finds the layer of mattes: " + matte.layer_name)
    mine = array.array("f")
    with open(path("mattes.f32"), "rb") as f:
        mine.frombytes(f.read())
    for part in range(4):
        matte.matte_id = "cluster_%d" % part
        out.file_slots[0].path = matte.matte_id + "_"
        bpy.ops.render.render()
        theirs = [p[0] for p in pixels("mattes/%s_%04d.exr" % (matte.matte_id, scene.frame_current))[2]]
        coverage = mine[part * w * h:(part + 1) * w * h]
        off = max(abs(a - b) for a, b in zip(theirs, coverage))
        check(max(coverage) > 0.5 and off < 1e-6, "its matte of %s is our coverage: off by %.1g" % (
            matte.matte_id, off))


def check_smoke():
    """The blob of check_view as smoke: as much is hidden as before, and all of its light is the scene's."""
    seen = pixels("mean.exr")
    theirs = load("mean", "smoke.exr", 1, 4, "--material", "smoke")
    hidden = sum(p[3] for p in theirs[2]) / sum(p[3] for p in seen[2])
    check(abs(hidden - 1) < 0.01,
          "smoke hides as much as what was reconstructed: %.4f of it, with noise" % hidden)
    check(max(p[0] for p in theirs[2]) > 0.1, "the sun of an empty scene lights it")
    lamp = bpy.data.objects["splinevox sun"]
    lamp.hide_render, bpy.context.scene.world.color = True, (0, 0, 0)
    bpy.context.scene.render.filepath = path("dark.exr")
    bpy.ops.render.render(write_still=True)
    check(max(max(p[:3]) for p in pixels("dark.exr")[2]) == 0, "without light it is black")


def check_fire():
    """Scene-linear light, which the view shows again as it was seen, wherever it hides what is behind it."""
    mine = ours("view.f32")
    seen = pixels("mean.exr")[2]
    fire = load("mean", "fire.exr", 1, 4, "--material", "fire", "--strength", "2")[2]
    check(bpy.context.scene.view_settings.view_transform == "Standard", "fire is light, shown as light")
    ratios = [b[1] / (2 * ((a[1] + 0.055) / 1.055) ** 2.4)
              for a, b in zip(seen, fire) if a[3] > 0.999 and a[1] > 0.3]
    ratio = sum(ratios) / max(1, len(ratios))
    check(len(ratios) > 500 and 0.9 < ratio < 1.15,
          "its light is the decoded colour times the strength: %.3f over %d pixels" % (ratio, len(ratios)))
    error = sum(abs(a[3] - b[3]) for a, b in zip(fire, mine)) / len(mine)
    check(error < 0.01, "it hides as much: mean alpha error %.5f" % error)


check_sequence()
check_open_scene()
check_clusters()
check_view()
check_mesh()
check_mattes()
check_smoke()
check_fire()
check_blur()
