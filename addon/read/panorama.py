# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A world made of nodes as an image of all that is around, as Cycles renders it.

An empty scene of its own with a copy of the world is rendered into a temporary file; both are gone afterwards. It must
be called where Blender's data may be changed, on the main thread.
"""

import contextlib
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import exr
from ...gi_core.scene import Texture
from .constants import LIGHT_PATH
from .render_depsgraph import own_render_slot

# Pixels and samples of each. A pixel is as wide as two thirds of the sun.
_SIZE, _SAMPLES = (1024, 512), 2

# The sun's few pixels hold most of the light: brighter than the mean by this factor they get so many samples in all.
_BRIGHT, _MOST = 10.0, 1 << 17


def panorama(world: bpy.types.World, frame: float) -> Texture:
    """The radiance of a world at a frame, equirectangular as `Environment` has it, as diffuse surfaces see it.

    Raises RuntimeError where Blender cannot render now.
    """
    with contextlib.ExitStack() as gone:
        gone.enter_context(own_render_slot())
        path = Path(gone.enter_context(tempfile.TemporaryDirectory())) / "panorama.exr"
        scene = _scene(world, frame, gone)
        scene.render.filepath = str(path)

        def rendered(samples: int) -> np.ndarray:
            scene.cycles.samples = samples
            bpy.ops.render.render(write_still=True, scene=scene.name)
            if not path.exists():
                raise RuntimeError("Blender cannot render the world now: wait until the running render has ended")
            return exr.read_layers(path)["Combined"][..., :3].copy()

        pixels = rendered(_SAMPLES)
        scene.render.use_border = True
        for box in _bright_boxes(pixels):
            rows, columns = box
            (width, height), size = _SIZE, pixels[box].size // 3
            scene.render.border_min_x, scene.render.border_max_x = columns.start / width, columns.stop / width
            scene.render.border_min_y, scene.render.border_max_y = rows.start / height, rows.stop / height
            if size * _SAMPLES < _MOST:
                pixels[box] = rendered(min(_MOST // size, 4096))[box]
        return Texture(world.name, pixels)


def _bright_boxes(pixels: np.ndarray) -> list[tuple[slice, slice]]:
    """Rows and columns around the brightest pixels, for either half of the image, at whose border a sun may be cut."""
    brightness = pixels.mean(-1)
    height, width = brightness.shape
    narrowing = np.cos(np.pi * ((np.arange(height) + 0.5) / height - 0.5))[:, None]
    bright = brightness > _BRIGHT * np.mean(brightness * narrowing) / np.mean(narrowing)
    boxes = []
    for half in (slice(0, width // 2), slice(width // 2, width)):
        row, column = np.nonzero(bright[:, half])
        if len(row):
            low, high = max(row.min() - 2, 0), min(row.max() + 3, height)
            left, right = max(column.min() - 2, 0), min(column.max() + 3, width // 2)
            boxes.append((slice(low, high), slice(half.start + left, half.start + right)))
    return boxes


def _scene(world: bpy.types.World, frame: float, gone: contextlib.ExitStack) -> bpy.types.Scene:
    """A scene with nothing but a copy of the world and a camera that looks around."""
    copy = world.copy()
    gone.callback(bpy.data.worlds.remove, copy)
    copy.cycles.sampling_method = "NONE"  # spares the map of where light comes from
    copy.cycles_visibility.camera = True
    _as_for_diffuse_rays(copy.node_tree, gone)

    scene = bpy.data.scenes.new("GI Bake")
    gone.callback(bpy.data.scenes.remove, scene)
    scene.world = copy
    scene.frame_current, scene.frame_subframe = int(frame // 1), frame % 1
    camera = bpy.data.cameras.new("GI Bake")
    gone.callback(bpy.data.cameras.remove, camera)  # takes the object along
    camera.type = "PANO"
    # Cycles' own setting until it became the camera's.
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    scene.camera = bpy.data.objects.new("GI Bake", camera)
    scene.camera.rotation_euler = (np.pi / 2, 0, -np.pi / 2)  # +X in the middle, +Z up
    scene.collection.objects.link(scene.camera)

    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = *_SIZE, 100
    render.use_compositing = render.use_sequencer = False
    cycles.device, cycles.pixel_filter_type = "CPU", "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    file = render.image_settings
    file.file_format, file.color_mode, file.color_depth = "OPEN_EXR", "RGB", "32"
    return scene


def _as_for_diffuse_rays(tree: bpy.types.NodeTree, gone: contextlib.ExitStack) -> None:
    """Puts what they are for light that comes to a diffuse surface in the place of Light Path nodes."""
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree:
            node.node_tree = node.node_tree.copy()
            gone.callback(bpy.data.node_groups.remove, node.node_tree)
            _as_for_diffuse_rays(node.node_tree, gone)
        elif node.type == "LIGHT_PATH":
            for output in node.outputs:
                constant = tree.nodes.new("ShaderNodeValue").outputs[0]
                constant.default_value = LIGHT_PATH.get(output.name, 0.0)
                for socket in [link.to_socket for link in output.links]:
                    tree.links.new(constant, socket)
