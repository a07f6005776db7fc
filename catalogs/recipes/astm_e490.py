"""Regenerate ``solar/astm-e490.csv``.

Package: ``pip install pyspectral==0.14.3`` (Apache-2.0); the table is its file ``data/e490_00a.dat``.
Origin: ASTM E490-00a (2000), as distributed openly by the US National Renewable Energy Laboratory.
Rights: the figures are public; the text of the standard belongs to ASTM International and is not used.

Run as ``python catalogs/recipes/astm_e490.py``.
"""

from __future__ import annotations

from importlib.resources import files
from itertools import pairwise

from _table_file import CATALOGS, Column, TableFile, require_version, write_table

LIMITS_UM = (0.3, 20.0)

SOURCE = (
    "ASTM E490-00a, Standard Solar Constant and Zero Air Mass Solar Spectral Irradiance Tables, "
    "ASTM International (2000), doi 10.1520/E0490-00A; table distributed by the US National Renewable Energy "
    "Laboratory (Renewable Resource Data Center)"
)
RIGHTS = (
    "figures public (openly distributed by the US National Renewable Energy Laboratory); the text of the "
    "standard is copyright ASTM International and no part of it is reproduced; the "
    "carrying package is Apache-2.0"
)
COLUMNS = (
    Column("wavelength_um", "um", "wavelength"),
    Column(
        "irradiance_W_m2_um",
        "W m-2 um-1",
        "solar spectral irradiance on a plane normal to the beam outside the atmosphere at 1 au",
    ),
)


def trapezoid(rows: list[list[str]]) -> float:
    """Integrate irradiance over wavelength by the trapezoidal rule.

    Parameters
    ----------
    rows : list of [wavelength_um, irradiance_W_m2_um]
        Numbers as text.

    Returns
    -------
    float
        Irradiance in W m-2.
    """
    points = [(float(w), float(e)) for w, e in rows]
    return sum(0.5 * (e0 + e1) * (w1 - w0) for (w0, e0), (w1, e1) in pairwise(points))


def main() -> None:
    """Read the table of the package, keep the wavelengths wanted, write the catalog file."""
    require_version("pyspectral", "0.14.3")
    text = (files("pyspectral") / "data" / "e490_00a.dat").read_text(encoding="utf-8")
    rows = [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]

    # The nodes just outside are kept so that the limits themselves need no extrapolation.
    first = max(i for i, row in enumerate(rows) if float(row[0]) <= LIMITS_UM[0])
    last = min(i for i, row in enumerate(rows) if float(row[0]) >= LIMITS_UM[1])
    kept = rows[first : last + 1]
    table = TableFile(
        title="Extraterrestrial solar spectral irradiance, ASTM E490-00a",
        source=SOURCE,
        rights=RIGHTS,
        made_by="recipes/astm_e490.py from the package pyspectral 0.14.3 (data/e490_00a.dat)",
        columns=COLUMNS,
        rows=kept,
        remarks=(
            f"Trapezoidal integral of the whole table, {rows[0][0]} to {rows[-1][0]} um: "
            f"{trapezoid(rows):.2f} W m-2 (the standard states 1366.1 W m-2); "
            f"of the part kept here: {trapezoid(kept):.2f} W m-2.",
            "Mean over the year at 1 au; scale with the inverse square of the Earth-Sun distance.",
            "Steps grow to 1 um beyond 10 um: interpolate ln irradiance in ln wavelength there (linear "
            "interpolation makes the integral from 8 to 14 um 0.5 percent too large).",
        ),
    )
    write_table(CATALOGS / "solar" / "astm-e490.csv", table)


if __name__ == "__main__":
    main()
