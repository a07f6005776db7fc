"""The band model against runs of MODTRAN (``HCSS_SAMPLE_DATA``, ``tests/sample_data.py``), which RRTMGP has no part in.

::

    HCSS_SAMPLE_DATA=FOLDER python benchmarks/gas_modtran.py
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import COEFFICIENTS, Aerosol, BandModelParameters
from hcss_twin.physics.paths import Leg, to_space
from hcss_twin.physics.paths import Path as AirPath
from hcss_twin.providers import AtmosphereInputs

STANDARD, TROPICAL = "us-standard-1976", "tropical"
SLIT_CM1 = 15.0
"""Half the base of the triangle that MODTRAN's 5 cm-1 steps are smoothed with at 655 to 750 cm-1."""

SHORT_EDGES_CM1 = (2000, 2080, 2250, 2390, 2680, 3175, 3250, 3475, 4000)
HALVES_CM1 = ((2050, 2074), (2075, 2100))


@dataclass(frozen=True)
class Comparison:
    """One quantity, ``what`` over ``cm1``, of MODTRAN and of each set of coefficients by name."""

    what: str
    cm1: tuple[int, int]
    modtran: float
    ours: dict[str, float]


@lru_cache(maxsize=8)
def rows(name: str) -> Array:
    """Return the numbers of a MODTRAN output, (V, columns); columns that not all rows have are left out.

    Raises
    ------
    FileNotFoundError
        Without the sample data.
    """
    folder = os.environ.get("HCSS_SAMPLE_DATA")
    if not folder:
        raise FileNotFoundError("HCSS_SAMPLE_DATA is not set: no runs of MODTRAN")
    split = [line.split() for line in (Path(folder) / "modtran" / name).read_text().splitlines()]
    found = [
        [float(each) for each in words]
        for words in split
        if len(words) > 8 and words[0].endswith(".00") and all(_is_number(each) for each in words)
    ]
    columns = min(map(len, found))
    return np.array([each[:columns] for each in found])


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def provider(file: str, model: str, aerosol: Aerosol) -> BandModelTransmittance:
    """Return the band model with a model atmosphere and its own gases, as MODTRAN has them."""
    catalog = Catalog()
    inputs = AtmosphereInputs(load_profile(model, catalog), catalog)
    return BandModelTransmittance(inputs, BandModelParameters(file=file, aerosol=aerosol))


def horizontal(file: str, model: str, altitude_m: float, length_m: float, wavenumber_cm1: Array) -> Array:
    """Return the transmittance (V,) of a horizontal path, of the amounts of a vertical path of 10 m."""
    gas = provider(file, model, "none")
    amounts = gas.absorber_amounts([AirPath((Leg(altitude_m, altitude_m + 10.0, 0.0),))])
    return gas.transmittance_of_amounts(wavenumber_cm1, amounts * (length_m / 10.0))[0]


def comparisons(coefficients: Sequence[str] = tuple(COEFFICIENTS)) -> Iterator[Comparison]:
    """Yield means over ranges of wavenumbers; at 655 to 750 cm-1 the root mean square error, of MODTRAN zero."""
    files = {name: COEFFICIENTS[name] for name in coefficients}
    run = rows("tape7-01b")
    wavenumber, known = run[:, 0], run[:, 1] / np.maximum(run[:, 9], 1e-9)
    slit = np.maximum(1.0 - np.abs(wavenumber[:, None] - wavenumber) / SLIT_CM1, 0.0)
    known = ((slit @ known) / slit.sum(axis=1))[3:-3]
    ours = {name: horizontal(file, TROPICAL, 0.0, 1e3, wavenumber)[3:-3] for name, file in files.items()}
    rms = {name: float(np.sqrt(np.mean((each - known) ** 2))) for name, each in ours.items()}
    yield Comparison("rms error of transmittance, 1 km at the sea, tropical", (655, 750), 0.0, rms)

    run = rows("tape7-01")
    wavenumber, known = run[:, 0], run[:, 1] / run[:, 9]
    ours = {name: horizontal(file, STANDARD, 2e3, 2e3, wavenumber) for name, file in files.items()}
    yield from _means("transmittance, 2 km at 2 km altitude, US standard", wavenumber, known, ours, HALVES_CM1)

    run, all_emits = rows("tape7-05b"), rows("tape7-05")
    wavenumber, path = run[:, 0], [to_space(0.0, 20.0)]
    gases = {name: provider(file, STANDARD, "rural") for name, file in files.items()}
    ours = {name: gas.transmittance(wavenumber, path)[0] for name, gas in gases.items()}
    yield from _means("transmittance, sea to space at 20 deg, US standard", wavenumber, run[:, 1], ours, HALVES_CM1)
    ours = {name: 1e3 * gas.sky_radiance(wavenumber, path)[0] for name, gas in gases.items()}
    what = "sky radiance, 1e-3 W m-2 sr-1 / cm-1, from the sea at 20 deg, US standard"
    yield from _means(what, wavenumber, 1e7 * run[:, 2], ours, HALVES_CM1)  # of W cm-2
    # MODTRAN without multiple scattering, and LOWTRAN7, count what aerosol scatters as its emission.
    lowtran7 = Catalog().find(COEFFICIENTS["lowtran7"], "atmospheres", ".nc")
    absorbed = 1e3 * provider(str(lowtran7), STANDARD, "rural").sky_radiance(wavenumber, path)[0]
    emitted = 1e3 * provider(COEFFICIENTS["lowtran7"], STANDARD, "rural").sky_radiance(wavenumber, path)[0]
    ours = {name: (0.0 if name == "lowtran7" else 1.0) * (emitted - absorbed) for name in files}
    what = "sky radiance, the same units, that rural aerosol scatters and does not emit"
    yield from _means(what, wavenumber, 1e7 * (all_emits[:, 2] - run[:, 2]), ours, HALVES_CM1)

    run = rows("ModTrantape7file")
    wavenumber, known = run[:, 0], 1.0 - run[:, 1]
    ours = {name: 1.0 - horizontal(file, TROPICAL, 2e3, 5.0, wavenumber) for name, file in files.items()}
    limits = tuple(pairwise(SHORT_EDGES_CM1))
    yield from _means("absorptance, 5 m at 2 km altitude, tropical", wavenumber, known, ours, limits)


def _means(
    what: str, wavenumber: Array, known: Array, ours: dict[str, Array], limits: Sequence[tuple[int, int]]
) -> Iterator[Comparison]:
    for low, high in limits:
        inside = (wavenumber >= low) & (wavenumber <= high)
        found = {name: float(np.mean(values[inside])) for name, values in ours.items()}
        yield Comparison(what, (low, high), float(np.mean(known[inside])), found)


def table() -> Iterator[str]:
    """Yield the lines of a table in Markdown."""
    yield "| quantity | cm-1 | MODTRAN | LOWTRAN7 | fitted |"
    yield "|---|---|---|---|---|"
    for each in comparisons():
        low, high = each.cm1
        values = " | ".join(f"{value:.4f}" for value in (each.modtran, each.ours["lowtran7"], each.ours["rrtmgp"]))
        yield f"| {each.what} | {low}-{high} | {values} |"


if __name__ == "__main__":
    sys.stdout.write("\n".join(table()) + "\n")
