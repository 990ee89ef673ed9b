# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at vertices so far, drawn over the 3D views: triangles of our own, so that no mesh of the file changes."""

import threading

import bpy
import numpy as np
from mathutils import Matrix

from ..gi_core.display import srgb

# How much nearer to the eye than their surfaces the triangles are, as a share of the distance.
_NEARER = 1e-3


class Preview3D:
    """`put` may be called on any thread; `show` and `remove` belong on the main thread."""

    def __init__(self):
        self._lock = threading.Lock()
        self._corners: dict[str, np.ndarray] = {}
        self._scene = bpy.context.scene.session_uid
        self._changed, self._handler, self._batch = False, None, None

    def put(self, name: str, rows: slice, light: np.ndarray, places: np.ndarray) -> None:
        """Light E/π (n, …, 3) at some corners of an object's triangles, and where they are (n, 3) [m]."""
        with self._lock:
            known = self._corners.get(name)
            if known is None or len(known) < rows.stop:
                grown = np.full((-(-rows.stop // 3) * 3, 6), np.nan, np.float32)
                if known is not None:
                    grown[: len(known)] = known
                known = self._corners[name] = grown
            known[rows] = np.concatenate([places, light.reshape(-1, 3)], 1)
            self._changed = True

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """The corners of all triangles that are known whole: places (3 t, 3) [m] and light E/π (3 t, 3)."""
        with self._lock:
            whole = [np.zeros((0, 3, 6), np.float32)]
            for known in self._corners.values():
                of = known.reshape(-1, 3, 6)
                whole.append(of[~np.isnan(of).any((1, 2))])
        corners = np.concatenate(whole).reshape(-1, 6)
        return corners[:, :3], corners[:, 3:]

    def show(self) -> bool:
        """Lets the views draw what there is; whether something has come since the last time."""
        with self._lock:
            changed, self._changed = self._changed, False
        if changed:
            self._batch = None
            if self._handler is None:
                self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")
        return changed

    def remove(self) -> None:
        if self._handler is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")
            self._handler = self._batch = None

    def _draw(self):
        # Nothing of the card is touched before there is something to draw.
        import gpu
        from gpu_extras.batch import batch_for_shader

        view = bpy.context.region_data
        if bpy.context.scene.session_uid != self._scene or view is None:
            return
        shader = gpu.shader.from_builtin("SMOOTH_COLOR")
        if self._batch is None:
            places, light = self.triangles()
            color = np.concatenate([srgb(light), np.ones_like(light[:, :1])], 1).astype(np.float32)
            self._batch = batch_for_shader(shader, "TRIS", {"pos": places, "color": color})
        gpu.state.depth_test_set("LESS_EQUAL")
        with gpu.matrix.push_pop():
            away = Matrix.Translation((0, 0, _NEARER * view.view_distance))
            nearer = Matrix.Scale(1 - _NEARER, 4) if view.is_perspective else away
            gpu.matrix.load_matrix(nearer @ gpu.matrix.get_model_view_matrix())
            self._batch.draw(shader)
        gpu.state.depth_test_set("NONE")
