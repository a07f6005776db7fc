"""Regenerate the tables of bulk optics ``optics/mie-*.nc`` and ``optics/bulk-*.nc``.

They hold what the optics providers would compute for the catalog's cloud types with their default parameters, over
0.3-16 um: our own computation, so that no Mie series is summed in a run. A table is found by its key, a hash of all
that it depends on; one whose refractive index or particles have changed is simply no longer found.

Run as ``python catalogs/recipes/bulk_optics.py [NAME ...]`` with hcss_twin importable; about 8 minutes for all.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from _table_file import CATALOGS

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import Accuracy, BulkTable
from hcss_twin.models.optics.table_store import write
from hcss_twin.models.parameters import BulkParameters, MieParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.scenario.cloud_types import load_cloud_type


@dataclass(frozen=True)
class Shipped:
    """One table: the type whose particles it has, the parameters, and whether moments are wanted."""

    cloud_type: str
    parameters: MieParameters
    has_moments: bool = True


MIE, BULK = MieParameters(), BulkParameters()

TABLES = {
    "mie-stratus": Shipped("stratus", MIE),  # stratocumulus has the same particles
    "mie-cumulus": Shipped("cumulus", MIE),  # and so has simulated
    "mie-cirrus": Shipped("cirrus", MIE),
    "bulk-stratus": Shipped("stratus", BULK),
    "bulk-cumulus": Shipped("cumulus", BULK),
    "bulk-cirrus": Shipped("cirrus", BULK, has_moments=False),  # crystals have a phase function of their own
}


def _quietly(pieces: Iterable[np.ndarray], total: int) -> Iterator[np.ndarray]:
    del total
    yield from pieces


def make(name: str) -> None:
    """Compute one table and write it over the catalog's."""
    shipped = TABLES[name]
    catalog = Catalog()
    cloud_type = load_cloud_type(shipped.cloud_type, catalog)
    phase, parameters = cloud_type.layer.material, shipped.parameters
    index_name = parameters.water_index if phase == "water" else parameters.ice_index
    accuracy = Accuracy(
        parameters.radius_nodes, parameters.spectral_step, parameters.moments_of(phase) if shipped.has_moments else 2
    )
    table = BulkTable(cloud_type.microphysics.particles(phase), load_refractive_index(catalog, index_name), accuracy)
    table.complete(table.properties.nodes, _quietly)
    write(
        table,
        CATALOGS / "optics" / f"{name}.nc",
        title=f"Bulk optics of the spheres of cloud type {shipped.cloud_type}, refractive index {index_name}",
        rights="own computation, as the project (BSD-3-Clause)",
        made_by="recipes/bulk_optics.py",
    )


if __name__ == "__main__":
    for each in sys.argv[1:] or TABLES:
        make(each)
