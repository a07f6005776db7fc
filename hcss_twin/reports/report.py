"""Reports: one HTML file about a cube or its evidence, or a file or folder for which an installed package has a page.

A package names a function in the entry point group ``hcss_twin.pages``. It takes the path of a NetCDF file and returns
a :class:`hcss_twin.reports.page.Page`; the name of the entry point is the global attribute that its files have. In the
group ``hcss_twin.pages_of_folders`` the function takes a folder, and the entry point has the name of a file in it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint
from pathlib import Path

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import Writing, require_not_read
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.own_packages import PAGES, PAGES_OF_FOLDERS, how_to_install
from hcss_twin.core.plugins import FAILURES, OWN_DISTRIBUTION, describe, installed
from hcss_twin.core.reading import Reading, require_no_stream
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.cube.zarr_writer import is_zarr

ALLOWED = (
    "allowed: a cube (.nc or .zarr, of `hcss run` or `hcss sense`), the folder or the dataset of a sweep "
    "(`hcss sweep`), a posterior (`hcss fit`), or a propagation (`hcss propagate`)"
)

GROUP, GROUP_OF_FOLDERS = "hcss_twin.pages", "hcss_twin.pages_of_folders"


@checked
def report(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    replace: bool = False,
    evidence: bool = False,
) -> Path:
    """Write a self-contained HTML report of a cube, or a file or folder of a plugin, such as a sweep.

    Parameters
    ----------
    source : path-like
        A cube (NetCDF or Zarr, clean or measured), or a file or folder for which an installed plugin has a page.
    output : path-like, optional
        Name of the file; default: ``SOURCE.html``, without the suffix of the source, next to it, or with ``evidence``
        ``SOURCE.evidence.html``.
    replace : bool
        Replace an existing file.
    evidence : bool
        Of a cube, instead of the report: what stands behind its numbers (certificate, error of each model,
        comparisons, what no measurement supports).

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
    if evidence:
        if entry != _of_cube()[1]:
            raise HcssError(f"no evidence of {path}: it is not a cube; allowed: a cube of `hcss run` or `hcss sense`")
        entry = EntryPoint(FORMAT_ATTRIBUTE, "hcss_twin.reports.evidence_page:evidence_page", GROUP)
    target = Path(output) if output is not None else _beside(path, ".evidence.html" if evidence else ".html")
    require_not_read(target, [path], HcssError)
    Writing(target, HcssError, "HTML").check()
    if target.exists() and not replace:
        raise HcssError(f"{target} exists; allowed: another name with -o, or --force")
    try:
        page = entry.load()  # only now, because pages import matplotlib
    except FAILURES as error:
        raise HcssError(f"page '{entry.name}' of {origin} cannot be imported: {describe(error)}") from error
    with Reading(path, HcssError):
        contents = page(path)
    contents.write(target)
    return target


def _page_of(path: Path) -> tuple[str, EntryPoint]:
    """Return the page for a path, and where it comes from; raise HcssError if there is none."""
    if not path.exists():
        raise HcssError(f"cannot report on {path}: there is no such file; {ALLOWED}")
    require_no_stream(path, HcssError)
    if path.is_dir():
        if is_zarr(path):
            return _of_cube()
        known = ", ".join(PAGES_OF_FOLDERS)
        what = f"a folder without {known} of a sweep"
        return _of_plugin(path, lambda name: (path / name).is_file(), GROUP_OF_FOLDERS, PAGES_OF_FOLDERS, what)
    try:
        with Reading(path, HcssError), NetcdfFile(path) as file:
            marks = set(file.ncattrs())
    except Exception as error:  # a damaged file of any kind
        raise HcssError(f"cannot report on {path}: {_why_not(path)}; {ALLOWED}") from error
    if FORMAT_ATTRIBUTE in marks:
        return _of_cube()
    known = ", ".join((FORMAT_ATTRIBUTE, *PAGES))
    return _of_plugin(path, marks.__contains__, GROUP, PAGES, f"NetCDF without {known}")


def _of_cube() -> tuple[str, EntryPoint]:
    return OWN_DISTRIBUTION, EntryPoint(FORMAT_ATTRIBUTE, "hcss_twin.reports.cube_page:cube_page", GROUP)


def _of_plugin(
    path: Path, has: Callable[[str], bool], group: str, known: Mapping[str, str], what: str
) -> tuple[str, EntryPoint]:
    """Return the page of an installed plugin; the error for a plugin that is not installed names it."""
    for origin, entry in installed(group):
        if not isinstance(entry, BaseException) and has(entry.name):
            return str(origin), entry
    for mark, plugin in known.items():
        if has(mark):
            raise HcssError(
                f"cannot report on {path}: its page comes with the plugin {plugin}: {how_to_install(plugin)}"
            )
    raise HcssError(f"cannot report on {path}: it is {what}; {ALLOWED}")


def _why_not(path: Path) -> str:
    if os.path.getsize(path) == 0:
        return "it is empty"
    if path.suffix.lower() in (".toml", ".json"):
        return f"it is not a NetCDF file; if it is a scenario, `hcss run {path}` computes its cube"
    return "it is not a NetCDF file, or it is damaged"


def _beside(path: Path, suffix: str) -> Path:
    """Return the default name of a report; a dot in a folder name does not start a suffix."""
    named = path if path.name not in ("", "..") else path.resolve()
    return named.with_name(f"{named.name if named.is_dir() and not is_zarr(named) else named.stem}{suffix}")
