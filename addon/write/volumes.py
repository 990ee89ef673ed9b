# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume as a thing to work with: an OpenVDB file, a Volume object, and nodes that light any mesh from it.

Grids of the file, vectors with red, green and blue as x, y and z, in world space, values at the middles of cells:

    gi_irradiance          irradiance, mean over all directions of a surface's normal [W/m²]
    gi_sh_0 … gi_sh_8      coefficients of the irradiance over the normal, in the order of `gi_core.sh`; 0 … 3 alone
                           are two bands

The largest cascade has these names, those within it end in _1, _2, … from coarse to fine.

The node group "GI Irradiance" samples them at each vertex, with its normal, and stores the attribute `gi_irradiance`
(E [W/m²], as a bake to vertices does) on whatever mesh it is put, wherever that goes.
"""

import importlib.util
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import sh
from ...gi_core.lpv import Level, Volume
from .attributes import ATTRIBUTE
from .images import MARK

GROUP = "GI Irradiance"


class NoOpenVDB(RuntimeError):
    """This Blender has no openvdb module."""

    def __init__(self):
        super().__init__("this Blender has no openvdb module: volumes cannot be written; use Blender's own build")


def available() -> bool:
    """Whether volumes can be written here."""
    return importlib.util.find_spec("openvdb") is not None


def save_volume(path: Path, volume: Volume, half: bool = True) -> Path:
    """Write an OpenVDB file, compressed; the path. half: 16 bits a value, else 32.

    Raises NoOpenVDB where Blender was built without it, ValueError for an empty volume.
    """
    if not available():
        raise NoOpenVDB
    import openvdb

    if not volume.levels:
        raise ValueError("there is no light in the volume: nothing to write")
    grids = []
    for suffix, level in _named(volume):
        coefficients = level.irradiance.reshape(*level.grid.shape, -1, 3)
        mean = sh.integral(coefficients) / np.float32(4 * np.pi)
        values = {f"gi_sh_{k}": coefficients[..., k, :] for k in range(coefficients.shape[-2])}
        for name, array in {"gi_irradiance": mean, **values}.items():
            grid = openvdb.Vec3SGrid()
            # One more cell around: up to the border values go on as they are, not down to zero.
            array = np.pad(array, ((1, 1), (1, 1), (1, 1), (0, 0)), mode="edge")
            grid.copyFromArray(np.ascontiguousarray(array))
            grid.name, grid.saveFloatAsHalf = name + suffix, half
            side, (x, y, z) = level.grid.cell, level.grid.low - level.grid.cell / 2
            grid.transform = openvdb.createLinearTransform(
                [[side, 0, 0, 0], [0, side, 0, 0], [0, 0, side, 0], [x, y, z, 1]]
            )
            grids.append(grid)
    openvdb.write(str(path), grids=grids)
    return path


def store_volume(path: Path, volume: Volume, scene: bpy.types.Scene, blend: float = 2.0) -> bpy.types.Object:
    """The file as a Volume object where the scene is, and the node group; an earlier one of the scene is replaced.

    blend: cells over which a cascade goes over into the next larger one. Neither shows in renders by itself.
    """
    name = f"{scene.name} GI Volume"
    obj = next((o for o in bpy.data.objects if o.get(MARK) == name and o.library is None), None)
    if obj is None:
        obj = bpy.data.objects.new(name, bpy.data.volumes.new(name))
        obj[MARK] = name
        obj.hide_render, obj.display_type = True, "BOUNDS"
        scene.collection.objects.link(obj)
    obj.data.filepath = str(Path(path).resolve())
    group_name = f"{GROUP} {scene.name}"
    group = next((g for g in bpy.data.node_groups if g.get(MARK) == group_name and g.library is None), None)
    if group is None:
        group = bpy.data.node_groups.new(group_name, "GeometryNodeTree")
        group[MARK], group.is_modifier, group.use_fake_user = group_name, True, True
        group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    _build(group, obj, volume, blend)
    return obj


def light(obj: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Modifier:
    """Puts the scene's node group on an object, last of its modifiers."""
    [group] = [g for g in bpy.data.node_groups if g.get(MARK) == f"{GROUP} {scene.name}"]
    modifier = obj.modifiers.new(GROUP, "NODES")
    modifier.node_group = group
    return modifier


def _named(volume: Volume) -> list[tuple[str, Level]]:
    """Suffixes of grids' names with their cascades, largest first."""
    return [("" if k == 0 else f"_{k}", level) for k, level in enumerate(reversed(volume.levels))]


