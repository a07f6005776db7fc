"""Light between columns of cloud, as simple as can be: each column is lit as the mean of its neighbourhood."""

from collections.abc import Sequence

import numpy as np
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs
from numpy.typing import NDArray

REACH_M = 300.0
"""Distance over which light is exchanged."""


class Smoothed:
    """Light at one instant."""

    def __init__(self, points: int, bands: int) -> None:
        self._points, self._bands = points, bands

    def correct(self, thickness_m: NDArray[np.float32]) -> tuple[Array, Array, Array]:
        """Return the thickness (y, x) at which tables are read, the share of their radiance, and what is added."""
        width = 2 * self._points + 1
        padded = np.pad(thickness_m.astype(np.float64), self._points, mode="edge")
        windows = np.lib.stride_tricks.sliding_window_view(padded, (width, width))
        cloudy = np.maximum((windows > 0.0).sum(axis=(2, 3)), 1)
        smooth = np.where(thickness_m > 0.0, windows.sum(axis=(2, 3)) / cloudy, 0.0)
        shape = self._bands, *thickness_m.shape
        return smooth, np.ones(shape), np.zeros(shape)


class Light:
    """Reads the tables at the thickness of the neighbourhood's mean optical path, and adds nothing.

    Clear points stay clear. A model for your own: replace the smoothing by physics, and the errors by measured ones.
    """

    cost = 2.0

    def __init__(self, inputs: LightInputs) -> None:
        self._bands = len(inputs.weights_cm1)
        self._points = max(1, min(8, round(REACH_M / inputs.point_m)))
        self.reach = (self._points, self._points), (self._points, self._points)

    def expected_errors(self) -> Sequence[float]:
        """Return the error (B,) to expect, which nobody has measured."""
        return [0.1] * self._bands

    def errors_of_columns(self) -> Sequence[float]:
        """Return the error (B,) to expect of independent columns."""
        return [0.1] * self._bands

    def at(self, sun: Sun | None) -> Smoothed:
        """Return the light under a sun; at night there is nothing to exchange here."""
        return Smoothed(0 if sun is None else self._points, self._bands)
