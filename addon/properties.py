# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What GI Bake keeps in a .blend: `Scene.gi_bake`, its settings and the list of its results, and `Object.gi_bake`.

All of it is plain properties: a Blender without the extension opens such a file, shows its images and keeps the rest.
What is only true of this session (a bake on its way, its findings) is not here but in `session`.
"""

from dataclasses import fields

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..gi_core.lpv.settings import LpvSettings
from ..gi_core.rsm.settings import RsmSettings
from ..gi_core.settings import Settings
from ..gi_core.ssgi.settings import SsgiSettings
from .rna import annotations, own_fields

METHODS = (
    (
        "RSM", "RSM",
        "Reflective shadow maps. Every lamp sees the scene, and what it sees lights the rest, with shadow rays: equals "
        "Cycles as samples grow. "
        "The first choice for stills and lightmaps", 0,
    ),
    (
        "LPV", "LPV",
        "Light propagation volumes. Light travels through a grid around the scene: smooth without noise, softer than "
        "Cycles in corners, and the "
        "only one that can light what moves later", 1,
    ),
    (
        "SSGI", "SSGI",
        "Screen-space GI. The camera's picture lights itself, on the screen, by rays or both: for camera images and "
        "animations, as game engines show them", 2,
    ),
)  # fmt: skip

TARGETS = (
    ("IMAGE", "Camera Image", "What the active camera sees, with layers for compositing", "RENDER_STILL", 0),
    ("LIGHTMAP", "Lightmaps", "An image for each object, laid out by its UV map", "UV", 1),
    (
        "VERTICES", "Vertices",
        "Light at each vertex as the attribute gi_irradiance: needs no UV map, as fine as the mesh is", "VERTEXSEL", 2,
    ),
    (
        "VOLUME", "Volume",
        "Light everywhere in a box, as an OpenVDB file and a node group that lights any mesh; propagation volumes only",
        "VOLUME_DATA", 3,
    ),
)  # fmt: skip

SCOPES = (
    ("ALL", "All", "Every object that renders and is not left out in its Object properties"),
    ("SELECTED", "Selected", "Only what is selected and renders"),
)

KEEPS = (
    ("PACKED", "In the .blend", "Images are packed into the .blend and saved with it"),
    ("FILES", "In a Folder", "Images are written to the output folder and the .blend refers to them"),
)


# Of paths that may begin with //, beside the .blend.
_RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"}


class GiBakeRsm(PropertyGroup):
    """Settings of reflective shadow maps."""

    __annotations__ = annotations(own_fields(RsmSettings))


class GiBakeLpv(PropertyGroup):
    """Settings of light propagation volumes."""

    __annotations__ = annotations(own_fields(LpvSettings))


class GiBakeSsgi(PropertyGroup):
    """Settings of screen-space global illumination."""

    __annotations__ = annotations(own_fields(SsgiSettings))


class GiBakeImage(PropertyGroup):
    """An image that a result consists of."""

    image: PointerProperty(name="Image", type=bpy.types.Image, description="Image that holds a part of the result")


class GiBakeResult(PropertyGroup):
    """One line in the list of what was baked; `name`, which every group has, is what it is called there."""

    key: StringProperty(name="Key", description="Tells this bake from all others", options={"HIDDEN"})
    method: EnumProperty(name="Technique", description="Technique that the result was baked with", items=METHODS)
    target: EnumProperty(name="Target", description="What the light was baked for", items=TARGETS)
    view_layer: StringProperty(name="View Layer", description="View layer that was baked")
    frame: IntProperty(name="Frame", description="Frame that was baked")
    size: StringProperty(name="Resolution", description="Resolution or number of vertices of the result")
    seconds: FloatProperty(
        name="Time", description="How long the bake took", subtype="TIME_ABSOLUTE", unit="TIME_ABSOLUTE"
    )
    compared: BoolProperty(name="Compared", description="Whether the result was compared with Cycles")
    error: FloatProperty(
        name="relMSE", description="Relative mean square error against Cycles, of reflected light; 0 is equal"
    )
    bias: FloatProperty(
        name="Bias", description="How much too bright (+) or too dark (-) the whole is against Cycles, as a share"
    )
    report: StringProperty(
        name="Report", description="Page with the comparison", subtype="FILE_PATH", options=_RELATIVE
    )
    folder: StringProperty(
        name="Folder", description="Folder that holds the result's files", subtype="DIR_PATH", options=_RELATIVE
    )
    images: CollectionProperty(name="Images", description="Images that the result consists of", type=GiBakeImage)
    comparisons: CollectionProperty(
        name="Comparisons", description="What was compared: as it was baked, by Cycles, and the difference",
        type=GiBakeImage,
    )  # fmt: skip
    objects: StringProperty(
        name="Objects", description="Names of the objects that got light at vertices or are the volume, as a JSON list"
    )


class GiBakeScene(PropertyGroup):
    """`Scene.gi_bake`: how this scene is baked, and what was."""

    __annotations__ = annotations(fields(Settings)) | {
        "method": EnumProperty(
            name="Technique", description="How reflected light is found", items=METHODS, options=set()
        ),
        "target": EnumProperty(name="Target", description="What the light is baked for", items=TARGETS, options=set()),
        "scope": EnumProperty(
            name="Objects", description="Which objects get lightmaps or light at vertices; all others still reflect",
            items=SCOPES, options=set(),
        ),
        "resolution": IntProperty(
            name="Resolution", description="Side of each object's lightmap; memory and time grow with its square",
            default=256, min=4, max=16384, subtype="PIXEL", options=set(),
        ),
        "use_render_size": BoolProperty(
            name="Render Resolution",
            description="Camera image as large as a render; off, with a longer side of its own",
            default=True, options=set(),
        ),
        "image_resolution": IntProperty(
            name="Longer Side", description="Longer side of the camera image; time grows with its square",
            default=512, min=4, max=16384, subtype="PIXEL", options=set(),
        ),
        "uv": StringProperty(
            name="UV Map", description="UV map that lightmaps lie on, of the same name on every mesh; empty takes each "
            "mesh's active one", options=set(),
        ),
        "keep": EnumProperty(
            name="Keep Images", description="Where the result's images are kept", items=KEEPS, options=set()
        ),
        "folder": StringProperty(
            name="Output Folder", description="Folder for images, volumes and reports; // is beside the .blend",
            default="//gi_bake/", subtype="DIR_PATH", options=_RELATIVE,
        ),
        "reference_samples": IntProperty(
            name="Cycles Samples", description="Samples that Cycles takes for each pixel, texel or vertex to compare "
            "with; with few of them its own noise counts as our error, and time grows with their number",
            default=256, min=1, max=65536, options=set(),
        ),
        "rsm": PointerProperty(name="RSM", description="Settings of reflective shadow maps", type=GiBakeRsm),
        "lpv": PointerProperty(name="LPV", description="Settings of light propagation volumes", type=GiBakeLpv),
        "ssgi": PointerProperty(name="SSGI", description="Settings of screen-space GI", type=GiBakeSsgi),
        "results": CollectionProperty(name="Results", description="What was baked in this scene", type=GiBakeResult),
        "active_result": IntProperty(name="Active Result", description="Result that the buttons below the list work on",
                                     options=set()),
    }  # fmt: skip


class GiBakeObject(PropertyGroup):
    """`Object.gi_bake`: what holds for one object, see `object_options`."""

    use: BoolProperty(
        name="Bake",
        description="The object gets a lightmap or light at its vertices; off, it still reflects and casts shadows",
        default=True,
        options=set(),
    )
    casts: BoolProperty(
        name="Cast Light",
        description="The object casts shadows and reflects light; off, it only receives. Both off leave it out",
        default=True,
        options=set(),
    )
    lightmap_factor: FloatProperty(
        name="Density Factor",
        description="How many times more texels the object gets for each metre than the others",
        default=1.0, min=0.01, soft_max=8.0, max=100.0,
        options=set(),
    )  # fmt: skip
    lightmap_group: StringProperty(
        name="Lightmap Group",
        description="Name of a lightmap that the object shares with others of the same group; empty for what the scene "
        "says",
        options=set(),
    )
    method: EnumProperty(
        name="Technique",
        description="How reflected light on the object is found, in lightmaps and at vertices",
        items=(("SCENE", "Scene's", "The technique that is chosen for all"), *METHODS),
        options=set(),
    )


classes = (
    GiBakeRsm, GiBakeLpv, GiBakeSsgi, GiBakeImage, GiBakeResult, GiBakeScene, GiBakeObject,
)  # fmt: skip
_register, _unregister = bpy.utils.register_classes_factory(classes)


def register():
    _register()
    bpy.types.Scene.gi_bake = PointerProperty(
        name="GI Bake", description="How this scene is baked, and what was", type=GiBakeScene
    )
    bpy.types.Object.gi_bake = PointerProperty(
        name="GI Bake", description="How this object is baked", type=GiBakeObject
    )


def unregister():
    del bpy.types.Object.gi_bake
    del bpy.types.Scene.gi_bake
    _unregister()
