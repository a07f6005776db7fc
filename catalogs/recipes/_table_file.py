"""Write a catalog table: comment header, one row of column names, rows of numbers.

Shared by the recipes of this directory; needs nothing beyond the standard library.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

CATALOGS = Path(__file__).resolve().parents[1]
"""Directory that holds the catalog files."""

HEADER_WIDTH = 108


@dataclass(frozen=True)
class Column:
    """One column of a catalog table.

    Parameters
    ----------
    name : str
        Column name, with the unit as suffix unless the quantity is dimensionless.
    unit : str
        Unit as written in the header ("1" for a dimensionless quantity).
    meaning : str
        What the numbers are.
    """

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class TableFile:
    """Everything that goes into one catalog table.

    Parameters
    ----------
    title, source, rights, made_by : str
        Header entries: name of the table, full citation, licence or rights, recipe and its inputs.
    columns : Sequence[Column]
        Columns in the order of the numbers.
    rows : Iterable[Sequence[str]]
        Numbers as text, so that no digit of the origin is lost or invented.
    remarks : Sequence[str], optional
        Further header entries, one line of thought each.
    """

    title: str
    source: str
    rights: str
    made_by: str
    columns: Sequence[Column]
    rows: Iterable[Sequence[str]]
    remarks: Sequence[str] = ()


def require_version(package: str, wanted: str) -> None:
    """Stop unless the installed package is the one the catalog file was made from.

    Parameters
    ----------
    package : str
        Distribution name.
    wanted : str
        Version the recipe is written for.

    Raises
    ------
    RuntimeError
        If another version is installed.
    """
    found = version(package)
    if found != wanted:
        raise RuntimeError(
            f"{package}: found version {found}, this recipe is written for {wanted}; "
            f"install it with: pip install {package}=={wanted}"
        )


def write_table(path: Path, table: TableFile) -> None:
    """Write a catalog table.

    Parameters
    ----------
    path : Path
        File to write; an existing one is replaced.
    table : TableFile
        Contents.

    Raises
    ------
    ValueError
        If a row has not one number for each column, or the first column does not increase strictly.
    """
    lines: list[str] = []
    for key in ("title", "source", "rights", "made_by"):
        lines += _header_entry(f"{key}: {getattr(table, key)}")
    for column in table.columns:
        lines += _header_entry(f"column: {column.name} [{column.unit}] {column.meaning}")
    for remark in table.remarks:
        lines += _header_entry(f"remark: {remark}")
    lines.append(",".join(column.name for column in table.columns))

    previous = float("-inf")
    for row in table.rows:
        if len(row) != len(table.columns):
            raise ValueError(f"{path.name}: row {row} has {len(row)} numbers, expected {len(table.columns)}")
        values = [float(text) for text in row]
        if values[0] <= previous:
            raise ValueError(f"{path.name}: {table.columns[0].name} {values[0]} does not exceed {previous}")
        previous = values[0]
        lines.append(",".join(row))

    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _header_entry(text: str) -> list[str]:
    """Fold one header entry into comment lines; continuation lines are indented."""
    return textwrap.wrap(
        text,
        HEADER_WIDTH,
        initial_indent="# ",
        subsequent_indent="#     ",
        break_on_hyphens=False,
        break_long_words=False,
    )
