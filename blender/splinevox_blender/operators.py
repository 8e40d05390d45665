# SPDX-License-Identifier: Apache-2.0
"""What the buttons of the panel do."""
import argparse
import os

import bpy

from . import load_in_blender as loader
from .calls import Calls, Failed
from .sequence import is_export, is_run, read_sequence


def chosen(settings):
    folder = os.path.normpath(bpy.path.abspath(settings.folder)) if settings.folder else ""
    if not folder:
        raise Failed("No folder is chosen. Expected: a run, or an export with the profile blender")
    if not os.path.isdir(folder):
        raise Failed("%s: there is no such folder" % folder)
    return folder


def chosen_run(settings):
    folder = chosen(settings)
    if not is_run(folder):
        raise Failed("%s is no run. Expected: a folder that `splinevox train` or `edit` made" % folder)
    return folder


def beside(settings, name):
    """A folder whose name is a run's and one word more, unless another one is chosen."""
    if settings.out:
        return os.path.normpath(bpy.path.abspath(settings.out))
    return "%s_%s" % (chosen_run(settings), name)


def shot(context):
    """The scene's frames, as the program counts them."""
    scene = context.scene
    return ["--frames", "%d-%d" % (scene.frame_start, scene.frame_end),
            "--fps", repr(scene.render.fps / scene.render.fps_base)]


def show(context, folder, sequence):
    """The sequence of a folder in the open scene, in a collection of its own. @return its objects"""
    settings = context.scene.splinevox
    args = argparse.Namespace(material=settings.material, strength=settings.strength,
                              albedo="color" if settings.albedo_of_color else round(settings.albedo, 6))
    volumes = loader.show(sequence, args, fresh=False)
    collection = bpy.data.collections.new("splinevox " + os.path.basename(folder))
    context.scene.collection.children.link(collection)
    for volume in volumes:
        for old in volume.users_collection:
            old.objects.unlink(volume)
        collection.objects.link(volume)
    return volumes


def set_motion_blur(scene, settings):
    scene.render.use_motion_blur = settings.motion_blur
    scene.render.motion_blur_shutter = settings.shutter
    # Blender 4.2 moved it from Cycles to all engines.
    owner = scene.render if hasattr(scene.render, "motion_blur_position") else scene.cycles
    owner.motion_blur_position = "CENTER"


def volumes_of(folder):
    """Volumes that earlier imports made of the folder's frames."""
    return [v for v in bpy.data.volumes
            if os.path.realpath(os.path.dirname(bpy.path.abspath(v.filepath))) == os.path.realpath(folder)]


def take_over(earlier, shown):
    """Objects of earlier volumes show the frames that are there now: Blender keeps some of the old ones as
    long as a volume has them. What the user did to an object and its material stays. @return what is shown"""
    def part(volume):
        return os.path.basename(volume.filepath).rpartition("frame_")[0]
    fresh = {part(o.data): o for o in shown}
    stands_for = {}
    for old in earlier:
        new = fresh.get(part(old))
        objects = [o for o in bpy.data.objects if o.data == old]
        if new is not None and objects:
            materials = list(old.materials)
            new.data.materials.clear()
            for material in materials:
                new.data.materials.append(material)
            for o in objects:
                o.data = new.data
            stands_for[new] = objects[0]
        bpy.data.volumes.remove(old)
    shown = [stands_for.get(o, o) for o in shown]
    for new in stands_for:
        bpy.data.objects.remove(new)
    return shown


