"""The sun at the frames of a scene, and omitted sunlight: of a very low sun, or negligible."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import SAFETY_FACTOR, FewColumns, Omission, few_columns
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.numerics import PER_BAND as LEVEL_WAVENUMBERS
from hcss_twin.providers import Sun, View

SAME_DEG = 0.25
"""Suns closer to each other than this are treated as one."""

_SEED = 2**17


def checked_frames(parts: int, frames: int) -> list[int]:
    """Return one random frame from each of several equal parts of a sequence.

    The frames do not depend on the scenario's seed, so that the certificate can reuse solutions of the tables for the
    sun of a checked frame.

    Parameters
    ----------
    parts, frames : int
        1 to ``frames`` parts.
    """
    ends = np.arange(parts + 1) * frames // parts
    chosen: list[int] = np.random.default_rng(_SEED).integers(ends[:-1], ends[1:]).tolist()
    return chosen


@dataclass(frozen=True)
class Sunlight:
    """Whether sunlight is computed, or omitted by day because it is faint.

    Attributes
    ----------
    share : float
        Largest share of omitted sunlight in any band.
    """

    is_computed: bool = True
    share: float = 0.0

    def matters(self, zenith_deg: Array) -> bool:
        """Whether it is computed, and the sun is above the horizon at one of its zenith angles at least."""
        return self.is_computed and bool(np.any(zenith_deg < 90.0))


COMPUTED = Sunlight()


@dataclass(frozen=True)
class SunFrames:
    """The sun at the frames of a scene.

    Attributes
    ----------
    time_s, zenith_deg, azimuth_deg : ndarray (F,)
        Values at each frame.
    """

    track: SunTrack
    time_s: Array
    zenith_deg: Array
    azimuth_deg: Array

    @property
    def up(self) -> NDArray[np.intp]:
        """Frames with the sun above the horizon."""
        return np.flatnonzero(self.zenith_deg < 90.0)

    def at(self, frames: Iterable[int]) -> list[tuple[float, Sun | None]]:
        """Return time and sun (None: below the horizon) of some frames, without repeated sun positions."""
        frames_and_suns: list[tuple[float, Sun | None]] = []
        for frame in frames:
            time_s = float(self.time_s[frame])
            position = self.track.at(time_s)
            sun = position if position.is_up else None
            if not any(_same(sun, other) for _, other in frames_and_suns):
                frames_and_suns.append((time_s, sun))
        return frames_and_suns

    def checked(self) -> Sun | None:
        """Return the sun of a frame in the certificate, for which others solve clouds, too."""
        return self.at(checked_frames(1, self.time_s.size))[0][1]

    def evenly(self, count: int) -> list[tuple[float, Sun | None]]:
        """Time and sun of at most ``count`` frames from the first to the last."""
        frames = np.linspace(0, self.time_s.size - 1, count).round().astype(np.intp)
        return self.at(np.unique(frames).tolist())

    def extremes(self, view: View) -> list[tuple[float, Sun | None]]:
        """Time and sun nearest to the mirror direction, highest and lowest, and for a frame without sun."""
        up = self.up
        frames = list(np.flatnonzero(self.zenith_deg >= 90.0)[:1])
        if up.size:
            highest, lowest = up[np.argmin(self.zenith_deg[up])], up[np.argmax(self.zenith_deg[up])]
            frames = [self.mirror(view), highest, lowest, *frames]
        return self.at(int(frame) for frame in frames)

    def mirror(self, view: View) -> int:
        """Frame with the sun above the horizon whose mirror direction is nearest to the view."""
        up = self.up
        return int(up[np.argmax(_nearness(view, self.zenith_deg[up], self.azimuth_deg[up]))])


def _nearness(view: View, zenith_deg: Array, azimuth_deg: Array) -> Array:
    """Cosine between a view and the mirror directions of suns, whose bearings are opposite to those of the suns."""
    sun, seen = np.radians(zenith_deg), math.radians(view.zenith_deg)
    turn = np.radians(view.azimuth_deg - azimuth_deg)
    nearness: Array = math.cos(seen) * np.cos(sun) - math.sin(seen) * np.sin(sun) * np.cos(turn)
    return nearness


_PLACES = np.linspace(-1.0, 1.0, 17).tolist()
"""Positions along either side of a rectangle of directions, among which that nearest to the mirror is sought."""


def toward_glint(assembly: Assembly, suns: Iterable[Sun | None]) -> list[Assembly]:
    """Return a scene toward the views that bounds on sunlight from the sea need: its own, and those nearest to glint.

    Parameters
    ----------
    suns : iterable of Sun or None
        For each, the direction of view that is nearest to its mirror direction.
    """
    if assembly.directions is None:
        return [assembly]
    every = assembly.directions.at((x, y) for x in _PLACES for y in _PLACES)
    nearest = [
        max(every, key=lambda view: float(_nearness(view, np.array(sun.zenith_deg), np.array(sun.azimuth_deg))))
        for sun in suns
        if sun is not None
    ]
    return [assembly, *(assembly.toward(view) for view in dict.fromkeys(nearest))]


def _same(one: Sun | None, other: Sun | None) -> bool:
    """Whether two suns have the same position, or are both below the horizon; at two times places may have others."""
    if one is None or other is None:
        return one is other
    if one.time_s != other.time_s:
        return False
    turn = (one.azimuth_deg - other.azimuth_deg + 180.0) % 360.0 - 180.0
    across = abs(turn) * math.sin(math.radians(one.zenith_deg))
    return max(abs(one.zenith_deg - other.zenith_deg), across) <= SAME_DEG


LOW_SUN_DEG = 88.0
"""Largest sun zenith angle for which radiance models compute scattered sunlight."""

HIGHER_DEG = 1.0
"""Margin for steep paths, along which the sun's zenith angle varies."""

