# SPDX-License-Identifier: Apache-2.0
# Opens the VDB sequence beside this file in Blender (tried with 3.4) and makes Cycles show it as the radiance
# field that it is. Written by splinevox together with the frames.
#
#   blender -P load_in_blender.py
#   blender -P load_in_blender.py -- --material smoke
#   blender -b -P load_in_blender.py -- --camera camera.json --frame 1 --render out.png
#   blender -b scene.blend -P load_in_blender.py -- --write-cameras cameras.json
#   splinevox render RUN --out film --camera cameras.json --frames FIRST-LAST
FIRST, LAST = 1, 1
FPS = 24
VELOCITY = True  # the frames hold a velocity grid
LINEAR = False  # colours are scene-linear, not display values
PREFIXES = ("", )  # of the frames' names; an object for each
SH_ORDER = -1  # harmonics in the grids sh0, sh1, ...; -1: the colour looks the same from everywhere
BACKGROUND = (1, 1, 1)  # display colour the model was made before; composite over it

import argparse
import collections
import functools
import json
import os
import sys

import bpy
from mathutils import Matrix

# A folder of frames and what is above.
Sequence = collections.namedtuple("Sequence", "folder first last fps velocity linear prefixes sh_order")


def import_sequence(sequence, prefix):
    """The frames that begin with it as one Volume object at the world's origin, in scene units."""
    folder, first = sequence.folder, sequence.first
    files = ["%sframe_%04d.vdb" % (prefix, f) for f in range(first, sequence.last + 1)]
    bpy.ops.object.volume_import(
        filepath=os.path.join(folder, files[0]), directory=folder + os.sep,
        files=[{"name": f} for f in files], use_sequence_detection=True, align="WORLD", location=(0, 0, 0))
    volume = bpy.context.object
    volume.name = " ".join(["splinevox"] + prefix.split("_")).strip()
    if len(files) > 1:
        volume.data.frame_start, volume.data.frame_duration = first, len(files)  # frame n: frame_000n.vdb
    bpy.context.scene.frame_set(first)
    if sequence.velocity:
        if volume.data.grids.load() and volume.data.velocity_grid != "velocity":
            volume.data.velocity_grid = "velocity"
        volume.data.grids.unload()  # or Blender keeps this frame when the file is written again
        volume.data.velocity_unit = "SECOND"  # 'FRAME', the default, blurs too much
    return volume


class Nodes:
    """Numbers and vectors as sockets of a node tree: what is written here as a formula runs in the shader."""

    def __init__(self, tree, sequence):
        self.tree = tree
        self.sequence = sequence

    def node(self, kind, x, y, **settings):
        n = self.tree.nodes.new(kind)
        n.location = (x, y)
        for key, value in settings.items():
            setattr(n, key, value)
        return n

    def put(self, value, socket):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation, a, b=0.0):
        n = self.node("ShaderNodeMath", -1500, -400, operation=operation)
        self.put(a, n.inputs[0])
        self.put(b, n.inputs[1])
        return n.outputs[0]

    def vector(self, operation, a, b):
        n = self.node("ShaderNodeVectorMath", -1200, -400, operation=operation)
        self.put(a, n.inputs[0])
        self.put(b, n.inputs["Scale" if operation == "SCALE" else 1])
        return n.outputs["Value" if operation == "DOT_PRODUCT" else "Vector"]

    def combined(self, xyz):
        n = self.node("ShaderNodeCombineXYZ", -1350, -400)
        for value, socket in zip(xyz, n.inputs):
            self.put(value, socket)
        return n.outputs[0]


def harmonics(nodes):
    """The real spherical harmonics of the direction of sight, bands 0 to sh_order, in the object's axes."""
    order = nodes.sequence.sh_order
    sight = nodes.node("ShaderNodeNewGeometry", -2200, -400).outputs["Incoming"]  # towards the camera
    turned = nodes.node("ShaderNodeVectorTransform", -2000, -400, vector_type="VECTOR", convert_from="WORLD",
                        convert_to="OBJECT")
    nodes.put(sight, turned.inputs[0])
    unit = nodes.node("ShaderNodeVectorMath", -1850, -400, operation="NORMALIZE")
    nodes.put(turned.outputs[0], unit.inputs[0])
    split = nodes.node("ShaderNodeSeparateXYZ", -1700, -400)
    nodes.put(nodes.vector("SCALE", unit.outputs[0], -1.0), split.inputs[0])
    x, y, z = split.outputs

    def times(*factors):
        return functools.reduce(lambda product, f: nodes.math("MULTIPLY", f, product), factors)

    minus = functools.partial(nodes.math, "SUBTRACT")
    found = [0.28209479177387814]
    if order > 0:
        found += [times(v, 0.4886025119029199) for v in (y, z, x)]
    if order > 1:
        b = 1.0925484305920792
        xx, yy, zz = times(x, x), times(y, y), times(z, z)
        found += [times(x, y, b), times(y, z, b),
                  times(minus(times(zz, 3.0), 1.0), 0.31539156525252005), times(x, z, b),
                  times(minus(xx, yy), 0.5462742152960396)]
    if order > 2:
        one, three = minus(times(zz, 5.0), 1.0), minus(times(zz, 5.0), 3.0)
        found += [times(minus(times(xx, 3.0), yy), y, 0.5900435899266435), times(x, y, z, 2.890611442640554),
                  times(one, y, 0.4570457994644658), times(three, z, 0.3731763325901154),
                  times(one, x, 0.4570457994644658), times(minus(xx, yy), z, 1.445305721320277),
                  times(minus(xx, times(yy, 3.0)), x, 0.5900435899266435)]
    return found


