"""What a plan found out, kept between runs."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping

from hcss_twin.core.cache import PLANS
from hcss_twin.core.catalog import Catalog
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.kept_results import KeptResults, key_of
from hcss_twin.plan.scene_analysis import SceneAnalysis
from hcss_twin.plan.views import ViewAxis
from hcss_twin.scenario.scenario import Scenario


def kept_findings(scenario: Scenario, assembly: Assembly, catalog: Catalog) -> SceneAnalysis | None:
    """Return what an earlier plan of the same scenario found; None if there is none, or a file has changed since."""
    return _results(catalog).find(_key(scenario, assembly, catalog.used))


def keep_findings(
    scenario: Scenario, assembly: Assembly, catalog: Catalog, before: Mapping[str, str], findings: SceneAnalysis
) -> None:
    """Keep what a plan found out.

    Parameters
    ----------
    before : mapping of str to str
        Files that were read before it was found out, with their hashes.
    """
    _results(catalog).keep(_key(scenario, assembly, before), findings, before)


def _results(catalog: Catalog) -> KeptResults[SceneAnalysis]:
    return KeptResults(PLANS, catalog, SceneAnalysis, (RequestedAccuracy, Omission, ViewAxis))


def _key(scenario: Scenario, assembly: Assembly, files: Mapping[str, str]) -> str:
    """Hash of everything that the findings depend on.

    They are about columns: where clouds are does not matter, but whether there are cloudy and clear columns at all.
    Waves that are drawn depend on the seed, but scenes with them keep nothing.
    """
    text = json.loads(scenario.to_json())
    for layer in text["clouds"]["layers"]:
        layer["coverage"] = "some" if 0.0 < layer["coverage"] < 1.0 else layer["coverage"]
        del layer["edge_taper"]
    parts = {
        "scenario": {name: value for name, value in text.items() if name not in ("title", "seed", "sensor")},
        "filled_in": [dataclasses.asdict(each) for each in assembly.filled_in],
        "files": dict(files),
    }
    return key_of(parts, assembly.code)
