# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise taken out by Open Image Denoise, which Blender carries in its compositor's Denoise node.

A scene of its own, with nothing in it but that node, is rendered into a temporary file; scene, images and file are gone
afterwards. It needs no window and no graphics card, and must be called on the main thread like all of bpy.
"""

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import exr, images, tiles
from ..gi_core.dilate import dilate
from ..gi_core.filter import smooth
from ..gi_core.surfels import Surfels
from .read.render_depsgraph import own_render_slot

# The denoiser is given the image with its mirror image around it, to this distance and this side at least [px]: at the
# border of what it sees it would change colours by a quarter, and Blender renders no less than 4 pixels.
_FRAME, _SIDE = 8, 32

# What lies beyond a border is made up to this distance [px], by a filter of so many passes.
_MARGIN, _PASSES = 4, 3

# Albedo up to which light counts at least, where a pixel's subpixels are weighed by it: black surfaces are lit too.
_DARK = 1e-3


class DenoiserMissing(RuntimeError):
    """This Blender was built without Open Image Denoise, or the processor is too old for it."""


def oidn(image: np.ndarray, albedo: np.ndarray | None = None, normal: np.ndarray | None = None) -> np.ndarray:
    """An image without its noise: (h, w, 3) float32, scene-linear, of any range, to the same.

    albedo, normal: (h, w, 3) float32 guides without noise, 0…1 and −1…1; edges in them stay sharp in the image.
    Raises ValueError for values that are not finite, guides of another size and a normal without an albedo, which
    Blender ignores; DenoiserMissing; RuntimeError where Blender cannot render now.
    """
    if normal is not None and albedo is None:
        raise ValueError("Open Image Denoise takes a normal as a guide only beside an albedo")
    inputs = {name: a for name, a in (("Image", image), ("Albedo", albedo), ("Normal", normal)) if a is not None}
    for name, pixels in inputs.items():
        if pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size or pixels.shape != image.shape:
            raise ValueError(f"cannot denoise: {name} has the shape {pixels.shape}, not that of a (h, w, 3) image")
        if bad := np.count_nonzero(~np.isfinite(pixels).all(-1)):
            raise ValueError(f"cannot denoise: {name} has {bad} pixels that are not finite numbers")
    height, width = image.shape[:2]
    frame = [(_FRAME, max(_FRAME, _SIDE - height)), (_FRAME, max(_FRAME, _SIDE - width)), (0, 0)]
    noisy = {name: np.pad(pixels, frame, mode="symmetric") for name, pixels in inputs.items()}
    clean = _composited(noisy)
    # Without the library the node hands its input on, and says so nowhere.
    if np.array_equal(clean, noisy["Image"]) and np.ptp(clean) > 0:
        raise DenoiserMissing("Open Image Denoise does not work in this Blender: use denoise=bilateral")
    return clean[_FRAME : _FRAME + height, _FRAME : _FRAME + width].copy()


def is_available() -> bool:
    """Whether `oidn` works in this Blender, found out on a small image."""
    try:
        oidn(np.random.default_rng(0).random((_SIDE, _SIDE, 3), np.float32))
    except DenoiserMissing:
        return False
    return True


def smoothed(irradiance: np.ndarray, surfels: Surfels, resolution: tuple[int, int], subpixels: int) -> Iterator[float]:
    """Irradiance of an image's surfels, denoised by whole pixels: each gets its pixel's, so that the pixel's light over
    its colour is just what the denoiser gave.

    irradiance: (n, 3 k). resolution: (width, height) in subpixels; `subpixels`: of a pixel along each axis.
    A generator of progress; returns (n, 3 k) float32. Raises what `oidn` raises.
    """

    def mean(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
        return images.by_pixel(values, weight, surfels, resolution, subpixels)

    one = np.ones((len(surfels), 1), np.float32)
    valid = mean(one, one)[..., 0] > 0
    guides = np.concatenate([mean(surfels.albedo, one), mean(surfels.normal, one)], -1)
    position = mean(surfels.position, one)
    grown, _ = dilate(guides, valid, _MARGIN)
    parts = np.split(irradiance, irradiance.shape[1] // 3, axis=1)
    for k, part in enumerate(parts):
        yield k / len(parts)
        if not part.any():
            continue
        light = mean(part, surfels.albedo + np.float32(_DARK))
        if not valid.all():
            # Black beyond the border would darken it, and single noisy pixels drawn out would be taken for light.
            filled = tiles.finish(smooth(light, position, guides[..., 3:], _PASSES))
            filled, _ = dilate(filled, valid, _MARGIN)
            light = np.where(valid[..., None], light, filled)
        clean = oidn(light, grown[..., :3], grown[..., 3:])
        parts[k] = images.of_pixels(clean, surfels, subpixels)
    return np.concatenate(parts, axis=1)


def _composited(inputs: dict[str, np.ndarray]) -> np.ndarray:
    """What a Denoise node makes of the images at its sockets: socket name -> (h, w, 3), to (h, w, 3) float32."""
    height, width = inputs["Image"].shape[:2]
    with contextlib.ExitStack() as gone:
        gone.enter_context(own_render_slot())
        path = Path(gone.enter_context(tempfile.TemporaryDirectory())) / "denoised.exr"
        # Ours and those that Blender adds by itself, of viewers.
        before = set(bpy.data.images)
        gone.callback(lambda: bpy.data.batch_remove(set(bpy.data.images) - before))
        scene = bpy.data.scenes.new("GI Bake")
        gone.callback(bpy.data.scenes.remove, scene)
        camera = bpy.data.cameras.new("GI Bake")
        gone.callback(bpy.data.cameras.remove, camera)  # takes the object along
        scene.camera = bpy.data.objects.new("GI Bake", camera)
        scene.view_layers[0].use = False
        render = scene.render
        # Nothing is drawn; this engine is the one that starts at once.
        render.engine = "BLENDER_WORKBENCH"
        render.resolution_x, render.resolution_y = width, height
        render.compositor_device = "CPU"
        render.filepath = str(path)
        file = render.image_settings
        file.file_format, file.color_mode, file.color_depth, file.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"

        tree, output = _tree(scene, gone)
        node = _denoise_node(tree)
        tree.links.new(node.outputs["Image"], output.inputs["Image"])
        for name, pixels in inputs.items():
            picture = bpy.data.images.new("GI Bake", width, height, float_buffer=True, is_data=True)
            opaque = np.ones((height, width, 4), np.float32)
            opaque[..., :3] = pixels
            picture.pixels.foreach_set(opaque.ravel())
            source = tree.nodes.new("CompositorNodeImage")
            source.image = picture
            tree.links.new(source.outputs["Image"], node.inputs[name])

        bpy.ops.render.render(write_still=True, scene=scene.name)
        if not path.exists():
            raise RuntimeError("Blender cannot denoise now: wait until the running render has ended")
        return exr.read_layers(path)["Combined"][..., :3]


def _tree(scene: bpy.types.Scene, gone: contextlib.ExitStack) -> tuple[bpy.types.NodeTree, bpy.types.Node]:
    """An empty compositor tree of the scene and the node that its picture goes to."""
    if bpy.app.version < (5, 0):
        scene.use_nodes = True
        scene.node_tree.nodes.clear()
        return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite")
    tree = bpy.data.node_groups.new("GI Bake", "CompositorNodeTree")
    gone.callback(bpy.data.node_groups.remove, tree)
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    scene.compositing_node_group = tree
    return tree, tree.nodes.new("NodeGroupOutput")


def _denoise_node(tree: bpy.types.NodeTree) -> bpy.types.Node:
    node = tree.nodes.new("CompositorNodeDenoise")
    node.inputs["HDR"].default_value = True
    # Our guides have no noise to be taken out first, which takes longer than all the rest.
    if bpy.app.version < (5, 0):
        node.prefilter = "NONE"
    else:
        node.inputs["Prefilter"].default_value = "None"
    return node
