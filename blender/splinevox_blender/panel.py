# SPDX-License-Identifier: Apache-2.0
"""Preferences, what can be chosen, and the panel in the 3D view's sidebar."""
import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from . import operators
from .sequence import is_export, is_run

PROFILES = [
    ("blender", "Blender", "Import it here"),
    ("houdini", "Houdini", "Write it for Houdini, import nothing"),
    ("unreal", "Unreal", "Write it for Unreal, import nothing"),
    ("usd", "USD", "Write a USD stage, import nothing"),
    ("splats", "Splats", "Write Gaussian splats, import nothing"),
]
MATERIALS = [
    ("seen", "As seen", "Absorption and emission: as it was reconstructed"),
    ("smoke", "Smoke", "Scattering and absorption: lit by this scene"),
    ("fire", "Fire", "Emission in scene-linear light: lights this scene"),
]
CAMERAS = [
    ("dataset:train", "Training cameras", "Those that took the training pictures, in their order"),
    ("dataset:test", "Test cameras", "Those of the test pictures"),
    ("stabilised", "Stabilised", "The way of a film without its shake"),
    ("interpolate", "Interpolated", "A way through the training cameras"),
    ("held", "Held", "One training camera, while time runs"),
    ("spiral", "Spiral", "An ellipse around the mean training camera"),
    ("orbit", "Orbit", "Around the scene"),
    ("auto", "Automatic", "What suits the training cameras"),
]


class SplinevoxPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", subtype="FILE_PATH", default="splinevox",
                            description="Path of splinevox; a name alone is looked for in PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


class SplinevoxSettings(bpy.types.PropertyGroup):
    folder: StringProperty(name="Folder", subtype="DIR_PATH",
                           description="A run, or an export with the profile blender")
    out: StringProperty(name="Output", subtype="DIR_PATH",
                        description="Where files are written; empty: beside the run, with its name")
    profile: EnumProperty(name="Profile", items=PROFILES)
    material: EnumProperty(name="Material", items=MATERIALS)
    albedo: FloatProperty(name="Albedo", min=0, max=1, default=0.8, description="Grey of smoke")
    albedo_of_color: BoolProperty(name="Albedo from colour", description="The colours of the reconstruction")
    strength: FloatProperty(name="Strength", min=0, default=1, description="A factor of the light of fire")
    parts: BoolProperty(name="Parts as objects", description="One object for each part that moves alike")
    view: BoolProperty(name="Colours of the view", description="Harmonics: colours change with the view")
    voxel_size: FloatProperty(name="Voxel size", min=0, precision=4,
                              description="Scene units; 0: the run's own")
    replace: BoolProperty(name="Replace", description="Write again what an earlier export left there")
    camera: EnumProperty(name="Cameras", items=CAMERAS)
    motion_blur: BoolProperty(name="Motion blur")
    shutter: FloatProperty(name="Shutter", min=0.01, max=1, default=0.5, description="Frames it is open")
    time: FloatProperty(name="Time", min=0, max=1,
                        description="The run's time that a frame shows: key it over the scene's frames")


class SPLINEVOX_PT_panel(bpy.types.Panel):
    bl_idname = "SPLINEVOX_PT_panel"
    bl_label = "Splinevox"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Splinevox"

    def draw(self, context):
        s, column = context.scene.splinevox, self.layout.column()
        folder = bpy.path.abspath(s.folder)
        run, export = is_run(folder), is_export(folder)
        column.prop(s, "folder")
        if s.folder and not run and not export:
            column.label(text="neither a run nor an export", icon="ERROR")
        if run:
            column.label(text="a run", icon="CHECKMARK")
            for name in ("out", "profile", "parts", "view", "voxel_size", "replace"):
                column.prop(s, name)
        column.prop(s, "material")
        if s.material == "smoke":
            column.prop(s, "albedo_of_color")
            if not s.albedo_of_color:
                column.prop(s, "albedo")
        if s.material == "fire":
            column.prop(s, "strength")
        row = column.row(align=True)
        row.prop(s, "motion_blur")
        if s.motion_blur:
            row.prop(s, "shutter")
        column.operator(operators.SPLINEVOX_OT_motion_blur.bl_idname)
        column.operator(operators.SPLINEVOX_OT_import.bl_idname, icon="IMPORT")
        if run:
            column.separator()
            column.prop(s, "camera")
            column.operator(operators.SPLINEVOX_OT_cameras.bl_idname, icon="CAMERA_DATA")
            column.separator()
            column.prop(s, "time")
            column.operator(operators.SPLINEVOX_OT_edit_time.bl_idname, icon="TIME")


CLASSES = (SplinevoxPreferences, SplinevoxSettings, SPLINEVOX_PT_panel)
