"""Table III: shape parameters and heights of the cloud types, which are inputs."""

from __future__ import annotations

from hcss_twin.core.catalog import Catalog
from hcss_twin.paper.item import Check, Reproduction, Row
from hcss_twin.paper.published import published
from hcss_twin.paper.verdict import judged


def table_3(seed: int) -> Reproduction:
    """Return the printed parameters beside those of the catalog's cloud types."""
    del seed  # nothing is drawn
    catalog = Catalog()
    rows = []
    for name, printed in published()["table_3"]["rows"].items():
        gamma, hurst, cells, octaves, heights_km = printed
        kept = catalog.toml(catalog.find(name.lower(), "cloud_types", ".toml"))
        shape, layer = kept["fractal"], kept["layer"]
        rows += [
            Row(f"{name}, gamma", "1", gamma, float(shape["gamma"])),
            Row(f"{name}, H", "1", hurst, float(shape["H"])),
            Row(f"{name}, L along x", "1", cells[0], float(shape["L"][0])),
            Row(f"{name}, L along y", "1", cells[1], float(shape["L"][1])),
            Row(f"{name}, first k", "1", octaves[0], float(shape["k"][0])),
            Row(f"{name}, last k", "1", octaves[1], float(shape["k"][1])),
            Row(f"{name}, base", "km", heights_km[0], 1e-3 * float(layer["base"])),
            Row(f"{name}, top", "km", heights_km[1], 1e-3 * float(layer["top"])),
        ]
    largest = max(abs(row.difference or 0.0) for row in rows)
    return judged(
        rows,
        [Check(f"cloud types of the catalog: largest difference {largest:.1g}, at most 1e-12", largest <= 1e-12)],
        holds="These are inputs, and the catalog's cloud types have them.",
        fails="A cloud type of the catalog differs from the table.",
        notes=(
            "L, the interpolation resolution, is ambiguous in print. It is read as lattice cells per 16 km, which "
            "gives the density of Table VIII; pixels per cell does not.",
            "The paper shows stratocumulus (Fig 10) without a row here; the catalog's has published measurements "
            "instead.",
        ),
    )
