"""Absorber densities at profile levels, scaled for the band model (subroutine STDMDL of LOWTRAN7)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.band_model.absorption import BandModelCoefficients
from hcss_twin.models.atmosphere.band_model.aerosol import haze_m1
from hcss_twin.models.parameters import DEFAULT_VISIBILITY_KM, BandModelParameters
from hcss_twin.physics.profile import Profile

STANDARD_PRESSURE_PA = 101_325.0
ZERO_CELSIUS_K = 273.15
LOSCHMIDT_CM3 = 2.6868e19
"""Loschmidt's number as in LOWTRAN7."""

_ATM_CM_PER_KM = 3.7194e-21 * 1e6 * LOSCHMIDT_CM3
"""Thickness in atm cm of 1 km of a pure gas at standard conditions: 1e5, with the rounding of LOWTRAN7."""

_NITRIC_ATM_CM_PER_KM = 1e5

_WATER_G_M3_PER_MOLECULE_CM3 = 2.989e-23 * 1e6
_WATER_MOLECULES_CM2_KM = 3.3429e21
"""Molecules cm-2 per km and g m-3 of water vapour."""

AEROSOL_COLUMNS = 5
COLD_SELF_COLUMN, OXYGEN_COLUMN, OXYGEN_LINEAR_COLUMN = -13, -8, -7
"""Density columns that depend on the mean layer temperature or on another column."""

_NITROGEN_SHARE = 0.781
_CONTINUUM_TEMPERATURE_K = 296.0
OXYGEN_TEMPERATURE_K = 220.0
_WATER_GAS_CONSTANT_MB = 4.6152e-3
"""mb K-1 per g m-3."""

_DISPERSION_CM1 = 7392.5
"""Wavenumber of the refractive index: the middle of the native grid."""


@dataclass(frozen=True)
class LevelState:
    """State of the air at the profile levels.

    Attributes
    ----------
    altitude_m, pressure_Pa, temperature_K, refractivity : ndarray (L,)
    density : ndarray (L, K)
        Per kilometre of path: channels of the band model; the ten continua of the coefficients (H2O self twice, O2
        also times T and times (T - 220 K)^2); aerosol extinction at 0.55 um of four regions; boundary-layer
        extinction times ln(100 - relative humidity).
    """

    altitude_m: Array
    pressure_Pa: Array
    temperature_K: Array
    refractivity: Array
    density: Array

    @cached_property
    def thickness_m(self) -> Array:
        """Of the layers between the levels, (L - 1,)."""
        result: Array = np.diff(self.altitude_m)
        return result

    @cached_property
    def fall(self) -> Array:
        """Logarithms of refractivity below over that above, (L - 1,)."""
        result: Array = np.log(self.refractivity[:-1] / self.refractivity[1:])
        return result


def mixing_ratio(gas: str, profile: Profile, coefficients: BandModelCoefficients) -> Array:
    """Return the volume mixing ratio at the profile levels, by default that of the 1976 US Standard.

    Raises
    ------
    ProviderError
        If the profile has no water vapour.
    """
    if gas in profile.mixing_ratio:
        return profile.mixing_ratio[gas]
    if gas == "h2o":
        raise ProviderError(
            f"band model: profile '{profile.name}' has no column h2o (volume mixing ratio); water vapour is "
            "needed, every other gas falls back to the 1976 US Standard"
        )
    result: Array = np.interp(
        profile.altitude_m, coefficients.default_altitude_m, coefficients.default_mixing_ratio[gas]
    )
    return result


