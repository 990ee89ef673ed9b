# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is true while Blender runs and of no file: the work on its way, what was found, the last results.

Nothing of it is kept in a .blend, where a crash would leave a bake that runs forever.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import bpy

from . import preview
from .preflight import Finding
from .result import Result
from .run import Run

# Results that can be compared without a bake anew; large ones take memory.
_KEPT = 4


@dataclass
class Session:
    """run: the bake or comparison on its way, None without. of: name of the scene that it is about.

    results: key of a line in a scene's list -> what was baked.
    """

    run: Run | None = None
    of: str = ""
    results: dict[str, Result] = field(default_factory=dict)
    _findings: dict[int, tuple[Finding, ...]] = field(default_factory=dict)

    def findings(self, scene: bpy.types.Scene) -> tuple[Finding, ...] | None:
        """What the last check of a scene found, errors first; None where it was not checked."""
        return self._findings.get(scene.session_uid)

    def found(self, scene: bpy.types.Scene, findings: Sequence[Finding]) -> None:
        self._findings[scene.session_uid] = tuple(findings)

    def keep(self, key: str, result: Result) -> None:
        """Remembers a result, and forgets the oldest."""
        self.results[key] = result
        while len(self.results) > _KEPT:
            del self.results[next(iter(self.results))]

    def stop(self) -> None:
        """Ends a bake at once."""
        if self.run:
            self.run.close()
            self.run = None

    def clear(self) -> None:
        """Ends a bake and forgets everything, as another file is opened."""
        self.stop()
        self.results.clear()
        self._findings.clear()


session = Session()


@bpy.app.handlers.persistent
def _before_load(*_):
    session.clear()


@bpy.app.handlers.persistent
def _before_save(*_):
    # The next look at the bake makes it anew.
    preview.drop()


@bpy.app.handlers.persistent
def _before_undo(*_):
    # What it knows of the file may be gone afterwards.
    if session.run and session.run.holds_file:
        session.run.cancel()


@bpy.app.handlers.persistent
def _after_undo(*_):
    # A step that was made during a bake holds the bake's preview.
    if not session.run:
        preview.drop()


_HANDLERS = (
    ("load_pre", _before_load), ("save_pre", _before_save), ("undo_pre", _before_undo),
    ("redo_pre", _before_undo), ("undo_post", _after_undo), ("redo_post", _after_undo),
)  # fmt: skip


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    session.clear()
