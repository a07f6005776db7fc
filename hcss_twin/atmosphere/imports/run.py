"""Import of files as a whole: read, combine, write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hcss_twin.atmosphere.imports.combine import combine
from hcss_twin.atmosphere.imports.reader import ReadOptions, read_paths
from hcss_twin.atmosphere.imports.spectral_path import SpectralPath
from hcss_twin.atmosphere.imports.table_writer import write_atmosphere_table
from hcss_twin.atmosphere.profile_file import load_profile
from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError

_US_STANDARD = 6

_MODEL_NAMES = {
    1: "tropical",
    2: "mid-latitude summer",
    3: "mid-latitude winter",
    4: "sub-arctic summer",
    5: "sub-arctic winter",
    6: "US Standard 1976",
}


def import_files(
    files: Sequence[Path],
    output: Path,
    options: ReadOptions,
    *,
    profile: str | None = None,
    resolution_cm1: float | None = None,
    title: str | None = None,
) -> list[str]:
    """Combine the runs of several files into one atmosphere table.

    Parameters
    ----------
    files : sequence of Path
        Output of other codes.
    output : Path
        Table to write.
    options : ReadOptions
        What the files do not tell.
    profile : str, optional
        Catalog name or CSV of the atmosphere the runs were made with; by default the 1976 US Standard if
        every run says that it is this one.
    resolution_cm1 : float, optional
        Where the files do not tell it.
    title : str, optional
        Title of the table.

    Returns
    -------
    list of str
        What was read and checked, one line each.

    Raises
    ------
    CatalogError
        If a file is malformed or the runs do not make a table.
    """
    paths = [each for file in files for each in read_paths(file, options)]
    lines = [f"{path.source}: {path.code}, {path.geometry or 'no geometry'}" for path in paths]
    lines += [f"{path.source}: {note}" for path in paths for note in path.notes]
    name = profile or _profile_of(paths)
    combined = combine(paths, load_profile(name, Catalog()), resolution_cm1)
    attributes = {
        "title": title or f"{name}, imported",
        "origin": f"imported from {', '.join(file.name for file in files)}",
        "profile": name,
    }
    write_atmosphere_table(output, combined.table, attributes)
    return [*lines, *combined.checks]


def _profile_of(paths: Sequence[SpectralPath]) -> str:
    models = {path.model for path in paths}
    if models == {_US_STANDARD}:
        return "us-standard-1976"
    named = ", ".join(sorted(_MODEL_NAMES.get(model or 0, "unknown") for model in models))
    known = ", ".join(Catalog().names("atmospheres", ".csv"))
    raise CatalogError(
        f"the runs' atmosphere is {named}; say which profile they were made with: --profile NAME ({known}) or a "
        "CSV file"
    )
