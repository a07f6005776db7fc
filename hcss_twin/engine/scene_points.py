"""Values at the points of the scene, and between them, where rays meet it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.plan.clear_sky import EvenFields
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.windows import Window, pixel_sums

Values = TypeVar("Values", bound=NDArray[Any])

ANYWHERE: Window = slice(0, 1), slice(0, 1)
"""Pixel of the scene whose values rays get that all miss it."""


def at_rays(
    plan: Plan,
    window: Window,
    time_s: float,
    height_m: float,
    of_scene: Callable[[Window], Values],
    between: Callable[[Values, Array, Array, tuple[int, int]], Values],
    rays: Rays | None = None,
) -> Values:
    """Return values (..., y, x) at the points of a window of the image, whose rays see the scene at a height.

    Parameters
    ----------
    of_scene : callable
        Returns the values (..., Y, X) at the points of a window of the scene's plane, in or around it.
    between : callable
        :func:`nearest`, :func:`linear` or :func:`interpolated`; on a grid on the ground, rays see the points of the
        scene themselves.
    rays : Rays, optional
        By default those of the plan.
    """
    if plan.is_grid:
        return of_scene(window)
    scene = plan.scene
    row, column = scene.in_points(*(rays or plan.rays).points_m(window, time_s, height_m))
    below = scene.around(row, column) or ANYWHERE
    return between(of_scene(below), row, column, scene.corner_of(below))


def nearest(values: NDArray[Any], row: Array, column: Array, corner: tuple[int, int]) -> NDArray[Any]:
    """Return the values (..., Y, X) of points from a corner on, nearest to places (y, x), or of the edge beyond it."""
    y, x = (
        np.clip(np.rint(np.nan_to_num(position)).astype(np.int64) - first, 0, size - 1)
        for position, first, size in zip((row, column), corner, values.shape[-2:], strict=True)
    )
    return values[..., y, x]


def linear(values: NDArray[np.float32], row: Array, column: Array, corner: tuple[int, int]) -> NDArray[np.float32]:
    """Return the values (K, Y, X) of points from a corner on, interpolated at places (y, x); 0 where they are NaN."""
    result = np.empty((len(values), *row.shape), dtype=np.float32)
    _linear(result, np.ascontiguousarray(values), row, column, *corner)
    return result


@kernel()
def _linear(result, fields, row, column, first_row, first_column):  # type: ignore[no-untyped-def]
    """Interpolate fields (K, Y, X) at places (y, x) between their points, of which all have neighbours."""
    for i in range(row.shape[0]):
        for j in range(row.shape[1]):
            if not (row[i, j] == row[i, j] and column[i, j] == column[i, j]):
                result[:, i, j] = 0.0
                continue
            # Whole parts first: a place has the same bits whatever the window.
            top, left = np.floor(row[i, j]), np.floor(column[i, j])
            y, x = row[i, j] - top, column[i, j] - left
            up, side = np.int64(top) - first_row, np.int64(left) - first_column
            for k in range(fields.shape[0]):
                near = (1.0 - x) * fields[k, up, side] + x * fields[k, up, side + 1]
                far = (1.0 - x) * fields[k, up + 1, side] + x * fields[k, up + 1, side + 1]
                result[k, i, j] = np.float32((1.0 - y) * near + y * far)


def seen_fields(
    plan: Plan, fields: EvenFields, time_s: float, window: Window
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return how far the pixels (y, x) of a window of the image are perturbed by texture, as :meth:`.EvenFields.at`.

    The fields are means over the pixels of the scene. Other rays than those of a grid see them between the centres of
    these, and their pixels are means over their points.
    """
    if plan.is_grid:
        return fields.at(time_s, *window)
    samples = plan.scene.samples

    def of_scene(below: Window) -> NDArray[np.float32]:
        around = (slice(pixels.start - 1, pixels.stop + 1) for pixels in below)  # to interpolate within the outer ones
        return np.stack(fields.at(time_s, *around))

    def between(fields: NDArray[np.float32], row: Array, column: Array, corner: tuple[int, int]) -> NDArray[np.float32]:
        of_pixels = (row + 0.5) / samples - 0.5, (column + 0.5) / samples - 0.5
        return linear(fields, *of_pixels, (corner[0] // samples - 1, corner[1] // samples - 1))

    warmer, drier = at_rays(plan, window, time_s, 0.0, of_scene, between)
    per = plan.samples_per_pixel
    of_pixels = (np.asarray(pixel_sums(of_points, per) / per**2, np.float32) for of_points in (warmer, drier))
    return next(of_pixels), next(of_pixels)


def interpolated(
    thickness_m: NDArray[np.float32], row: Array, column: Array, corner: tuple[int, int]
) -> NDArray[np.float32]:
    """Return the thickness (Y, X) of points from a corner on, interpolated at places (y, x); 0 where they are NaN."""
    result = np.empty(row.shape, dtype=np.float32)
    _interpolate(result, np.ascontiguousarray(thickness_m), row, column, *corner)
    return result


@kernel()
def _interpolate(result, field, row, column, first_row, first_column):  # type: ignore[no-untyped-def]
    """Interpolate the thickness of a field (Y, X) at places (y, x), counted from the first point of the scene.

    A place is cloudy if the bilinear weights of its cloudy neighbours are at least half; then its thickness is their
    mean, so that none is thinner than the thinnest cloud. Places that are NaN are clear.
    """
    last_y, last_x = field.shape[0] - 1, field.shape[1] - 1
    for i in range(row.shape[0]):
        for j in range(row.shape[1]):
            result[i, j] = 0.0
            if not (row[i, j] == row[i, j] and column[i, j] == column[i, j]):
                continue
            # Whole parts first: a place has the same bits whatever the window.
            top, left = np.floor(row[i, j]), np.floor(column[i, j])
            y, x = row[i, j] - top, column[i, j] - left
            up, side = np.int64(top) - first_row, np.int64(left) - first_column
            if up < 0:
                up, y = 0, 0.0
            elif up >= last_y:
                up, y = max(last_y - 1, 0), 1.0 if last_y > 0 else 0.0
            if side < 0:
                side, x = 0, 0.0
            elif side >= last_x:
                side, x = max(last_x - 1, 0), 1.0 if last_x > 0 else 0.0
            cloudy, total = 0.0, 0.0
            for a in range(2):
                for b in range(2):
                    weight = (y if a else 1.0 - y) * (x if b else 1.0 - x)
                    value = np.float64(field[min(up + a, last_y), min(side + b, last_x)])
                    if weight > 0.0 and value > 0.0:
                        cloudy += weight
                        total += weight * value
            if cloudy >= 0.5:
                result[i, j] = np.float32(total / cloudy)
