"""Choice of one plane of a file that holds several."""

from __future__ import annotations

from pathlib import Path

from hcss_twin.errors import CatalogError, choose_from


def choose_plane(path: Path, variable: str | None, planes: list[str], known: list[str]) -> str:
    """Return the variable to read: the one asked for, or the only one there is.

    Parameters
    ----------
    path : Path
        The file, for messages.
    variable : str or None
        What was asked for.
    planes, known : list of str
        Names of the planes, and of all that can be asked for.

    Raises
    ------
    CatalogError
        If there is no such variable, or several planes and none was asked for.
    """
    if variable is not None:
        if variable not in known:
            raise CatalogError(f"{path}: no variable '{variable}'; {choose_from(variable, planes)}")
        return variable
    if len(planes) == 1:
        return planes[0]
    if not planes:
        raise CatalogError(f"{path}: no image: none of its variables has two dimensions")
    listed = ", ".join(sorted(planes))
    raise CatalogError(f"{path}: several images; set variable to one of: {listed}")
