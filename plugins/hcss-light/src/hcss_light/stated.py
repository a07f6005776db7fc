"""Errors that the tiers state for a scene, from clouds of the scene itself.

In some windows of the first frame the tier ``source`` is computed and compared with columns and ``slant``: what they
differ by is their error as far as ``source`` is right. Its own error grows with the same difference, that is with how
much broken clouds matter in the scene; the shares were found by Monte Carlo in random scenes
(``benchmarks/estimates.py``). No table of cloud types, angles or pixels is needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from hcss_light.source import Direction
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

SIDE, WINDOWS = 24, 2
"""Points along the sides of a window, and windows along each side of the image if these fit into it twice."""

EMITTED_UM = 5.0
"""Wavelength above which sunlight does not matter."""

SUNLIT, SHORT, LONG = (0.02, 0.2), (0.005, 0.05), (0.0012, 0.05)
"""Least error of ``source``, and its share of the difference of columns: by day below 5 um, by night, and above."""

OPPOSITE_DEG = 10.0
"""Angle between view and sun within which the share grows to 1: there the parts of voxels are seen that are lit."""

FACTOR = 1.5
"""What is stated over what is expected: pixels differ, and most scenes are to be within it."""


def differences(
    inputs: LightInputs, lights: Sequence[Any], reach: Sequence[tuple[int, int]], clouds: Callable[[slice, slice], Any]
) -> list[Array]:
    """Return by how much columns, and other tiers, differ (B,) from ``source``: rms over points over the mean.

    Parameters
    ----------
    lights : sequence of ScatteredLight
        The tier ``source``, and others.
    reach : sequence of (int, int)
        Rows, and columns, of points around others that matter to them.
    clouds : callable
        Returns the thickness of clouds in rows and columns, and their shares of heights.
    """
    sun, parts = lowest_sun(inputs), list[list[Array]]()
    instants = [each.at(sun) for each in lights]
    for window in windows_of(inputs.image):
        wide = [slice(own.start - low, own.stop + high) for own, (low, high) in zip(window, reach, strict=True)]
        inner = [slice(low, low + own.stop - own.start) for own, (low, _) in zip(window, reach, strict=True)]
        thickness, shares = clouds(wide[0], wide[1])
        # Tables are not known yet: uniform cloud is that of the tier source.
        found = [instants[0].uniform(thickness)]
        for light in instants:
            amount, share, change = light.correct(thickness, shares=shares)
            found.append(instants[0].uniform(amount) * share + change)
        parts.append([each[:, *inner].reshape(each.shape[0], -1) for each in found])
    columns, exact, *others = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
    mean = np.maximum(np.mean(exact, axis=1), np.finfo(float).tiny)
    return [np.sqrt(np.mean((each - exact) ** 2, axis=1)) / mean for each in (columns, *others)]


def error_of_source(inputs: LightInputs, of_columns: Array) -> Array:
    """Return the error (B,) to expect of the tier ``source`` from the difference (B,) of columns."""
    weights = np.maximum(inputs.weights_cm1, 0.0)
    wavelength_um, sun = 1e4 * np.sum(weights, axis=1) / (weights @ inputs.wavenumber_cm1), lowest_sun(inputs)
    errors = []
    for wavelength, difference in zip(wavelength_um.tolist(), of_columns.tolist(), strict=True):
        lit = sun is not None and wavelength < EMITTED_UM
        least, share = SUNLIT if lit else SHORT if wavelength < EMITTED_UM else LONG
        if lit and sun is not None:
            toward = Direction(sun.zenith_deg, sun.azimuth_deg).vector
            across = toward @ Direction(inputs.view.zenith_deg, inputs.view.azimuth_deg).vector
            angle = math.degrees(math.acos(min(max(float(across), -1.0), 1.0)))
            share += (1.0 - share) * math.exp(-((angle / OPPOSITE_DEG) ** 2))
        errors.append(math.hypot(least, share * difference))
    return np.array(errors)


def stated_errors(inputs: LightInputs, of_columns: Array, of_tier: Array | float) -> list[float]:
    """Return the error (B,) of a tier from its difference from ``source``, and from that of columns.

    It is a bound for the rms over pixels, relative to the mean radiance, not its mean over scenes.
    """
    own = error_of_source(inputs, of_columns)
    return [FACTOR * float(each) for each in np.hypot(of_tier, own)]


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
