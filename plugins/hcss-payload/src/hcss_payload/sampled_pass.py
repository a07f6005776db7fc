"""What a camera sees over a pass: directions, places and footprints of sampled pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera import Camera
from hcss_payload.ray_geometry import GROUND, FrameGeometry
from hcss_twin.providers import Array, Problem, ScenarioError

FIELD, FIELD_AT_LIMB = 9, 129
"""Points along each side of the detector at which a pass is sampled; the second where pixels miss the ground."""


@dataclass(frozen=True, eq=False)
class SampledPass:
    """Sampled pixels of the ground.

    Attributes
    ----------
    toward : ndarray (N, 3)
        Directions to the camera.
    place_deg : ndarray (M, 2)
        Latitude and longitude.
    footprint_m : ndarray (M,)
        Geometric mean of the sides.
    limit_deg : float or None
        Largest zenith, if pixels see the ground beyond it.
    """

    toward: Array
    place_deg: Array
    footprint_m: Array
    limit_deg: float | None


def sample_pass(
    camera: Camera,
    geometry_at: Callable[[float], FrameGeometry],
    require_ground: Callable[[NDArray[np.uint8], float], None],
    times_s: Array,
    margin_px: float,
    largest_deg: float,
) -> SampledPass:
    """Return sampled pixels of a pass.

    Parameters
    ----------
    require_ground : callable
        Raises an error for kinds of pixels that are not allowed, at a time.
    margin_px : float
        Around the detector: between the sampled times jitter may turn the image as far as it ever does.
    largest_deg : float
        View zenith up to which pixels are of the ground.

    Raises
    ------
    ScenarioError
        If no pixel sees the ground.
    """
    toward, places, footprints, limit_deg = [], [], [], None
    for time_s in times_s.tolist():
        geometry = geometry_at(time_s)
        kind = geometry.exact(*_sampled(camera, FIELD)).kind
        require_ground(kind, time_s)
        if not np.all(kind == GROUND):
            limit_deg = largest_deg
        rays = geometry.exact(*_sampled(camera, FIELD if np.all(kind == GROUND) else FIELD_AT_LIMB, margin_px))
        ground = rays.kind == GROUND
        if not ground.any():
            continue
        # Between sampled pixels at the limit others may be closer to it. Far from the scene there are no directions.
        near = ground
        if limit_deg is not None:
            near = (rays.toward[..., 2] > np.cos(np.radians(limit_deg + 1.0))) & ~np.isnan(rays.toward[..., 0])
        toward.append(rays.toward[near])
        places.append(np.stack(geometry.latitude_longitude(rays), axis=-1)[ground])
        distance = np.linalg.norm(geometry.pose.position_m - rays.position_m[ground], axis=-1)
        footprints.append(distance * camera.pixel_rad / np.sqrt(rays.toward[ground][:, 2]))
    if not toward:
        message = f"no pixel of any frame sees the ground below zenith {largest_deg:g} deg; allowed: passes that do"
        raise ScenarioError([Problem("attitude", message)])
    return SampledPass(np.concatenate(toward), np.concatenate(places), np.concatenate(footprints), limit_deg)


def _sampled(camera: Camera, count: int, margin: float = 0.0) -> tuple[Array, Array]:
    """Return rows (n, 1) and columns (1, n) from edge to edge of the image, with a margin in pixels."""
    rows, columns = (np.linspace(-0.5 - margin, size - 0.5 + margin, count) for size in (camera.rows, camera.columns))
    return rows[:, None], columns[None, :]
