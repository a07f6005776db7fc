"""Table X: what the method is said to offer, as statements about this package."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.paper.cloud_images import cloud_field
from hcss_twin.paper.item import Check, Reproduction
from hcss_twin.paper.published import published
from hcss_twin.paper.scene import BANDS, columns_over_views, scene
from hcss_twin.paper.verdict import judged

_CLOUD_TYPES = 4
_BANDS = 3


def table_10(seed: int) -> Reproduction:
    """Return the claims of the column "Proposed Method", each put to a test that can fail."""
    return judged(
        [],
        [_mirrors(), _makes_images(seed), _needs_no_data(), _has_terms(), _applies_widely()],
        holds="The table compares features and has no numbers. What it claims for the paper's method holds for "
        "this package.",
        fails="A feature that the table claims is missing here.",
        notes=("The columns about MODTRAN and deep learning are no statements about this package.",),
    )


def _mirrors() -> Check:
    band = list(BANDS).index("3.0-5.0")
    views = published()["view_zenith_deg"]
    day = columns_over_views("as-printed").clear[:, band]
    night = columns_over_views("as-printed", sunlit=False).clear[:, band]
    peak = views[int(np.argmax(day - night))]
    holds = bool(20 <= peak <= 30 and np.argmax(day) > 0 and np.argmax(night) == 0)
    return Check(
        f"specular reflection: the glint in 3-5 um is brightest at {peak} deg, near the sun's 24.4 deg; without sun "
        "the sea is brightest from above",
        holds,
    )


def _makes_images(seed: int) -> Check:
    field = cloud_field("simulated", seed)
    rows, columns = field.shape
    varied = np.unique(field).size
    return Check(
        f"image generation: {rows} x {columns} pixels, {varied} different values", varied > rows * columns // 2
    )


def _needs_no_data() -> Check:
    used = scene("as-printed", 0.0, (BANDS["3.0-5.0"],)).catalog.used
    own = [name for name in used if Path(name).is_absolute()]
    return Check(
        f"data dependency: the scene is made from {len(used)} files, all of the catalog, no image among them",
        bool(used) and not own and not any(name.endswith((".png", ".tif", ".npy")) for name in used),
    )


def _has_terms() -> Check:
    plan = scene("physical", 20.0, tuple(BANDS.values()))
    sunlight = plan.assembly.model.clear(plan.spectral_grid.wavenumber_cm1, None)
    dark = all(not np.any(sunlight[name]) for name in plan.assembly.model.solar_terms)
    return Check(
        f"physical interpretability: radiance comes in {len(plan.assembly.model.terms)} named terms, and the "
        f"{len(plan.assembly.model.solar_terms)} of sunlight are 0 without sun",
        dark and len(plan.assembly.model.terms) > 1,
    )


def _applies_widely() -> Check:
    catalog = Catalog()
    types = len(catalog.names("cloud_types", ".toml"))
    airs = len(catalog.names("atmospheres", ".csv"))
    bands = len(catalog.toml(catalog.find("bands", "", ".toml"))["bands"])
    return Check(
        f"applicability: {types} cloud types, {airs} model atmospheres and {bands} bands by name; the paper has "
        f"{_CLOUD_TYPES}, 1 and {_BANDS}",
        types >= _CLOUD_TYPES and airs > 1 and bands >= _BANDS,
    )
