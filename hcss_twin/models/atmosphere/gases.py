"""Amounts of gases: annual means, and profiles scaled to given amounts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.moist_air import column_m2
from hcss_twin.physics.profile import Profile

DOBSON_M2 = 2.6867e20
"""Molecules m-2 of one Dobson unit."""

MOLE_FRACTIONS = MappingProxyType({"ppm": 1e-6, "ppb": 1e-9})

LARGEST_FACTOR = 100.0
"""Largest factor on an amount in the profile, as for amounts that are given as a factor."""

MEANS: Mapping[int, tuple[float, float, float]] = MappingProxyType(
    {
        1980: (338.91, 1600.0, 301.0),
        1985: (345.54, 1657.3, 304.0),
        1990: (354.06, 1714.4, 308.5),
        1995: (360.18, 1748.9, 311.5),
        2000: (368.96, 1773.2, 315.6),
        2005: (378.98, 1774.2, 318.9),
        2010: (388.75, 1798.9, 323.2),
        2015: (399.65, 1834.2, 328.2),
        2020: (412.44, 1878.7, 333.0),
        2025: (425.64, 1935.9, 338.9),
    }
)
"""Global means of CO2 (ppm), CH4 and N2O (ppb) in marine surface air by year.

X. Lan, K. W. Thoning, E. J. Dlugokencky: *Trends in globally-averaged CO2, CH4, N2O and SF6*, NOAA Global Monitoring
Laboratory, doi:10.15138/P8XG-AA10; CH4 of 1980 and N2O before 2001, which that record lacks, to about 1 %.
"""


def means_of_year(year: int) -> dict[str, float]:
    """Return the mole fractions of CO2, CH4 and N2O in a year, linear between those of ``MEANS``, constant beyond."""
    known = sorted(MEANS)
    columns = zip(*(MEANS[gas] for gas in known), strict=True)
    return {
        gas: float(np.interp(year, known, values)) * unit
        for gas, unit, values in zip(("co2", "ch4", "n2o"), (1e-6, 1e-9, 1e-9), columns, strict=True)
    }


def factor_of(profile: Profile, gas: str, amount: float | str) -> float:
    """Return the factor that brings a gas of a profile to an amount.

    Parameters
    ----------
    profile : Profile
    gas : str
    amount : float or str
        A factor; or ``"420 ppm"`` or ``"1900 ppb"`` at the surface, or ``"300 DU"``, the column.

    Raises
    ------
    CatalogError
        If the profile lacks the gas, or has less than a hundredth of the amount.
    """
    if not isinstance(amount, str):
        return amount
    ratio = profile.mixing_ratio.get(gas)
    if ratio is None or ratio[0] <= 0.0:
        raise CatalogError(f"profile '{profile.name}' has no {gas.upper()} that could be scaled to {amount}")
    number, unit = amount.split()
    has = float(ratio[0]) / MOLE_FRACTIONS[unit] if unit in MOLE_FRACTIONS else column_m2(profile, gas) / DOBSON_M2
    factor = float(number) / has
    if factor > LARGEST_FACTOR:
        raise CatalogError(
            f"{amount} is {factor:.3g} times the amount in profile '{profile.name}'; allowed: above 0 to "
            f"{LARGEST_FACTOR * has:.4g} {unit}, {LARGEST_FACTOR:g} times that amount"
        )
    return factor


def with_factors(profile: Profile, factors: Mapping[str, float]) -> Profile:
    """Return a profile with gases multiplied at all levels."""
    scaled = {gas: ratio * factors.get(gas, 1.0) for gas, ratio in profile.mixing_ratio.items()}
    return replace(profile, mixing_ratio=scaled)


def amount_note(profile: Profile, gases: Iterable[str]) -> str:
    """Return a note for the user with the amounts of gases in a profile."""
    ozone = {"o3": f"{column_m2(profile, 'o3') / DOBSON_M2:.4g} DU"} if "o3" in profile.mixing_ratio else {}
    surface = {gas: f"{1e6 * float(ratio[0]):.4g} ppm" for gas, ratio in profile.mixing_ratio.items()} | ozone
    return f"profile '{profile.name}': {', '.join(f'{gas.upper()} {surface[gas]}' for gas in gases)}, as given"
