"""Decks of cards, LOWTRAN7's input file TAPE5 (AFGL-TR-88-0177, section 3; comments of LWTRN7)."""

from __future__ import annotations

from dataclasses import dataclass

from hcss_lowtran7.levels import Levels
from hcss_twin.providers import EARTH_RADIUS_M

SLANT, TO_SPACE = 2, 3
"""ITYPE: a slant path between two altitudes, and one that leaves the atmosphere."""
TRANSMITTANCE, RADIANCE, SOLAR_RADIANCE, SOLAR_IRRADIANCE = 0, 1, 2, 3
"""IEMSCT: what LOWTRAN7 computes."""

# LOWTRAN7 takes the refractive index at the middle of the wavenumbers on card 4. Absorber amounts
# are asked for at these, whatever the spectrum, so that no result depends on what else is asked.
REFRACTION_CM1 = (5245.0, 5255.0)


@dataclass(frozen=True)
class Haze:
    """Aerosol: IHAZE, ISEASN (0: LOWTRAN7's choice) and visibility in km (0: LOWTRAN7's choice)."""

    ihaze: int = 0
    iseasn: int = 0
    visibility_km: float = 0.0


@dataclass(frozen=True)
class Air:
    """Model atmosphere (1 to 6 built in, 7 with user-defined levels) and aerosol."""

    model: int
    levels: Levels | None = None
    haze: Haze = Haze()


@dataclass(frozen=True)
class Ray:
    """Path from ``h1_km`` at zenith angle ``angle_deg`` (there) to ``h2_km`` or, with ITYPE 3, to space."""

    itype: int
    h1_km: float
    h2_km: float
    angle_deg: float


@dataclass(frozen=True)
class SunGeometry:
    """Sun as seen from ``h1_km`` of the ray: azimuth relative to the line of sight, zenith, day of the year."""

    relative_azimuth_deg: float
    zenith_deg: float
    day_of_year: int


def deck(
    air: Air,
    ray: Ray,
    iemsct: int = TRANSMITTANCE,
    wavenumbers_cm1: tuple[float, float] = REFRACTION_CM1,
    sun: SunGeometry | None = None,
    listing: bool = False,
) -> str:
    """Return the cards of one run: no clouds, no rain, no multiple scattering, a black ground.

    Parameters
    ----------
    air, ray
        Atmosphere and path.
    iemsct : int
        0 transmittance, 1 radiance, 2 radiance with single scattering of the sun, 3 solar irradiance.
    wavenumbers_cm1 : (float, float)
        First and last, multiples of 5.
    sun : SunGeometry, optional
        For ``iemsct`` 2; of 3 only the day is used.
    listing : bool
        Whether profiles, path and spectra are listed (NOPRT), for readers of TAPE6 to TAPE8; takes 15 ms.

    Raises
    ------
    ValueError
        If ``iemsct`` needs a sun and none is given.
    """
    if iemsct in (SOLAR_RADIANCE, SOLAR_IRRADIANCE) and sun is None:
        raise ValueError(f"iemsct {iemsct}: needs sun")
    has_levels = air.levels is not None
    cards = [
        _integers(air.model, ray.itype, iemsct, 0, 0, 0, 0, 0, 0, 0, 0, int(has_levels), int(not listing))
        + f"{0.0:8.3f}{0.0:7.2f}",
        _integers(air.haze.ihaze, air.haze.iseasn, 0, 0, 0, 0) + _reals(air.haze.visibility_km, 0, 0, 0, 0),
    ]
    if air.levels is not None:
        cards += _level_cards(air.levels)
    radius_km = EARTH_RADIUS_M / 1000.0
    ends = _reals(ray.h1_km, ray.h2_km, ray.angle_deg)
    if iemsct == SOLAR_IRRADIANCE and sun is not None:
        cards.append(ends + _integers(sun.day_of_year) + 5 * " " + _reals(radius_km) + _integers(0) + _reals(0))
    else:
        cards.append(ends + _reals(0, 0, radius_km) + _integers(0))
    if iemsct == SOLAR_RADIANCE and sun is not None:
        # IPARM 2: azimuth and zenith; IPH 2: Mie phase functions of the aerosol models; the sun.
        cards.append(_integers(2, 2, sun.day_of_year, 0))
        cards.append(_reals(sun.relative_azimuth_deg, sun.zenith_deg, 0, 0, 0, 0, 0, 0))
    cards += [_reals(*wavenumbers_cm1, 5), _integers(0)]
    return "\n".join(cards) + "\n"


def _level_cards(levels: Levels) -> list[str]:
    """Cards 2C, 2C1 and 2C2; gases without values are those of the 1976 US Standard atmosphere (key 6)."""
    keys = "AA" + "".join("6" if column is None else "A" for column in levels.mixing_ppmv)
    cards = [_integers(levels.altitude_km.size, 1, 0) + "profile"]
    for row in range(levels.altitude_km.size):
        gases = [0.0 if column is None else float(column[row]) for column in levels.mixing_ppmv]
        state = (levels.altitude_km[row], levels.pressure_mb[row], levels.temperature_K[row])
        cards.append(_reals(*state, *gases[:3]) + keys)
        cards += [_reals(*gases[3:11]), _reals(*gases[11:])]
    return cards


def _integers(*values: int) -> str:
    return "".join(f"{value:5d}" for value in values)


def _reals(*values: float) -> str:
    return "".join(map(_real, values))


def _real(value: float) -> str:
    """Write a number with as many digits as ten columns hold; a written point overrides F10.3 and E10.3.

    Nine characters at most, so that a blank parts the columns for the reader of a deck.
    """
    written = [f"{value:.{digits}f}" for digits in range(7, 0, -1)]
    written += [f"{value:.{digits}E}" for digits in range(4, 0, -1)]
    fitting = [text for text in written if len(text) <= 9]
    best = min(fitting, key=lambda text: abs(float(text) - value))
    return f"{best:>10}"
