# SPDX-License-Identifier: Apache-2.0
"""Renders a moving Blender scene as a D-NeRF data set with motion ground truth.

    blender -b [FILE.blend] -P data_scripts/render_scene.py -- --out DIR [--scene bounce|arm] [--frames N]
            [--size W] [--rig K [--turns] [--exposures E] [--offsets I] [--masks]]

Writes transforms_{train,val,test}.json, PNG pictures with straight alpha, and for every test picture
truth/r_XXX_0000.exr: layers `position` (X, Y, Z: where the surface point of the pixel is) and `rest`
(R, G, B: where the same point was at the first frame), one point sample per pixel, 0 where nothing is hit.
`splinevox eval --truth` reads them.

FILE.blend: time 0 is its first frame, time 1 its last. Its meshes get the ground truth, with armatures,
shape keys and modifiers that keep the order of vertices (subdivision interpolates it); particles, instances,
smoke and meshes made of something else are rendered but have none. Cameras look at the middle of all meshes
from a sphere that sees them at all times.

--rig K: K cameras that stand still film --frames moments, and test pictures are of two others. Frames have
`camera_id`; truth.json has the gains and the time offset of each camera and the box of all meshes. With masks
they have `mask_path`: white are the meshes of pass index 1 or, if none has it, those that move.
"""
import argparse
import json
import math
import os
import random
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import rig

ANGLE = 0.6911112  # full horizontal field of view, that of the published NeRF scenes
REST = "splinevox_rest"


def arguments():
    parser = argparse.ArgumentParser(prog="render_scene.py", description=__doc__.splitlines()[0])
    parser.add_argument("--out", required=True, help="folder of the data set; must not exist or be empty")
    parser.add_argument("--scene", choices=sorted(SCENES), help="a built-in scene instead of the .blend file")
    parser.add_argument("--frames", type=int, default=100,
                        help="training pictures; a tenth as many val and a fifth as many test pictures")
    parser.add_argument("--size", type=int, default=400, help="width and height of every picture")
    parser.add_argument("--samples", type=int, default=64, help="of Cycles, per pixel")
    parser.add_argument("--seed", type=int, default=1, help="of the training cameras")
    parser.add_argument("--rig", type=int, default=0, metavar="K", help="cameras that stand still, 2 to 100")
    parser.add_argument("--turns", action="store_true", help="of a rig: one camera a moment, in turn")
    parser.add_argument("--exposures", type=float, default=0,
                        help="of a rig: gains of training cameras' channels, from 1 - E to 1 + E, up to 0.5")
    parser.add_argument("--offsets", type=float, default=0,
                        help="of a rig: one training camera in eight is late by so many intervals, -2 to 2")
    parser.add_argument("--masks", action="store_true", help="of a rig: masks, white where the subject is")
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    if args.frames < 2 or args.size < 8 or args.samples < 1:
        parser.error("--frames must be at least 2, --size at least 8, --samples at least 1")
    if args.rig and not 2 <= args.rig <= 100:
        parser.error("--rig must be from 2 to 100")
    if not args.rig and (args.turns or args.exposures or args.offsets or args.masks):
        parser.error("--turns, --exposures, --offsets and --masks need --rig")
    if not 0 <= args.exposures <= 0.5 or not -2 <= args.offsets <= 2:
        parser.error("--exposures must be from 0 to 0.5, --offsets from -2 to 2")
    if os.path.isdir(args.out) and os.listdir(args.out) or os.path.isfile(args.out):
        parser.error(f"{args.out}: there is something of that name already; give another folder")
    if not args.scene and not bpy.data.filepath:
        parser.error("give a .blend file before -P, or --scene " + "|".join(sorted(SCENES)))
    return args


def colour(obj, rgb):
    material = bpy.data.materials.new(obj.name)
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*rgb, 1)
    obj.data.materials.append(material)
    return obj


def light():
    bpy.ops.object.light_add(type="SUN", rotation=(0.6, 0.3, 0))
    bpy.context.object.data.energy = 3
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
    bpy.context.scene.world = world


