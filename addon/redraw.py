# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parts of the windows are to be drawn again."""


def redraw(context) -> None:
    """Draws the editors that show a panel of ours or an image."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"PROPERTIES", "VIEW_3D", "IMAGE_EDITOR"}:
                area.tag_redraw()
