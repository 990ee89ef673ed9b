# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Constants: the one value that stands best for what a node tree computes, and whether it is exact."""

import colorsys

import bpy
import numpy as np

from ...gi_core.gloss import fresnel_mean
from .nodes import Feed, Reading, feed, set_value

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

MIXES = {"MIX", "MIX_RGB"}

# What a ray sees that comes to a surface after a diffuse bounce, which is most of what a bake is made of.
LIGHT_PATH = {"Is Diffuse Ray": 1.0, "Is Reflection Ray": 1.0, "Ray Depth": 1.0, "Diffuse Depth": 1.0}


def estimate(source: Feed, reading: Reading) -> tuple[np.ndarray, str]:
    """The constant that stands best for a `Feed`: ((3,) float64, name of the node that makes it inexact or "")."""
    if source.node is None:
        return set_value(source.socket), ""
    key = source.socket.as_pointer(), tuple(group.as_pointer() for group in source.groups)
    if key not in reading.known:
        reading.known[key] = _estimate_node(source, reading)
    return reading.known[key]


def _estimate_node(source: Feed, reading: Reading) -> tuple[np.ndarray, str]:
    node = source.node

    def of(socket):
        inner = feed(socket, source.groups)
        value, doubt = estimate(inner, reading)
        if socket.type == "VALUE" and inner.socket.type == "RGBA":
            value = np.full(3, value @ LUMINANCE)
        return value, doubt

    match node.type:
        case "RGB" | "VALUE":
            return set_value(source.socket), ""
        case "BLACKBODY":
            value, doubt = of(node.inputs[0])
            return blackbody(value[0]), doubt
        case "TEX_IMAGE" | "TEX_ENVIRONMENT":
            if source.socket.name == "Alpha":
                return np.ones(3), node.name
            return reading.images.texture(node, reading).pixels.mean((0, 1), dtype=np.float64), node.name
        case "LIGHT_PATH":
            return np.full(3, LIGHT_PATH.get(source.socket.name, 0.0)), node.name
        case "FRESNEL":  # the mean over a cosine-weighted hemisphere
            ior, _ = of(node.inputs["IOR"])
            return fresnel_mean(max(ior[0], 1.0)) * np.ones(3), node.name
        case "VALTORGB":
            factor, doubt = of(node.inputs[0])
            places = np.linspace(0, 1, 33) if doubt else factor[:1]
            value = np.mean([node.color_ramp.evaluate(float(place)) for place in places], axis=0)
            return (value[:3] if source.socket.name == "Color" else np.full(3, value[3])), doubt
        case "HUE_SAT" | "INVERT" | "GAMMA" | "BRIGHTCONTRAST":
            parts = [of(socket) for socket in node.inputs]
            return _adjusted(node.type, *(value for value, _ in parts)), _first(parts)
        case "SEPARATE_COLOR" if node.mode == "RGB":
            value, doubt = of(node.inputs[0])
            return np.full(3, value[list(node.outputs).index(source.socket)]), doubt
        case "COMBINE_COLOR" if node.mode == "RGB":
            parts = [of(socket) for socket in node.inputs]
            return np.array([value[0] for value, _ in parts]), _first(parts)
        case "MATH" if node.operation in MATH:
            parts = [of(socket) for socket in node.inputs[:2]]
            value = MATH[node.operation](*(value for value, _ in parts))
            return (np.clip(value, 0, 1) if node.use_clamp else value), _first(parts)
        case "MIX" | "MIX_RGB" if is_color_mix(node) or node.data_type != "ROTATION":
            parts = [of(socket) for socket in mix_inputs(node)]
            (share, _), (a, _), (b, _) = parts
            share = np.clip(share, 0, 1)
            blend = node.blend_type if is_color_mix(node) else "MIX"
            mixed = {"MIX": b, "MULTIPLY": a * b, "ADD": a + b, "SUBTRACT": a - b}.get(blend)
            if mixed is None:
                return a + share * (b - a), node.name
            return a + share * (mixed - a), _first(parts)
    # Any other node: its colours, where it has some, else grey.
    colors = [of(socket)[0] for socket in node.inputs if socket.type == "RGBA" and not socket.is_unavailable]
    return (np.mean(colors, axis=0) if colors else np.full(3, 0.5)), node.name


def is_color_mix(node: bpy.types.Node) -> bool:
    """Whether a node of type MIXES mixes colours."""
    return node.type == "MIX_RGB" or node.data_type == "RGBA"


def mix_inputs(node: bpy.types.Node) -> list[bpy.types.NodeSocket]:
    """Factor, A and B of a node of type MIXES, whose every type of data has sockets of its own."""
    if node.type == "MIX_RGB":
        return node.inputs[:3]
    kind = {"FLOAT": "Float", "RGBA": "Color", "VECTOR": "Vector"}[node.data_type]
    uniform = kind != "Vector" or node.factor_mode == "UNIFORM"
    names = ("Factor_Float" if uniform else "Factor_Vector", f"A_{kind}", f"B_{kind}")
    return [next(socket for socket in node.inputs if socket.identifier == name) for name in names]


def _adjusted(kind: str, *inputs: np.ndarray) -> np.ndarray:
    """What the nodes that adjust a colour make of a constant one."""
    match kind, inputs:
        case "HUE_SAT", (hue, saturation, value, share, color):
            h, s, v = colorsys.rgb_to_hsv(*color)
            s = min(max(s * saturation[0], 0.0), 1.0)
            adjusted = colorsys.hsv_to_rgb((h + hue[0] + 0.5) % 1.0, s, v * value[0])
            return np.maximum(color + share * (np.array(adjusted) - color), 0.0)
        case "INVERT", (share, color):
            return color + share * (1 - 2 * color)
        case "GAMMA", (color, gamma):
            return np.where(color > 0, np.maximum(color, 0.0) ** gamma, color)
        case "BRIGHTCONTRAST", (color, bright, contrast):
            return np.maximum((1 + contrast) * color + bright - contrast / 2, 0.0)


MATH = {
    "ADD": np.add,
    "SUBTRACT": np.subtract,
    "MULTIPLY": np.multiply,
    "DIVIDE": lambda a, b: np.divide(a, b, out=np.zeros(3), where=b != 0),
    "POWER": lambda a, b: np.power(np.maximum(a, 0.0), b),
    "MINIMUM": np.minimum,
    "MAXIMUM": np.maximum,
}


def _first(parts: list[tuple[np.ndarray, str]]) -> str:
    return next((doubt for _, doubt in parts if doubt), "")


def blackbody(temperature: float) -> np.ndarray:
    """Rec.709 colour of a black body at `temperature` [K], of luminance 1.

    Planck's law through the colour matching functions of Wyman, Sloan and Shirley (JCGT 2013), multi-lobe. From 2000 K
    on it is within 3 % of Cycles' own fit.
    """
    wavelength = np.arange(380.0, 781.0, 5.0)

    def lobe(scale, centre, below, above):
        width = np.where(wavelength < centre, below, above)
        return scale * np.exp(-0.5 * ((wavelength - centre) * width) ** 2)

    matching = np.array([
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ])
    metres = wavelength * 1e-9
    emitted = metres**-5 / np.expm1(1.438777e-2 / (metres * max(temperature, 800.0)))
    xyz = matching @ emitted
    rgb = _XYZ_TO_REC709 @ (xyz / xyz[1])
    return np.maximum(rgb, 0.0)


_XYZ_TO_REC709 = np.array([
    [3.2404542, -1.5371385, -0.4985314],
    [-0.9692660, 1.8760108, 0.0415560],
    [0.0556434, -0.2040259, 1.0572252],
])
