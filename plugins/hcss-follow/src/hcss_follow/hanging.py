"""Clouds with given brightness temperatures in a scene: thickness and top by temperature and excess of the top.

An opaque cloud has the lowest top with its temperature; a cloud whose top is higher is as thin as that temperature
needs. The temperature K of a cloud with top z and depth d lies between those of the clear sky and of an opaque cloud,

    v = -ln(1 - (clear - K) / (clear - opaque(z))),

which is about its optical thickness: d is nearly proportional to v, and changes slowly with z. So does opaque(z) less
the temperature of the air. Both are interpolated between altitudes that are added where they are needed.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from hcss_follow.state import Field
from hcss_twin.core.cache import kept_result
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array, BrightnessInversion, Catalog, CloudLayer

LOWEST_M, HIGHEST_M = 100.0, 18_500.0
"""Altitudes of tops; the highest is that of the coldest air between them."""

ERROR_K = 0.08
"""Largest error halfway between two altitudes, before the one there is added: about a quarter of it is left."""

_FIRST_M = LOWEST_M, 1500.0, 4000.0, 9000.0
_MOST_ALTITUDES = 40

_STEP_M = 25.0
"""Between altitudes of the tables."""

_LARGEST_V, _STEP_V = 12.0, 1.0 / 16.0
"""Of v: beyond, clouds are as cold as opaque ones within 1e-3 K."""


@dataclass(frozen=True)
class HangingClouds:
    """Tables of the clouds of a scene.

    Attributes
    ----------
    clear_K : float
    altitude_m : ndarray (Z,)
        Of tops, evenly spaced.
    opaque_K : ndarray (Z,)
        Brightness temperature of an opaque cloud.
    thickness_m : ndarray of float32 (Z, V)
        By top and v, evenly spaced from 0.
    """

    clear_K: float
    altitude_m: Array
    opaque_K: Array
    thickness_m: Field

    @property
    def visible_m(self) -> float:
        """Thickness of about 1 optical thickness."""
        return float(self.thickness_m[self.altitude_m.size // 2, round(1.0 / _STEP_V)])

    def tops_m(self, kelvin: Array) -> Array:
        """Return the lowest tops with brightness temperatures, any shape."""
        tops: Array = np.interp(-kelvin, -np.minimum.accumulate(self.opaque_K), self.altitude_m)
        return tops

    def up_to(self, top_m: float) -> HangingClouds:
        """Return the tables of tops no higher than one."""
        count = max(int(np.searchsorted(self.altitude_m, top_m)) + 1, 2)
        return HangingClouds(self.clear_K, self.altitude_m[:count], self.opaque_K[:count], self.thickness_m[:count])

    def look_up(self, pairs: Field, layer: CloudLayer) -> None:
        """Replace brightness temperature in K and excess in m (rows, columns, 2) by thickness and top in m."""
        falling = np.minimum.accumulate(self.opaque_K - 1e-9 * np.arange(self.opaque_K.size))
        _look_up(
            pairs, self.clear_K, float(self.altitude_m[0]), _STEP_M, self.opaque_K, falling, self.thickness_m,
            1.0 / _STEP_V, np.float32(layer.thickness_max_m),
        )  # fmt: skip


def hanging_clouds(inversion: BrightnessInversion, layer: CloudLayer, catalog: Catalog) -> HangingClouds:
    """Return the clouds of a scene, from the user's cache if it has been asked before.

    Parameters
    ----------
    inversion : BrightnessInversion
        In the band of the images.
    """
    altitude_m = np.arange(LOWEST_M, HIGHEST_M + _STEP_M, _STEP_M)
    air_K = inversion.air_temperature_K(altitude_m)
    altitude_m = altitude_m[: max(int(np.argmin(air_K)), 2) + 1]
    highest_m = float(altitude_m[-1])
    thickness_m, kelvin = inversion.hanging_K(highest_m)
    # The light of the sea, of the whole air, and of clouds of all thicknesses: other scenes have others.
    seen = hashlib.sha256(b"".join(array.tobytes() for array in (thickness_m, kelvin, air_K)))
    parts = {"hanging clouds": [1, seen.hexdigest(), repr(layer)]}

    def compute() -> HangingClouds:
        return _tables(inversion, layer, altitude_m, {highest_m: (thickness_m, kelvin)})

    return kept_result(parts, catalog, compute, (HangingClouds,))


Curves = dict[float, tuple[Array, Array]]


def _tables(inversion: BrightnessInversion, layer: CloudLayer, altitude_m: Array, known: Curves) -> HangingClouds:
    """Ask for curves at more altitudes until those between are known, and return the tables."""
    first = [top_m for top_m in _FIRST_M if top_m < altitude_m[-1]]
    pending = list(pairwise([*first, float(altitude_m[-1])]))
    for top_m in first:
        known[top_m] = inversion.hanging_K(top_m)
    while pending and len(known) < _MOST_ALTITUDES:
        guesses = _Between(inversion, known)
        asked = [0.5 * (low + high) for low, high in pending]
        found = {top_m: inversion.hanging_K(top_m) for top_m in asked}
        wrong = [np.abs(guesses.kelvin(top_m, found[top_m][0]) - found[top_m][1]).max() > ERROR_K for top_m in asked]
        known |= found
        pending = [
            half
            for (low, high), middle, more in zip(pending, asked, wrong, strict=True)
            if more
            for half in ((low, middle), (middle, high))
        ]
    between = _Between(inversion, known)
    opaque_K = between.opaque_K(altitude_m)
    count = int(np.argmin(opaque_K)) + 1  # above the tropopause opaque clouds are warmer
    altitude_m, opaque_K = altitude_m[:count], opaque_K[:count]
    v = np.arange(0.0, _LARGEST_V + _STEP_V, _STEP_V)
    thickness_m = np.minimum(np.exp(between.log_thickness(altitude_m, v[1:])), layer.thickness_max_m)
    thickness_m = np.concatenate((np.zeros((count, 1)), thickness_m), axis=1).astype(np.float32)
    return HangingClouds(between.clear_K, altitude_m, opaque_K, thickness_m)


class _Between:
    """Clouds with tops between altitudes (A,) whose curves are known."""

    def __init__(self, inversion: BrightnessInversion, known: Curves) -> None:
        self._inversion = inversion
        self._altitude_m = np.array(sorted(known))
        curves = [known[top_m] for top_m in self._altitude_m.tolist()]
        self.clear_K = float(curves[0][1][0])
        opaque_K = np.array([kelvin[-1] for _, kelvin in curves])
        below_K = opaque_K - inversion.air_temperature_K(self._altitude_m)
        self._below_K = PchipInterpolator(self._altitude_m, below_K)
        logarithms = [self._of_curve(*curve) for curve in curves]
        colder = [index for index, (log_v, _) in enumerate(logarithms) if log_v.size > 1]  # than clear sky
        self._colder_m = self._altitude_m[colder]
        self._log_v = [logarithms[index] for index in colder]

    def _of_curve(self, thickness_m: Array, kelvin: Array) -> tuple[Array, Array]:
        """Return the logarithms of v and thickness of one curve, ascending, without clear sky and opaque cloud."""
        share = (self.clear_K - kelvin[1:]) / max(self.clear_K - kelvin[-1], 1e-6)
        v = -np.log1p(-np.clip(share, 0.0, 1.0 - np.exp(-_LARGEST_V)))
        rises = (v > 0.0) & (v > np.maximum.accumulate(np.concatenate(([0.0], v[:-1]))))
        return np.log(v[rises]), np.log(thickness_m[1:][rises])

    def opaque_K(self, altitude_m: Array) -> Array:
        """Return the brightness temperature of opaque clouds."""
        kelvin: Array = self._inversion.air_temperature_K(altitude_m) + self._below_K(altitude_m)
        return kelvin

    def log_thickness(self, altitude_m: Array, v: Array) -> Array:
        """Return the logarithm of the thickness (N, V); beyond the opaque cloud proportional to v."""
        at_nodes = np.array([_extended(np.log(v), *curve) for curve in self._log_v])
        position = np.clip(np.searchsorted(self._colder_m, altitude_m) - 1, 0, self._colder_m.size - 2)
        low, high = self._colder_m[position], self._colder_m[position + 1]
        share = np.clip((altitude_m - low) / (high - low), 0.0, 1.0)[:, None]
        log: Array = (1.0 - share) * at_nodes[position] + share * at_nodes[position + 1]
        return log

    def kelvin(self, top_m: float, thickness_m: Array) -> Array:
        """Return the brightness temperature of clouds (N,), the first of which is clear sky."""
        v = np.geomspace(1e-5, _LARGEST_V, 400)
        at_v = np.exp(self.log_thickness(np.array([top_m]), v)[0])
        opaque_K = float(self.opaque_K(np.array([top_m]))[0])
        share = -np.expm1(-np.interp(thickness_m, np.concatenate(([0.0], at_v)), np.concatenate(([0.0], v))))
        share[-1] = 1.0
        kelvin: Array = self.clear_K + share * (opaque_K - self.clear_K)
        return kelvin


def _extended(log_v: Array, known_v: Array, known: Array) -> Array:
    """Return the logarithm of the thickness at v, beyond what is known proportional to v."""
    inside = PchipInterpolator(known_v, known)(np.clip(log_v, known_v[0], known_v[-1]))
    extended: Array = inside + np.minimum(log_v - known_v[0], 0.0) + np.maximum(log_v - known_v[-1], 0.0)
    return extended


@kernel()
def _look_up(
    pairs: Any, clear: float, lowest: float, step: float, opaque: Any, falling: Any, thickness: Any, per_v: float,
    thickest: Any,
) -> None:  # fmt: skip
    last, most = opaque.size - 1, thickness.shape[1] - 1
    for i in range(pairs.shape[0]):
        for j in range(pairs.shape[1]):
            kelvin = float(pairs[i, j, 0])
            low, high = 0, last  # the lowest altitude at which an opaque cloud is as cold
            while low < high:
                middle = (low + high) // 2
                if falling[middle] > kelvin:
                    low = middle + 1
                else:
                    high = middle
            at = float(low)
            if falling[low] > kelvin:
                at = float(last)
            elif low > 0:
                at = low - (kelvin - falling[low]) / (falling[low - 1] - falling[low])
            at = min(at + max(float(pairs[i, j, 1]), 0.0) / step, float(last))
            z = min(int(at), last - 1)
            up = at - z
            cold = opaque[z] + up * (opaque[z + 1] - opaque[z])
            top = np.float32(lowest + step * at)
            left = (kelvin - cold) / max(clear - cold, 1e-6)
            deep = thickest
            if kelvin >= clear:
                deep = np.float32(0.0)
            elif left > 0.0:
                v = -np.log(left) * per_v
                if v < most:
                    n = int(v)
                    part = v - n
                    one = thickness[z, n] + part * (thickness[z, n + 1] - thickness[z, n])
                    other = thickness[z + 1, n] + part * (thickness[z + 1, n + 1] - thickness[z + 1, n])
                    deep = np.float32(one + up * (other - one))
            pairs[i, j, 0] = min(deep, min(top, thickest))
            pairs[i, j, 1] = top
