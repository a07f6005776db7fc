"""The image of a point through optics and detector: the mean of the point spread over each pixel, at any place.

A point that moves is the mean of its images along its way, close enough that their distance cannot be seen.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import j1, ndtr

from hcss_twin.core.arrays import Array
from hcss_twin.physics.quadrature import gauss_legendre
from hcss_twin.providers import Points

_STEPS, _STEPS_PER_PIXEL, _STEPS_WITHOUT_SPREAD = 3, 4, 64
"""Images along any motion, and along each pixel of it; more where each is in one pixel only."""

_AT_ONCE = 64
"""Points whose images are added together."""

_NEAR, _RINGS = 8.0, 12.0
"""Distance in pixels, and in rings of diffraction, within which an Airy pattern is integrated over each pixel; beyond,
its rings are averaged, which leaves 2e-4 of the light."""

_SPLINE, _EDGE = 5, 8
"""Degree of the spline through a measured spot, and zeros around the spot, in pixels."""


class PointImage:
    """Images of points in one band.

    Parameters
    ----------
    sigma : float, optional
        Standard deviation of a Gaussian point spread, pixels.
    cutoff : float, optional
        Cut-off frequency of a round aperture, cycles per pixel.
    spot : ndarray (K, L), optional
        Measured image of a point in the middle of a pixel. Without all three the point is in the pixel that holds it.
    """

    def __init__(self, sigma: float | None = None, cutoff: float | None = None, spot: Array | None = None) -> None:
        self._sigma, self._cutoff, self._spot = sigma, cutoff, None
        if spot is not None:
            from scipy.ndimage import spline_filter  # only for measured spots

            wide = np.pad(spot, _EDGE)
            self._spot = spline_filter(wide, _SPLINE, mode="grid-constant") if spot.size > 1 else wide

    def draw(self, image: Array, points: Points, band: int, exposure_s: float) -> None:
        """Add the images of points to a frame (Y, X), smeared by their motion in an exposure around its time."""
        spreads = any(spread is not None for spread in (self._sigma, self._cutoff, self._spot))
        steps = _STEPS_PER_PIXEL if spreads else _STEPS_WITHOUT_SPREAD
        together = _AT_ONCE if self._cutoff is None and self._spot is None else 1
        for first in range(0, points.row.size, together):
            part = slice(first, first + together)
            row, column, share = _along_the_way(points, part, exposure_s, steps)
            light = points.radiance[band, part]
            if self._cutoff is not None:
                _add_airy(image, row, column, float(light[0]), self._cutoff)
            elif self._spot is not None:
                for at in zip(row.tolist(), column.tolist(), strict=True):
                    _add_spot(image, *at, float(light[0]) / row.size, self._spot)
            else:
                down, across = (
                    _profile(position, size, self._sigma)
                    for position, size in zip((row, column), image.shape, strict=True)
                )
                image += (down * (share @ light)[:, None]).T @ across


def _along_the_way(points: Points, part: slice, exposure_s: float, steps: int) -> tuple[Array, Array, Array]:
    """Return rows and columns (N,) of some points (P,) in the middles of equal parts of the exposure.

    The third array (N, P) is the share of each point's light that is at each of these places.
    """
    row_rate, column_rate = points.row_rate[part], points.column_rate[part]
    motion = exposure_s * np.hypot(row_rate, column_rate)
    counts = np.where(motion > 0.0, np.ceil(steps * motion) + _STEPS, 1.0).astype(np.intp)
    which = np.repeat(np.arange(counts.size), counts)
    step = np.arange(which.size) - np.repeat(np.cumsum(counts) - counts, counts)
    later = ((step + 0.5) / counts[which] - 0.5) * exposure_s
    share = np.zeros((which.size, counts.size))
    share[np.arange(which.size), which] = 1.0 / counts[which]
    row, column = points.row[part][which], points.column[part][which]
    return row + later * row_rate[which], column + later * column_rate[which], share


def _profile(position: Array, size: int, sigma: float | None) -> Array:
    """Return the shares (N, size) of points in rows or columns: of a Gaussian, or without spread in one."""
    edges = np.arange(size + 1.0)
    if sigma is None:
        held: Array = (np.floor(position)[:, None] == edges[:-1]).astype(np.float64)
        return held
    shares: Array = np.diff(ndtr((edges - position[:, None]) / sigma), axis=1)
    return shares


def _window(least: float, most: float, reach: int, size: int) -> slice:
    """Pixels of an axis within reach of places."""
    first, last = math.floor(least) - reach, math.floor(most) + reach
    return slice(min(max(first, 0), size), min(max(last + 1, 0), size))


def _add_airy(image: Array, row: Array, column: Array, light: float, cutoff: float) -> None:
    """Add the diffraction pattern of a round aperture (Born and Wolf, Principles of Optics, section 8.5.2).

    Per pixel^2 it is (pi u^2 / 4) (2 J1(v) / v)^2 with v = pi u r, the cut-off frequency u in cycles per pixel and the
    distance r in pixels. Far away it falls as 1 / (pi^3 u r^3), averaged over its rings. The light is shared evenly by
    the places (N,) on a way.
    """
    reach = math.ceil(max(_NEAR, _RINGS / cutoff))
    near = tuple(
        _window(float(at.min()), float(at.max()), reach, size)
        for at, size in zip((row, column), image.shape, strict=True)
    )
    y, x = (np.arange(size) + 0.5 for size in image.shape)
    inner = image[near].copy()
    away = np.hypot((y - row.mean())[:, None], x - column.mean())
    image += light / (np.pi**3 * cutoff * np.maximum(away, 0.5) ** 3)
    if not inner.size:
        return
    abscissa, weight = gauss_legendre(4 + math.ceil(2.5 * cutoff))
    inside, share = 0.5 * abscissa, 0.5 * weight
    pattern = np.zeros(inner.shape)
    for at_row, at_column in zip(row.tolist(), column.tolist(), strict=True):
        down, across = (y[near[0], None] + (inside - at_row)) ** 2, (x[near[1], None] + (inside - at_column)) ** 2
        v = np.maximum(np.pi * cutoff * np.sqrt(down[:, None, :, None] + across[:, None, :]), 1e-9)
        pattern += np.einsum("yxij,i,j->yx", (2.0 * j1(v) / v) ** 2, share, share)
    image[near] = inner + light * 0.25 * np.pi * cutoff**2 / row.size * pattern


def _add_spot(image: Array, row: float, column: float, light: float, spot: Array) -> None:
    """Add a measured spot, interpolated by a spline, which keeps its sum and its centroid."""
    from scipy.ndimage import map_coordinates

    rows, columns = (
        _window(at, at, length // 2 + 1, size)
        for at, length, size in zip((row, column), spot.shape, image.shape, strict=True)
    )
    y, x = (
        np.arange(pixels.start, pixels.stop) + 0.5 - at + length // 2
        for pixels, at, length in zip((rows, columns), (row, column), spot.shape, strict=True)
    )
    at = np.meshgrid(y, x, indexing="ij")
    image[rows, columns] += light * map_coordinates(spot, at, order=_SPLINE, mode="grid-constant", prefilter=False)
