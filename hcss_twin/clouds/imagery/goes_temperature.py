"""Brightness temperature of GOES ABI radiances, with the coefficients that their files carry."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.imagery.netcdf_image import quiet
from hcss_twin.errors import CatalogError

UNITS = "mW m-2 sr-1 (cm-1)-1"
"""Of the radiances that the coefficients belong to."""

_NAMES = ("planck_fk1", "planck_fk2", "planck_bc1", "planck_bc2")


@dataclass(frozen=True)
class PlanckCoefficients:
    """Coefficients of T = [fk2 / ln(fk1 / L + 1) - bc1] / bc2.

    GOES-R Product Definition and Users' Guide, volume 3, emissive bands of level 1b; L in mW m-2 sr-1 (cm-1)-1, T in K.
    """

    fk1: float
    fk2: float
    bc1: float
    bc2: float

    def kelvin(self, radiance: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return brightness temperatures; NaN where radiance is missing or not positive."""
        known = radiance > 0.0
        safe = np.where(known, radiance, 1.0)
        temperature = (self.fk2 / np.log(self.fk1 / safe + 1.0) - self.bc1) / self.bc2
        return np.where(known, temperature, np.nan)


def planck_coefficients(path: Path) -> PlanckCoefficients | None:
    """Return the coefficients of a NetCDF file; None where it has none, or for another kind of file.

    Raises
    ------
    CatalogError
        If the file cannot be read.
    """
    import netCDF4

    with path.open("rb") as file:
        if not file.read(4).startswith((b"\x89HDF", b"CDF")):
            return None
    try:
        with quiet(), netCDF4.Dataset(path) as dataset:
            if not all(name in dataset.variables for name in _NAMES):
                return None
            found = [_number(dataset.variables[name]) for name in _NAMES]
    except (OSError, RuntimeError) as error:
        raise CatalogError(f"{path}: not a NetCDF file that can be read: {error}") from error
    return PlanckCoefficients(*found) if np.all(np.isfinite(found)) else None


def _number(variable: Any) -> float:
    """Return a scalar, NaN where it is missing, as in files of reflected sunlight."""
    return float(np.ma.filled(np.ma.asarray(variable[...]).astype(np.float64), np.nan).ravel()[0])
