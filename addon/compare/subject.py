# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is compared: one image of light as Cycles found it, and as each technique did."""

from dataclasses import dataclass, field

import numpy as np

from ...gi_core import metrics


@dataclass(frozen=True)
class Subject:
    """Light without colour in one place, E/π.

    name: as a reader knows it, "Diffuse Indirect" or "Floor, indirect". kind: "indirect", "direct", "combined" and
        "glossy …"; pages switch by it.
    reference: (h, w, 3) float32, the mean of two renders. noise: (h, w, 3), half their difference, whose spread
        is that of the mean about the truth.
    mask: (h, w) bool, the pixels that count. seen: (h, w) bool, all that have light; the mask leaves edges out of them.
    dark: (h, w) bool, pixels of the region that is to be dark; None where none is marked.
    ours: technique -> (h, w, 3). flat: whether it is a picture; light at vertices is none.
    """

    name: str
    kind: str
    reference: np.ndarray
    noise: np.ndarray
    mask: np.ndarray
    seen: np.ndarray
    ours: dict[str, np.ndarray]
    dark: np.ndarray | None = None
    flat: bool = True
    measures: dict[str, dict[str, float]] = field(init=False)
    floor: dict[str, float] = field(init=False)

    def __post_init__(self):
        found = {label: self._measured(image) for label, image in self.ours.items()}
        object.__setattr__(self, "measures", found)
        # One of two renders against their mean: as different from it as the truth is, but no smoother than it, so what
        # measures likeness of structure says nothing here.
        floor = self._measured(self.reference + self.noise) | {"ssim": float("nan"), "flip": float("nan")}
        object.__setattr__(self, "floor", floor)

    def _measured(self, image: np.ndarray) -> dict[str, float]:
        values = metrics.measure(image, self.reference, self.mask)
        if not np.array_equal(self.seen, self.mask):
            values["relmse_all"] = metrics.relmse(*(i[self.seen].astype(np.float64) for i in (image, self.reference)))
        if self.dark is not None:
            values["leak"] = metrics.leak(image, self.reference, self.mask & self.dark, self.mask & ~self.dark)
        return values


def summed(direct: Subject, indirect: Subject, name: str) -> Subject:
    """Both lights together."""
    ours = {label: image + indirect.ours[label] for label, image in direct.ours.items()}
    return Subject(
        name, "combined", direct.reference + indirect.reference, direct.noise + indirect.noise,
        direct.mask & indirect.mask, direct.seen & indirect.seen, ours, indirect.dark, indirect.flat,
    )  # fmt: skip
