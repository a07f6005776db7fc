"""Air with smoke in it: the model that the effect of smoke puts in the place of a scene's air."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from hcss_twin.providers import Array, ColumnSetting, Leg, Path, planck, to_space


class SmokyAir:
    """The air of a setting with an absorber whose optical depth falls as the inverse of the wavelength."""

    def __init__(self, setting: ColumnSetting, scale_height_m: float, optical_depth: float) -> None:
        self._air: Any = setting.transmittance
        self._profile, self.declares = setting.profile, setting.transmittance.declares
        above = np.exp(-setting.profile.altitude_m / scale_height_m)
        self._depth = optical_depth * -np.diff(above) / (above[0] - above[-1])
        self._along = functools.lru_cache(20_000)(self._new)  # paths share legs
        for name in ("solar_path_radiance", "thread_safe"):  # what the air may also have
            if hasattr(self._air, name):
                setattr(self, name, getattr(self._air, name))
        self._highest_m = self.declares.valid.get("target_altitude_m", (0.0, np.inf))[1]
        if self._highest_m < self._profile.altitude_m[-1] and hasattr(self._air, "path_radiance"):
            self.path_radiance = self._added_to_the_air

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return the transmittance (P, V) of paths."""
        smoke = np.array([sum(self._along(leg) for leg in path.legs) for path in paths])
        through = self._air.transmittance(wavenumber_cm1, paths)
        return np.asarray(through * np.exp(-smoke[:, None] * wavenumber_cm1 / 1e4))

    def _new(self, leg: Leg) -> float:
        """Return the optical depth of a leg at 1 um."""
        return float(self._profile.airmass(Path((leg,))) @ self._depth)

    def _added_to_the_air(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return the emission of air that knows its own, and no paths from high levels, where there is no smoke.

        Its sum over the levels below changes by the smoke.
        """
        radiance = np.array(self._air.path_radiance(wavenumber_cm1, paths))
        for row, leg in enumerate(path.legs[0] for path in paths):
            above = self._profile.altitude_m
            levels = np.append(leg.lower_m, above[(above > leg.lower_m) & (above <= self._highest_m)])
            ways = [to_space(level, leg.zenith_deg) for level in levels.tolist()]
            kelvin = self._profile.temperature_at(levels)
            source = planck(wavenumber_cm1[None, :], 0.5 * (kelvin[1:] + kelvin[:-1])[:, None])
            smoky, clear = (air.transmittance(wavenumber_cm1, ways) for air in (self, self._air))
            radiance[row] += np.sum(source * np.diff(smoky - clear, axis=0), axis=0)
        return radiance
