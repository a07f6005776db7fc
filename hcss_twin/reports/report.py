"""Reports: one HTML file about a cube, a sweep, a posterior or a propagation."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import require_file, require_not_read
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.reading import reading, require_no_stream
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.cube.zarr_writer import is_zarr
from hcss_twin.reports.page import write_page
from hcss_twin.sweeps.dataset import MARK

ALLOWED = (
    "allowed: a cube (.nc or .zarr, of `hcss run` or `hcss sense`), the folder or the dataset of a sweep "
    "(`hcss sweep`), a posterior (`hcss fit`), or a propagation (`hcss run --draws`)"
)

PAGES = {
    MARK: "sweep_page",  # first, because the dataset of a sweep also has the marker attribute of cubes
    "hcss_posterior_version": "posterior_page",
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
    name = _page_of(path)
    target = Path(output) if output is not None else _beside(path)
    require_not_read(target, [path], HcssError)
    require_file(target, HcssError, "HTML")
    if target.exists() and not replace:
        raise HcssError(f"{target} exists; allowed: another name with -o, or --force")
    # imported when needed, because pages import matplotlib
    page = getattr(import_module(f"hcss_twin.reports.{name}"), name)
    with reading(path, HcssError):
        contents = page(path)
    write_page(target, contents)
    return target


def _page_of(path: Path) -> str:
    """Return the name of the page for a path; raise HcssError if there is none."""
    if not path.exists():
        raise HcssError(f"cannot report on {path}: there is no such file; {ALLOWED}")
    require_no_stream(path, HcssError)
    if path.is_dir():
        # imported here because it imports the whole scenario package, which a file does not need
        from hcss_twin.sweeps.folder import INDEX

        if is_zarr(path):
            return PAGES[FORMAT_ATTRIBUTE]
        if (path / INDEX).is_file():
            return PAGES[MARK]
        raise HcssError(f"cannot report on {path}: it is a folder without {INDEX} of a sweep; {ALLOWED}")
    try:
        with reading(path, HcssError), NetcdfFile(path) as file:
            names = set(file.ncattrs())
    except Exception as error:  # a damaged file of any kind
        raise HcssError(f"cannot report on {path}: {_why_not(path)}; {ALLOWED}") from error
    for mark, page in PAGES.items():
        if mark in names:
            return page
    raise HcssError(f"cannot report on {path}: it is NetCDF without {', '.join(PAGES)}; {ALLOWED}")


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
