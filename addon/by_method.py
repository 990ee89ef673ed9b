# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with a technique of their own: a job is baked in parts, one for each technique, that come out as one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import fields, replace

import bpy
import numpy as np

from ..gi_core.settings import Settings
from ..gi_core.techniques import METHODS
from ..gi_core.tiles import relayed
from .job import Job
from .object_options import SURFACES, object_options
from .result import Light, Result
from .rna import own_fields, values


def method_of(scene: bpy.types.Scene, job: Job, name: str) -> str:
    """The technique that an object is baked with."""
    return object_options(scene.objects[name]).method or job.part_of or job.method


def parts(scene: bpy.types.Scene, job: Job) -> list[Job]:
    """The job, or where objects have a technique of their own, one for each technique.

    A part has the job's settings, and those that are its technique's own from the scene, where it has some.
    """
    if job.target not in ("lightmap", "vertices") or job.part_of:
        return [job]
    there = [obj.name for obj in scene.objects if obj.type in SURFACES]
    methods = {method_of(scene, job, name) for name in there if not job.objects or name in job.objects}
    if methods <= {job.method}:
        return [job]
    # What looks from cameras is first: it is refused where there is none.
    return [
        replace(job, method=m, part_of=job.method, settings=_settings(scene, job, m))
        for m in sorted(methods, reverse=True)
    ]


def _settings(scene: bpy.types.Scene, job: Job, method: str) -> Settings:
    if method == job.method:
        return job.settings
    kind = METHODS[method].settings
    own = getattr(getattr(scene, "gi_bake", None), method, None)
    shared = {f.name: getattr(job.settings, f.name) for f in fields(Settings)}
    return kind(**shared, **(values(own, own_fields(kind)) if own else {}))


def together(
    job: Job, parts: list[Job], run: Callable[[Job], Iterator[tuple[float, str]]]
) -> Iterator[tuple[float, str]]:
    """The bake of a job's parts, one after the other. A generator of (fraction, stage); returns a Result."""
    results: list[Result] = []
    for k, part in enumerate(parts):
        result = yield from relayed(run(part), lambda step, k=k: ((k + step[0]) / len(parts), step[1]))
        results.append(result)
    first, stages = results[0], Counter()
    light: dict[str, Light] = {}
    for result in results:
        stages.update(result.stages)
        for name, found in result.light.items():
            light[name] = _over(light[name], found) if name in light else found

    def every(name: str) -> dict:
        return {key: value for result in results for key, value in getattr(result, name).items()}

    def sentences(name: str) -> tuple[str, ...]:
        return tuple(dict.fromkeys(text for result in results for text in getattr(result, name)))

    return replace(
        first, job=job, light=light, stages=dict(stages), approximated=sentences("approximated"),
        warnings=sentences("warnings"), hashes=every("hashes"), kept=every("kept"), meshes=every("meshes"),
        uvs=every("uvs"),
    )  # fmt: skip


def _over(one: Light, other: Light) -> Light:
    """Both on one lightmap: each where its objects lie, and around them."""
    take = other.valid | (other.filled & ~one.filled)

    def both(a: np.ndarray | None, b: np.ndarray | None) -> np.ndarray | None:
        if a is None and b is None:
            return None
        a, b = (np.zeros_like(b) if a is None else a), (np.zeros_like(a) if b is None else b)
        return np.where(take.reshape(*take.shape, *[1] * (a.ndim - take.ndim)), b, a)

    return Light(**{f.name: both(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)})
