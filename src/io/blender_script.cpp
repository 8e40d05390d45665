// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/blender_script.hpp"

#include "io/exact_text.hpp"

namespace splinevox {
namespace {

constexpr const char* kScript = R"py(
import argparse
import json
import os
import sys

import bpy
from mathutils import Matrix

HERE = os.path.dirname(os.path.abspath(__file__))
FILES = ["frame_%04d.vdb" % f for f in range(FIRST, LAST + 1)]


def import_sequence():
    """The frames as one Volume object at the world's origin, in scene units."""
    bpy.ops.object.volume_import(
        filepath=os.path.join(HERE, FILES[0]), directory=HERE + os.sep, files=[{"name": f} for f in FILES],
        use_sequence_detection=True, align="WORLD", location=(0, 0, 0))
    volume = bpy.context.object
    volume.name = "splinevox"
    if len(FILES) > 1:
        volume.data.frame_start = FIRST  # scene frame n shows frame_000n.vdb
        volume.data.frame_duration = len(FILES)
    bpy.context.scene.frame_set(FIRST)
    if VELOCITY:
        if volume.data.grids.load() and volume.data.velocity_grid != "velocity":  # Blender looks for the name itself
            volume.data.velocity_grid = "velocity"
        volume.data.velocity_unit = "SECOND"  # 'FRAME', the default, blurs too much
    return volume


def make_material():
    """Emission and absorption, both driven by density: radiance = integral of T * density * color.

    Not Principled Volume: its emission is not weighted by density, and its density scatters as well."""
    material = bpy.data.materials.new("splinevox")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()

    def node(kind, x, y, **settings):
        n = tree.nodes.new(kind)
        n.location = (x, y)
        for key, value in settings.items():
            setattr(n, key, value)
        return n

    density = node("ShaderNodeAttribute", -600, 100, attribute_name="density")
    color = node("ShaderNodeAttribute", -600, -150, attribute_name="color")
    absorb = node("ShaderNodeVolumeAbsorption", -300, 100)
    emit = node("ShaderNodeEmission", -300, -100)
    add = node("ShaderNodeAddShader", -50, 0)
    out = node("ShaderNodeOutputMaterial", 150, 0)
    absorb.inputs["Color"].default_value = (0, 0, 0, 1)  # black: the absorption coefficient is the density itself
    link = tree.links.new
    link(density.outputs["Fac"], absorb.inputs["Density"])
    link(density.outputs["Fac"], emit.inputs["Strength"])
    link(color.outputs["Color"], emit.inputs["Color"])
    link(absorb.outputs[0], add.inputs[0])
    link(emit.outputs[0], add.inputs[1])
    link(add.outputs[0], out.inputs["Volume"])
    return material


def set_up_scene(scene):
    scene.frame_start, scene.frame_end = FIRST, LAST
    scene.render.fps = max(1, round(FPS))
    scene.render.fps_base = scene.render.fps / FPS
    scene.render.engine = "CYCLES"
    scene.cycles.volume_bounces = 0
    scene.cycles.use_denoising = False
    scene.render.film_transparent = True
    # Display-referred colours are shown as they are; any other transform would change the picture.
    scene.view_settings.view_transform = "Standard" if LINEAR else "Raw"


def set_up_camera(scene, path):
    """A pinhole camera from JSON: w, h, fl_x, fl_y, cx, cy in pixels, transform_matrix camera to world, OpenGL axes."""
    with open(path) as f:
        c = json.load(f)
    w, h = c["w"], c["h"]
    data = bpy.data.cameras.new("splinevox")
    data.sensor_fit = "HORIZONTAL"
    data.lens = c["fl_x"] * data.sensor_width / w
    data.shift_x = (0.5 * w - c["cx"]) / w
    data.shift_y = (c["cy"] - 0.5 * h) / w
    data.clip_start, data.clip_end = 1e-3, 1e4
    camera = bpy.data.objects.new("splinevox camera", data)
    camera.matrix_world = Matrix(c["transform_matrix"])
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = w, h
    scene.render.resolution_percentage = 100
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = 1, c["fl_x"] / c["fl_y"]


def render(scene, path, frame, samples):
    scene.frame_set(frame)
    scene.cycles.samples = samples
    image = scene.render.image_settings
    if path.endswith(".exr"):
        image.file_format, image.color_depth = "OPEN_EXR", "32"
    else:
        image.file_format, image.color_depth = "PNG", "8"
    image.color_mode = "RGBA"
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def main():
    argv = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(prog="load_in_blender.py")
    parser.add_argument("--camera", help="JSON file with a pinhole camera")
    parser.add_argument("--render", help="picture to write, .exr or .png")
    parser.add_argument("--frame", type=int, default=FIRST)
    parser.add_argument("--samples", type=int, default=64)
    args = parser.parse_args(argv)
    if not bpy.data.filepath:  # nothing of the user's is open: start without the default cube
        bpy.ops.wm.read_factory_settings(use_empty=True)
    volume = import_sequence()
    volume.data.materials.append(make_material())
    scene = bpy.context.scene
    set_up_scene(scene)
    scene.frame_set(args.frame)
    if args.camera:
        set_up_camera(scene, args.camera)
    if args.render:
        render(scene, args.render, args.frame, args.samples)


main()
)py";

}  // namespace

std::string blender_script(const BlenderSequence& s) {
  const auto python = [](bool v) { return v ? "True" : "False"; };
  std::string text =
      "# Opens the VDB sequence beside this file in Blender (3.4 or newer) and makes Cycles show it as the radiance "
      "field that it\n"
      "# is. Written by splinevox together with the frames.\n"
      "#\n"
      "#   blender -P load_in_blender.py\n"
      "#   blender -b -P load_in_blender.py -- --camera camera.json --frame " +
      std::to_string(s.first) + " --render out.png\n";
  text += "FIRST, LAST = " + std::to_string(s.first) + ", " + std::to_string(s.last) + "\n";
  text += "FPS = " + exact_text<double>({s.fps}) + "\n";
  text += std::string("VELOCITY = ") + python(s.velocity) + "  # the frames hold a velocity grid\n";
  text += std::string("LINEAR = ") + python(s.linear) + "  # colours are scene-linear, not display values\n";
  text += "BACKGROUND = (" + exact_text<float>({s.background.x}) + ", " + exact_text<float>({s.background.y}) + ", " +
          exact_text<float>({s.background.z}) + ")  # display colour the model was made before; composite over it\n";
  return text + kScript;
}

}  // namespace splinevox
