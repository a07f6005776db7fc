"""Compiled tables of scenes, kept between runs under a name that says all they depend on."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from hcss_twin.cache.fingerprint import package_fingerprint, top_level
from hcss_twin.cache.kinds import TABLES
from hcss_twin.cache.records import read_record, write_record
from hcss_twin.cache.store import Store
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.radiance.spectral_nodes import SpectralNodes
from hcss_twin.registry.kinds import Kind
from hcss_twin.scene.budget import Budget
from hcss_twin.scene.compile import compile_tables
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.layer_pair import LayerPair
from hcss_twin.scene.tables.radiance_tables import (
    InstantTable,
    Quantities,
    RadianceTables,
    ShadowTables,
    WaveTables,
)
from hcss_twin.scene.tables.spectrum import Spectrum
from hcss_twin.scene.tables.thickness_axis import ThicknessAxis
from hcss_twin.scene.users_folder import of_the_same_folder, users_folder
from hcss_twin.version import __version__
from hcss_twin.versions import versions

_FORMAT = 2
"""Raised when what is written here changes its meaning."""

_INDEPENDENT = ("title", "seed", "image", "clouds", "output")
"""Sections of a scenario that tables do not depend on, but for what is taken from the plan."""


@dataclass(frozen=True)
class KeptTables:
    """Tables, and the files that were read to compute them beside those the plan had read.

    ``base`` is the folder of the scenario, if a user's files are among these.
    """

    tables: RadianceTables
    file_names: tuple[str, ...]
    file_sha256: tuple[str, ...]
    base: str = ""


_CLASSES: Mapping[str, type] = {
    each.__name__: each
    for each in (
        KeptTables,
        RadianceTables,
        Budget,
        Quantities,
        ThicknessAxis,
        LayerPair,
        InstantTable,
        ShadowTables,
        WaveTables,
        Spectrum,
        SpectralNodes,
    )
}


def tables_of(plan: Plan) -> RadianceTables:
    """Return the tables of a plan: those kept from an earlier run, or new ones, which are kept.

    They are the same to the bit. What an earlier run read is recorded again and must not have changed.
    """
    store, key = Store(*TABLES), table_key(plan)
    path = store.find(key)
    if path is not None:
        try:
            kept = read_record(path, _CLASSES)
            if isinstance(kept, KeptTables):
                own = of_the_same_folder(plan.catalog, kept.base)
                if own and plan.catalog.unchanged(dict(zip(kept.file_names, kept.file_sha256, strict=True))):
                    return kept.tables
        except Exception:  # whatever is wrong with the file, it is made again
            pass
        store.forget(key)
    before = plan.catalog.used
    tables = compile_tables(plan)
    read = {name: digest for name, digest in plan.catalog.used.items() if name not in before}
    new = KeptTables(tables, tuple(read), tuple(read.values()), users_folder(plan.catalog, read))
    store.keep(key, lambda draft: write_record(draft, new, _CLASSES))
    return tables


def table_key(plan: Plan) -> str:
    """Return a hash of everything the tables of a plan depend on."""
    scenario = json.loads(plan.scenario.to_json())
    # Most providers come from one package, whose many files are looked at once.
    fingerprint = cache(package_fingerprint)
    parts: dict[str, Any] = {
        "format": _FORMAT,
        "version": __version__,
        "libraries": versions(),
        "scenario": {name: value for name, value in scenario.items() if name not in _INDEPENDENT},
        "accuracy": plan.accuracy.relative,
        "files": dict(plan.catalog.used),
        "terms": [spec.name for spec in plan.variables if spec.name.startswith(TERM_PREFIX)],
        "sunlight": [plan.sun_matters, plan.faint_sunlight],
        "layers": [
            dataclasses.asdict(dataclasses.replace(layer, coverage=float(cloudy), edge_taper=0.0, name=""))
            for layer, cloudy in zip(plan.layers, plan.cloudy_layers, strict=True)
        ],
        "code": {
            kind: [
                entry.qualified_name,
                entry.version,
                fingerprint(top_level(entry.spec.target)),
            ]
            for kind, entry in plan.assembly.entries.items()
            if entry.kind is not Kind.CLOUDS
        },
        "engine": fingerprint(__name__.partition(".")[0]),
    }
    if plan.waves is not None or plan.slant.shadows:
        parts["image"] = scenario["image"]
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()
