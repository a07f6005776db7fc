"""Regenerate ``atmospheres/us-standard-1976.csv``.

Package: ``pip install joseki==2.7.0`` (LGPL-3.0; only the tabulated figures are read, from its CSV copies of
tables 1f and 2a).
Origin: G. P. Anderson et al., AFGL-TR-86-0110 (1986), model 6.
Rights: the figures come from a technical report of the US government, public domain.

Run as ``python catalogs/recipes/us_standard_1976.py``. With ``--check`` and ``pip install ussa1976==0.3.4``
(MIT) it also prints the largest differences from the U.S. Standard Atmosphere 1976 computed from its
defining equations.
"""

from __future__ import annotations

import csv
import sys
from decimal import Decimal
from importlib.resources import files

from _table_file import CATALOGS, Column, TableFile, require_version, write_table

PACKAGE = ("joseki", "2.7.0")

SOURCE = (
    "G. P. Anderson, S. A. Clough, F. X. Kneizys, J. H. Chetwynd and E. P. Shettle, AFGL atmospheric "
    "constituent profiles (0-120 km), AFGL-TR-86-0110, Air Force Geophysics Laboratory (1986), model 6 "
    "(U.S. Standard): pressure, temperature, number density from table 1f, mixing ratios from table 2a"
)
RIGHTS = (
    "public domain (technical report of the US government); the carrying package is LGPL-3.0 and contributes "
    "no code"
)
REMARKS = (
    "Gases as of 1986: CO2 330 ppmv, CH4 1.70 ppmv, N2O 0.320 ppmv at the surface; scale for the present.",
    "Methane at 19 km is 1.48 ppmv as in table 2a and in LOWTRAN7; table 1f of the package has 1.46.",
    "Interpolate ln pressure, ln number density, ln mixing ratio and temperature linearly in altitude.",
    "Against the defining equations of the 1976 atmosphere: pressure within 0.03 percent and temperature "
    "within 0.05 K up to 32 km; above, the largest differences are pressure 3 percent low at 32.5 km and "
    "temperature 0.5 K low at 37.5 km.",
    "Column amounts: water vapour 14.2 kg m-2, ozone 344 DU.",
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


def rows() -> list[list[str]]:
    """Join the two tables and convert to SI.

    Returns
    -------
    list of list of str
        One row a level, in the order of `COLUMNS`.

    Raises
    ------
    ValueError
        If the levels of the two tables differ.
    """
    joined: list[list[str]] = []
    for state, gases in zip(read("table_1f"), read("table_2a"), strict=True):
        if Decimal(state["z"]) != Decimal(gases["z"]):
            raise ValueError(f"level {state['z']} km of table 1f meets level {gases['z']} km of table 2a")
        joined.append(
            [
                f"{Decimal(state['z']) * 1000:.0f}",
                scaled(state["p"], 2),
                state["t"],
                scaled(state["n"], 6),
                *(scaled(gases[gas], -6) for gas in GASES),
            ]
        )
    return joined


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


def main() -> None:
    """Write the catalog file."""
    require_version(*PACKAGE)
    levels = rows()
    table = TableFile(
        title="U.S. Standard Atmosphere, AFGL 1986 model 6, 0-120 km",
        source=SOURCE,
        rights=RIGHTS,
        made_by="recipes/us_standard_1976.py from the package joseki 2.7.0 (afgl_1986/table_1f, table_2a)",
        columns=COLUMNS,
        rows=levels,
        remarks=REMARKS,
    )
    write_table(CATALOGS / "atmospheres" / "us-standard-1976.csv", table)
    if "--check" in sys.argv[1:]:
        print_check(levels)


if __name__ == "__main__":
    main()
