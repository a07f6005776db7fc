"""Reports: one HTML file about a cube, a sweep, a posterior or a propagation."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import require_file, require_not_read
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.plugins import FAILURES, describe, installed
from hcss_twin.core.reading import reading, require_no_stream
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.cube.zarr_writer import is_zarr
from hcss_twin.reports.page import Page, write_page
from hcss_twin.sweeps.dataset import MARK

ALLOWED = (
    "allowed: a cube (.nc or .zarr, of `hcss run` or `hcss sense`), the folder or the dataset of a sweep "
    "(`hcss sweep`), a propagation (`hcss run --draws`), or a posterior (`hcss fit` of the package hcss-evaluate)"
)

GROUP = "hcss_twin.reports"
"""Entry point group of pages of other packages. The name of an entry point is the global attribute that marks its
NetCDF files; the value is a function that takes the path and returns a :class:`~hcss_twin.reports.page.Page`."""

PAGES = {
    MARK: "sweep_page",  # first, because the dataset of a sweep also has the marker attribute of cubes
    "hcss_propagation_version": "propagation_page",
    FORMAT_ATTRIBUTE: "cube_page",
}
"""Page of each file type by its marker attribute; the module and its function have the same name."""


@checked
def report(
    source: str | os.PathLike[str], output: str | os.PathLike[str] | None = None, *, replace: bool = False
) -> Path:
    """Write a self-contained HTML report of a cube, a sweep, a posterior or a propagation.

    Parameters
    ----------
    source : path-like
        A cube (NetCDF or Zarr, clean or measured), the folder or the dataset of a sweep, a posterior,
        or a propagation.
    output : path-like, optional
        Name of the file; default: ``SOURCE.html``, without the suffix of the source, next to it.
    replace : bool
        Replace an existing file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    HcssError
        If the source has no report, the file exists, or it cannot be written.
    """
    path = Path(source)
    page = _page_of(path)
    target = Path(output) if output is not None else _beside(path)
    require_not_read(target, [path], HcssError)
    require_file(target, HcssError, "HTML")
    if target.exists() and not replace:
        raise HcssError(f"{target} exists; allowed: another name with -o, or --force")
    with reading(path, HcssError):
        contents = page(path)
    write_page(target, contents)
    return target


def _page_of(path: Path) -> Callable[[Path], Page]:
    """Return the function that makes the page of a path; raise HcssError if there is none."""
    if not path.exists():
        raise HcssError(f"cannot report on {path}: there is no such file; {ALLOWED}")
    require_no_stream(path, HcssError)
    if path.is_dir():
        # imported here because it imports the whole scenario package, which a file does not need
        from hcss_twin.sweeps.folder import INDEX

        if is_zarr(path):
            return _own_page(FORMAT_ATTRIBUTE)
        if (path / INDEX).is_file():
            return _own_page(MARK)
        raise HcssError(f"cannot report on {path}: it is a folder without {INDEX} of a sweep; {ALLOWED}")
    try:
        with reading(path, HcssError), NetcdfFile(path) as file:
            names = set(file.ncattrs())
    except Exception as error:  # a damaged file of any kind
        raise HcssError(f"cannot report on {path}: {_why_not(path)}; {ALLOWED}") from error
    for mark in PAGES:
        if mark in names:
            return _own_page(mark)
    for origin, entry_point in installed(GROUP):
        if not isinstance(entry_point, BaseException) and entry_point.name in names:
            try:
                page: Callable[[Path], Page] = entry_point.load()
            except FAILURES as error:
                raise HcssError(f"page of {entry_point.name} of {origin}: {describe(error)}") from error
            return page
    raise HcssError(f"cannot report on {path}: it is NetCDF without {', '.join(PAGES)}; {ALLOWED}")


def _own_page(mark: str) -> Callable[[Path], Page]:
    """Return a page of this package; imported when needed, because pages import matplotlib."""
    page: Callable[[Path], Page] = getattr(import_module(f"hcss_twin.reports.{PAGES[mark]}"), PAGES[mark])
    return page


def _why_not(path: Path) -> str:
    if os.path.getsize(path) == 0:
        return "it is empty"
    if path.suffix.lower() in (".toml", ".json"):
        return f"it is not a NetCDF file; if it is a scenario, `hcss run {path}` computes its cube"
    return "it is not a NetCDF file, or it is damaged"


def _beside(path: Path) -> Path:
    """Return the default name of a report; a dot in a folder name does not start a suffix."""
    named = path if path.name not in ("", "..") else path.resolve()
    return named.with_name(f"{named.name if named.is_dir() and not is_zarr(named) else named.stem}.html")
