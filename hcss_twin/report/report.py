"""What a file or folder is that a report is asked for.

Reports: one HTML file about a cube, a sweep, a posterior or a propagation.
"""

from __future__ import annotations

import os
from enum import Enum, auto
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.core.errors import HcssError
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.cube.zarr_writer import is_zarr
from hcss_twin.report.page.page import write_page
from hcss_twin.sweeps.dataset import MARK

if TYPE_CHECKING:
    from hcss_twin.report.page.page import Page


POSTERIOR_ATTRIBUTE = "hcss_posterior_version"
PROPAGATION_ATTRIBUTE = "hcss_propagation_version"

ALLOWED = (
    "allowed: a cube (.nc or .zarr, of `hcss run` or `hcss sense`), the folder or the dataset of a sweep "
    "(`hcss sweep`), a posterior (`hcss fit`), or a propagation (`hcss run --draws`)"
)


class Kind(Enum):
    """What there are reports of."""

    CUBE = auto()
    SWEEP = auto()
    POSTERIOR = auto()
    PROPAGATION = auto()


MARKS = {
    FORMAT_ATTRIBUTE: Kind.CUBE,
    MARK: Kind.SWEEP,
    POSTERIOR_ATTRIBUTE: Kind.POSTERIOR,
    PROPAGATION_ATTRIBUTE: Kind.PROPAGATION,
}
"""Global attribute that tells each kind; the dataset of a sweep has that of its cubes, too."""


def kind_of(path: Path) -> Kind:
    """Return what a path holds.

    Raises
    ------
    HcssError
        If it is nothing that there are reports of; says what is allowed.
    """
    if not path.exists():
        raise HcssError(f"cannot report on {path}: there is no such file; {ALLOWED}")
    if path.is_dir():
        # imported here because it brings all of the scenario, which a file does not need
        from hcss_twin.sweeps.folder import INDEX

        if is_zarr(path):
            return Kind.CUBE
        if (path / INDEX).is_file():
            return Kind.SWEEP
        raise HcssError(f"cannot report on {path}: it is a folder without {INDEX} of a sweep; {ALLOWED}")
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            names = set(file.ncattrs())
    except (OSError, RuntimeError) as error:
        raise HcssError(f"cannot report on {path}: {_why_not(path)}; {ALLOWED}") from error
    for mark in (MARK, POSTERIOR_ATTRIBUTE, PROPAGATION_ATTRIBUTE, FORMAT_ATTRIBUTE):
        if mark in names:
            return MARKS[mark]
    raise HcssError(f"cannot report on {path}: it is NetCDF without {', '.join(MARKS)}; {ALLOWED}")


def _why_not(path: Path) -> str:
    if os.path.getsize(path) == 0:
        return "it is empty"
    if path.suffix.lower() in (".toml", ".json"):
        return f"it is no NetCDF file; if it is a scenario, `hcss run {path}` makes a cube of it"
    return "it is no NetCDF file, or it is damaged"


def report(
    source: str | os.PathLike[str], output: str | os.PathLike[str] | None = None, *, replace: bool = False
) -> Path:
    """Write one HTML file about a cube, a sweep, a posterior or a propagation; it needs no network and no other files.

    Parameters
    ----------
    source : path-like
        A cube (NetCDF or Zarr, clean or measured), the folder or the dataset of a sweep, a posterior,
        or a propagation.
    output : path-like, optional
        Name of the file; default: ``SOURCE.html``, without the suffix of the source, beside it.
    replace : bool
        Replace an existing file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    HcssError
        If there is nothing of the kind to report on, the file exists, or it cannot be written.
    """
    path = Path(source)
    kind = kind_of(path)
    target = Path(output) if output is not None else _beside(path)
    if target.exists() and target.samefile(path):
        raise HcssError(f"cannot write {target}: it is what the report is about; allowed: another name with -o")
    if target.exists() and not replace:
        raise HcssError(f"{target} exists; allowed: another name with -o, or --force")
    write_page(target, _page(kind, path))
    return target


def _beside(path: Path) -> Path:
    """Return the default name of a report; a point in the name of a folder begins no suffix."""
    named = path if path.name not in ("", "..") else path.resolve()
    return named.with_name(f"{named.name if named.is_dir() and not is_zarr(named) else named.stem}.html")


def _page(kind: Kind, path: Path) -> Page:
    # A new kind has a mark in recognition.py and its page here, imported when it is needed because pages draw.
    if kind is Kind.CUBE:
        from hcss_twin.report.cube_report.page import cube_page

        return cube_page(path)
    if kind is Kind.POSTERIOR:
        from hcss_twin.report.posterior_report.page import posterior_page

        return posterior_page(path)
    if kind is Kind.PROPAGATION:
        from hcss_twin.report.propagation_report.page import propagation_page

        return propagation_page(path)
    from hcss_twin.report.sweep_report.page import sweep_page

    return sweep_page(path)
