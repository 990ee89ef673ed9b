# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Animations: one pass over the timeline, a layered EXR for each frame, each starting from what the last one knew.

    paths = finish(bake_frames(scene, view_layer, job, range(1, 17), folder))

A run that was stopped goes on where it was. frames.json in the folder says of which .blend and job the frames are and
what their files' contents hash to; frames that are there and unchanged are kept. The history that the next frame starts
from lies beside the last one until the run has ended. What comes out is the same, stopped or not.
"""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import exr, ssgi
from ..gi_core.geometry import Geometry
from ..gi_core.tiles import finish, relayed
from ..gi_core.trace import Tracer
from . import gpu_context
from .bake import bake
from .job import Job
from .read import read_scene, with_bakes
from .read.surface_bakes import SurfaceBakes

JOURNAL = "frames.json"


def bake_frames(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, job: Job, frames: range, folder: Path
) -> Iterator[tuple[float, str]]:
    """The camera's picture at each frame, as FOLDER/image.NNNN.exr. A generator of (fraction, stage).

    Returns the paths, of kept frames too. The scene is left at the frame that it was at.
    Raises Refused, before any work on a frame, where the preflight finds errors at it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    journal = _Journal.of(folder, job, frames)
    kept = journal.kept(frames)
    before = scene.frame_current
    try:
        history = None
        if 0 < len(kept) < len(frames):
            scene.frame_set(kept[-1])
            history = _restored(scene, view_layer, job, journal.history(kept[-1]))
        for k, frame in enumerate(frames[len(kept) :], len(kept)):
            scene.frame_set(frame)
            work = bake(scene, view_layer, job, folder, history=history)
            result = yield from relayed(
                work, lambda step, k=k, frame=frame: ((k + step[0]) / len(frames), f"frame {frame}: {step[1]}")
            )
            history = result.history
            journal.add(frame, result.layers, view_layer.name, history)
    finally:
        scene.frame_set(before)
    journal.close()
    return [journal.picture(frame) for frame in frames]


class _Journal:
    """Which frames of a run are there.

    of: a text that changes with what is baked. hashes: frame -> SHA-256 of its file.
    """

    def __init__(self, folder: Path, of: str, hashes: dict[int, str]):
        self.folder, self.of, self.hashes = folder, of, hashes

    @staticmethod
    def of(folder: Path, job: Job, frames: range) -> "_Journal":
        """What the folder says, if it says it of this job, from this frame on, of this state of the .blend."""
        blend = Path(bpy.data.filepath)
        of = hashlib.sha256(json.dumps([asdict(job), frames.start], sort_keys=True).encode())
        if blend.is_file():
            of.update(blend.read_bytes())
        try:
            said = json.loads((folder / JOURNAL).read_text(encoding="utf-8"))
            hashes = {int(k): str(v) for k, v in said["frames"].items()} if said["of"] == of.hexdigest() else {}
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            hashes = {}
        return _Journal(folder, of.hexdigest(), hashes)

    def picture(self, frame: int) -> Path:
        return self.folder / f"image.{frame:04d}.exr"

    def history(self, frame: int) -> Path:
        return self.folder / f"history.{frame:04d}.npz"

    def kept(self, frames: range) -> list[int]:
        """The first frames, up to the last from which a run can go on."""
        good = []
        for frame in frames:
            path = self.picture(frame)
            if not path.is_file() or _hash(path) != self.hashes.get(frame):
                break
            good.append(frame)
        if len(good) == len(frames):
            return good
        while good and not self.history(good[-1]).is_file():
            good.pop()
        return good

    def add(self, frame: int, layers: dict[str, np.ndarray], view_layer: str, history: ssgi.History | None) -> None:
        """Writes a frame, then what the next one starts from, and says last that both are there."""
        exr.write_layers(self.picture(frame), layers, view_layer)
        file = self.history(frame)
        part = file.with_name(f".{file.name}.part")
        try:
            with part.open("wb") as out:
                np.savez(out, **(history.arrays if history else {}))
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
        self.hashes[frame] = _hash(self.picture(frame))
        text = json.dumps({"of": self.of, "frames": self.hashes}, indent=1)
        part = self.folder / f".{JOURNAL}.part"
        try:
            part.write_text(text + "\n", encoding="utf-8")
            part.replace(self.folder / JOURNAL)
        finally:
            part.unlink(missing_ok=True)
        for old in self.folder.glob("history.*.npz"):
            if old != file:
                old.unlink()

    def close(self) -> None:
        """The run has ended: nothing starts from its last frame."""
        for old in self.folder.glob("history.*.npz"):
            old.unlink()


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _restored(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, job: Job, file: Path) -> ssgi.History | None:
    """The history that a file holds of the current frame; what was seen is looked at again."""
    with np.load(file) as arrays:
        if not arrays.files:
            return None
        bakes = SurfaceBakes()
        core = finish(with_bakes(read_scene(scene, view_layer, bakes=bakes), scene, view_layer, bakes))
        camera = core.camera.at(job.resolution)
        device, _ = gpu_context.device(job.settings.device, job.settings.memory << 20)
        return finish(ssgi.restored(Tracer(Geometry(core), device), camera, job.settings, arrays))
