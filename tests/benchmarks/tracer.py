# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays per second: incoherent shadow rays and closest hits on a bumpy surface of 200 k triangles, on one core and on
all.

python tests/benchmarks/tracer.py [--json FILE]
"""

import argparse
import json
import os
import time
from pathlib import Path

import numpy as np
from gi_bake.gi_core import tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.scene import ColorSource, Instance, Material, Mesh, Scene
from gi_bake.gi_core.trace import Tracer

RAYS, TILE, SIDE = 1 << 21, 1 << 16, 318


def bumps() -> Scene:
    x, y = np.meshgrid(np.linspace(0, 1, SIDE), np.linspace(0, 1, SIDE))
    vertices = np.dstack([x, y, 0.1 * np.sin(40 * x) * np.cos(43 * y)]).reshape(-1, 3).astype(np.float32)
    i = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    triangles = np.concatenate([np.dstack([a, b, c]).reshape(-1, 3), np.dstack([a, c, d]).reshape(-1, 3)]).astype(
        np.int32
    )
    normals = np.zeros((len(triangles), 3, 3), np.float32)
    mesh = Mesh("bumps", vertices, triangles, normals, np.zeros(len(triangles), np.int32))
    return Scene(
        (mesh,), (Instance("bumps", 0, np.eye(4), (0,)),), (Material("m", ColorSource(np.ones(3, np.float32))),)
    )


def rates() -> dict:
    """Mrays/s of each kind of query."""
    geometry = Geometry(bumps())
    tracer = Tracer(geometry)
    rng = np.random.default_rng(0)
    origins = rng.uniform((0, 0, -0.1), (1, 1, 0.3), (RAYS, 3)).astype(np.float32)
    directions = rng.standard_normal((RAYS, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    far = np.full(RAYS, 1.0, np.float32)
    queries = {
        "shadow": lambda part: tracer.occluded(origins[part], directions[part], far[part]),
        "closest": lambda part: tracer.closest(origins[part], directions[part]),
    }
    parts = tiles.slices(RAYS, TILE)
    found = {}
    for name, query in queries.items():
        begin = time.perf_counter()
        for part in parts:
            query(part)
        one = time.perf_counter() - begin
        begin = time.perf_counter()
        tiles.finish(tiles.run(query, parts))
        every = time.perf_counter() - begin
        found[name] = {
            "one core [Mrays/s]": RAYS / one / 1e6,
            "all cores [Mrays/s]": RAYS / every / 1e6,
            "ratio": one / every,
        }
    return {"triangles": len(geometry.triangles), "rays": RAYS, "cores": os.cpu_count(), "rates": found}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--json", type=Path)
    file = arguments.parse_args().json
    result = rates()
    if file:
        file.write_text(json.dumps(result, indent=1))
    lines = [f"{result['triangles']} triangles, {RAYS} rays, {result['cores']} cores"]
    for name, values in result["rates"].items():
        lines.append(f"  {name:<8}" + "  ".join(f"{k} {v:6.2f}" for k, v in values.items()))
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
