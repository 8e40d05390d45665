# SPDX-License-Identifier: Apache-2.0
# Run by blender_addon.sh inside Blender: blender -b ... -P blender_addon.py -- PROGRAM ZIP FOLDER
# FOLDER has a run. Ends Blender with an error if anything is not as it should be.
import json
import os
import sys
import types

import bpy

PROGRAM, ZIP, FOLDER = sys.argv[sys.argv.index("--") + 1:]
RUN = os.path.join(FOLDER, "run")
FRAMES = 4


def check(ok, what):
    print(("ok      " if ok else "FAILED  ") + what, flush=True)
    if not ok:
        sys.exit(3)


def refused(call, *words):
    """That a button fails and says why."""
    try:
        call()
    except RuntimeError as e:
        check(all(w in str(e) for w in words), "refused: " + str(e).strip())
        return
    check(False, "should have been refused, with " + " ".join(words))


def volumes():
    return sorted(o.name for o in bpy.data.objects if o.type == "VOLUME")


def grids(name):
    bpy.context.scene.frame_set(bpy.context.scene.frame_start)
    data = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    check(data.grids.load(), "grids load " + data.grids.error_message)
    return {g.name for g in data.grids}


def check_install(settings_of):
    bpy.ops.preferences.addon_install(filepath=ZIP)
    bpy.ops.preferences.addon_enable(module="splinevox_blender")
    check("splinevox_blender" in bpy.context.preferences.addons, "the zip installs and is enabled")
    check(hasattr(bpy.types, "SPLINEVOX_PT_panel"), "the panel is there")
    check(bpy.types.SPLINEVOX_PT_panel.bl_category == "Splinevox", "in the sidebar")
    settings = settings_of()
    settings.folder = RUN
    preferences = bpy.context.preferences.addons["splinevox_blender"].preferences
    preferences.program = "/no/such/program"
    refused(bpy.ops.splinevox.import_scene, "no program", "/no/such/program", "Preferences")
    preferences.program = PROGRAM


def check_import(scene, settings):
    scene.frame_start, scene.frame_end = 1, FRAMES
    settings.motion_blur, settings.shutter = True, 0.25
    bpy.ops.splinevox.import_scene()
    check(volumes() == ["splinevox"], "a run is one volume: %s" % volumes())
    data = bpy.data.objects["splinevox"].data
    check(data.is_sequence and data.frame_duration == FRAMES, "of the scene's frames")
    check(grids("splinevox") == {"density", "color", "velocity"}, "with its grids")
    check(data.materials[0].name == "splinevox seen", "as it was seen")
    kinds = {n.bl_idname for n in data.materials[0].node_tree.nodes}
    check({"ShaderNodeVolumeAbsorption", "ShaderNodeEmission"} <= kinds, "by absorption and emission")
    check("splinevox run_blender" in bpy.data.collections, "in a collection of its own")
    check(scene.render.use_motion_blur and abs(scene.render.motion_blur_shutter - 0.25) < 1e-6,
          "motion blur is on")
    settings.motion_blur = False
    bpy.ops.splinevox.motion_blur()
    check(not scene.render.use_motion_blur, "and off again")
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.8
    bpy.ops.splinevox.import_scene()
    check(scene.render.use_motion_blur and scene.render.motion_blur_shutter > 0.7, "the user's blur stays")
    many = len(volumes())
    own = bpy.data.objects["splinevox"]
    own.location.x, settings.replace = 3, True
    before = own.data.name
    bpy.ops.splinevox.import_scene()
    settings.replace = False
    check(len(volumes()) == many and own.location.x == 3, "new frames show where the old ones did")
    check(before not in bpy.data.volumes or own.data.name != before, "by a volume that has no old frame")
    check(len([c for c in bpy.data.collections if not c.all_objects]) == 0, "and leave no empty collection")
    settings.parts = True
    refused(bpy.ops.splinevox.import_scene, "run_blender", "clusters")
    settings.out, settings.material = os.path.join(FOLDER, "parts"), "smoke"
    bpy.ops.splinevox.import_scene()
    parts = [n for n in volumes() if "cluster" in n]
    check(len(parts) >= 2, "parts are objects: %s" % parts)
    smoke = bpy.data.objects[parts[0]].data.materials[0]
    check(any(n.bl_idname == "ShaderNodeVolumeScatter" for n in smoke.node_tree.nodes),
          "of smoke, which scatters")
    settings.parts, settings.out = False, ""


