"""Regenerate the six AFGL model atmospheres: ``atmospheres/tropical.csv`` ... ``us-standard-1976.csv``.

Package: ``pip install joseki==2.7.0`` (LGPL-3.0; only the tabulated figures are read, from its CSV copies of
tables 1a-1f and 2a).
Origin: G. P. Anderson et al., AFGL-TR-86-0110 (1986), models 1 to 6.
Rights: the figures come from a technical report of the US government, public domain.

Run as ``python catalogs/recipes/afgl_1986.py``. With ``--check`` it also prints the column water vapour of
each model and, with ``pip install ussa1976==0.3.4`` (MIT), the largest differences of model 6 from the
U.S. Standard Atmosphere 1976 computed from its defining equations.
"""

from __future__ import annotations

import csv
import math
import sys
from dataclasses import dataclass
from decimal import Decimal
from importlib.resources import files

from _table_file import CATALOGS, Column, TableFile, require_version, write_table

PACKAGE = ("joseki", "2.7.0")

RIGHTS = (
    "public domain (technical report of the US government); the carrying package is LGPL-3.0 and contributes no code"
)
EVERY_MODEL = (
    "Gases as of 1986: CO2 330 ppmv, CH4 1.70 ppmv, N2O {n2o} ppmv at the surface; scale for the present.",
    "Interpolate ln pressure, ln number density, ln mixing ratio and temperature linearly in altitude.",
)


