# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise taken out by Open Image Denoise, which Blender carries.

Where the library cannot be reached the Denoise node of Blender's compositor calls it: a scene of its own, with nothing
in it but that node, is rendered into a temporary file; scene, images and file are gone afterwards. It needs no window
and no graphics card, but must be called on the main thread like all of bpy.
"""

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import exr, tiles
from ..gi_core.dilate import dilate
from ..gi_core.filter import smooth
from ..gi_core.islands import islands
from . import oidn as library
from .read.render_depsgraph import own_render_slot

# The denoiser is given the image with its mirror image around it, to this distance and this side at least [px]: at the
# border of what it sees it would change colours by a quarter, and Blender renders no less than 4 pixels.
_FRAME, _SIDE = 8, 32

# What lies beyond a border is made up to this distance [px], by a filter of so many passes.
_MARGIN, _PASSES = 4, 3

# What is known of each pixel beside its light.
_GUIDES = ("Color", "Normal", "Position", "Coverage")

# Pixels that go through the denoiser at once, where images are small: each time costs as much as ten thousand of them.
_PIXELS = 1 << 21


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
    clean = _clean({name: _framed(pixels) for name, pixels in inputs.items()})
    return clean[_FRAME : _FRAME + height, _FRAME : _FRAME + width].copy()


def _clean(noisy: dict[str, np.ndarray]) -> np.ndarray:
    """What the denoiser makes of images that have a frame around them: socket name -> (h, w, 3), to (h, w, 3)."""
    if library.library():
        return library.denoised(noisy["Image"], {name.lower(): noisy[name] for name in noisy if name != "Image"})
    clean = _composited(noisy)
    # Without the library the node hands its input on, and says so nowhere.
    if np.array_equal(clean, noisy["Image"]) and np.ptp(clean) > 0:
        raise DenoiserMissing("Open Image Denoise does not work in this Blender: use denoise=bilateral")
    return clean


def stage() -> str:
    """The stage of a bake whose steps it is called in: "oidn", on any thread, or "compositor", on the main thread."""
    return "oidn" if library.library() else "compositor"


def is_available() -> bool:
    """Whether `oidn` works in this Blender, found out on a small image."""
    try:
        oidn(np.random.default_rng(0).random((_SIDE, _SIDE, 3), np.float32))
    except DenoiserMissing:
        return False
    return True


def works_now() -> bool:
    """Whether `oidn` works in this Blender and at this moment, when it may be rendering."""
    try:
        return is_available()
    except RuntimeError:
        return False


def smoothed(light: list[np.ndarray], found: list[dict[str, np.ndarray]]) -> Iterator[float]:
    """Images of irradiance without their noise: (h, w, 3 k) each. A generator of progress; returns a list of the same.

    found: for each image what lies there: "Color", "Normal", "Position" (h, w, 3) and "Coverage" (h, w, 1).
    Small images go through the denoiser together. Raises what `oidn` raises.
    """
    prepared = [_prepared(*each) for each in zip(light, found)]
    clean: list[list[np.ndarray]] = [[] for _ in light]
    groups = _together([guides.shape for _, guides in prepared])
    layers = max((image.shape[2] // 3 for image in light), default=0)
    for k in range(layers):
        for done, group in enumerate(groups):
            yield (k + done / len(groups)) / layers
            stacked, guides = (np.concatenate([prepared[i][part] for i in group]) for part in (0, 1))
            noisy = stacked[..., 3 * k : 3 * k + 3]
            inputs = {"Image": noisy, "Albedo": guides[..., :3], "Normal": guides[..., 3:]}
            smooth = _clean(inputs) if noisy.any() else noisy
            ends = np.cumsum([len(prepared[i][1]) for i in group])
            for i, image in zip(group, np.split(smooth, ends[:-1])):
                h, w = light[i].shape[:2]
                clean[i].append(image[_FRAME : _FRAME + h, _FRAME : _FRAME + w])
    return [np.concatenate(parts, -1) if parts else image for parts, image in zip(clean, light)]


def smoothed_islands(light: list[np.ndarray], found: list[dict[str, np.ndarray]]) -> Iterator[float]:
    """`smoothed` for lightmaps: each island by itself, so that none takes light from another beside it."""
    whole = [islands(each["Coverage"][..., 0] > 0) for each in found]
    pieces = []
    for i, each in enumerate(whole):
        for k in range(len(each)):
            (top, bottom), (left, right) = each.rows[k], each.columns[k]
            pieces.append((_bucket(right - left), i, k, (slice(top, bottom), slice(left, right))))
    # Of one width they go through the denoiser together.
    pieces.sort(key=lambda piece: piece[:3])
    parts, guides = [], []
    for width, i, k, box in pieces:
        own = whole[i].label[box] == k

        def cut(image: np.ndarray, box=box, own=own, width=width) -> np.ndarray:
            return np.pad(np.where(own[..., None], image[box], 0), [(0, 0), (0, width - own.shape[1]), (0, 0)])

        parts.append(cut(light[i]))
        guides.append({name: cut(layer) for name, layer in found[i].items() if name in _GUIDES})
    clean = yield from smoothed(parts, guides)
    done = [np.zeros_like(image) for image in light]
    for (_, i, k, box), part in zip(pieces, clean):
        own = whole[i].label[box] == k
        done[i][box][own] = part[:, : own.shape[1]][own]
    return done


def _bucket(width: int) -> int:
    """The next power of two, or half between two."""
    size = _SIDE
    while size < width:
        size = size * 3 // 2 if width <= size * 3 // 2 else size * 2
    return size


def _prepared(light: np.ndarray, found: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Light and guides (…, 6) of an image, continued beyond its islands and its border."""
    valid = found["Coverage"][..., 0] > 0
    guides = np.concatenate([found["Color"], found["Normal"]], -1)
    if not valid.all():
        # Black beyond the border would darken it, and single noisy pixels drawn out would be taken for light.
        filled = tiles.finish(smooth(light, found["Position"], found["Normal"], _PASSES))
        filled, _ = dilate(filled, valid, _MARGIN)
        light = np.where(valid[..., None], light, filled)
        guides, _ = dilate(guides, valid, _MARGIN)
    return _framed(light), _framed(guides)


def _framed(image: np.ndarray) -> np.ndarray:
    """An image with its mirror image around it."""
    height, width = image.shape[:2]
    return np.pad(image, [(_FRAME, max(_FRAME, _SIDE - n)) for n in (height, width)] + [(0, 0)], mode="symmetric")


def _together(shapes: list[tuple[int, ...]]) -> list[list[int]]:
    """Numbers of images to go through the denoiser at once: of one width, and not too many pixels."""
    groups: list[list[int]] = []
    count = 0
    for i, (height, width, _) in enumerate(shapes):
        if groups and width == shapes[groups[-1][0]][1] and count + height * width <= _PIXELS:
            groups[-1].append(i)
            count += height * width
        else:
            groups.append([i])
            count = height * width
    return groups


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