class _Nodes:
    """A node tree as expressions; every method returns an output socket."""

    def __init__(self, tree):
        self.tree = tree
        tree.nodes.clear()

    def node(self, kind, *inputs, **attributes):
        node = self.tree.nodes.new(kind)
        for name, value in attributes.items():
            setattr(node, name, value)
        enabled = [s for s in node.inputs if s.enabled]
        for socket, value in zip(enabled, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def vector(self, operation, *inputs):
        node = self.node("ShaderNodeVectorMath", *inputs, operation=operation)
        return next(s for s in node.outputs if s.enabled)

    def scaled(self, vector, factor):
        """Vector Math's Scale hides the inputs between its two."""
        node = self.tree.nodes.new("ShaderNodeVectorMath")
        node.operation = "SCALE"
        for socket, value in ((node.inputs[0], vector), (node.inputs["Scale"], factor)):
            self.tree.links.new(value, socket)
        return node.outputs[0]

    def math(self, operation, *inputs, clamp=False):
        return self.node("ShaderNodeMath", *inputs, operation=operation, use_clamp=clamp).outputs[0]

    def xyz(self, vector):
        return self.node("ShaderNodeSeparateXYZ", vector).outputs


def _build(group, volume_object, volume: Volume, blend: float) -> None:
    n = _Nodes(group)
    geometry = n.node("NodeGroupInput").outputs[0]
    own = n.node("GeometryNodeObjectInfo", n.node("GeometryNodeSelfObject").outputs[0]).outputs["Transform"]
    there = n.node("GeometryNodeObjectInfo", volume_object)
    back = n.node("FunctionNodeInvertMatrix", there.outputs["Transform"]).outputs[0]
    # To the volume's own space, should it have been moved; normals go by inverse transposes.
    world = n.node("FunctionNodeTransformPoint", n.node("GeometryNodeInputPosition").outputs[0], own).outputs[0]
    position = n.node("FunctionNodeTransformPoint", world, back).outputs[0]
    normal = n.node("GeometryNodeInputNormal").outputs[0]
    for matrix in (n.node("FunctionNodeInvertMatrix", own).outputs[0], there.outputs["Transform"]):
        transposed = n.node("FunctionNodeTransposeMatrix", matrix).outputs[0]
        normal = n.node("FunctionNodeTransformDirection", normal, transposed).outputs[0]
    basis = _basis(n, n.vector("NORMALIZE", normal), volume.levels[0].irradiance.shape[1])

    irradiance = None
    for suffix, level in _named(volume):
        here = None
        for k, value in enumerate(basis):
            name = f"gi_sh_{k}{suffix}"
            grid = n.node("GeometryNodeGetNamedGrid", there.outputs["Geometry"], name, data_type="VECTOR")
            sample = n.node("GeometryNodeSampleGrid", grid.outputs["Grid"], position, data_type="VECTOR")
            term = n.scaled(sample.outputs[0], value)
            here = term if here is None else n.vector("ADD", here, term)
        if irradiance is None:
            irradiance = here
            continue
        share = _share(n, position, level, blend)
        change = n.vector("SUBTRACT", here, irradiance)
        irradiance = n.vector("ADD", irradiance, n.scaled(change, share))
    irradiance = n.vector("MAXIMUM", irradiance, (0, 0, 0))
    stored = n.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT_COLOR", domain="POINT")
    stored.inputs["Name"].default_value = ATTRIBUTE
    group.links.new(geometry, stored.inputs["Geometry"])
    group.links.new(irradiance, next(s for s in stored.inputs if s.name == "Value" and s.enabled))
    n.node("NodeGroupOutput", stored.outputs[0])


def _basis(n: _Nodes, normal, count: int) -> list:
    """The harmonics' values at a normal, as sockets."""
    axes = dict(zip("xyz", n.xyz(normal)))
    values = []
    for factor, terms in zip(sh.FACTORS[:count], sh.POLYNOMIALS):
        total = None
        for weight, letters in terms:
            value = n.math("ADD", float(factor) * weight, 0.0)
            for letter in letters:
                value = n.math("MULTIPLY", value, axes[letter])
            total = value if total is None else n.math("ADD", total, value)
        values.append(total)
    return values


def _share(n: _Nodes, position, level: Level, blend: float):
    """How much a cascade counts at a point: 1 inside, 0 outside, as in `gi_core.lpv.lookup`."""
    local = n.scaled(n.vector("SUBTRACT", position, tuple(level.grid.low)), n.math("ADD", 1 / level.grid.cell, 0.0))
    inward = n.vector("MINIMUM", local, n.vector("SUBTRACT", tuple(float(s) for s in level.grid.shape), local))
    x, y, z = n.xyz(inward)
    depth = n.math("MINIMUM", n.math("MINIMUM", x, y), z)
    return n.math("DIVIDE", depth, max(blend, 1e-6), clamp=True)
