"""Import of files from other codes: detect the format, read all runs, combine them and write an atmosphere table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from hcss_modtran.combine import combine
from hcss_modtran.libradtran import read_libradtran, read_settings
from hcss_modtran.modtran6 import read_modtran6_csv, read_modtran6_json
from hcss_modtran.modtran_tape7 import read_tape7
from hcss_modtran.spectral_path import PathGeometry, SpectralPath
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.providers import Catalog, CatalogError, choose_from

FORMATS = ("modtran-tape7", "modtran6-json", "modtran6-csv", "libradtran")

Format = Literal["auto", "modtran-tape7", "modtran6-json", "modtran6-csv", "libradtran"]

_TAPE7_SUFFIXES = (".tp7", ".7sc", ".fl7", ".scn")


@dataclass(frozen=True)
class ReadOptions:
    """User input for information that files lack.

    Attributes
    ----------
    format : str
        One of :data:`FORMATS`, or ``auto``.
    geometry : mapping of str to PathGeometry
        Line of sight by file name; the key ``*`` applies to every file.
    settings : sequence of str
        Lines of a uvspec input file; they replace a file ``NAME.inp`` in the folder of the output.
    """

    format: str = "auto"
    geometry: Mapping[str, PathGeometry] = field(default_factory=dict)
    settings: Sequence[str] = ()


def parse_geometry(text: str) -> tuple[str, PathGeometry]:
    """Parse ``[FILE=]H1_km,H2_km,ANGLE_deg`` into a key for :attr:`ReadOptions.geometry` and the geometry.

    Raises
    ------
    ValueError
        If the text does not have that form.
    """
    name, _, numbers = text.rpartition("=")
    try:
        height, end, angle = (float(number) for number in numbers.split(","))
    except ValueError as error:
        raise ValueError(f"'{text}': expected [FILE=]H1_km,H2_km,ANGLE_deg, for example 100,0,160") from error
    if not (0 <= angle <= 180 and 0 <= height < math.inf and 0 <= end < math.inf):
        raise ValueError(f"'{text}': allowed H1_km, H2_km >= 0 and 0 <= ANGLE_deg <= 180 (above 90: downwards)")
    return name or "*", PathGeometry(height * 1e3, end * 1e3, angle)


def detect_format(path: Path) -> str:
    """Detect the format from the suffix and the first lines.

    Raises
    ------
    CatalogError
        If the format is unknown.
    """
    suffix = path.suffix.lower()
    file = Reading(path, CatalogError)
    if file.is_netcdf:
        raise CatalogError(f"{path}: is NetCDF; an atmosphere table needs no import")
    head = file.first_bytes(100_000)
    start = head.lstrip()[:1]
    if start == b"{":
        return "modtran6-json"
    lines = head.decode("latin-1").splitlines()
    if suffix == ".csv":
        return "modtran6-csv"
    if suffix in _TAPE7_SUFFIXES or any(
        line.lstrip().upper().startswith(("FREQ ", "WAVLEN", "FREQ(")) for line in lines
    ):
        return "modtran-tape7"
    if path.with_suffix(".inp").is_file():
        return "libradtran"
    raise CatalogError(
        f"{path}: the format is not recognised; name it with --format ({', '.join(FORMATS)}); a uvspec output "
        "needs its input file NAME.inp beside it or its lines as settings"
    )


def read_paths(path: Path, options: ReadOptions | None = None) -> list[SpectralPath]:
    """Read every run of one file.

    Raises
    ------
    CatalogError
        If the format is unknown or the file is malformed; the message names the line.
    """
    options = options or ReadOptions()
    if options.format == "auto":
        chosen = "libradtran" if options.settings else detect_format(path)
    elif options.format in FORMATS:
        chosen = options.format
    else:
        raise CatalogError(f"no format '{options.format}'; {choose_from(options.format, ('auto', *FORMATS))}")
    given = options.geometry.get(path.name, options.geometry.get("*"))
    with Reading(path, CatalogError):
        if chosen == "modtran6-csv":
            return read_modtran6_csv(path, given)
        if chosen == "libradtran":
            return read_libradtran(path, read_settings([*_input_file(path), *options.settings]))
        paths = read_tape7(path) if chosen == "modtran-tape7" else read_modtran6_json(path)
        # An explicit line of sight overrides the header.
        return [replace(path, geometry=given) for path in paths] if given else paths


def _input_file(path: Path) -> list[str]:
    beside = path.with_suffix(".inp")
    return beside.read_text(encoding="utf-8", errors="replace").splitlines() if beside.is_file() else []


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
        Output files of other codes.
    output : Path
        Table to write.
    options : ReadOptions
        Information that the files lack.
    profile : str, optional
        Catalog name or CSV file of the profile used in the runs; by default the 1976 US Standard, if every run states
        that it used this one.
    resolution_cm1 : float, optional
        Needed where the files do not give it.
    title : str, optional
        Title of the table.

    Returns
    -------
    list of str
        Summary of what was read and checked, one line each.

    Raises
    ------
    CatalogError
        If a file is malformed or the runs do not form a table.
    """
    Writing(Path(output), CatalogError, "NetCDF", read=files).check()
    paths = [path for file in files for path in read_paths(file, options)]
    lines = [f"{path.source}: {path.code}, {path.geometry or 'no geometry'}" for path in paths]
    lines += [f"{path.source}: {note}" for path in paths for note in path.notes]
    name = profile or _profile_of(paths)
    of_runs = load_profile(name, Catalog())
    changes = dict.fromkeys(change for path in paths for change in path.changes)
    if changes:
        of_runs = replace(of_runs, mixing_ratio={})
        lines.append(f"the runs change amounts of gases ({', '.join(changes)}): the table states none of them")
    combined = combine(paths, of_runs, resolution_cm1)
    attributes = {
        "title": title or f"{name}, imported",
        "origin": f"imported from {', '.join(file.name for file in files)}",
        "profile": name,
    }
    combined.table.write(output, attributes)
    return [*lines, *combined.checks]


def _profile_of(paths: Sequence[SpectralPath]) -> str:
    models = {path.model for path in paths}
    if models == {_US_STANDARD}:
        return "us-standard-1976"
    named = ", ".join(sorted(_MODEL_NAMES.get(model or 0, "unknown") for model in models))
    known = ", ".join(Catalog().names("atmospheres", ".csv"))
    raise CatalogError(f"the runs' atmosphere is {named}; give their profile: --profile NAME ({known}) or a CSV file")
