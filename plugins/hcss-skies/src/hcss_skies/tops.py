"""Thickness and cloud-top altitude that belong to the two heights of an example, in the scene's own radiance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array, BrightnessInversion, CloudLayer

_ALTITUDES = 17
"""Number of altitudes at which the scene is asked; in between, brightness temperatures are linear."""

_EXCESSES = 97
_THICKNESSES = 64

_LOWEST_M = 100.0
"""Lowest cloud top; warmer clouds are thin ones there."""

_BEYOND_M = 1500.0
"""How far above the highest opaque cloud altitudes are tried: the air above clouds warms or cools them a little."""


@dataclass(frozen=True)
class HangingClouds:
    """Clouds that hang from their own tops.

    Attributes
    ----------
    fields : ndarray of float32 (P, X, 2)
        Thickness and altitude of the top in m, for knots of p and evenly spaced excesses x from 0.
    step_m : float
        Between these excesses.
    range_m : (float, float)
        Lowest and highest top.
    """

    fields: NDArray[np.float32]
    step_m: float
    range_m: tuple[float, float]


def hanging_clouds(
    inversion: BrightnessInversion, layer: CloudLayer, kelvin: Array, excess_m: Array, highest_m: float
) -> HangingClouds:
    """Return the clouds with given brightness temperatures: no lower than opaque, and x higher.

    An opaque cloud has the lowest top with its temperature; a cloud x above it is as thin as that temperature needs.

    Parameters
    ----------
    kelvin : ndarray (P,)
        Brightness temperature of each knot of p.
    excess_m : ndarray
        x of the example.
    highest_m : float
        Altitude of its highest cloud top.
    """
    lowest = max(_LOWEST_M, 2.0 * layer.thickness_min_m)
    # Close at the bottom, where clouds are too thin to be opaque.
    rise = np.linspace(0.0, 1.0, _ALTITUDES) ** 2
    altitude = lowest + (max(0.0, highest_m - lowest) + _BEYOND_M) * rise
    thinnest = max(layer.thickness_min_m, 1e-4 * layer.thickness_max_m)
    thickness = np.geomspace(thinnest, layer.thickness_max_m, _THICKNESSES)
    curves = np.stack([_curve(inversion, altitude_m, thickness) for altitude_m in altitude])
    # The coldest altitude is the highest: above the tropopause opaque clouds are warmer.
    last = int(np.argmin(curves[:, -1])) + 1
    altitude, curves = altitude[: max(last, 2)], curves[: max(last, 2)]
    opaque = np.minimum.accumulate(curves[:, -1] - 1e-9 * np.arange(altitude.size))
    lowest_top = np.interp(-kelvin, -opaque, altitude)
    x = np.linspace(0.0, max(float(np.max(excess_m)), 1.0), _EXCESSES)
    top = np.minimum(lowest_top[:, None] + x, altitude[-1])
    fields = np.empty((kelvin.size, x.size, 2), np.float32)
    fields[..., 1] = np.clip(top, np.float32(altitude[0]), np.float32(altitude[-1]))
    position = np.interp(top, altitude, np.arange(altitude.size))
    low = np.minimum(position.astype(int), altitude.size - 2)
    share = (position - low)[..., None]
    curve = (1.0 - share) * curves[low] + share * curves[low + 1]
    for p, curve_of_pixel in enumerate(curve):
        fields[p, :, 0] = _thickness_at(float(kelvin[p]), curve_of_pixel, np.concatenate(([0.0], thickness)))
    fields[..., 0] = np.minimum(fields[..., 0], np.minimum(fields[..., 1], np.float32(layer.thickness_max_m)))
    return HangingClouds(fields, float(x[1]), (float(fields[..., 1].min()), float(fields[..., 1].max())))


def _curve(inversion: BrightnessInversion, altitude_m: float, thickness_m: Array) -> Array:
    """Return the brightness temperature of clear sky and of clouds, (N + 1,), that never rises with thickness."""
    known, kelvin = inversion.hanging_K(altitude_m)
    cloudy_K = np.interp(np.log(thickness_m), np.log(known[1:]), kelvin[1:])
    curve: Array = np.minimum.accumulate(np.concatenate((kelvin[:1], cloudy_K)))
    return curve


def _thickness_at(kelvin: float, curves: Array, thickness_m: Array) -> Array:
    """Return the thickness (X,) at which each curve (X, N), which never rises, has a temperature: as np.interp."""
    numbers = np.arange(len(curves))
    low = np.clip(np.count_nonzero(curves >= kelvin, axis=1) - 1, 0, thickness_m.size - 2)
    warm, cold = curves[numbers, low], curves[numbers, low + 1]
    share = np.clip((warm - kelvin) / np.maximum(warm - cold, 1e-300), 0.0, 1.0)
    found: Array = thickness_m[low] + share * (thickness_m[low + 1] - thickness_m[low])
    return found


@kernel()
def look_up_pairs(out: Any, fields: Any, step_m: float) -> None:
    """Replace knots of p and x in m by thickness and altitude of the top, bilinear; ``out`` (rows, columns, 2)."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            at_p = min(max(float(out[i, j, 0]), 0.0), fields.shape[0] - 1.000001)
            at_x = min(max(float(out[i, j, 1]) / step_m, 0.0), fields.shape[1] - 1.000001)
            p, x = int(at_p), int(at_x)
            share_p, share_x = at_p - p, at_x - x
            for n in range(2):
                low = fields[p, x, n] + share_x * (fields[p, x + 1, n] - fields[p, x, n])
                high = fields[p + 1, x, n] + share_x * (fields[p + 1, x + 1, n] - fields[p + 1, x, n])
                out[i, j, n] = low + share_p * (high - low)


def between_cells(cells: Array, y: Array, x: Array, first: Sequence[int] = (0, 0)) -> Array:
    """Return values (Y, X) at positions between the centres of cells, bilinear; ``first`` is the place of ``cells``."""
    (i, fy), (j, fx) = (
        (np.clip(np.floor(at).astype(np.int64) - low, 0, side - 2), at - np.floor(at))  # the same bits in any window
        for at, side, low in zip((y, x), cells.shape[:2], first, strict=True)
    )
    fy = fy.reshape(-1, *(1,) * (cells.ndim - 1))
    fx = fx.reshape(-1, *(1,) * (cells.ndim - 2))
    rows = (1.0 - fy) * cells[i] + fy * cells[i + 1]
    values: Array = (1.0 - fx) * rows[:, j] + fx * rows[:, j + 1]
    return values
