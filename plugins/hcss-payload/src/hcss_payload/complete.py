"""Completion of the frames of a camera: coordinates of pixels, space, and what is not computed."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera_points import Window
from hcss_payload.limb import Limb, tangent_heights_m
from hcss_payload.pixel_variables import PIXEL_VARIABLES, TANGENT_HEIGHT
from hcss_payload.ray_geometry import GROUND, LIMB, SLANT, SPACE, FrameGeometry, PixelRays

PIXELS_AT_ONCE = 2**19
"""Pixels whose coordinates are computed together: the lines of sight of a full disk would take 3 GB."""

STEPS_PER_DEGREE = 2.0**26
"""Latitudes and longitudes are multiples of its inverse, 1.7 mm: what double precision has below does not compress."""


def complete(
    frame: dict[str, NDArray[Any]],
    geometry: FrameGeometry,
    extent: Window,
    shows_limb: bool,
    limb: Limb | None,
    derived: Collection[str] = (),
    coordinates: bool = True,
) -> None:
    """Add the coordinates of the pixels to a part of a frame; set space to 0 and what is not computed to missing.

    Parameters
    ----------
    shows_limb : bool
        Whether pixels of the limb have a tangent height.
    limb : Limb or None
        Radiance of the limb; None if it is missing.
    derived : collection of str
        Variables of other packages, which are missing in space, too.
    coordinates : bool
        Whether to add coordinates, which take longer than all else.
    """
    rows, columns = extent
    shape, ground_variables = (rows.stop - rows.start, columns.stop - columns.start), dict(frame)
    specs = (*PIXEL_VARIABLES, TANGENT_HEIGHT) if shows_limb else PIXEL_VARIABLES
    for spec in specs if coordinates else ():
        frame[spec.name] = np.empty(shape, dtype=spec.dtype)
    step = max(1, PIXELS_AT_ONCE // shape[1])
    for first in range(0, shape[0], step):
        strip = slice(first, min(first + step, shape[0]))
        window = slice(rows.start + strip.start, rows.start + strip.stop), columns
        rays = geometry.window(*window)
        beyond, space = rays.kind != GROUND, rays.kind == SPACE
        if beyond.any():
            for name, values in ground_variables.items():
                if values.dtype.kind == "f":
                    values[..., strip, :][..., beyond] = np.nan
                    values[..., strip, :][..., space] = np.nan if name in derived else 0.0
        if coordinates:
            for spec, coordinate in zip(PIXEL_VARIABLES, _coordinates(geometry, rays), strict=True):
                frame[spec.name][strip] = coordinate
        if shows_limb:
            height = _tangent_heights(geometry, rays.kind, window)
            if coordinates:
                frame[TANGENT_HEIGHT.name][strip] = np.where(rays.kind >= LIMB, height, np.nan)
            if limb is not None:
                air = (rays.kind >= SLANT) & ~space & (height >= limb.lowest_m)
                frame["radiance"][..., strip, :][..., air] = limb(height[air])


def _coordinates(geometry: FrameGeometry, rays: PixelRays) -> tuple[NDArray[Any], ...]:
    """Return the coordinates of pixels in the order of ``PIXEL_VARIABLES``."""
    latitude, longitude = (
        np.rint(degrees * STEPS_PER_DEGREE) / STEPS_PER_DEGREE for degrees in geometry.latitude_longitude(rays)
    )
    distance = np.linalg.norm(geometry.pose.position_m - rays.position_m, axis=-1)
    return latitude, longitude, *geometry.angles_deg(rays), distance, rays.kind


def _tangent_heights(geometry: FrameGeometry, kind: NDArray[np.uint8], window: Window) -> NDArray[np.float64]:
    """Return the tangent heights of pixels beyond the ground, those of lines that meet it below it; NaN for others."""
    seen = kind >= SLANT
    row, column = (np.arange(span.start, span.stop, dtype=np.float64) for span in window)
    places = (numbers[seen] for numbers in np.meshgrid(row, column, indexing="ij"))
    height = np.full(kind.shape, np.nan)
    ray = geometry.pose.to_earth(geometry.camera.directions(*places))
    height[seen] = tangent_heights_m(geometry.pose.position_m, ray)
    return height