@dataclass(frozen=True)
class Model:
    """One model atmosphere of the report.

    Parameters
    ----------
    number : int
        Its number in the report, 1 to 6; also that of table 1 (a to f).
    name : str
        File stem in the catalog.
    title, reported_as : str
        For the header.
    gases_from_table_2a : tuple of str
        Gases read from table 2a; the others stand in the model's own table 1.
    corrections : tuple of (str, str, str)
        Slips of the package's table: level in km as it stands there, column, number to take instead.
    remarks : tuple of str
        What is particular to it.
    """

    number: int
    name: str
    title: str
    reported_as: str
    gases_from_table_2a: tuple[str, ...] = ("CO2", "O2")
    corrections: tuple[tuple[str, str, str], ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def table(self) -> str:
        """File stem of the model's table 1 in the package."""
        return f"table_1{'abcdef'[self.number - 1]}"


MODELS = (
    Model(1, "tropical", "Tropical atmosphere (15 N, annual mean)", "Tropical"),
    Model(2, "midlatitude-summer", "Midlatitude summer atmosphere (45 N, July)", "Midlatitude Summer"),
    Model(3, "midlatitude-winter", "Midlatitude winter atmosphere (45 N, January)", "Midlatitude Winter"),
    Model(
        4,
        "subarctic-summer",
        "Subarctic summer atmosphere (60 N, July)",
        "Subarctic Summer",
        corrections=(("1.00", "n", "2.304e+19"), ("27.50", "t", "231.0")),
        remarks=(
            "Number density at 1 km is 2.304e25 m-3, which pressure and temperature give; table 1d of the "
            "package has 2.395e25. Temperature at 27.5 km is 231.0 K as in LOWTRAN7; the package has 231.1.",
        ),
    ),
    Model(
        5,
        "subarctic-winter",
        "Subarctic winter atmosphere (60 N, January)",
        "Subarctic Winter",
        corrections=(("8.00", "t", "220.6"),),
        remarks=(
            "Temperature at 8 km is 220.6 K as in LOWTRAN7; table 1e of the package has 220.9, which its own "
            "number density contradicts.",
        ),
    ),
    Model(
        6,
        "us-standard-1976",
        "U.S. Standard Atmosphere",
        "U.S. Standard",
        gases_from_table_2a=("H2O", "CO2", "O3", "N2O", "CO", "CH4", "O2"),
        remarks=(
            "Methane at 19 km is 1.48 ppmv as in table 2a and in LOWTRAN7; table 1f of the package has 1.46.",
            "Against the defining equations of the 1976 atmosphere: pressure within 0.03 percent and temperature "
            "within 0.05 K up to 32 km; above, the largest differences are pressure 3 percent low at 32.5 km and "
            "temperature 0.5 K low at 37.5 km.",
        ),
    ),
)
GASES = ("H2O", "CO2", "O3", "N2O", "CO", "CH4", "O2")
COLUMNS = (
    Column("altitude_m", "m", "geometric altitude above mean sea level"),
    Column("pressure_Pa", "Pa", "air pressure"),
    Column("temperature_K", "K", "air temperature"),
    Column("air_number_density_m3", "m-3", "number density of air"),
    *(Column(gas.lower(), "1", f"volume mixing ratio of {gas}, mol/mol") for gas in GASES),
)


def read(name: str) -> list[dict[str, str]]:
    """Read one table of the package.

    Parameters
    ----------
    name : str
        File stem, for example ``table_1f``.

    Returns
    -------
    list of dict
        Rows, from the ground upwards: column name to number as text.
    """
    text = (files("joseki") / "data" / "afgl_1986" / f"{name}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def scaled(text: str, power_of_ten: int) -> str:
    """Shift the decimal point of a number given as text, keeping exactly its digits.

    Parameters
    ----------
    text : str
        Number.
    power_of_ten : int
        Exponent of the factor.

    Returns
    -------
    str
        Number in scientific notation.
    """
    return f"{Decimal(text).scaleb(power_of_ten):e}"


def rows(model: Model) -> list[list[str]]:
    """Join the two tables of a model and convert to SI.

    Parameters
    ----------
    model : Model
        Which one.

    Returns
    -------
    list of list of str
        One row a level, in the order of `COLUMNS`.

    Raises
    ------
    ValueError
        If the levels of the two tables differ, or a correction belongs to none.
    """
    joined: list[list[str]] = []
    corrections = list(model.corrections)
    for own, common in zip(read(model.table), read("table_2a"), strict=True):
        if Decimal(own["z"]) != Decimal(common["z"]):
            raise ValueError(f"level {own['z']} km of {model.table} meets level {common['z']} km of table_2a")
        for each in [each for each in corrections if each[0] == own["z"]]:
            own[each[1]] = each[2]
            corrections.remove(each)
        gases = {gas: (common if gas in model.gases_from_table_2a else own)[gas] for gas in GASES}
        joined.append(
            [
                f"{Decimal(own['z']) * 1000:.0f}",
                scaled(own["p"], 2),
                own["t"],
                scaled(own["n"], 6),
                *(scaled(gases[gas], -6) for gas in GASES),
            ]
        )
    if corrections:
        raise ValueError(f"{model.table} has no level for the corrections {corrections}")
    return joined


def columns_of(levels: list[list[str]]) -> tuple[float, float]:
    """Integrate the column amounts of water vapour and ozone.

    Parameters
    ----------
    levels : list of list of str
        Rows as written; number density times mixing ratio is exponential in altitude between them.

    Returns
    -------
    water, ozone : float
        kg m-2 and Dobson units (2.6868e20 m-2).
    """

    def column(gas: str) -> float:
        at = COLUMNS.index(next(each for each in COLUMNS if each.name == gas))
        altitude = [float(row[0]) for row in levels]
        density = [float(row[3]) * float(row[at]) for row in levels]
        total = 0.0
        for low, high, below, above in zip(altitude, altitude[1:], density, density[1:], strict=False):
            ratio = math.log(below / above)
            total += (high - low) * ((below - above) / ratio if ratio else below)
        return total

    return column("h2o") * 18.01528e-3 / 6.02214076e23, column("o3") / 2.6868e20


def print_check(levels: list[list[str]]) -> None:
    """Print the largest differences from the defining equations of the 1976 atmosphere.

    Parameters
    ----------
    levels : list of list of str
        Rows as written.
    """
    import numpy as np
    import ussa1976

    require_version("ussa1976", "0.3.4")
    table = np.array(levels, dtype=float)
    altitude, pressure, temperature, density = table[:, :4].T
    reference = ussa1976.compute(z=altitude, variables=["p", "t", "n_tot"])
    differences = (
        ("pressure, relative", pressure / reference.p.values - 1.0),
        ("temperature, K", temperature - reference.t.values),
        ("number density, relative", density / reference.n_tot.values - 1.0),
    )
    for top in (32e3, 120e3):
        for label, difference in differences:
            worst = int(np.argmax(np.abs(np.where(altitude <= top, difference, 0.0))))
            print(f"0-{top / 1e3:.0f} km: {label}: {difference[worst]:+.2e} at {altitude[worst] / 1e3:g} km")


def source(model: Model) -> str:
    """Write the citation of a model.

    Parameters
    ----------
    model : Model
        Which one.

    Returns
    -------
    str
        For the header.
    """
    letter = model.table[-1]
    if model.number == 6:
        tables = f"pressure, temperature, number density from table 1{letter}, mixing ratios from table 2a"
    else:
        tables = f"table 1{letter}; CO2 and O2, the same for all models, from table 2a"
    return (
        "G. P. Anderson, S. A. Clough, F. X. Kneizys, J. H. Chetwynd and E. P. Shettle, AFGL atmospheric "
        "constituent profiles (0-120 km), AFGL-TR-86-0110, Air Force Geophysics Laboratory (1986), model "
        f"{model.number} ({model.reported_as}): {tables}"
    )


def main() -> None:
    """Write the catalog files."""
    require_version(*PACKAGE)
    for model in MODELS:
        levels = rows(model)
        water, ozone = columns_of(levels)
        surface = dict(zip((column.name for column in COLUMNS), levels[0], strict=True))
        n2o = f"{float(surface['n2o']) * 1e6:.3f}"
        table = TableFile(
            title=f"{model.title}, AFGL 1986 model {model.number}, 0-120 km",
            source=source(model),
            rights=RIGHTS,
            made_by=f"recipes/afgl_1986.py from the package joseki 2.7.0 (afgl_1986/{model.table}, table_2a)",
            columns=COLUMNS,
            rows=levels,
            remarks=(
                *(remark.format(n2o=n2o) for remark in EVERY_MODEL),
                *model.remarks,
                f"Column amounts: water vapour {water:.3g} kg m-2, ozone {ozone:.0f} DU.",
            ),
        )
        write_table(CATALOGS / "atmospheres" / f"{model.name}.csv", table)
        if "--check" in sys.argv[1:]:
            print(f"{model.name}: {surface['temperature_K']} K, water vapour {water:.2f} kg m-2, ozone {ozone:.0f} DU")
            if model.number == 6:
                print_check(levels)


if __name__ == "__main__":
    main()
