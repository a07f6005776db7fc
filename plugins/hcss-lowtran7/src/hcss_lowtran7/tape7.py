"""Reader of LOWTRAN7's listing TAPE7, for quantities that the driver does not return in full precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_lowtran7.deck import RADIANCE, SOLAR_IRRADIANCE, SOLAR_RADIANCE, TRANSMITTANCE

Array = NDArray[np.float64]

_WAVENUMBER = ("wavenumber_cm1", 7)
# Name and width of the columns, by IEMSCT (formats 907, 917, 927 and 937 of TRANS). Radiances are in
# W cm-2 sr-1 (cm-1)-1, irradiances in W cm-2 (cm-1)-1.
_COLUMNS: dict[int, tuple[tuple[str, int], ...]] = {
    TRANSMITTANCE: (
        _WAVENUMBER,
        *(
            (name, 8)
            for name in (
                "transmittance", "h2o", "uniform", "o3", "trace", "n2_continuum", "h2o_continuum",
                "molecular_scattering", "aerosol", "hno3", "aerosol_absorptance",
            )
        ),
    ),
    RADIANCE: (_WAVENUMBER, ("transmittance", 8), ("thermal", 9)),
    SOLAR_RADIANCE: (
        _WAVENUMBER,
        ("transmittance", 8),
        ("thermal", 9),
        ("scattered", 9),
        ("single_scattered", 9),
        ("ground_reflected", 9),
        ("ground_reflected_direct", 9),
        ("total", 9),
        ("sun_to_end_to_observer_transmittance", 8),
    ),
    SOLAR_IRRADIANCE: (_WAVENUMBER, ("transmittance", 8), ("transmitted", 9), ("solar", 9)),
}  # fmt: skip


def read_tape7(text: str, iemsct: int) -> dict[str, Array]:
    """Return the columns of the spectral table of one run.

    Parameters
    ----------
    text : str
        The file.
    iemsct : int
        What was computed (card 1), which fixes the columns.

    Returns
    -------
    dict of str to ndarray (V,)
        ``sun_to_end_to_observer_transmittance`` is that of the whole way from the sun to the end of the
        line of sight and on to the observer. Transmittances have four decimals, radiances three digits.

    Raises
    ------
    ValueError
        If there is no table, or a line of it cannot be read.
    """
    lines = text.splitlines()
    starts = [number for number, line in enumerate(lines) if line.startswith("  FREQ")]
    if not starts:
        raise ValueError("TAPE7 has no spectral table: LOWTRAN7 gave the path up")
    rows: list[list[float]] = []
    for number in range(starts[-1] + 1, len(lines)):
        if lines[number].startswith(" -9999."):
            break
        rows.append(_fields(lines[number], number + 1, _COLUMNS[iemsct]))
    table = np.array(rows, dtype=np.float64).T
    return {name: column for (name, _), column in zip(_COLUMNS[iemsct], table, strict=True)}


def _fields(line: str, number: int, columns: tuple[tuple[str, int], ...]) -> list[float]:
    values, start = [], 0
    for name, width in columns:
        field = line[start : start + width]
        start += width
        try:
            values.append(float(field))
        except ValueError as error:
            raise ValueError(f"TAPE7, line {number}: {name} is {field!r}; expected a number") from error
    return values
