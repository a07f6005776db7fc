"""Vertical profile of the atmosphere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.paths import Leg, Path

EARTH_RADIUS_M = 6_371_230.0
"""Earth radius of LOWTRAN7 for mid-latitude and US standard atmospheres, so that paths agree with its own."""

GASES = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")
"""Names of the gases of a profile."""


@dataclass(frozen=True)
class Profile:
    """Pressure, temperature and gases at levels, surface to top.

    Attributes
    ----------
    name : str
        Catalog name or file.
    altitude_m : ndarray (L + 1,)
        Level altitudes, ascending from 0.
    pressure_Pa, temperature_K : ndarray (L + 1,)
        At the levels.
    mixing_ratio : mapping of str to ndarray (L + 1,)
        Mole fraction of each gas (mole per mole of moist air) at the levels, under the names of ``GASES``: h2o, co2,
        o3, n2o, co, ch4, o2. A gas may be missing.
    notes : tuple of str
        Notes for the user on computed, filled or scaled values; copied into plan and cube.
    model_gases : frozenset of str
        Gases that are those of a model atmosphere, not of the user's file.
    """

    name: str
    altitude_m: Array
    pressure_Pa: Array
    temperature_K: Array
    mixing_ratio: Mapping[str, Array] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    model_gases: frozenset[str] = frozenset()

    @classmethod
    def mixed(cls, profiles: Sequence[Profile], weights: Sequence[float] | Array) -> Profile:
        """Return the weighted mean of profiles at the levels of the first, with its name and notes.

        Temperatures are averaged, and the logarithms of pressures and of the amounts of gases.
        """
        first, shares = profiles[0], np.asarray(weights, dtype=np.float64)
        parts = [profile.resampled(first.altitude_m) for profile in profiles]
        return replace(
            first,
            temperature_K=np.tensordot(shares, [part.temperature_K for part in parts], 1),
            pressure_Pa=np.exp(np.tensordot(shares, np.log([part.pressure_Pa for part in parts]), 1)),
            mixing_ratio={
                gas: np.exp(np.tensordot(shares, np.log([part.mixing_ratio[gas] for part in parts]), 1))
                for gas in first.mixing_ratio
            },
        )

    def temperature_at(self, altitude_m: Array | float) -> Array:
        """Temperature in kelvin at altitudes, linear between levels.

        Raises
        ------
        ValueError
            If an altitude lies outside the profile.
        """
        altitude = np.asarray(altitude_m, dtype=np.float64)
        low, high = self.altitude_m[0], self.altitude_m[-1]
        if np.any(altitude < low) or np.any(altitude > high):
            raise ValueError(f"altitude {altitude.min():g}..{altitude.max():g} m: allowed {low:g}..{high:g} m")
        result: Array = np.interp(altitude, self.altitude_m, self.temperature_K)
        return result

    def pressure_at(self, altitude_m: Array | float) -> Array:
        """Pressure in pascal at altitudes, log-linear between levels, 0 in space."""
        altitude = np.asarray(altitude_m, dtype=np.float64)
        inside = np.minimum(altitude, self.altitude_m[-1])
        pressure = np.exp(np.interp(inside, self.altitude_m, np.log(self.pressure_Pa)))
        result: Array = np.where(altitude > self.altitude_m[-1], 0.0, pressure)
        return result

    def resampled(self, altitude_m: Array) -> Profile:
        """Return the profile at other levels (K,) within it; the logarithm of gas amounts is linear in altitude."""
        gases = {
            gas: np.exp(np.interp(altitude_m, self.altitude_m, np.log(ratio)))
            if np.all(ratio > 0.0)
            else np.interp(altitude_m, self.altitude_m, ratio)
            for gas, ratio in self.mixing_ratio.items()
        }
        return replace(
            self,
            altitude_m=altitude_m,
            pressure_Pa=self.pressure_at(altitude_m),
            temperature_K=self.temperature_at(altitude_m),
            mixing_ratio=gases,
        )

    def airmass(self, path: Path) -> Array:
        """Slant length over vertical thickness of each layer, summed over the legs of a path.

        A partly crossed layer contributes in proportion (by pressure). Straight rays in spherical shells; the
        local zenith angle follows from sin(theta) (R + z) = sin(theta_surface) R.

        Returns
        -------
        ndarray (L,)
        """
        return np.asarray(np.sum(airmass_of_legs(self, path.legs), axis=0))

    def mean_airmass(self, lower_m: float, zenith_deg: Array) -> Array:
        """Air mass of slant paths to space relative to the vertical, weighted by pressure.

        Parameters
        ----------
        lower_m : float
            Altitude at which the paths begin.
        zenith_deg : ndarray (Z,)
            Zenith angles at the surface point.

        Returns
        -------
        ndarray (Z,)
        """
        lower = np.maximum(self.altitude_m[:-1], lower_m)
        upper = np.maximum(self.altitude_m[1:], lower_m)
        inside = upper > lower
        lower, upper = lower[inside], upper[inside]
        mass = self.pressure_at(lower) - self.pressure_at(upper)
        slant = slant_length_m(lower, upper, zenith_deg[:, None])
        result: Array = (slant / (upper - lower)) @ mass / np.sum(mass)
        return result


def airmass_of_legs(profile: Profile, legs: Sequence[Leg]) -> Array:
    """Slant length over vertical thickness of each layer, as :meth:`Profile.airmass`, for each of some legs.

    Returns
    -------
    ndarray (N, L)
    """
    ends = np.array([(leg.lower_m, leg.upper_m, leg.zenith_deg) for leg in legs]).reshape(-1, 3)
    lower_m, upper_m, zenith_deg = ends.T[:, :, None]
    lower = np.clip(profile.altitude_m[:-1], lower_m, upper_m)
    upper = np.clip(profile.altitude_m[1:], lower_m, upper_m)
    thickness = upper - lower
    crossed = thickness > 0
    full = profile.pressure_Pa[:-1] - profile.pressure_Pa[1:]
    share = (profile.pressure_at(lower) - profile.pressure_at(upper)) / full
    slant = slant_length_m(lower, upper, zenith_deg)
    result: Array = np.where(crossed, share * slant / np.where(crossed, thickness, 1.0), 0.0)
    return result


def slant_length_m(lower_m: Array, upper_m: Array, zenith_deg: Array | float) -> Array:
    """Length of a straight ray between two altitudes.

    Parameters
    ----------
    lower_m, upper_m : ndarray
        Altitudes of the ends.
    zenith_deg : float or ndarray
        Zenith angle at the surface point, below 90; broadcast against the altitudes.
    """
    impact = EARTH_RADIUS_M * np.sin(np.radians(zenith_deg))
    lower_radius = EARTH_RADIUS_M + lower_m
    upper_radius = EARTH_RADIUS_M + upper_m
    upper_part = np.sqrt((upper_radius - impact) * (upper_radius + impact))
    lower_part = np.sqrt((lower_radius - impact) * (lower_radius + impact))
    result: Array = upper_part - lower_part
    return result


def local_zenith_deg(surface_zenith_deg: float, altitude_m: float) -> float:
    """Zenith angle at an altitude of a straight ray with a given zenith angle at the surface."""
    sine = np.sin(np.radians(surface_zenith_deg)) * EARTH_RADIUS_M / (EARTH_RADIUS_M + altitude_m)
    return float(np.degrees(np.arcsin(sine)))
