"""Reports: one HTML file about a cube, a sweep, or a file for which an installed package has a page.

A package names a function in the entry point group ``hcss_twin.pages``. It takes the path of a NetCDF file and returns
a :class:`hcss_twin.reports.page.Page`; the name of the entry point is the global attribute that its files have.
"""

from __future__ import annotations

import os
from importlib.metadata import EntryPoint
from pathlib import Path

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import require_file, require_not_read
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.own_packages import PAGES as MARKED
from hcss_twin.core.own_packages import how_to_install
from hcss_twin.core.plugins import FAILURES, OWN_DISTRIBUTION, describe, installed
from hcss_twin.core.reading import reading, require_no_stream
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.cube.zarr_writer import is_zarr
from hcss_twin.reports.page import write_page
from hcss_twin.sweeps.dataset import MARK

ALLOWED = (
    "allowed: a cube (.nc or .zarr, of `hcss run` or `hcss sense`), the folder or the dataset of a sweep "
    "(`hcss sweep`), a posterior (`hcss fit`), or a propagation (`hcss propagate`)"
)

GROUP = "hcss_twin.pages"

PAGES = {
    MARK: "hcss_twin.reports.sweep_page:sweep_page",  # before cubes, whose mark the dataset of a sweep also has
    FORMAT_ATTRIBUTE: "hcss_twin.reports.cube_page:cube_page",
}
"""Page of each file type of this package by its marker attribute."""


@checked
def report(
    source: str | os.PathLike[str], output: str | os.PathLike[str] | None = None, *, replace: bool = False
) -> Path:
    """Write a self-contained HTML report of a cube, a sweep, or a file of a plugin, such as a posterior.

    Parameters
    ----------
    source : path-like
        A cube (NetCDF or Zarr, clean or measured), the folder or the dataset of a sweep, or a file for which an
        installed plugin has a page.
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
    origin, entry = _page_of(path)
    target = Path(output) if output is not None else _beside(path)
    require_not_read(target, [path], HcssError)
    require_file(target, HcssError, "HTML")
    if target.exists() and not replace:
        raise HcssError(f"{target} exists; allowed: another name with -o, or --force")
    try:
        page = entry.load()  # only now, because pages import matplotlib
    except FAILURES as error:
        raise HcssError(f"page '{entry.name}' of {origin} cannot be imported: {describe(error)}") from error
    with reading(path, HcssError):
        contents = page(path)
    write_page(target, contents)
    return target


def _page_of(path: Path) -> tuple[str, EntryPoint]:
    """Return the page for a path, and where it comes from; raise HcssError if there is none."""
    if not path.exists():
        raise HcssError(f"cannot report on {path}: there is no such file; {ALLOWED}")
    require_no_stream(path, HcssError)
    if path.is_dir():
        # imported here because it imports the whole scenario package, which a file does not need
        from hcss_twin.sweeps.folder import INDEX

        if is_zarr(path):
            return _of_package(FORMAT_ATTRIBUTE)
        if (path / INDEX).is_file():
            return _of_package(MARK)
        raise HcssError(f"cannot report on {path}: it is a folder without {INDEX} of a sweep; {ALLOWED}")
    try:
        with reading(path, HcssError), NetcdfFile(path) as file:
            marks = set(file.ncattrs())
    except Exception as error:  # a damaged file of any kind
        raise HcssError(f"cannot report on {path}: {_why_not(path)}; {ALLOWED}") from error
    for mark in PAGES:
        if mark in marks:
            return _of_package(mark)
    for origin, entry in installed(GROUP):
        if not isinstance(entry, BaseException) and entry.name in marks:
            return str(origin), entry
    for mark, plugin in MARKED.items():
        if mark in marks:
            raise HcssError(
                f"cannot report on {path}: its page comes with the plugin {plugin}: {how_to_install(plugin)}"
            )
    known = ", ".join((*PAGES, *MARKED))
    raise HcssError(f"cannot report on {path}: it is NetCDF without {known}; {ALLOWED}")


def _of_package(mark: str) -> tuple[str, EntryPoint]:
    return OWN_DISTRIBUTION, EntryPoint(mark, PAGES[mark], GROUP)


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