def level_state(profile: Profile, coefficients: BandModelCoefficients, parameters: BandModelParameters) -> LevelState:
    """Return the densities of all absorbers at the profile levels."""
    pressure = profile.pressure_Pa / STANDARD_PRESSURE_PA
    cold = ZERO_CELSIUS_K / profile.temperature_K

    def ratio(gas: str) -> Array:
        return mixing_ratio(gas, profile, coefficients)

    def atm_cm(gas: str) -> Array:
        result: Array = ratio(gas) * pressure * cold * _ATM_CM_PER_KM
        return result

    water_g_m3 = _water_g_m3(profile, coefficients)
    scaling = pressure[:, None] ** coefficients.pressure_exponent * cold[:, None] ** coefficients.temperature_exponent
    gases = {gas: atm_cm(gas) for gas in set(coefficients.channel_gas) - {"h2o"}}
    gases["h2o"] = 0.1 * water_g_m3  # g cm-2 km-1
    channels = np.stack([gases[gas] for gas in coefficients.channel_gas], axis=1) * scaling

    air = pressure * cold
    water = _WATER_MOLECULES_CM2_KM * water_g_m3 / (LOSCHMIDT_CM3 * 1e5)
    water_unit = LOSCHMIDT_CM3 * 1e5 / (ZERO_CELSIUS_K / _CONTINUUM_TEMPERATURE_K) * 1e-20
    oxygen = gases["o2"] * pressure
    warm = profile.temperature_K - OXYGEN_TEMPERATURE_K
    continua = np.stack(
        (
            _NITROGEN_SHARE * air * pressure * np.sqrt(cold),
            water_unit * water**2,
            water_unit * water**2,
            water_unit * water * (air - water),
            air,
            gases["o3"],
            ratio("hno3") * air * _NITRIC_ATM_CM_PER_KM,
            oxygen,
            oxygen * profile.temperature_K,
            oxygen * warm**2,
        ),
        axis=1,
    )
    aerosol = _aerosol(profile, coefficients, parameters, relative_humidity(water_g_m3, profile.temperature_K))
    return LevelState(
        profile.altitude_m,
        profile.pressure_Pa,
        profile.temperature_K,
        _refractivity(profile, water_g_m3),
        np.concatenate((channels, continua, aerosol), axis=1),
    )


def _water_g_m3(profile: Profile, coefficients: BandModelCoefficients) -> Array:
    molecules_cm3 = (
        LOSCHMIDT_CM3 * (profile.pressure_Pa / STANDARD_PRESSURE_PA) * (ZERO_CELSIUS_K / profile.temperature_K)
    )
    result: Array = _WATER_G_M3_PER_MOLECULE_CM3 * mixing_ratio("h2o", profile, coefficients) * molecules_cm3
    return result


def surface_humidity_percent(profile: Profile, coefficients: BandModelCoefficients) -> float:
    """Return the relative humidity at the lowest level, in percent."""
    return float(relative_humidity(_water_g_m3(profile, coefficients), profile.temperature_K)[0])


def relative_humidity(water_g_m3: Array, temperature_K: Array) -> Array:
    """Relative humidity over water in percent, at most 100, with LOWTRAN7's saturation density."""
    cold = ZERO_CELSIUS_K / temperature_K
    saturation_g_m3 = np.exp(18.9766 - 14.9595 * cold - 2.43882 * cold**2) * cold
    result: Array = np.minimum(100.0 * water_g_m3 / saturation_g_m3, 100.0)
    return result


def _aerosol(
    profile: Profile, coefficients: BandModelCoefficients, parameters: BandModelParameters, humidity_percent: Array
) -> Array:
    """Aerosol columns (L, 5)."""
    if parameters.aerosol == "none":
        return np.zeros((profile.altitude_m.size, AEROSOL_COLUMNS))
    visibility_km = parameters.visibility_km or DEFAULT_VISIBILITY_KM
    haze = 1e3 * haze_m1(coefficients.aerosol, profile.altitude_m, visibility_km, parameters.season)
    ln_dryness = np.log(100.0 - np.minimum(humidity_percent, 99.0))
    return np.concatenate((haze, haze[:, :1] * ln_dryness[:, None]), axis=1)


def _refractivity(profile: Profile, water_g_m3: Array) -> Array:
    """Refractive index minus one: B. Edlen, Metrologia 2, 71 (1966), as in LOWTRAN7."""
    dry = 83.42 + 185.08 / (1.0 - (_DISPERSION_CM1 / 1.140e5) ** 2) + 4.11 / (1.0 - (_DISPERSION_CM1 / 6.24e4) ** 2)
    moist = 43.49 - (_DISPERSION_CM1 / 1.70e4) ** 2
    water_mb = _WATER_GAS_CONSTANT_MB * water_g_m3 * profile.temperature_K
    density = (profile.pressure_Pa / STANDARD_PRESSURE_PA) * (ZERO_CELSIUS_K + 15.0) / profile.temperature_K
    result: Array = 1e-6 * (dry * density - moist * water_mb / (STANDARD_PRESSURE_PA * 1e-2))
    return result
