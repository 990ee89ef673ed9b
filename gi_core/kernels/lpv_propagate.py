# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One step of light from every cell to its six neighbours: Kaplanyan & Dachsbacher 2010, §4.3.

A cell's intensity is u + v·ω, its two bands (see `sh.affine`). In each direction D the neighbour's front face and its
four side faces receive what the cell sends towards their middles,

    front:   I = max(0, u + D·v),        flux = Ω_front I
    side F:  I = max(0, u + e·v),        flux = Ω_side I,        e = (2D + F)/√5,

and each face sends that on from the neighbour's middle as a cosine lobe about its own direction: of the flux Φ it adds
Φ/π · ¼ to u and Φ/π · ½ F to v. The solid angles are exact, 6 (Ω_front + 4 Ω_side) = 4π: an isotropic cell loses
nothing. A cosine lobe gains 13.8 % in its first step, since two bands are negative behind it and what is clamped there
is not taken away from the rest.
"""

import numpy as np

FRONT, SIDE = 0.4006696846, 0.4234313544


def step(front, blocked=None, albedo=None, damping: float = 1.0, layers: slice = slice(None)):
    """The light after one more step: (4, x, y, z, 3) of u, v_x, v_y, v_z [W/sr] -> the same. What leaves is gone.

    blocked: (3, x, y, z) share of light stopped on its way from a cell to the next one along an axis, and back.
    albedo: (3, x, y, z, 3) share of what is stopped there that is sent back as a lobe.
    damping: what is left of light after the step. layers: which are wanted along x.
    """
    first, last, _ = layers.indices(front.shape[1])
    if first > 0 or last < front.shape[1]:
        around = slice(max(first - 1, 0), last + 1)
        walls = (None if a is None else a[:, around] for a in (blocked, albedo))
        return step(front[:, around], *walls, damping)[:, first - around.start :][:, : last - first]
    u, v = front[0], front[1:]
    out = np.zeros_like(front)
    ahead, aside = np.float32(2 / np.sqrt(5)), np.float32(1 / np.sqrt(5))
    for axis in range(3):
        here, there = [slice(None)] * 3, [slice(None)] * 3
        here[axis], there[axis] = slice(None, -1), slice(1, None)
        here, there = tuple(here), tuple(there)
        open_share = 1 if blocked is None else (1 - blocked[axis][here])[..., None]
        for sign in (1, -1):
            source, target = (here, there) if sign > 0 else (there, here)
            along = u[source] + sign * ahead * v[axis][source]
            sent = np.maximum(u[source] + sign * v[axis][source], 0) * np.float32(FRONT / np.pi)
            total = sent.copy()
            out[1 + axis][target] += (0.5 * sign) * sent * open_share
            for other in (a for a in range(3) if a != axis):
                across = aside * v[other][source]
                plus = np.maximum(along + across, 0) * np.float32(SIDE / np.pi)
                minus = np.maximum(along - across, 0) * np.float32(SIDE / np.pi)
                out[1 + other][target] += 0.5 * (plus - minus) * open_share
                total += plus + minus
            out[0][target] += 0.25 * total * open_share
            if albedo is not None:
                back = total * (1 - open_share) * albedo[axis][here]
                out[0][source] += 0.25 * back
                out[1 + axis][source] -= (0.5 * sign) * back
    return out if damping == 1 else out * np.float32(damping)


def step_on_gpu(gpu, front, blocked=None, albedo=None, damping: float = 1.0, layers: slice = slice(None)):
    _, x, y, z, _ = front.shape
    following = gpu.empty(front.shape, 3)
    inputs = {"front": (front, 3)}
    if blocked is not None:
        inputs["blocked"] = blocked, 1
        if albedo is not None:
            inputs["albedo"] = albedo, 3
    gpu.dispatch(
        "lpv_propagate", x * y * z, inputs, {"next": following}, integers={"size_x": x, "size_y": y, "size_z": z},
        floats={"damping": damping}, defines={"WALLS": int("blocked" in inputs), "BOUNCE": int("albedo" in inputs)},
        steps=12,
    )  # fmt: skip
    return following


def layer_sums(front):
    """What each layer of cells along x holds: (4, x, y, z, 3) -> (x, 3) float32, 4π of which is its flux [W/sr]."""
    return front[0].sum((1, 2))


def layer_sums_on_gpu(gpu, front):
    _, x, y, z, _ = front.shape
    held = gpu.empty((x, 3), 3)
    gpu.dispatch("layer_sums", x, {"front": (front, 3)}, {"held": held}, integers={"count": y * z}, steps=y * z)
    return held
