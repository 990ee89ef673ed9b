# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The last step of lightmaps: `gi_core.borders` on all that a page holds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..gi_core import borders
from ..gi_core.atlas import Page
from ..gi_core.geometry import Geometry
from ..gi_core.seams import Seams, atlas_seams
from ..gi_core.settings import Settings
from .result import Light
from .sentence import Sentence


def finished(geometry: Geometry, pages: Sequence[Page], light: dict[str, Light], settings: Settings) -> Iterator[float]:
    """Lightmaps without texels from inside of walls, with islands grown and seams closed. A generator of progress;
    returns the lights by their names, and sentences."""
    done, found, hidden = {}, {}, 0
    for k, page in enumerate(pages):
        yield k / len(pages)
        raw = light[page.name]
        layers = [raw.direct, raw.indirect]
        unlit = borders.unlit(np.concatenate(layers, -1), raw.valid, raw.centred, raw.inside)
        layers.append(raw.radiance if raw.radiance is not None else np.zeros((*raw.valid.shape, 0), np.float32))
        if raw.directional is not None:
            layers.append(raw.directional.reshape(*raw.valid.shape, -1))
        cuts = atlas_seams(geometry, page) if settings.stitch else Seams.concatenate([])
        whole = borders.bordered(np.concatenate(layers, -1), raw.valid, unlit, settings.margin, cuts)
        direct, indirect, radiance, more = np.split(whole.image, np.cumsum([n.shape[-1] for n in layers[:3]]), -1)
        done[page.name] = replace(
            raw, direct=direct, indirect=indirect, centred=raw.centred & ~unlit, filled=whole.filled,
            radiance=None if raw.radiance is None else radiance,
            directional=None if raw.directional is None else more.reshape(*raw.valid.shape, 4, 3),
        )  # fmt: skip
        hidden += whole.inside
        if len(cuts):
            found[page.name] = whole.before, whole.after, len(cuts)
    notes = []
    if hidden:
        notes.append(
            Sentence(
                "inside: {hidden} texels lie inside of something, or at its border: filled from around them",
                hidden=hidden,
            )
        )  # fmt: skip
    if found:
        pairs = sum(n for _, _, n in found.values())
        before, after = (sum(f[k] * f[2] for f in found.values()) / pairs for k in (0, 1))
        notes.append(
            Sentence(
                "seams: the two sides disagree by {after:.2%}, before stitching by {before:.2%}",
                after=after, before=before,
            )
        )  # fmt: skip
    return done, notes
