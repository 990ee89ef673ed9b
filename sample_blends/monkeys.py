# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of monkeys that a baked volume lights: `python sample_blends/monkeys.py`, with GI Bake and the bpy wheel.

The volume of cornell.blend is baked without them. Then monkeys stand in the room, whose material shines with the light
that the node group finds where they are and shows nothing of the lamp's, and Cycles renders pictures/monkeys.png.
"""

import argparse
import math
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

# openvdb comes with Blender, in a folder that the bpy wheel leaves off the path.
sys.path.extend(str(p) for p in Path(find_spec("bpy").origin).parent.glob("*/python/lib/python3.*/site-packages"))

import bpy
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.addon.write.results import export, store
from gi_bake.addon.write.volumes import light
from gi_bake.gi_core.lpv import LpvSettings
from gi_bake.gi_core.tiles import finish

FOLDER = Path(__file__).resolve().parent
IN_THE_WAY = ("Tall box", "Short box")
PLACES = ((-0.62, -0.35, 0.5), (0.0, 0.1, 1.3), (0.62, -0.35, 0.5))
ALBEDO = 0.8


def main():
    parser = argparse.ArgumentParser(description="Render the picture of monkeys in a baked volume.")
    parser.add_argument("--output", type=Path, default=FOLDER / "pictures" / "monkeys.png", metavar="FILE")
    parser.add_argument("--resolution", type=int, default=360, metavar="N", help="side of the picture [px]")
    parser.add_argument("--samples", type=int, default=128, metavar="N", help="Cycles' samples")
    args = parser.parse_args()
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / "cornell.blend"))
    scene = bpy.context.scene
    for name in IN_THE_WAY:
        bpy.data.objects.remove(bpy.data.objects[name])
    job = Job(method="lpv", target="volume", settings=LpvSettings(bounces=4))
    result = finish(bake(scene, bpy.context.view_layer, job))
    with tempfile.TemporaryDirectory() as folder:
        export(result, Path(folder), "")
        store(result, scene, Path(folder))
        material = shining()
        for place in PLACES:
            monkey(scene, place, material)
        render(scene, args)


def shining():
    """A material that sends out what a surface of ALBEDO reflects of `gi_irradiance`: radiance albedo · E/π."""
    material = bpy.data.materials.new("Lit by the volume")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    attribute, emission, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "Emission", "OutputMaterial")
    )
    attribute.attribute_name = "gi_irradiance"
    emission.inputs["Strength"].default_value = ALBEDO / math.pi
    tree.links.new(attribute.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def monkey(scene, place, material):
    bpy.ops.mesh.primitive_monkey_add(size=0.6, location=place)
    obj = bpy.context.object
    obj.modifiers.new("Smooth", "SUBSURF").render_levels = 2
    bpy.ops.object.shade_smooth()
    obj.data.materials.append(material)
    light(obj, scene)
    # It is lit, and lights and shades nothing.
    for ray in ("diffuse", "glossy", "transmission", "shadow"):
        setattr(obj, f"visible_{ray}", False)


def render(scene, args):
    scene.render.resolution_x = scene.render.resolution_y = args.resolution
    scene.render.resolution_percentage = 100
    scene.cycles.samples, scene.cycles.seed, scene.cycles.use_denoising = args.samples, 0, True
    scene.view_settings.exposure = 1.7
    scene.render.image_settings.file_format = "PNG"
    for stamp in (key for key in scene.render.bl_rna.properties.keys() if key.startswith("use_stamp_")):
        setattr(scene.render, stamp, False)  # no paths, dates or times in the picture's metadata
    scene.render.filepath = str(args.output.resolve())
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
