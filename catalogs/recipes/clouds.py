"""Make the cloud entries in catalogs/clouds with the fractal generator of hcss_twin, at fixed seeds.

::

    python catalogs/recipes/clouds.py

The files are made by this project, not from satellite images. The two entries ``made-scene-...`` have the coverages of
the two satellite images of the HCSS paper (Table I).
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from hcss_evaluate.database.cloud_import import ImportOptions, import_image

from hcss_twin.models.clouds.coverage import cloud_fraction_value
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario

FOLDER = Path(__file__).parents[1] / "clouds"

ENTRIES = {
    "made-cirrus": ("cirrus", 0.35, 256, 50.0, 3),
    "made-cumulus": ("cumulus", 0.25, 256, 20.0, 4),
    "made-scene-30": ("simulated", 0.30, 400, 20.0, 1),
    "made-scene-47": ("simulated", 0.47, 400, 20.0, 2),
    "made-stratocumulus": ("stratocumulus", 0.60, 256, 50.0, 5),
    "made-stratus": ("stratus", 0.70, 256, 50.0, 6),
}
"""Cloud type, coverage, pixels along a side, pixel size in metres, seed."""


def make(name: str) -> None:
    """Write one entry."""
    kind, coverage, side, pixel_m, seed = ENTRIES[name]
    image = {"rows": side, "columns": side, "pixel_size": pixel_m}
    changes = {"clouds.type": kind, "seed": seed, "image": image, "output.variables": ["cloud_mask"]}
    generator: Any = make_plan(Scenario.load("stratus", changes)).assembly.generators[0]
    field = generator.field(0.0, slice(0, side), slice(0, side)).astype(np.float64)
    values = cloud_fraction_value(field)
    # Clear pixels have one value: a threshold is found for any coverage up to this one, and the file is small.
    values = np.maximum(values, np.quantile(values, 1.0 - coverage, method="higher") - 1e-9)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.npy"
        # Images have north in the first row, fields in the last.
        np.save(path, values[::-1].astype(np.float32))
        options = ImportOptions(
            method="coverage",
            coverage=coverage,
            cloud_is="bright",
            pixel_size_m=pixel_m,
            band="none: cloud fraction value of eq 5",
            source=f"hcss_twin, fractal clouds of type {kind}, seed {seed} (catalogs/recipes/clouds.py)",
            licence="BSD-3-Clause",
        )
        entry = import_image(path, options)
    # No time of writing, so that the file is the same each time.
    facts = replace(entry.facts, source_file="none", source_sha256="none", created="not stated")
    replace(entry, facts=facts).write(FOLDER / f"{name}{CloudEntry.SUFFIX}")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for each in ENTRIES:
        make(each)
        print(FOLDER / f"{each}{CloudEntry.SUFFIX}")
