"""A followed sky without end: a forecast at any place and time, and what is beyond the edge of its images.

Beyond the edge the sky is blended from the image as by the generator `example`: it has the image's statistics, not its
clouds. Both parts move along the same velocities, those at the edge beyond it.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

import numpy as np
from hcss_skies.blended import BlendedExample
from hcss_skies.example import Example, make_example
from hcss_skies.importing import CLEAR_K, detail_of
from numpy.typing import NDArray

from hcss_follow.analysis import LAPSE_K_M
from hcss_follow.coefficients import Coefficients
from hcss_follow.forecast import Forecast
from hcss_follow.motion import departures, interpolate
from hcss_follow.state import Field, State
from hcss_twin.providers import Array

_FADE = 24
"""Pixels beyond the edge over which mirrored pixels of the image give way to the blended ones."""

_REACH = 2
"""Pixels around a place that interpolation needs."""

_WARM_PERCENTILE = 99.9


@lru_cache(maxsize=4)
def example_of(state: State) -> Example:
    """Return the example of a state, for places beyond its edge; plans make a generator repeatedly."""
    kelvin = state.kelvin.astype(np.float64)
    warm = float(np.percentile(kelvin, _WARM_PERCENTILE))
    return make_example(
        (warm - kelvin) / LAPSE_K_M, state.excess_m.astype(np.float64), pixel_size_m=state.pixel_size_m,
        clear_m=CLEAR_K / LAPSE_K_M, kind="followed", source=state.source, licence=state.rights,
        detail=detail_of(kelvin, warm), lapse_K_m=LAPSE_K_M,
    )  # fmt: skip


class FollowedSky:
    """Brightness temperature and cloud-top excess of a state at any place and time.

    Parameters
    ----------
    state : State
    seed : int
        Of what is beyond the edge.
    member : int or None
        Of the ensemble; None: the mean forecast.
    coefficients : Coefficients, optional
        Default: those of the package.
    """

    def __init__(
        self, state: State, seed: int, member: int | None = None, coefficients: Coefficients | None = None
    ) -> None:
        self.state = state
        seeds = None if member is None else np.random.SeedSequence([seed, member]).generate_state(1)[0]
        self._forecast = Forecast(state, None if seeds is None else int(seeds), coefficients)
        self._velocity = state.flow_m_s / np.float32(state.pixel_size_m)
        self._seed = seed
        self._blended: BlendedExample | None = None
        self._last: tuple[float, Field] | None = None

    @cached_property
    def example(self) -> Example:
        """What the sky is blended from beyond the edge."""
        return example_of(self.state)

    def at(self, lead_s: float, y: Array, x: Array) -> Field:
        """Return brightness temperature in K and excess in m, (N, M, 2), at positions (N,), (M,).

        Parameters
        ----------
        lead_s : float
            Time after the latest image.
        y, x : ndarray of float64
            In pixels of the image from its middle, northward and eastward.
        """
        rows, columns = self.state.shape
        from_y, from_x = departures(self._velocity, lead_s, y + (0.5 * rows - 0.5), x + (0.5 * columns - 0.5))
        out = np.empty((*from_y.shape, 2), np.float32)
        if not out.size:
            return out
        low = [math.floor(float(of.min())) - _REACH for of in (from_y, from_x)]
        high = [math.floor(float(of.max())) + _REACH + 2 for of in (from_y, from_x)]
        for field, image in enumerate(self._around(lead_s, low, high)):
            part = np.empty(from_y.shape, np.float32)
            interpolate(part, image, from_y, from_x, *low)
            out[..., field] = part
        np.maximum(out[..., 1], np.float32(0.0), out=out[..., 1])
        return out

    def _around(self, lead_s: float, low: list[int], high: list[int]) -> tuple[Field, Field]:
        """Return the fields at pixels of time 0 from ``low`` to ``high``, which may be beyond the edge."""
        last = self._last
        if last is None or last[0] != lead_s:
            last = self._last = lead_s, self._forecast.kelvin(lead_s)
        sides = self.state.shape
        places = [np.arange(first, end, dtype=np.intp) for first, end in zip(low, high, strict=True)]
        mirrored = [_mirrored(place, side) for place, side in zip(places, sides, strict=True)]
        fields = [image[np.ix_(*mirrored)] for image in (last[1], self.state.excess_m)]
        beyond = [
            np.maximum(np.maximum(-place, place - side + 1), 0) for place, side in zip(places, sides, strict=True)
        ]
        far = np.minimum(np.maximum(beyond[0][:, None], beyond[1][None, :]) / _FADE, 1.0).astype(np.float32)
        if far.any():
            y, x = (place.astype(np.float64) - 0.5 * (side - 1) for place, side in zip(places, sides, strict=True))
            blended = self._beyond(lead_s, y, x)
            part = far * far * (np.float32(3.0) - np.float32(2.0) * far)
            fields = [own + part * (other - own) for own, other in zip(fields, blended, strict=True)]
        return np.ascontiguousarray(fields[0]), np.ascontiguousarray(fields[1])

    def _beyond(self, lead_s: float, y: Array, x: Array) -> list[Field]:
        """Return the two fields of the blended sky."""
        if self._blended is None:
            self._blended = BlendedExample(self.example, self.example.pixel_size_m, self._seed)
        heights = self._blended.level.heights_m
        warm = float(np.percentile(self.state.kelvin.astype(np.float64), _WARM_PERCENTILE))
        tables = np.stack([warm - LAPSE_K_M * heights[:, 0], heights[:, 1]], axis=1).astype(np.float32)
        out = np.empty((y.size, x.size, 2), np.float32)
        self._blended.blend(lead_s, out, y.astype(np.float64), x.astype(np.float64), tables, 1.0)
        return [out[..., 0], out[..., 1]]


def _mirrored(place: NDArray[np.intp], side: int) -> NDArray[np.intp]:
    """Return pixels inside an image for places beyond its edge."""
    folded = np.mod(place, 2 * side)
    inside: NDArray[np.intp] = np.where(folded < side, folded, 2 * side - 1 - folded)
    return inside
