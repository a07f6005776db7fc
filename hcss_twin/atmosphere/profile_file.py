"""Reader of profiles: CSV files with pressure, temperature and gases at levels."""

from __future__ import annotations

import numpy as np

from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError
from hcss_twin.physics.profile import Profile

GASES = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")


def load_profile(name: str, catalog: Catalog) -> Profile:
    """Read a profile by catalog name or from a user's CSV file.

    Columns ``altitude_m``, ``pressure_Pa``, ``temperature_K`` are required; columns named after a gas
    (``h2o``, ``co2``, ``o3``, ...) hold its volume mixing ratio.

    Raises
    ------
    CatalogError
        If a column is missing, altitudes do not ascend from 0, or a value is not physical.
    """
    path = catalog.find(name, "atmospheres", ".csv")
    columns = catalog.columns(path)
    for required in ("altitude_m", "pressure_Pa", "temperature_K"):
        if required not in columns:
            raise CatalogError(f"{path.name}: column '{required}' is missing; found {', '.join(columns)}")
    altitude, pressure, temperature = (
        columns["altitude_m"],
        columns["pressure_Pa"],
        columns["temperature_K"],
    )
    if altitude.size < 2 or altitude[0] != 0.0 or np.any(np.diff(altitude) <= 0):
        raise CatalogError(f"{path.name}: altitude_m must ascend from 0 over at least two levels")
    if np.any(pressure <= 0) or np.any(np.diff(pressure) >= 0):
        raise CatalogError(f"{path.name}: pressure_Pa must be positive and fall with altitude")
    if np.any(temperature < 100) or np.any(temperature > 1500):
        raise CatalogError(f"{path.name}: temperature_K must lie in 100..1500")
    gases = {gas: columns[gas] for gas in GASES if gas in columns}
    if any(np.any(ratio < 0) or np.any(ratio > 1) for ratio in gases.values()):
        raise CatalogError(f"{path.name}: mixing ratios must lie in 0..1")
    return Profile(name, altitude, pressure, temperature, gases)
