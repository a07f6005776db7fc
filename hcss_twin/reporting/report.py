"""Reports: one HTML file about a cube, a sweep, a posterior or a propagation."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.cube.formats import is_zarr
from hcss_twin.errors import HcssError
from hcss_twin.reporting.page.page import write_page
from hcss_twin.reporting.recognition import Kind, kind_of

if TYPE_CHECKING:
    from hcss_twin.reporting.page.page import Page


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
        raise HcssError(
            f"cannot write {target}: it is what the report is about; allowed: another name with -o"
        )
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
        from hcss_twin.reporting.cube_report.page import cube_page

        return cube_page(path)
    if kind is Kind.POSTERIOR:
        from hcss_twin.reporting.posterior_report.page import posterior_page

        return posterior_page(path)
    if kind is Kind.PROPAGATION:
        from hcss_twin.reporting.propagation_report.page import propagation_page

        return propagation_page(path)
    from hcss_twin.reporting.sweep_report.page import sweep_page

    return sweep_page(path)
