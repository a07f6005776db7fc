"""A part of the shipped table of the atmosphere, for tests of tables with few nodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table import TableTransmittance
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.models.parameters import TableParameters
from hcss_twin.providers import AtmosphereInputs

WHOLE = AtmosphereTable.read(catalog_root() / "atmospheres" / "us-standard-1976-lowtran7.nc")
ROWS = slice(60, 180, 4)
"""Wavenumbers of the part."""

WAVENUMBER = WHOLE.wavenumber_cm1[ROWS]


def table_provider(file: Path | str) -> TableTransmittance:
    """Return the provider of a table, a file or a name of the catalog, in the air of the shipped one."""
    catalog = Catalog()
    inputs = AtmosphereInputs(load_profile("us-standard-1976", catalog), catalog)
    return TableTransmittance(inputs, TableParameters(file=str(file)))


def stored(height_m: float, zenith_deg: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return transmittance and radiance (V,) of one path of the shipped table."""
    at = list(WHOLE.target_altitude_m).index(height_m), list(WHOLE.zenith_deg).index(zenith_deg)
    return WHOLE.transmittance[at][ROWS], WHOLE.path_radiance[at][ROWS]
