"""Columns on the reference path, kept between runs: a scene that is run again has the same pixels."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cache.kinds import REFERENCES
from hcss_twin.radiance.reference import reference_terms
from hcss_twin.scene.kept_results import KeptResults
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.kept_tables import table_key

Array = NDArray[np.float64]

COLUMNS_AT_ONCE = 32
"""Columns for which the model is asked together; its memory grows with them."""


@dataclass(frozen=True)
class KeptReference:
    """Terms (N, K, B) of columns."""

    terms: Array


def reference_of(plan: Plan, thickness_m: Array, time_s: float) -> Array:
    """Terms (N, K, B) of columns (N, L) at a time, computed at every wavenumber of the dense grid.

    What is kept goes by all that the tables of the plan depend on, by the columns and the time.

    Raises
    ------
    ProviderError
        If a provider breaks its contract.
    """
    digest = hashlib.sha256(table_key(plan).encode())
    digest.update(repr((float(time_s), thickness_m.shape)).encode())
    digest.update(np.ascontiguousarray(thickness_m).tobytes())
    results = KeptResults(REFERENCES, plan.catalog, KeptReference)
    key, before = digest.hexdigest(), plan.catalog.used
    kept = results.find(key)
    if kept is None:
        sun = plan.sun_up_at(time_s)
        kept = KeptReference(
            reference_terms(plan.model, plan.spectral_grid, thickness_m, sun, COLUMNS_AT_ONCE)
        )
        results.keep(key, kept, before)
    return kept.terms