def bounce():
    """A ball that squashes as it bounces beside a box that stands still."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.5)
    ball = colour(bpy.context.object, (0.8, 0.2, 0.1))
    for frame in range(1, 49):
        phase = (frame - 1) / 47
        height = abs(math.cos(2 * math.pi * phase))
        squash = 1 - 0.3 * max(0.0, 1 - 5 * height)
        ball.location, ball.scale = (-0.5, 0, 0.5 * squash + height), (squash ** -0.5, squash ** -0.5, squash)
        ball.keyframe_insert("location", frame=frame)
        ball.keyframe_insert("scale", frame=frame)
    bpy.ops.mesh.primitive_cube_add(size=0.7, location=(0.7, 0.2, 0.35))
    colour(bpy.context.object, (0.1, 0.4, 0.8))
    return 48


def arm():
    """Two links that turn, one on the other."""
    bpy.ops.mesh.primitive_cube_add(size=1)
    lower = colour(bpy.context.object, (0.9, 0.7, 0.1))
    lower.data.transform(Matrix.Translation((0, 0, 0.5)) @ Matrix.Diagonal((0.25, 0.25, 1, 1)))
    bpy.ops.mesh.primitive_cube_add(size=1)
    upper = colour(bpy.context.object, (0.2, 0.7, 0.3))
    upper.data.transform(Matrix.Translation((0, 0, 0.4)) @ Matrix.Diagonal((0.2, 0.2, 0.8, 1)))
    upper.parent, upper.location = lower, (0, 0, 1)
    for frame in (1, 24, 48):
        lower.rotation_euler, upper.rotation_euler = (0, 0, 0.03 * (frame - 1)), (0.04 * (frame - 1), 0, 0)
        lower.keyframe_insert("rotation_euler", frame=frame)
        upper.keyframe_insert("rotation_euler", frame=frame)
    return 48


SCENES = {"bounce": bounce, "arm": arm}


def build(name):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, SCENES[name]()
    light()


def set_time(scene, time):
    frame = scene.frame_start + time * (scene.frame_end - scene.frame_start)
    scene.frame_set(int(math.floor(frame)), subframe=frame - math.floor(frame))


def meshes(scene):
    return [o for o in scene.objects if o.type == "MESH" and not o.hide_render]


def corners(scene):
    """Of every mesh at eight moments: {name: [corners of its box at one moment, ...]}."""
    found = {}
    for moment in range(8):
        set_time(scene, moment / 7)
        graph = bpy.context.evaluated_depsgraph_get()
        for obj in meshes(scene):
            evaluated = obj.evaluated_get(graph)
            at = [evaluated.matrix_world @ Vector(c) for c in evaluated.bound_box]
            found.setdefault(obj.name, []).append(at)
    if not found:
        sys.exit("render_scene.py: there is no mesh in this scene")
    return found


def box(found):
    every = [c for moments in found.values() for at in moments for c in at]
    return (Vector([min(c[i] for c in every) for i in range(3)]),
            Vector([max(c[i] for c in every) for i in range(3)]))


def subject(scene, found):
    """Names of the meshes that masks show."""
    chosen = [o.name for o in meshes(scene) if o.pass_index == 1]
    moves = [name for name, moments in found.items()
             if any((a - b).length > 1e-6 for at in moments for a, b in zip(at, moments[0]))]
    return chosen or moves or list(found)


def remember_rest(scene):
    """Where every vertex is at the first frame, as an attribute of its mesh, and a pass that shows it."""
    set_time(scene, 0)
    graph = bpy.context.evaluated_depsgraph_get()
    for obj in meshes(scene):
        if obj.data.users > 1:
            obj.data = obj.data.copy()
        evaluated = obj.evaluated_get(graph)
        same_order = len(evaluated.data.vertices) == len(obj.data.vertices)
        shape = evaluated.data.vertices if same_order else obj.data.vertices
        values = [c for v in shape for c in obj.matrix_world @ v.co]
        attribute = obj.data.attributes.new(REST, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", values)
        if not any(slot.material for slot in obj.material_slots):
            colour(obj, (0.8, 0.8, 0.8))
    for material in bpy.data.materials:
        if not material.use_nodes:
            rgba = material.diffuse_color[:]
            material.use_nodes = True
            principled = material.node_tree.nodes.get("Principled BSDF")
            if principled:
                principled.inputs["Base Color"].default_value = rgba
        nodes = material.node_tree.nodes
        read, show = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeOutputAOV")
        read.attribute_name, show.name = REST, "rest"
        material.node_tree.links.new(read.outputs["Vector"], show.inputs["Color"])
    layer = scene.view_layers[0]
    layer.use_pass_position = True
    aov = layer.aovs.add()
    aov.name, aov.type = "rest", "COLOR"


def truth_output(scene, folder):
    """Compositor nodes that write both passes; muted until they are wanted."""
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    layers, out = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeOutputFile")
    out.format.file_format, out.format.color_depth = "OPEN_EXR_MULTILAYER", "32"
    out.base_path = folder
    out.layer_slots.clear()
    for slot, source in (("position", "Position"), ("rest", "rest")):
        out.layer_slots.new(slot)
        tree.links.new(layers.outputs[source], out.inputs[slot])
    picture = tree.nodes.new("CompositorNodeComposite")
    tree.links.new(layers.outputs["Image"], picture.inputs["Image"])
    tree.links.new(layers.outputs["Alpha"], picture.inputs["Alpha"])
    return out


def look_at(position, target):
    back = (position - target).normalized()
    right = Vector((0, 0, 1)).cross(back)
    right = right.normalized() if right.length > 1e-6 else Vector((1, 0, 0))
    up = back.cross(right)
    return Matrix(((right.x, up.x, back.x, position.x), (right.y, up.y, back.y, position.y),
                   (right.z, up.z, back.z, position.z), (0, 0, 0, 1)))


def cameras(split, count, centre, distance, seed):
    """Drawn from the upper half of a sphere for training; once round on a smooth path for the others."""
    draw = random.Random(seed)
    for i in range(count):
        if split == "train":
            turn, height = draw.uniform(0, 2 * math.pi), draw.uniform(0.05, 0.95)
        else:
            turn, height = 2 * math.pi * (i + 0.5 * (split == "val")) / count, 0.4
        flat = math.sqrt(1 - height * height)
        direction = Vector((flat * math.cos(turn), flat * math.sin(turn), height))
        yield look_at(centre + distance * direction, centre)


def plan_single(args, centre, distance):
    """One camera a picture."""
    counts = {"train": args.frames, "val": max(2, args.frames // 10), "test": max(2, args.frames // 5)}
    return [{"split": split, "name": f"r_{i:03d}", "time": i / (count - 1), "matrix": matrix}
            for split, count in counts.items()
            for i, matrix in enumerate(cameras(split, count, centre, distance, args.seed))]


def rewrite(path, change):
    """Changes the values of a picture on disk, [pixels, RGBA] in [0, 1] as stored."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name, image.alpha_mode = "Non-Color", "CHANNEL_PACKED"
    pixels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(-1, 4)
    change(pixels)
    image.pixels.foreach_set(numpy.clip(pixels, 0, 1).ravel())
    image.save()
    bpy.data.images.remove(image)