class SPLINEVOX_OT_import(Calls, bpy.types.Operator):
    """Show the chosen run or export in this scene. Frames of a run are made first, for this scene's frames"""
    bl_idname = "splinevox.import_scene"
    bl_label = "Import"

    def begin(self, context):
        settings = context.scene.splinevox
        run = chosen_run(settings)
        self.out = beside(settings, settings.profile)
        words = ["export", run, "--out", self.out, "--profile", settings.profile, *shot(context)]
        words += ["--clusters", "auto"] if settings.parts else []
        words += ["--sh"] if settings.view else []
        words += ["--voxel-size", "%.6g" % settings.voxel_size] if settings.voxel_size > 0 else []
        words += ["--shutter", "%.6g" % settings.shutter]
        return words + (["--afresh"] if settings.replace else [])

    def end(self, context, result):
        if context.scene.splinevox.profile != "blender":
            return "%d frames for %s are in %s" % (result["frames"], result["profile"], self.out)
        return self.shown(context, self.out, volumes_of(self.out) if context.scene.splinevox.replace else [])

    def shown(self, context, folder, earlier=()):
        sequence = read_sequence(folder)
        volumes = show(context, folder, sequence)
        if earlier:
            volumes = take_over(earlier, volumes)
            for collection in [c for c in context.scene.collection.children if not c.all_objects]:
                if collection.name.startswith("splinevox "):
                    bpy.data.collections.remove(collection)
        if context.scene.splinevox.motion_blur:  # what the scene has is the user's
            set_motion_blur(context.scene, context.scene.splinevox)
        said = ["%s: %d volume%s" % (folder, len(volumes), "" if len(volumes) == 1 else "s")]
        return "; ".join(said + loader.differences(context.scene, sequence))

    def of_export(self, context):
        """An export needs no program."""
        try:
            folder = chosen(context.scene.splinevox)
            if is_run(folder) or not is_export(folder):
                return None
            self.report({"INFO"}, self.shown(context, folder))
            return {"FINISHED"}
        except (Failed, ValueError) as e:
            self.report({"ERROR"}, str(e))
            return {"CANCELLED"}

    def execute(self, context):
        return self.of_export(context) or super().execute(context)

    def invoke(self, context, event):
        return self.of_export(context) or super().invoke(context, event)


class SPLINEVOX_OT_cameras(Calls, bpy.types.Operator):
    """Key a camera as the run's cameras stood, or on a way through them, over this scene's frames"""
    bl_idname = "splinevox.import_cameras"
    bl_label = "Import cameras"

    def begin(self, context):
        settings = context.scene.splinevox
        self.out = beside(settings, "cameras")
        return ["render", chosen_run(settings), "--out", self.out, "--format", "cameras",
                "--camera", settings.camera, *shot(context)]

    def end(self, context, result):
        camera = loader.set_up_camera(context.scene, os.path.join(self.out, result["files"][0]))
        return "%s: %d frames" % (camera.name, result["cameras"])


class SPLINEVOX_OT_motion_blur(bpy.types.Operator):
    """Set this scene's motion blur as chosen above"""
    bl_idname = "splinevox.motion_blur"
    bl_label = "Set motion blur"
    bl_options = {"UNDO"}

    def execute(self, context):
        set_motion_blur(context.scene, context.scene.splinevox)
        return {"FINISHED"}


def time_curve(scene):
    """The keyed time as "T:S,...": at T, 0 to 1 over the scene's frames, the run's time S. Frames on a
    straight line between others are left out."""
    curve = next((c for c in loader.keyed_curves(scene) if c.data_path == "splinevox.time"), None)
    first, last = scene.frame_start, scene.frame_end
    if curve is None or last <= first:
        raise Failed("The time is not keyed. Try: right-click on Time > Insert Keyframe, at two frames")
    points = [((f - first) / (last - first), min(1.0, max(0.0, curve.evaluate(f))))
              for f in range(first, last + 1)]
    kept, since = points[:1], []  # since: left out behind the last one kept
    for i in range(1, len(points) - 1):
        (t0, s0), (t2, s2) = kept[-1], points[i + 1]
        since.append(points[i])
        if any(abs(s0 + (s2 - s0) * (t1 - t0) / (t2 - t0) - s1) > 1e-4 for t1, s1 in since):
            kept.append(points[i])
            since = []
    return ",".join("%.6g:%.6g" % point for point in kept + points[-1:])


class SPLINEVOX_OT_edit_time(Calls, bpy.types.Operator):
    """Make a run that shows the keyed time at each of this scene's frames, and choose it"""
    bl_idname = "splinevox.edit_time"
    bl_label = "Make a run with this time"

    def begin(self, context):
        run = chosen_run(context.scene.splinevox)
        number = 1
        while os.path.exists("%s_time%d" % (run, number)):
            number += 1
        self.out = "%s_time%d" % (run, number)
        return ["edit", run, "--out", self.out, "--time-curve", time_curve(context.scene)]

    def end(self, context, result):
        context.scene.splinevox.folder = self.out
        return "%s is chosen now" % self.out


CLASSES = (SPLINEVOX_OT_import, SPLINEVOX_OT_cameras, SPLINEVOX_OT_motion_blur, SPLINEVOX_OT_edit_time)
