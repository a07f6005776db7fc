"""Focal-plane camera: from pixels to directions and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hcss_payload.checks import PayloadError, require_within, unit_quaternion
from hcss_twin.providers import Array

_CONVERGED, _MAX_ITERATIONS = 1e-13, 50


@dataclass(frozen=True)
class Camera:
    """A camera with a flat focal plane and lens distortion.

    A pixel's coordinates are those of its centre, from 0: pixel (row 0, column 0) covers -0.5 to 0.5. The camera looks
    along +z, columns count along +x and rows along +y.

    Parameters
    ----------
    rows, columns : int
        Of the detector.
    focal_length_m, pitch_m : float
        Focal length, and distance between the centres of neighbouring pixels.
    principal_point : (float, float), optional
        Row and column at which the optical axis meets the detector; by default its centre.
    radial : (float, float)
        Coefficients k1, k2 of radial distortion, in coordinates x / z, y / z.
    tangential : (float, float)
        Coefficients p1, p2 of tangential distortion.
    mounting : (float, float, float, float)
        Quaternion (x, y, z, w) that turns vectors of the camera into vectors of the body.

    References
    ----------
    Distortion: D. C. Brown, "Decentering distortion of lenses", Photogrammetric Engineering 32 (3), 444-462 (1966),
    with the sign and order of p1 and p2 as in OpenCV.
    """

    rows: int
    columns: int
    focal_length_m: float
    pitch_m: float
    principal_point: tuple[float, float] | None = None
    radial: tuple[float, float] = (0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)
    mounting: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        require_within("camera.rows", self.rows, 1, 65536)
        require_within("camera.columns", self.columns, 1, 65536)
        require_within("camera.focal_length_m", self.focal_length_m, 1e-4, 1e3, "m")
        require_within("camera.pitch_m", self.pitch_m, 1e-7, 1e-2, "m")
        unit_quaternion("camera.mounting", self.mounting)
        self._require_invertible()

    @property
    def centre(self) -> tuple[float, float]:
        """Row and column of the principal point."""
        return self.principal_point or (0.5 * (self.rows - 1), 0.5 * (self.columns - 1))

    @property
    def pixel_rad(self) -> float:
        """Angle between neighbouring pixels on the optical axis."""
        return self.pitch_m / self.focal_length_m

    def directions(self, row: Array, column: Array) -> Array:
        """Return the unit vectors (..., 3), in the body, toward which points (...) of the detector look."""
        at_row, at_column = self.centre
        seen = np.stack(np.broadcast_arrays(column - at_column, row - at_row), axis=-1) * self.pixel_rad
        ideal = self._undistorted(seen)
        vector = np.concatenate((ideal, np.ones_like(ideal[..., :1])), axis=-1)
        vector /= np.linalg.norm(vector, axis=-1, keepdims=True)
        turned: Array = Rotation.from_quat(self.mounting).apply(vector.reshape(-1, 3)).reshape(vector.shape)
        return turned

    def pixels(self, direction: Array) -> tuple[Array, Array]:
        """Return row and column (...) that see directions (..., 3) of the body; NaN for those behind the camera."""
        flat = Rotation.from_quat(self.mounting).apply(direction.reshape(-1, 3), inverse=True).reshape(direction.shape)
        ahead = np.where(flat[..., 2:] > 0.0, flat[..., 2:], np.nan)
        seen = self._distorted(flat[..., :2] / ahead) / self.pixel_rad
        return seen[..., 1] + self.centre[0], seen[..., 0] + self.centre[1]

    def _distorted(self, ideal: Array) -> Array:
        x, y = ideal[..., 0], ideal[..., 1]
        (k1, k2), (p1, p2) = self.radial, self.tangential
        square = x**2 + y**2
        radial = 1.0 + square * (k1 + k2 * square)
        return np.stack(
            (
                x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x**2),
                y * radial + p1 * (square + 2.0 * y**2) + 2.0 * p2 * x * y,
            ),
            axis=-1,
        )

    def _undistorted(self, seen: Array) -> Array:
        """Invert the distortion by fixed-point iteration; not finite where it does not converge."""
        ideal = seen
        if not (any(self.radial) or any(self.tangential)):
            return ideal
        for _ in range(_MAX_ITERATIONS):
            step = seen - self._distorted(ideal)
            ideal = ideal + step
            if np.all(np.abs(step) < _CONVERGED):
                return ideal
        return np.where(np.abs(step) < _CONVERGED, ideal, np.nan)

    def _require_invertible(self) -> None:
        """Distortion grows outward, so that the border of the detector decides."""
        row, column = np.array([-0.5, 0.5 * self.rows, self.rows - 0.5]), np.array([-0.5, self.columns - 0.5])
        with np.errstate(over="ignore", invalid="ignore"):
            border = self.directions(row[:, None], column[None, :])
        if not np.all(np.isfinite(border)):
            raise PayloadError(
                f"camera.radial, camera.tangential: {self.radial}, {self.tangential} cannot be inverted at the border "
                "of the detector; allowed: smaller coefficients, or a narrower field"
            )
