# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The last step of lightmaps: `gi_core.borders` on all that a page holds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..gi_core import borders, tiles
from ..gi_core.atlas import Page
from ..gi_core.borders import Bordered
from ..gi_core.geometry import Geometry
from ..gi_core.seams import Seams, atlas_seams
from ..gi_core.settings import Settings
from .result import Light
from .sentence import Sentence


def finished(geometry: Geometry, pages: Sequence[Page], light: dict[str, Light], settings: Settings) -> Iterator[float]:
    """Lightmaps without texels from inside of walls, with islands grown and seams closed. A generator of progress;
    returns the lights by their names, and sentences."""
    done, wholes = {}, {}

    def finish(part: slice):
        for page in pages[part]:
            done[page.name], wholes[page.name] = _finished(geometry, page, light[page.name], settings)

    yield from tiles.run(finish, tiles.slices(len(pages), 1))
    notes, hidden = [], sum(whole.inside for whole in wholes.values())
    found = [whole for whole in wholes.values() if whole.pairs]
    if hidden:
        notes.append(
            Sentence(
                "inside: {hidden} texels lie inside of something, or at its border: filled from around them",
                hidden=hidden,
            )
        )  # fmt: skip
    if found:
        pairs = [whole.pairs for whole in found]
        before = float(np.average([whole.before for whole in found], weights=pairs))
        after = float(np.average([whole.after for whole in found], weights=pairs))
        notes.append(
            Sentence(
                "seams: the two sides disagree by {after:.2%}, before stitching by {before:.2%}",
                after=after, before=before,
            )
        )  # fmt: skip
    return {page.name: done[page.name] for page in pages}, notes


def _finished(geometry: Geometry, page: Page, raw: Light, settings: Settings) -> tuple[Light, Bordered]:
    layers = [raw.direct, raw.indirect]
    unlit = borders.unlit(np.concatenate(layers, -1), raw.valid, raw.centred, raw.inside)
    layers.append(raw.radiance if raw.radiance is not None else np.zeros((*raw.valid.shape, 0), np.float32))
    if raw.directional is not None:
        layers.append(raw.directional.reshape(*raw.valid.shape, -1))
    cuts = atlas_seams(geometry, page) if settings.stitch else Seams.concatenate([])
    whole = borders.bordered(np.concatenate(layers, -1), raw.valid, unlit, raw.centred, settings.margin, cuts)
    direct, indirect, radiance, more = np.split(whole.image, np.cumsum([n.shape[-1] for n in layers[:3]]), -1)
    light = replace(
        raw, direct=direct, indirect=indirect, centred=raw.centred & ~unlit, filled=whole.filled,
        radiance=None if raw.radiance is None else radiance,
        directional=None if raw.directional is None else more.reshape(*raw.valid.shape, 4, 3),
    )  # fmt: skip
    return light, whole
