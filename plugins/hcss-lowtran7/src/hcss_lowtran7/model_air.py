"""Choice of the LOWTRAN7 model atmosphere for the scenario's profile."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_lowtran7.build import Program
from hcss_lowtran7.deck import TO_SPACE, Air, Haze, Ray, deck
from hcss_lowtran7.levels import GASES, levels_of
from hcss_lowtran7.program import AIR, Job, run
from hcss_twin.providers import Profile

Array = NDArray[np.float64]

BUILT_IN = {
    "tropical": 1,
    "midlatitude-summer": 2,
    "midlatitude-winter": 3,
    "subarctic-summer": 4,
    "subarctic-winter": 5,
    "us-standard-1976": 6,
}
"""Catalog names of the AFGL profiles (AFGL-TR-86-0110) and their MODEL on card 1."""

USER_DEFINED = 7

# The catalog and LOWTRAN7 print the same tables with three or four digits.
_TEMPERATURE_TOLERANCE_K = 0.6
_RELATIVE_TOLERANCE = 0.02
_COMPARED_UP_TO_KM = 50.0

# Columns of the driver's list of a model atmosphere after altitude, pressure and temperature.
_LISTED_GASES = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")
# g m-3 of water vapour per ppmv in air of 1013.25 mb and 273.15 K, as in WATVAP.
_WATER_G_M3 = 2.989e-23 * 2.6868e19


def model_air(program: Program, profile: Profile, haze: Haze) -> Air:
    """Return the built-in atmosphere if the profile has its name and values, otherwise the levels of the profile."""
    model = BUILT_IN.get(profile.name)
    if model is not None and agrees(profile, built_in(program, model)):
        return Air(model, None, haze)
    return Air(USER_DEFINED, levels_of(profile), haze)


def built_in(program: Program, model: int) -> Profile:
    """Return one of LOWTRAN7's built-in atmospheres."""
    ray = Ray(TO_SPACE, 0.0, 0.0, 0.0)
    numbers = run(program, [Job(AIR, (deck(Air(model), ray),))], 5000.0, 5100.0).numbers
    columns = numbers.reshape(-1, 3 + len(_LISTED_GASES)).T
    density = columns[1] / 1013.25 * 273.15 / columns[2]
    ratios = dict(zip(_LISTED_GASES, columns[3:], strict=True))
    ratios["h2o"] = ratios["h2o"] / (_WATER_G_M3 * density)
    return Profile(
        name=next(name for name, number in BUILT_IN.items() if number == model),
        altitude_m=1000.0 * columns[0],
        pressure_Pa=100.0 * columns[1],
        temperature_K=columns[2],
        mixing_ratio={gas: 1e-6 * ratio for gas, ratio in ratios.items()},
    )


def agrees(profile: Profile, other: Profile) -> bool:
    """Whether a profile has the values of another at the other's levels up to 50 km; gases it lacks count not."""
    top_m = 1000.0 * _COMPARED_UP_TO_KM
    low = other.altitude_m <= top_m
    where = other.altitude_m[low]
    if profile.altitude_m[-1] < where[-1]:
        return False
    warmer = np.abs(profile.temperature_at(where) - other.temperature_K[low])
    pairs = [(profile.pressure_at(where), other.pressure_Pa[low])]
    for gas in GASES:
        if gas in profile.mixing_ratio and gas in other.mixing_ratio:
            ratio = np.interp(where, profile.altitude_m, profile.mixing_ratio[gas])
            pairs.append((ratio, other.mixing_ratio[gas][low]))
    same = [np.allclose(one, another, rtol=_RELATIVE_TOLERANCE, atol=0.0) for one, another in pairs]
    return bool(np.all(warmer <= _TEMPERATURE_TOLERANCE_K)) and all(same)