def check_export(settings):
    before = len(volumes())
    settings.folder, settings.material = RUN + "_blender", "fire"
    bpy.ops.splinevox.import_scene()
    check(len(volumes()) == before + 1, "an export is imported as it is")
    script = os.path.join(RUN + "_blender", "load_in_blender.py")
    with open(script, encoding="utf-8") as f:
        text = f.read()
    with open(script, "w", encoding="utf-8") as f:
        f.write(text.replace("import argparse", "raise SystemExit('run')\nimport argparse", 1))
    bpy.ops.splinevox.import_scene()
    check(len(volumes()) == before + 2, "without running what is in its folder")
    settings.folder, settings.material = RUN, "seen"


def check_cameras(scene, settings):
    settings.camera = "dataset:train"
    bpy.ops.splinevox.import_cameras()
    with open(os.path.join(RUN + "_cameras", "cameras.json"), encoding="utf-8") as f:
        shots = json.load(f)["frames"]
    check([s["frame"] for s in shots] == list(range(1, FRAMES + 1)), "a camera for each frame")
    worst = 0
    for shot in shots:
        scene.frame_set(shot["frame"])
        for row, theirs in zip(shot["transform_matrix"], scene.camera.matrix_world):
            worst = max([worst, *(abs(a - b) for a, b in zip(row, theirs))])
        wide = scene.camera.data.sensor_width / scene.camera.data.lens
        worst = max(worst, abs(wide - shot["w"] / shot["fl_x"]))
    check(worst < 1e-4, "keyed where it stood: off by %.2g" % worst)
    check(len({str(s["transform_matrix"]) for s in shots}) == FRAMES, "and it moves")
    check(scene.render.resolution_x == shots[0]["w"], "the picture has its size")
    with open(os.path.join(RUN + "_cameras", "cameras.usda"), encoding="utf-8") as f:
        check(f.read().count("( (") == FRAMES, "the same in USD")


def check_time(scene, settings):
    refused(bpy.ops.splinevox.edit_time, "not keyed")
    for frame, time in ((1, 1.0), (FRAMES, 0.0)):
        settings.time = time
        scene.keyframe_insert("splinevox.time", frame=frame)
    from splinevox_blender import load_in_blender as loader
    check(not list(loader.keyed_curves(bpy.data.worlds.new("not keyed"))), "nothing keyed has no curves")
    keyed = list(loader.keyed_curves(scene))
    slot = types.SimpleNamespace(identifier="SCScene")
    strip = types.SimpleNamespace(
        channelbag=lambda of: types.SimpleNamespace(fcurves=keyed) if of is slot else None)
    layers = [types.SimpleNamespace(strips=[strip])]
    slotted = types.SimpleNamespace(action=types.SimpleNamespace(layers=layers), action_slot=slot)
    check(loader.keyed_curves(types.SimpleNamespace(animation_data=slotted)) == keyed, "as in Blender 5")
    for point in next(c for c in keyed if c.data_path == "splinevox.time").keyframe_points:
        point.interpolation = "LINEAR"
    bpy.ops.splinevox.edit_time()
    check(settings.folder == RUN + "_time1", "the new run is chosen")
    with open(os.path.join(settings.folder, "edit.json"), encoding="utf-8") as f:
        steps = json.load(f)["history"][0]["operations"]
    check(steps[0]["operation"] == "time-curve" and steps[0]["value"] == "0:1,1:0", "backwards: %s" % steps)
    settings.folder = FOLDER
    refused(bpy.ops.splinevox.edit_time, "no run")


def main():
    scene = bpy.context.scene
    check_install(lambda: scene.splinevox)
    settings = scene.splinevox
    check_import(scene, settings)
    check_export(settings)
    check_cameras(scene, settings)
    check_time(scene, settings)
    bpy.ops.preferences.addon_disable(module="splinevox_blender")
    check(not hasattr(bpy.types, "SPLINEVOX_PT_panel"), "disabled, it leaves nothing behind")


main()