def shown_color(nodes, color):
    """The colour as it is seen from the camera. With harmonics it is color * (1 - sigmoid(q) / 2), where q is
    the sum of sh_j Y_j."""
    if nodes.sequence.sh_order < 0:
        return color
    y = harmonics(nodes)
    y += [0.0] * (-len(y) % 3)
    q = 0.0
    for k in range(len(y) // 3):
        name = "sh%d" % k
        sh = nodes.node("ShaderNodeAttribute", -1500, -700 - 150 * k, attribute_name=name).outputs["Vector"]
        q = nodes.math("ADD", nodes.vector("DOT_PRODUCT", sh, nodes.combined(y[3 * k:3 * k + 3])), q)
    odds = nodes.math("ADD", nodes.math("EXPONENT", nodes.math("MULTIPLY", q, -1.0)), 1.0)
    factor = nodes.math("SUBTRACT", 1.0, nodes.math("DIVIDE", 0.5, odds))
    return nodes.vector("SCALE", color, factor)


def linear_color(nodes, color):
    """Scene-linear light of display values: sRGB's power law, without its straight piece below 0.04."""
    if nodes.sequence.linear:
        return color
    shifted = nodes.vector("SCALE", nodes.vector("ADD", color, (0.055, 0.055, 0.055)), 1 / 1.055)
    gamma = nodes.node("ShaderNodeGamma", -450, -150)
    nodes.put(shifted, gamma.inputs["Color"])
    nodes.put(2.4, gamma.inputs["Gamma"])
    return gamma.outputs["Color"]


def glowing(nodes, density, color, strength):
    """Absorption by density, and emission."""
    absorb = nodes.node("ShaderNodeVolumeAbsorption", -300, 100)
    emit = nodes.node("ShaderNodeEmission", -300, -100)
    # Black: the absorption coefficient is the density itself.
    nodes.put((0, 0, 0, 1), absorb.inputs["Color"])
    nodes.put(density, absorb.inputs["Density"])
    nodes.put(strength, emit.inputs["Strength"])
    nodes.put(color, emit.inputs["Color"])
    return absorb.outputs[0], emit.outputs[0]


def seen(nodes, density, color, args):
    """Emission and absorption, both driven by density: radiance = integral of T * density * color.
    Not Principled Volume: its emission is not weighted by density, and its density scatters as well."""
    return glowing(nodes, density, shown_color(nodes, color), density)


def smoke(nodes, density, color, args):
    """Lit by the scene, gives off nothing. Scattering is density * albedo, absorption density * (1 - albedo):
    together the density, so that it hides as much as it was seen to hide."""
    scatter = nodes.node("ShaderNodeVolumeScatter", -300, -100)
    absorb = nodes.node("ShaderNodeVolumeAbsorption", -300, 100)
    albedo = (args.albedo, args.albedo, args.albedo, 1)
    if args.albedo == "color":
        albedo = nodes.vector("MINIMUM", linear_color(nodes, color), (1, 1, 1))
    for node in (scatter, absorb):
        nodes.put(albedo, node.inputs["Color"])
        nodes.put(density, node.inputs["Density"])
    return absorb.outputs[0], scatter.outputs[0]


def fire(nodes, density, color, args):
    """As it was seen, in scene-linear light times a strength, so that it lights what is around it."""
    return glowing(nodes, density, linear_color(nodes, shown_color(nodes, color)),
                   nodes.math("MULTIPLY", density, args.strength))


MATERIALS = {"seen": seen, "smoke": smoke, "fire": fire}


def make_material(sequence, args):
    """The volume material that --material names. Its two shaders are added up."""
    material = bpy.data.materials.new("splinevox " + args.material)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    nodes = Nodes(material.node_tree, sequence)
    density = nodes.node("ShaderNodeAttribute", -600, 100, attribute_name="density").outputs["Fac"]
    color = nodes.node("ShaderNodeAttribute", -600, -150, attribute_name="color").outputs["Vector"]
    add = nodes.node("ShaderNodeAddShader", -50, 0)
    out = nodes.node("ShaderNodeOutputMaterial", 150, 0)
    for shader, socket in zip(MATERIALS[args.material](nodes, density, color, args), add.inputs):
        nodes.put(shader, socket)
    nodes.put(add.outputs[0], out.inputs["Volume"])
    said = {"seen": "absorption and emission by density, colours as they were seen",
            "smoke": "absorption and scattering by density, albedo %s, no emission" % args.albedo,
            "fire": "absorption and emission by density, scene-linear, strength %g" % args.strength}
    print("material %s: %s" % (args.material, said[args.material]), flush=True)
    return material


def light_up(scene):
    """A sun and a dim sky, without which smoke in an empty scene is black."""
    sun = bpy.data.objects.new("splinevox sun", bpy.data.lights.new("splinevox sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 5, (0.7, 0.2, 0.6)
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("splinevox sky")
    scene.world.color = (0.3, 0.3, 0.3)
    print("the scene was empty: a sun and a grey sky light it", flush=True)


def differences(scene, sequence):
    """In what an open scene does not go with a sequence, a sentence each."""
    rate, said = scene.render.fps / scene.render.fps_base, []
    if abs(rate - sequence.fps) > 1e-3:
        said.append("the scene has %g frames a second, the sequence %g" % (rate, sequence.fps))
    if sequence.last < scene.frame_start or sequence.first > scene.frame_end:
        said.append("the scene's frames %d to %d show none of the sequence's, %d to %d" % (
            scene.frame_start, scene.frame_end, sequence.first, sequence.last))
    return [text + "; splinevox export --frames --fps makes others" for text in said]


def set_up_scene(scene, sequence, args, fresh):
    """Frames, rate and film are set in an empty scene alone: in one that is open they are the user's."""
    scene.render.engine = "CYCLES"
    if fresh:
        scene.frame_start, scene.frame_end = sequence.first, sequence.last
        scene.render.fps = max(1, round(sequence.fps))
        scene.render.fps_base = scene.render.fps / sequence.fps
        scene.cycles.volume_bounces, scene.cycles.use_denoising = 0, False
        scene.render.film_transparent = True
        scene.view_settings.look, scene.view_settings.exposure = "None", 0  # of the user's start-up file
    for difference in [] if fresh else differences(scene, sequence):
        print(difference, flush=True)
    if args.material == "smoke":
        scene.cycles.volume_bounces = max(4, scene.cycles.volume_bounces)
    # Display-referred colours are shown as they are; any other transform would change the picture. Light in a
    # scene of the user's is shown as the user chose.
    if args.material == "seen":
        scene.view_settings.view_transform = "Standard" if sequence.linear else "Raw"
    elif fresh:
        scene.view_settings.view_transform = "Standard"
    if fresh and args.material == "smoke":
        light_up(scene)


def keyed_curves(thing):
    """Curves of a thing's action; from Blender 5 on actions have none of their own, but one set a slot."""
    action = thing.animation_data and thing.animation_data.action
    if not action or hasattr(action, "fcurves"):
        return action.fcurves if action else ()
    slot = thing.animation_data.action_slot
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [curve for bag in bags if bag for curve in bag.fcurves]


def set_up_camera(scene, path):
    """Pinhole cameras from JSON: w, h, fl_x, fl_y, cx, cy in pixels, transform_matrix camera to world, OpenGL
    axes; or a list `frames` of such, one a frame, as `splinevox render --format cameras` and --write-cameras
    write it: then the camera is keyed. The picture's size and pixels are those of the first."""
    with open(path) as f:
        top = json.load(f)
    shots = [dict(top, **shot) for shot in top.get("frames", [top])]
    data = bpy.data.cameras.new("splinevox")
    data.sensor_fit = "HORIZONTAL"
    data.clip_start, data.clip_end = 1e-3, 1e4
    camera = bpy.data.objects.new("splinevox camera", data)
    camera.rotation_mode = "QUATERNION"
    scene.collection.objects.link(camera)
    scene.camera = camera
    for number, c in enumerate(shots):
        w, h = int(c["w"]), int(c["h"])
        aspect = c["fl_x"] / c["fl_y"]
        data.lens = c["fl_x"] * data.sensor_width / w
        data.shift_x = (0.5 * w - c["cx"]) / w
        data.shift_y = (c["cy"] - 0.5 * h) * aspect / w
        before = camera.rotation_quaternion.copy()
        camera.matrix_world = Matrix(c["transform_matrix"])
        if number == 0:
            scene.render.resolution_x, scene.render.resolution_y = w, h
            scene.render.resolution_percentage = 100
            # Blender takes neither below 1.
            scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = max(1, 1 / aspect), max(1, aspect)
        elif before.dot(camera.rotation_quaternion) < 0:
            camera.rotation_quaternion.negate()  # the same turn, without a way around in between
        if len(shots) == 1:
            break
        frame = c.get("frame", scene.frame_start + number)
        for thing, names in ((camera, ("location", "rotation_quaternion")),
                             (data, ("lens", "shift_x", "shift_y"))):
            for name in names:
                thing.keyframe_insert(name, frame=frame)
    for curve in [*keyed_curves(camera), *keyed_curves(data)]:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    return camera


def write_cameras(scene, path):
    """The scene's camera at each of its frames, for `splinevox render RUN --out DIR --camera PATH --frames
    A-B`. Times are spread over all of the motion; for a part of it `render` has --at and --seconds."""
    if scene.camera is None:
        sys.exit("load_in_blender.py: the scene has no camera to write; "
                 "open your .blend file first, or give --camera")
    pixels = scene.render.resolution_x, scene.render.resolution_y
    size = [s * scene.render.resolution_percentage // 100 for s in pixels]
    frames, shown = [], scene.frame_current
    for number in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(number)
        if scene.camera.data.type != "PERSP":
            sys.exit("load_in_blender.py: the camera '%s' is of type %s, and only perspective ones can be "
                     "written; set its lens to Perspective" % (scene.camera.name, scene.camera.data.type))
        # What the picture shows of a plane before the camera, in its axes, with fit, shift and pixel shape.
        corners = scene.camera.data.view_frame(scene=scene)
        x, y = [c.x for c in corners], [c.y for c in corners]
        wide, high = max(x) - min(x), max(y) - min(y)
        frames.append({"frame": number, "w": size[0], "h": size[1],
                       "fl_x": -corners[0].z * size[0] / wide, "fl_y": -corners[0].z * size[1] / high,
                       "cx": -min(x) * size[0] / wide, "cy": max(y) * size[1] / high,
                       "transform_matrix": [list(row) for row in scene.camera.matrix_world.normalized()]})
    scene.frame_set(shown)
    with open(path, "w") as f:
        json.dump({"frames": frames}, f, indent=1)


def render(scene, path, frame, samples):
    scene.frame_set(frame)
    scene.cycles.samples = samples
    image = scene.render.image_settings
    image.file_format, image.color_depth = ("OPEN_EXR", "32") if path.endswith(".exr") else ("PNG", "8")
    image.color_mode, scene.render.filepath = "RGBA", os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def show(sequence, args, fresh):
    """Volumes, material and scene. @return the volume objects, one for each prefix"""
    material = make_material(sequence, args)
    shown = bpy.context.scene.frame_current
    volumes = [import_sequence(sequence, prefix) for prefix in sequence.prefixes]
    if not fresh:
        bpy.context.scene.frame_set(shown)
    for volume in volumes:
        volume.data.materials.append(material)
    set_up_scene(bpy.context.scene, sequence, args, fresh)
    return volumes


def albedo(text):
    if text != "color" and not 0 <= float(text) <= 1:
        raise argparse.ArgumentTypeError("expected 'color' or a number in [0, 1], got '%s'" % text)
    return text if text == "color" else float(text)


def main():
    argv = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(prog="load_in_blender.py")
    parser.add_argument("--camera", help="JSON file with a pinhole camera, or one for every frame")
    parser.add_argument("--write-cameras", help="JSON file to write: the scene's camera at every frame, "
                                                "for splinevox render --camera")
    parser.add_argument("--render", help="picture to write, .exr or .png")
    parser.add_argument("--frame", type=int, help="the one to show and render; of an empty scene the first")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--material", choices=sorted(MATERIALS), default="seen",
                        help="seen: as it was reconstructed; smoke: lit by the scene; fire: lights it")
    parser.add_argument("--albedo", type=albedo, default=0.8,
                        help="of smoke: a grey in [0, 1], or 'color', the colours of the reconstruction")
    parser.add_argument("--strength", type=float, default=1.0, help="of fire: a factor of its light")
    args = parser.parse_args(argv)
    fresh = not bpy.data.filepath and not bpy.data.is_dirty  # nothing of the user's is open
    if fresh:
        bpy.ops.wm.read_homefile(use_empty=True)
    here = os.path.dirname(os.path.abspath(__file__))
    sequence = Sequence(here, FIRST, LAST, FPS, VELOCITY, LINEAR, PREFIXES, SH_ORDER)
    show(sequence, args, fresh)
    scene = bpy.context.scene
    if fresh or args.frame is not None:
        scene.frame_set(FIRST if args.frame is None else args.frame)
    if args.camera:
        set_up_camera(scene, args.camera)
    if args.write_cameras:
        write_cameras(scene, args.write_cameras)
    if args.render:
        render(scene, args.render, scene.frame_current, args.samples)


if __name__ == "__main__":
    main()