HIGH_DEG = 60.0
"""Sun zenith angle up to which all paths have scattered sunlight."""


def low_sun(
    assembly: Assembly, columns: FewColumns, known: Mapping[tuple[float, Sun | None], Mapping[str, Array]]
) -> Iterator[Omission]:
    """Yield the solar terms that are missing for the lowest sun but present for a higher one.

    They decrease as the sun sets: their values for the next higher sun that has them, at 87 degrees for steep views,
    bound the loss, relative to the darker columns of the lowest sun.

    Parameters
    ----------
    known : mapping of (float, Sun or None) to mapping of str to ndarray (C, B)
        Terms of the columns at some times with their sun, including the lowest.
    """
    suns = {sun: terms for (_, sun), terms in known.items() if sun is not None}
    if not suns:
        return
    lowest = max(suns, key=lambda sun: sun.zenith_deg)
    terms = suns[lowest]
    gone = [name for name in assembly.model.solar_terms if not np.any(terms[name])]
    if lowest.zenith_deg <= HIGH_DEG or not gone:
        return
    what, missing = "sunlight of a very low sun", ", ".join(sorted(gone))
    higher, sun = terms, lowest
    for zenith_deg in np.arange(min(LOW_SUN_DEG, lowest.zenith_deg) - HIGHER_DEG, HIGH_DEG - 1.0, -3.0):
        sun = replace(lowest, zenith_deg=float(zenith_deg))
        try:
            higher = columns.terms(assembly, sun)
        except ProviderError:
            continue
        # Along slant paths the term is missing even for a higher sun.
        if any(np.any(higher[name]) for name in gone):
            break
    total = np.sum(list(terms.values()), axis=0)
    lost = np.sum([higher[name] for name in gone], axis=0)
    if np.any(lost):
        yield Omission(
            what,
            f"the radiance model has no {missing} with the sun beyond {LOW_SUN_DEG:g} deg from the zenith of any point "
            f"seen; the bound is for {sun.zenith_deg:g} deg",
            SAFETY_FACTOR * float(np.max(lost[total > 0.0] / total[total > 0.0], initial=0.0)),
            needs="another time, as no radiance model has it: no key computes it",
        )


_PER_BAND = 16
_THICKNESSES = 3
"""Number of cloud thicknesses per layer, from the thinnest to the thickest."""


def negligible_sunlight(assembly: Assembly, sun: SunFrames, limit: float) -> Sunlight:
    """Return whether sunlight is computed: not if its share in every band of all columns is below a limit.

    It is omitted in all bands or in none, because omitting it in some saves little.

    Parameters
    ----------
    limit : float
        Relative to the total of a band.
    """
    suns = [position for _, position in sun.extremes(assembly.view) if position is not None]
    if not suns:
        return COMPUTED
    largest = 0.0
    columns = few_columns(assembly, _PER_BAND)
    cloudy = replace(columns, clear=False, thickness_m=_thicknesses(assembly))
    # Clear sky is fast to compute and decides most scenes; the choice of the level has solved the thickest cloud.
    first = replace(columns, thickness_m=columns.thickness_m[:0])
    if not columns.clear:
        first = replace(few_columns(assembly, LEVEL_WAVENUMBERS), thickness_m=columns.thickness_m[-1:])
    for part in (first, cloudy) if cloudy.thickness_m.size else (first,):
        for position in suns:
            largest = max(largest, SAFETY_FACTOR * _share(assembly, part, position))
            if largest > limit:
                return COMPUTED
    return Sunlight(False, largest)


def _share(assembly: Assembly, columns: FewColumns, sun: Sun) -> float:
    terms = columns.terms(assembly, sun)
    total = np.sum(list(terms.values()), axis=0)
    sunlight = sum((terms[name] for name in assembly.model.solar_terms), np.zeros_like(total))
    return float(np.max(sunlight[total > 0] / total[total > 0], initial=0.0))


def _thicknesses(assembly: Assembly) -> Array:
    """Columns (N, L): the extreme ones, and each layer alone at thicknesses between its limits."""
    rows = [assembly.extreme_thicknesses_m]
    for index, (layer, cloudy) in enumerate(zip(assembly.layers, assembly.cloudy_layers, strict=True)):
        if cloudy and layer.thickness_min_m < layer.thickness_max_m:
            between = np.geomspace(layer.thickness_min_m, layer.thickness_max_m, _THICKNESSES)[1:-1]
            alone = np.zeros((between.size, len(assembly.layers)))
            alone[:, index] = between
            rows.append(alone)
    return np.concatenate(rows)
