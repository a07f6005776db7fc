"""What a file or folder is that a report is asked for."""

from __future__ import annotations

import os
from enum import Enum, auto
from pathlib import Path

from hcss_twin.cube.formats import is_zarr
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.errors import HcssError
from hcss_twin.sweeps.reader import MARK

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
