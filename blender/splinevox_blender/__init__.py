# SPDX-License-Identifier: Apache-2.0
# Brings runs of splinevox, and what it exported, into Blender. docs/blender.md says how to install it.
bl_info = {
    "name": "splinevox",
    "author": "the splinevox authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Splinevox",
    "description": "Moving scenes that splinevox reconstructed: volumes, cameras, parts, time curves",
    "doc_url": "",
    "category": "Import-Export",
}

import bpy

from . import operators, panel

CLASSES = (*panel.CLASSES, *operators.CLASSES)


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    bpy.types.Scene.splinevox = bpy.props.PointerProperty(type=panel.SplinevoxSettings)


def unregister():
    del bpy.types.Scene.splinevox
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
