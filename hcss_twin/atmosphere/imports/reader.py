"""One door to all file readers: find out the format, read every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from hcss_twin.atmosphere.imports.libradtran import read_libradtran, read_settings
from hcss_twin.atmosphere.imports.modtran6_csv import read_modtran6_csv
from hcss_twin.atmosphere.imports.modtran6_json import read_modtran6_json
from hcss_twin.atmosphere.imports.modtran_tape7 import read_tape7
from hcss_twin.atmosphere.imports.spectral_path import Geometry, SpectralPath
from hcss_twin.errors import CatalogError, choose_from

FORMATS = ("modtran-tape7", "modtran6-json", "modtran6-csv", "libradtran")

Format = Literal["auto", "modtran-tape7", "modtran6-json", "modtran6-csv", "libradtran"]

_TAPE7_SUFFIXES = (".tp7", ".7sc", ".fl7", ".scn")


@dataclass(frozen=True)
class ReadOptions:
    """What a user adds to files that do not tell everything.

    Attributes
    ----------
    format : str
        One of :data:`FORMATS`, or ``auto``.
    geometry : mapping of str to Geometry
        Line of sight by file name; the key ``*`` holds for every file.
    settings : sequence of str
        Lines of a uvspec input file; they replace those of a file ``NAME.inp`` beside the output.
    """

    format: str = "auto"
    geometry: Mapping[str, Geometry] = field(default_factory=dict)
    settings: Sequence[str] = ()


def parse_geometry(text: str) -> tuple[str, Geometry]:
    """Parse ``[FILE=]H1_km,H2_km,ANGLE_deg`` into a key for :attr:`ReadOptions.geometry` and the geometry.

    Raises
    ------
    ValueError
        If it is not of that form.
    """
    name, _, numbers = text.rpartition("=")
    try:
        height, end, angle = (float(number) for number in numbers.split(","))
    except ValueError as error:
        raise ValueError(f"'{text}': expected [FILE=]H1_km,H2_km,ANGLE_deg, for example 100,0,160") from error
    if not 0 <= angle <= 180 or height < 0 or end < 0:
        raise ValueError(
            f"'{text}': allowed H1_km, H2_km >= 0 and 0 <= ANGLE_deg <= 180 (above 90: downwards)"
        )
    return name or "*", Geometry(height * 1e3, end * 1e3, angle)


def detect_format(path: Path) -> str:
    """Tell the format from the name's ending and the first lines.

    Raises
    ------
    CatalogError
        If the file is none of the known ones.
    """
    suffix = path.suffix.lower()
    try:
        with path.open("rb") as stream:
            head = stream.read(100_000)
    except OSError as error:
        raise CatalogError(f"{path}: cannot be read: {error}") from error
    if head[:4] in (b"\x89HDF", b"CDF\x01", b"CDF\x02"):
        raise CatalogError(f"{path}: is NetCDF; an atmosphere table needs no import")
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
        If the format is unknown or the file is malformed; with the line.
    """
    options = options or ReadOptions()
    if options.format == "auto":
        chosen = "libradtran" if options.settings else detect_format(path)
    elif options.format in FORMATS:
        chosen = options.format
    else:
        raise CatalogError(f"no format '{options.format}'; {choose_from(options.format, ('auto', *FORMATS))}")
    given = options.geometry.get(path.name, options.geometry.get("*"))
    if chosen == "modtran6-csv":
        return read_modtran6_csv(path, given)
    if chosen == "libradtran":
        return read_libradtran(path, read_settings([*_input_file(path), *options.settings]))
    found = read_tape7(path) if chosen == "modtran-tape7" else read_modtran6_json(path)
    # What a user says explicitly holds over what a header says.
    return [replace(each, geometry=given) for each in found] if given else found


def _input_file(path: Path) -> list[str]:
    beside = path.with_suffix(".inp")
    return beside.read_text(encoding="utf-8", errors="replace").splitlines() if beside.is_file() else []