def expose(path, gain):
    def change(pixels):
        pixels[:, :3] *= numpy.array(gain, numpy.float32)
    if gain != [1.0, 1.0, 1.0]:
        rewrite(path, change)


def render_mask(scene, path, shown):
    """How much of each pixel shows the meshes `shown`: the others are cut out of the film."""
    others = [o for o in scene.objects if o.name not in shown and not o.is_holdout]
    samples, scene.cycles.samples = scene.cycles.samples, 16
    for obj in others:
        obj.is_holdout = True
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    for obj in others:
        obj.is_holdout = False
    scene.cycles.samples = samples

    def change(pixels):
        pixels[:, :3] = pixels[:, 3:]
        pixels[:, 3] = 1
    rewrite(path, change)


def settings(scene, args):
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.render.resolution_x = scene.render.resolution_y = args.size
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = True
    scene.render.use_motion_blur = False
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGBA"
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.render.use_compositing, scene.render.use_sequencer = True, False


def render_truth(scene, out, name, args):
    samples, width = scene.cycles.samples, scene.cycles.filter_width
    scene.cycles.samples, scene.cycles.filter_width = 1, 0.01
    out.mute, out.base_path = False, os.path.join(args.out, "truth", name + "_")
    kept = scene.frame_current, scene.frame_subframe
    bpy.ops.render.render()
    out.mute = True
    scene.cycles.samples, scene.cycles.filter_width = samples, width
    made = f"{name}_{kept[0]:04d}.exr"  # the compositor puts the frame's number behind the name
    os.replace(os.path.join(args.out, "truth", made), os.path.join(args.out, "truth", name + "_0000.exr"))


def main():
    args = arguments()
    args.out = os.path.abspath(args.out)
    if args.scene:
        build(args.scene)
    scene = bpy.context.scene
    settings(scene, args)
    found = corners(scene)
    low, high = box(found)
    centre, radius = (low + high) / 2, (high - low).length / 2
    remember_rest(scene)
    out = truth_output(scene, args.out)
    out.mute = True
    lens = bpy.data.cameras.new("splinevox")
    lens.angle, lens.sensor_fit = ANGLE, "HORIZONTAL"
    lens.clip_start, lens.clip_end = radius / 100, radius * 100
    camera = bpy.data.objects.new("splinevox", lens)
    scene.collection.objects.link(camera)
    scene.camera, scene.cycles.samples = camera, args.samples
    distance = 1.1 * radius / math.sin(ANGLE / 2)
    shots = rig.plan(args, lambda d: look_at(centre + distance * Vector(d), centre)) if args.rig \
        else plan_single(args, centre, distance)
    shown = subject(scene, found)
    files = {}
    for shot in shots:
        split, name = shot["split"], shot["name"]
        os.makedirs(os.path.join(args.out, split), exist_ok=True)
        set_time(scene, shot["time"] + shot.get("late", 0))
        camera.matrix_world = shot["matrix"]
        path = os.path.join(args.out, split, name + ".png")
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        frame = {"file_path": f"./{split}/{name}", "time": shot["time"],
                 "transform_matrix": [list(row) for row in shot["matrix"]]}
        if args.rig:
            expose(path, shot["gain"])
            frame["camera_id"] = shot["camera_id"]
        if args.masks:
            frame["mask_path"] = f"masks/{split}/{name}.png"
            render_mask(scene, os.path.join(args.out, frame["mask_path"]), shown)
        if split == "test":
            render_truth(scene, out, name, args)
        files.setdefault(split, {"camera_angle_x": lens.angle, "frames": []})["frames"].append(frame)
    if args.rig:
        rig.write_truth(args, shots, (low, high))
    for split, content in files.items():  # last: a folder that was interrupted is no data set
        with open(os.path.join(args.out, f"transforms_{split}.json"), "w", encoding="utf-8") as text:
            json.dump(content, text, indent=1)
    count = len(files["train"]["frames"])
    print(f"render_scene.py: {args.out}: {count} training pictures of {args.size}x{args.size}")


main()
