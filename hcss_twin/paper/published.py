"""The printed numbers, as the catalog has them.

What the paper states about its figures, in numbers.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.catalog import catalog_root


def published() -> dict[str, Any]:
    """Return the numbers of Tables I to IX and of the baseline geometry (catalogs/paper/hcss-tables.json)."""
    path = catalog_root() / "paper" / "hcss-tables.json"
    tables: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return tables


def printed_row(table: str, row: str, column: str = "Ours") -> NDArray[np.float64]:
    """Return one row of Table II or IV over the view zenith angles, (8,).

    Parameters
    ----------
    table : {"table_2", "table_4"}
    row : str
        ``"Scenario3"``, ``"3.0-5.0"``.
    column : {"Ours", "Modtran", "RE", "Ours/Modtran"}
    """
    return np.array(published()[table][row][column], dtype=np.float64)


CLOUD_HEIGHTS_KM = {"stratus": (0.033, 1.0), "cumulus": (0.066, 3.0), "cirrus": (6.0, 10.0), "simulated": (0.333, 6.0)}
"""Base and top by Table III."""
