# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All light on one tile of receivers: direct, from the surroundings and reflected, refined in passes and smoothed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import count

import numpy as np

from . import borders, images, tiles
from .coarse import Coarse
from .direct import surroundings
from .receivers import Tile
from .refine import Estimate, Goal, added_up, refined
from .rsm.glossy import glossy_light
from .rsm.interpolation import interpolated_indirect
from .sampling import Samples
from .scene import Camera
from .settings import Settings
from .shadow_maps import lamps
from .subpixels import alike
from .surfels import Surfels
from .techniques import Technique
from .tiles import named
from .trace import Tracer
from .vectors import pick, put

# How long the stages of a tile take beside each other, roughly.
_STAGES = {"points": 1, "lamps": 1, "gather": 5, "denoise": 1, "gloss": 5, "medium": 3}

# Samples of a pass from which on each subpixel asks for itself: these are stratified all the same, and with one point
# for each pass the light's change within the pixel would stay as noise.
_MANY = 4

# Points that are asked at once whether they lie inside of something, with 16 rays each.
_ASKED = 1 << 12


@dataclass(frozen=True)
class TileLight:
    """What a bake knows when it comes to a tile.

    emitted: what the technique gathers from; None where reflected light is not wanted. direct: whether direct light is.
    camera: None for lightmaps and vertices. settings: with samples for one point, see `per_point`.
    share: of all points that a tile has, and so of the time that there is.
    reused: points that were interpolated between and points in all, of each pass.
    coarse: a lightmap's reflected light where it was found at coarse texels; None where it is to be found here.
    """

    tracer: Tracer
    technique: Technique
    settings: Settings
    emitted: object | None
    direct: bool
    camera: Camera | None
    share: float
    reused: list[tuple[float, int]] = field(default_factory=list)
    coarse: Coarse | None = None

    @property
    def stages(self) -> dict[str, float]:
        """What each stage takes of a tile's time, roughly."""
        settings = self.settings
        absent = {
            "lamps": not self.direct, "denoise": not settings.smooths,
            "gloss": not settings.glossy, "medium": not self._has_medium,
        }  # fmt: skip
        taken = {name: length for name, length in _STAGES.items() if not absent.get(name)}
        return {name: length / sum(taken.values()) for name, length in taken.items()}

    def on(self, tile: Tile, seen: Callable[[dict[str, np.ndarray]], None] | None = None) -> Iterator:
        """Works a tile out. A generator of (stage, its share); returns layers (h, w, c), see `images.resolved`, with
        light "Lamps", "Around" and "Indirect" [W/m²], bool "Centred", whether the surface covers the texel's middle,
        and but for a camera "Inside", what no light reaches inside of something; and the Estimate of the latter two.

        seen: is shown the three layers of light: direct light first and after each pass, where reflected light comes in
            passes, and what is found.
        """
        settings, shape, subpixels = self.settings, tile.shape, tile.bands[0].receiver.subpixels
        points, place, centred = yield from named("points", tile.points())
        direct = np.zeros((len(points), 3), np.float32)
        if self.direct:
            resolution = settings.shadow_map_resolution
            work = lamps(self.tracer, points, settings.light_samples, settings.seed, resolution)
            direct = yield from named("lamps", work)

        def layers(light: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
            return images.resolved(points, place, shape, subpixels, light)

        def show(values: np.ndarray):
            seen(layers({"Lamps": direct, "Around": values[:, 0], "Indirect": values[:, 1]}))

        if seen and self.direct and self.technique.in_passes(settings):
            show(np.zeros((len(points), 2, 3), np.float32))
        estimate, deep = yield from named("gather", self._gathered(points, place, tile, show if seen else None))
        values = estimate.values
        inside = None
        if not self.camera:
            inside = yield from named("gather", self._inside(points, direct + added_up(values), deep))
        if settings.smooths and tile.bands[0].receiver.is_image:
            values = yield from named("denoise", self._smoothed(estimate, points, place, tile))
        found = layers({"Lamps": direct, "Around": values[:, 0], "Indirect": values[:, 1]})
        if seen:
            seen(found)
        found["Centred"] = images.spread(centred[:, None], place, shape)[::subpixels, ::subpixels]
        if inside is not None:
            found["Inside"] = images.spread(inside[:, None], place, shape)
        if self.camera:
            band = tile.bands[0]
            found["Sky"] = images.sky(self.tracer.geometry.scene.environment, self.camera, subpixels, band.rows, place)
        if self.camera and settings.glossy:
            found |= yield from named("gloss", self._gloss(points, tile))
        if self._has_medium:
            found |= yield from named("medium", self._medium(tile))
        return found, estimate

    def _inside(self, points: Surfels, light: np.ndarray, deep: np.ndarray) -> Iterator[float]:
        """Which points that get no light lie inside of something: a generator of progress; returns (n,) bool.

        light: (n, 3). deep: (n,) bool, those of which it is known.
        """
        inside = ~light.any(-1)
        asked = np.flatnonzero(inside & ~deep)

        def ask(part: slice):
            inside[asked[part]] = borders.inside(self.tracer, points[asked[part]])

        # The light is known by then: of its stage nothing is left.
        yield from tiles.within(1, 1, tiles.run(ask, tiles.slices(len(asked), _ASKED)))
        return inside

    @property
    def _has_medium(self) -> bool:
        return bool(self.camera and self.technique.medium and self.settings.fog_density)

    def _medium(self, tile: Tile) -> Iterator[float]:
        """What a medium scatters to the camera, and how much it lets through: a generator; returns layers."""
        rows, subpixels = tile.bands[0].rows, tile.bands[0].receiver.subpixels
        (direct, indirect), through = yield from self.technique.medium(
            self.tracer, self.camera, subpixels, rows, self.emitted, self.settings
        )
        h, w = (n // subpixels for n in tile.shape)
        found = {"Volume Direct": direct, "Volume Indirect": indirect, "Transmittance": through[:, None]}
        return {k: v.reshape(h, subpixels, w, subpixels, -1).mean((1, 3)) for k, v in found.items()}

    def _gloss(self, points: Surfels, tile: Tile) -> Iterator[float]:
        """What glossy surfaces reflect to the camera: a generator of progress; returns layers."""
        settings, rows, subpixels = self.settings, tile.bands[0].rows, tile.bands[0].receiver.subpixels
        around = None
        if getattr(settings, "glossy_lookup", "rays") == "volume":
            around = partial(self.technique.radiance, self.tracer, volume=self.emitted, settings=settings)
        shown = yield from glossy_light(self.tracer, points, self.camera, subpixels, rows, settings, around)
        place, shape = shown.surfels.place - rows.start * tile.shape[1], tile.shape
        noisy = np.concatenate([shown.around, shown.indirect], -1)
        if settings.denoise != "none":
            # What a mirror shows has edges that its surface knows nothing of: a filter along it must not reach far, and
            # Open Image Denoise, told of colour and normal, makes up light (14 % on a small ball).
            noisy = yield from images.smoothed(noisy, shown.surfels, place, shape, 1, device=self.tracer.device)
        light = {"Glossy Lamps": shown.lamps, "Glossy Around": noisy[:, :3], "Glossy Indirect": noisy[:, 3:]}
        layers = {k: images.over_color(v, shown.color, place, shape, subpixels) for k, v in light.items()}
        whole = images.spread(shown.color, place, shape)
        h, w = (n // subpixels for n in shape)
        return layers | {"Glossy Color": whole.reshape(h, subpixels, w, subpixels, 3).mean((1, 3))}

    def _gathered(self, points: Surfels, place: np.ndarray, tile: Tile, seen) -> Iterator[float]:
        """Light of the surroundings and reflected light: a generator; returns the Estimate of both, (n, 2, 3), and
        which points are known to lie inside of something, (n,) bool."""
        settings, n = self.settings, len(points)
        deep = np.zeros(n, bool)
        in_passes = self.emitted is not None and self.coarse is None and self.technique.in_passes(settings)
        s2, alone, turns = tile.bands[0].receiver.subpixels ** 2, np.ones(n, bool), count()
        whole = np.zeros((0, s2), np.int64)
        if s2 > 1 and getattr(settings, "interpolation", 1) == 1:
            whole = alike(points, place, tile.shape, self.camera, settings.antialias, settings.seed)
            alone[whole] = False

        def of(points: Surfels, samples: Samples) -> Iterator[float]:
            values = np.zeros((len(points), 2, 3), np.float32)
            if self.direct:
                values[:, 0] = yield from surroundings(self.tracer, points, samples, settings.seed)
            if in_passes:
                values[:, 1] = yield from self._indirect(points, samples)
            return values

        def one_pass(samples: Samples) -> Iterator[float]:
            if samples.count >= _MANY or not len(whole):
                values = yield from of(points, samples)
                mean = sum(pick(values, whole[:, k]) for k in range(s2)) / np.float32(s2)
                put(values, whole, mean[:, None])
                return values
            values, share = np.zeros((n, 2, 3), np.float32), whole.size / max(1, n)
            asking = points[whole[:, next(turns) % s2]]
            put(values, whole, (yield from tiles.within(0, share, of(asking, samples.part(s2))))[:, None])
            put(values, alone, (yield from tiles.within(share, 1, of(points[alone], samples))))
            return values

        if self.direct or in_passes:
            goal = Goal(settings.samples, settings.noise_threshold, settings.time_limit * self.share)
            estimate = yield from refined(one_pass, goal, seen if in_passes else None)
        else:
            estimate = Estimate(np.zeros((n, 2, 3), np.float32), settings.samples, None)
        if self.coarse is not None:
            estimate.values[:, 1], deep = yield from self._between(points, place, tile)
        elif self.emitted is not None and not in_passes:
            estimate.values[:, 1] = yield from self._indirect(points, Samples(settings.samples))
        if seen and not in_passes:
            seen(estimate.values)
        return estimate, deep

    def _indirect(self, points: Surfels, samples: Samples) -> Iterator[float]:
        settings = self.settings
        if self.camera is None or getattr(settings, "interpolation", 1) == 1:
            return (yield from self.technique.indirect(self.tracer, points, self.emitted, settings, samples))
        irradiance, share = yield from interpolated_indirect(
            self.tracer, points, self.emitted, settings, self.camera, settings.antialias, samples
        )
        self.reused.append((share * len(points), len(points)))
        return irradiance

    def _between(self, points: Surfels, place: np.ndarray, tile: Tile) -> Iterator[float]:
        """Reflected light by that at coarse texels: a generator of progress; returns (n, 3) [W/m²], and which points
        lie inside of something, (n,) bool."""
        irradiance, (sure, deep) = np.zeros((len(points), 3), np.float32), np.zeros((2, len(points)), bool)
        ends = np.searchsorted(place, np.cumsum([0, *(band.height for band in tile.bands)]) * tile.shape[1])
        for band, begin, end in zip(tile.bands, ends[:-1], ends[1:]):
            part = slice(begin, end)
            irradiance[part], sure[part], deep[part] = yield from tiles.within(
                0, 0, self.coarse.at(self.tracer.device, band.receiver, points[part])
            )
        # Alone they take as many samples as the filter would have brought together.
        samples = Samples(self.settings.samples * self.coarse.step**2)
        irradiance[~sure] = yield from self._indirect(points[~sure], samples)
        self.reused.append((np.count_nonzero(sure), len(points)))
        return irradiance, deep

    def _smoothed(self, estimate: Estimate, points: Surfels, place: np.ndarray, tile: Tile) -> Iterator[float]:
        """The estimate's values without their noise: a generator of progress; returns (n, 2, 3)."""
        # A lightmap goes on under walls; what a camera sees does not.
        walls = self.tracer if self.camera is None else None
        island = np.repeat(np.arange(len(tile.bands)), [band.height for band in tile.bands])
        values, passes = estimate.values, self.settings.denoise_passes
        noisy = values if self.technique.noisy(self.settings) and self.coarse is None else values[:, :1]
        flat, variance = noisy.reshape(len(points), -1), estimate.variance
        smooth = yield from images.smoothed(
            flat, points, place, tile.shape, passes, variance, walls, island, self.tracer.device,
            tile.bands[0].receiver.subpixels,
        )  # fmt: skip
        return np.concatenate([smooth.reshape(noisy.shape), values[:, noisy.shape[1] :]], 1)
