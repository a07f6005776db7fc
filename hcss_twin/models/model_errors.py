"""Tables of how far our providers are from the best references known (``python benchmarks/model_errors.py``)."""

from __future__ import annotations

import csv
from pathlib import Path

from hcss_twin.providers.declarations import ModelError

TABLE = "model_errors.csv"
"""Name of the table in the folder of a provider."""

_SUNLIGHT = {"": None, "with": True, "without": False}


def from_table(module_file: str, provider: str) -> staticmethod[[], tuple[ModelError, ...]]:
    """Return the method ``model_errors`` of a provider that has its figures in the table beside its module.

    Parameters
    ----------
    module_file : str
        ``__file__`` of the module.
    provider : str
        Name in the table's first column.
    """

    def model_errors() -> tuple[ModelError, ...]:
        """Return how far the provider is from the best references known."""
        with (Path(module_file).parent / TABLE).open(encoding="utf-8", newline="") as file:
            return tuple(model_error(row) for row in csv.DictReader(file) if row["provider"] == provider)

    return staticmethod(model_errors)


def model_error(row: dict[str, str]) -> ModelError:
    """Convert a row of a table."""
    return ModelError(
        name=row["name"],
        lower_um=float(row["lower_um"]),
        upper_um=float(row["upper_um"]),
        relative=float(row["relative"]) if row["relative"] else None,
        kelvin=float(row["kelvin"]) if row["kelvin"] else None,
        statistic=row["statistic"],
        condition=row["condition"],
        source=row["source"],
        command=row["command"],
        path=row["path"],
        column=row["column"],
        sunlight=_SUNLIGHT[row["sunlight"]],
        zenith_deg=(float(row["zenith_low"]), float(row["zenith_high"])),
        needs=row["needs"],
    )
