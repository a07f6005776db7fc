"""Files of tabulated bulk properties: those that ship, and those that a run keeps for the next one."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError
from hcss_twin.netcdf_format import open_format
from hcss_twin.optics.bulk_table import BulkTable

FORMAT, VERSION = "hcss-bulk-optics", 1

_GROUPS = (("properties", "f8"), ("moments", "f4"))
"""Parts of a table and how precisely they are kept; single precision is 6e-8 of a moment."""


def key_of(path: Path) -> str:
    """Key of the table in a file.

    Raises
    ------
    CatalogError
        If it is no file of this format.
    """
    with open_format(path, FORMAT, VERSION) as dataset:
        return str(getattr(dataset, "key", ""))


def read_into(table: BulkTable, path: Path) -> None:
    """Take over the values of a file where ``table`` has none.

    Raises
    ------
    CatalogError
        If the file is damaged (every block carries a checksum), of another table, or of another format.
    """
    found = {}
    with open_format(path, FORMAT, VERSION) as dataset:
        if getattr(dataset, "key", None) != table.key:
            raise CatalogError(f"{path}: holds another table than {table.key[:12]}")
        try:
            for name, _ in _GROUPS:
                dataset[name].set_auto_mask(False)
                found[name] = np.asarray(dataset[name][:], dtype=np.float64)
        except (IndexError, OSError, RuntimeError) as error:
            raise CatalogError(f"{path}: damaged: {error}") from error
    for name, values in found.items():
        part = getattr(table, name)
        if values.shape != part.values.shape:
            raise CatalogError(f"{path}: {name} has shape {values.shape}; allowed {part.values.shape}")
        part.adopt(values)


def write(table: BulkTable, path: Path, **attributes: str) -> None:
    """Write a table; the file appears when it is complete and replaces an older one in one step.

    Raises
    ------
    CatalogError
        If the system refuses.
    """
    import netCDF4

    with draft_of(path, CatalogError) as draft, netCDF4.Dataset(draft, "w") as dataset:
        dataset.format, dataset.format_version, dataset.key = FORMAT, VERSION, table.key
        dataset.setncatts(attributes)
        for name, kind in _GROUPS:
            _write_part(dataset, name, kind, getattr(table, name))


def _write_part(dataset: Any, name: str, kind: str, part: Any) -> None:
    components, nodes = part.values.shape
    dataset.createDimension(f"{name}_component", components)
    dataset.createDimension(f"{name}_node", nodes)
    # least_significant_digit would be smaller still, but the values then differ from those computed on demand.
    variable = dataset.createVariable(
        name,
        kind,
        (f"{name}_component", f"{name}_node"),
        zlib=True,
        complevel=6,
        shuffle=True,
        fletcher32=True,
    )
    variable.long_name = {
        "properties": "ln of extinction and absorption cross section per particle (m2), asymmetry parameter",
        "moments": "Legendre moments of the phase function",
    }[name]
    variable[:] = part.values
    position = dataset.createVariable(
        f"{name}_wavelength", "f8", (f"{name}_node",), zlib=True, fletcher32=True
    )
    position.units = "um"
    position[:] = np.exp(part.nodes)


def write_if_possible(table: BulkTable, path: Path) -> bool:
    """Keep a table for the next run, together with what another run has put there in the meantime.

    Nobody depends on the file: where it cannot be written (a full or read-only disk), the next run computes again.
    """
    with suppress(CatalogError, OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with suppress(CatalogError):
            read_into(table, path)
        write(table, path)
        return True
    return False
