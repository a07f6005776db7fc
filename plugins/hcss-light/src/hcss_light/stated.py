"""Errors that the tiers state for a scene, from clouds of the scene itself.

In some windows of the first frame the tier ``source`` is computed and compared with columns and ``slant``: what they
differ by is their error as far as ``source`` is right. Its own error grows with the same differences, that is with how
much broken clouds, and light scattered in them, matter in the scene, and by day with the size of voxels and toward the
direction of the sun; the shares were found by Monte Carlo in random scenes (``benchmarks/estimates.py``). No table of
cloud types, angles or pixels is needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_light.source import Direction
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

SIDE, WINDOWS = 24, 2
"""Points along the sides of a window, and windows along each side of the image if these fit into it twice."""

EMITTED_UM = 5.0
"""Wavelength above which sunlight does not matter."""


@dataclass(frozen=True)
class Shares:
    """Error of ``source``: a least one, and shares of what columns and ``slant`` differ by, added in squares."""

    least: float
    of_columns: float
    of_slant: float


SUNLIT, SHORT, LONG = Shares(0.01, 0.15, 0.0), Shares(0.0045, 0.0, 0.25), Shares(0.0015, 0.05, 0.6)
"""By day below 5 um for points of :data:`POINT_M`, by night, and above 5 um. Scattered light makes ``slant`` err."""

OF_LAYERS = Shares(0.03, 0.3, 0.0), Shares(0.015, 0.1, 0.0), Shares(0.005, 0.06, 0.0)
"""The same for several layers, which have no tier ``slant`` (``benchmarks/errors-layers.csv``)."""

POINT_M = 100.0
"""By day the share grows as the root of the distance of points: sunlight varies within thick voxels."""

OPPOSITE_DEG, OPPOSITE = 25.0, 0.8
"""Angle between view and sun within which the share grows to this: there the parts of voxels are seen that are lit."""

FACTOR, FACTOR_OF_LAYERS, FACTOR_OF_SOURCE = 1.2, 1.5, 1.4
"""What is stated over the difference from ``source``, and over its expected error: most scenes are to be within it."""


def differences(
    image: tuple[int, int],
    instants: Sequence[Any],
    reach: Sequence[tuple[int, int]],
    clouds: Callable[[slice, slice], Any],
) -> list[Array]:
    """Return by how much columns, and other tiers, differ (B,) from ``source``: rms over points over the mean.

    Parameters
    ----------
    image : (int, int)
        Rows and columns of points.
    instants : sequence of InstantLight
        Of the tier ``source``, and of others, under the :func:`lowest_sun`.
    reach : sequence of (int, int)
        Rows, and columns, of points around others that matter to them.
    clouds : callable
        Returns the thickness of clouds in rows and columns, and their shares of heights.
    """
    parts = list[list[Array]]()
    for around, windows in _together(windows_of(image), reach):
        wide = [slice(span.start - low, span.stop + high) for span, (low, high) in zip(around, reach, strict=True)]
        thickness, shares = clouds(wide[0], wide[1])
        # Tables are not known yet: uniform cloud is that of the tier source.
        found = [instants[0].uniform(thickness, shares)]
        for light in instants:
            amount, share, change = light.correct(thickness, shares=shares)
            found.append(instants[0].uniform(amount, shares) * share + change)
        for window in windows:
            inner = [
                slice(span.start - far.start, span.stop - far.start) for span, far in zip(window, wide, strict=True)
            ]
            parts.append([radiance[:, *inner].reshape(radiance.shape[0], -1) for radiance in found])
    columns, exact, *others = (np.concatenate(radiances, axis=1) for radiances in zip(*parts, strict=True))
    mean = np.maximum(np.mean(exact, axis=1), np.finfo(float).tiny)
    return [np.sqrt(np.mean((radiance - exact) ** 2, axis=1)) / mean for radiance in (columns, *others)]


def _together(
    windows: list[tuple[slice, slice]], reach: Sequence[tuple[int, int]]
) -> list[tuple[tuple[slice, slice], list[tuple[slice, slice]]]]:
    """Return the windows to compute, each with those in it: one around all of them where that has fewer points."""

    def size(window: tuple[slice, slice]) -> int:
        return math.prod(span.stop - span.start + sum(both) for span, both in zip(window, reach, strict=True))

    rows, columns = (
        slice(min(span.start for span in spans), max(span.stop for span in spans))
        for spans in zip(*windows, strict=True)
    )
    apart = [(window, [window]) for window in windows]
    return [((rows, columns), windows)] if size((rows, columns)) < sum(map(size, windows)) else apart


def error_of_source(inputs: LightInputs, of_columns: Array, of_slant: Array | None) -> Array:
    """Return the error (B,) to expect of ``source`` from the differences (B,) of columns and of ``slant``, if any."""
    weights = np.maximum(inputs.weights_cm1, 0.0)
    wavelength_um, sun = 1e4 * np.sum(weights, axis=1) / (weights @ inputs.wavenumber_cm1), lowest_sun(inputs)
    angle_deg = None
    if sun is not None:
        toward = Direction(sun.zenith_deg, sun.azimuth_deg).vector
        across = float(toward @ Direction(inputs.view.zenith_deg, inputs.view.azimuth_deg).vector)
        angle_deg = math.degrees(math.acos(min(max(across, -1.0), 1.0)))
    slant = [None] * of_columns.size if of_slant is None else of_slant.tolist()
    given = zip(wavelength_um.tolist(), of_columns.tolist(), slant, strict=True)
    return np.array([expected_error(*differences, angle_deg, inputs.point_m) for differences in given])


def expected_error(
    wavelength_um: float, of_columns: float, of_slant: float | None, angle_deg: float | None, point_m: float
) -> float:
    """Return the error to expect of ``source``; the angle is that between view and sun, None at night."""
    lit = angle_deg is not None and wavelength_um < EMITTED_UM
    sunlit, short, long = OF_LAYERS if of_slant is None else (SUNLIT, SHORT, LONG)
    shares = sunlit if lit else short if wavelength_um < EMITTED_UM else long
    share = shares.of_columns
    if lit and angle_deg is not None:
        share *= math.sqrt(point_m / POINT_M)
        share += max(OPPOSITE - share, 0.0) * math.exp(-((angle_deg / OPPOSITE_DEG) ** 2))
    return math.hypot(shares.least, share * of_columns, shares.of_slant * (of_slant or 0.0))


def stated_errors(
    inputs: LightInputs, of_columns: Array, of_slant: Array | None, of_tier: Array | float
) -> list[float]:
    """Return the error (B,) of a tier from its difference (B,) from ``source``, and those of columns and ``slant``.

    It is a bound for the rms over pixels, relative to the mean radiance, not its mean over scenes.
    """
    of_source = FACTOR_OF_SOURCE * error_of_source(inputs, of_columns, of_slant)
    factor = FACTOR_OF_LAYERS if of_slant is None else FACTOR
    return [float(error) for error in np.hypot(factor * np.asarray(of_tier), of_source)]


def lowest_sun(inputs: LightInputs) -> Sun | None:
    """Return the lowest sun of all frames; None at night."""
    if not inputs.sun_zenith_deg.size:
        return None
    lowest = int(np.argmax(inputs.sun_zenith_deg))
    return Sun(float(inputs.sun_zenith_deg[lowest]), float(inputs.sun_azimuth_deg[lowest]), 1.0)


def windows_of(image: tuple[int, int]) -> list[tuple[slice, slice]]:
    """Return windows in the middle of equal parts of the image; the whole image if it is small."""
    parts = []
    for size in image:
        count = WINDOWS if size >= 2 * WINDOWS * SIDE // 2 else 1
        side = min(SIDE, size)
        middles = [math.floor(size * (number + 0.5) / count) for number in range(count)]
        starts = [min(max(middle - side // 2, 0), size - side) for middle in middles]
        parts.append([slice(start, start + side) for start in starts])
    return [(rows, columns) for rows in parts[0] for columns in parts[1]]
