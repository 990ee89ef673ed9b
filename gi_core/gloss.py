# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What glossy surfaces reflect to a viewer: their Fresnel reflectance over a GGX lobe (`kernels/ggx.py`).

Light that bounces among microfacets and comes out late is given back by scaling the lobe, as Cycles does it for its
multiscatter GGX: a lobe of mirrors that reflects E of what it gets is brightened to

    1 + F_ms (1 − E) / E      F_ms = F̄ Ē / (1 − F̄ (1 − Ē))

with means F̄, Ē over a cosine-weighted hemisphere (Kulla & Conty 2017; Turquin 2019).
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache

import numpy as np

from .geometry import Geometry
from .kernels import ggx
from .sampling import frame, r2_sequence
from .vectors import dot, normalize

# The narrowest lobe, α: in single precision a narrower one is a mirror.
_NARROWEST = 1e-3

# The least cosine to the viewer; a shading normal that looks away is turned until it is met.
_GRAZING = 1e-3

# Steps of the tables, evenly spaced in roughness √α and in the cosine to the viewer, and samples of each entry.
_STEPS, _SAMPLES = 32, 1024


@dataclass(frozen=True)
class Gloss:
    """Points of glossy surfaces and where they are seen from, all arrays with one row per point.

    normal: (n, 3) float32, unit, on the viewer's side. view: (n, 3) float32, unit, to the viewer.
    alpha: (n,) float32, width of the lobe. specular, edge, metal, dielectric: (n, 3) float32, ior: (n,) float32: see
        `scene.Gloss`.
    """

    normal: np.ndarray
    view: np.ndarray
    alpha: np.ndarray
    specular: np.ndarray
    edge: np.ndarray
    metal: np.ndarray
    dielectric: np.ndarray
    ior: np.ndarray

    def __len__(self) -> int:
        return len(self.normal)

    def __getitem__(self, rows) -> "Gloss":
        """The points that a slice, mask or index array picks."""
        return Gloss(*(getattr(self, f.name)[rows] for f in fields(self)))

    def reflectance(self, cosine: np.ndarray) -> np.ndarray:
        """Of facets that are met at an angle, light that comes out late included: (n,) cosines -> (n, 3) float32."""
        return self._sum(1, schlick(cosine), dielectric(cosine, self.ior))

    def color(self) -> np.ndarray:
        """Share of light that comes from everywhere alike which is reflected to the viewer: (n, 3) float32."""
        cosine, dull = dot(self.normal, self.view), np.zeros(len(self), np.float32)
        for ior in np.unique(self.ior):
            here = self.ior == ior
            dull[here] = _look_up(_reflected(float(ior)), self.alpha[here], cosine[here])
        whole, rise = (_look_up(_reflected(curve), self.alpha, cosine) for curve in (np.inf, 0.0))
        return self._sum(whole, rise, dull)

    def _sum(self, whole, rise, dull) -> np.ndarray:
        """What metals and dielectrics reflect together, each brightened, given it for a reflectance of 1, for one that
        rises from 0 to 1, and for a dielectric's: (n,) -> (n, 3) float32."""
        whole, rise, dull = (np.broadcast_to(a, len(self))[:, None] for a in (whole, rise, dull))
        late = self._late()
        metal = self.specular + (self.edge - self.specular) / 21
        metal = np.divide(metal, self.metal, out=np.zeros_like(metal), where=self.metal > 0)
        out = (self.specular * (whole - rise) + self.edge * rise) * late(metal)
        return (out + self.dielectric * dull * late(fresnel_mean(self.ior)[:, None])).astype(np.float32)

    def _late(self) -> Callable[[np.ndarray], np.ndarray]:
        """By what the lobe is brightened, of a mean reflectance: (n, 1 or 3) -> the same."""
        whole = _look_up(_reflected(np.inf), self.alpha, dot(self.normal, self.view))[:, None]
        mean = np.interp(np.sqrt(self.alpha), np.linspace(0, 1, _STEPS), _means())[:, None]
        return lambda once: 1 + once * mean / (1 - once * (1 - mean)) * (1 - whole) / whole

    def drawn(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A direction for each point that light may come from, (n, 2) in [0, 1)² -> (n, 3), and what radiance from
        there is worth: (n, 3) float32, zero for directions below the surface."""
        x, y = frame(self.normal)
        view = np.stack([dot(axis, self.view) for axis in (x, y, self.normal)], -1)
        half = ggx.facets(view, self.alpha, u)
        local = ggx.mirrored(view, half)
        direction = local[:, :1] * x + local[:, 1:2] * y + local[:, 2:] * self.normal
        weight = ggx.worth(view, local, self.alpha)[:, None] * self.reflectance(dot(view, half))
        return normalize(direction).astype(np.float32), weight

    def brdf(self, direction: np.ndarray) -> np.ndarray:
        """The BRDF towards the viewer, for unit directions to the light: (n, 3) -> (n, 3) float32 [1/sr]."""
        x, y = frame(self.normal)
        view, light = (np.stack([dot(a, d) for a in (x, y, self.normal)], -1) for d in (self.view, direction))
        half = normalize(self.view + direction)
        return ggx.brdf(view, light, self.alpha)[:, None] * self.reflectance(dot(self.view, half))


def at(geometry: Geometry, triangle, weights, normal, view) -> Gloss:
    """Glossy surfaces at points on triangles.

    triangle: (n,), weights: (n, 3) barycentric. normal: (n, 3) shading normals. view: (n, 3) directions to the viewer.
    """
    # Where a smooth normal looks away from the viewer though the face does not, it is turned to just not.
    short = np.maximum(_GRAZING - dot(normal, view), 0)[:, None]
    names = ("roughness", "specular", "edge", "metal", "dielectric")
    roughness, *colors = (geometry.color(f"gloss.{name}", triangle, weights) for name in names)
    ior = np.array([m.gloss.ior for m in geometry.scene.materials], np.float32)[geometry.material(triangle)]
    alpha = np.clip(roughness[:, 0] ** 2, _NARROWEST, 1)
    return Gloss(normalize(normal + short * view), view, alpha, *colors, ior)


def schlick(cosine: np.ndarray) -> np.ndarray:
    """How far reflectance has risen from normal incidence to grazing (Schlick 1994): 0…1."""
    return np.clip(1 - cosine, 0, 1) ** 5


def dielectric(cosine: np.ndarray, ior) -> np.ndarray:
    """Fresnel reflectance of a smooth dielectric for light without polarisation, from outside."""
    cosine = np.clip(cosine, 0, 1)
    g = np.sqrt(np.maximum(ior * ior - 1 + cosine * cosine, 0))
    a, b = (g - cosine) / np.maximum(g + cosine, 1e-9), cosine * (g + cosine)
    return a * a / 2 * (1 + ((b - 1) / np.maximum(cosine * (g - cosine) + 1, 1e-9)) ** 2)


def fresnel_mean(ior):
    """Cosine-weighted mean reflectance of a smooth dielectric (the fit of Kulla & Conty 2017)."""
    return (ior - 1) / (4.08567 + 1.00071 * ior)


@cache
def _reflected(ior: float) -> np.ndarray:
    """Share of even light that a lobe reflects to the viewer, by roughness and by the viewer's cosine: (s, s) float32.

    ior: of a dielectric; 0 for Schlick's rise alone, infinite for mirrors.
    """
    curve: Callable = {0.0: schlick, np.inf: np.ones_like}.get(ior, lambda cosine: dielectric(cosine, ior))
    step = np.linspace(0, 1, _STEPS, dtype=np.float32)
    alpha = np.repeat(np.maximum(step**2, _NARROWEST), _STEPS)
    cosine = np.tile(np.maximum(step, _GRAZING), _STEPS)
    view = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], -1)
    total = np.zeros(_STEPS * _STEPS)
    for u in r2_sequence(_SAMPLES):
        half = ggx.facets(view, alpha, np.broadcast_to(u, (len(view), 2)))
        total += ggx.worth(view, ggx.mirrored(view, half), alpha) * curve(dot(view, half))
    return (total / _SAMPLES).astype(np.float32).reshape(_STEPS, _STEPS)


@cache
def _means() -> np.ndarray:
    """Ē, the cosine-weighted mean of what a lobe of mirrors reflects, by roughness: (s,) float32."""
    reflected = _reflected(np.inf) * np.linspace(0, 2, _STEPS, dtype=np.float32)
    return (reflected[:, 1:] + reflected[:, :-1]).mean(1) / 2


def _look_up(table: np.ndarray, alpha: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Bilinear, in roughness and in the cosine: (n,), (n,) -> (n,) float32."""
    place = [np.clip(x, 0, 1) * (_STEPS - 1) for x in (np.sqrt(alpha), cosine)]
    (i, j) = (np.minimum(p.astype(np.int32), _STEPS - 2) for p in place)
    u, v = place[0] - i, place[1] - j
    below = table[i, j] * (1 - v) + table[i, j + 1] * v
    return below * (1 - u) + (table[i + 1, j] * (1 - v) + table[i + 1, j + 1] * v) * u
