"""What a cube was made from: scenario, providers, versions, hashes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.cube.zarr_writer import cube_bytes
from hcss_twin.report.cube_report.scene import json_attribute
from hcss_twin.report.page.page import Markup, bullets, facts, folded, preformatted, table

if TYPE_CHECKING:
    import xarray as xr


_TOLD_APART = ("hcss_", "geospatial_", "time_coverage_")


def sensor(dataset: xr.Dataset) -> Iterator[Markup]:
    """Yield what the sensor of a measured cube is."""
    about = json_attribute(dataset, SENSOR_ATTRIBUTE, {})
    pairs = [(str(key).replace("_", " "), _told(value)) for key, value in about.items() if value not in (None, "", [])]
    if "clean_cube" in dataset.attrs:
        pairs.append(("clean cube", str(dataset.attrs["clean_cube"])))
    yield facts(pairs)


def _told(value: object) -> str:
    """Write what a sensor says of itself; what it does not have is left out."""
    if isinstance(value, dict):
        return bullets(
            f"{str(key).replace('_', ' ')}: {_plain(each)}" for key, each in value.items() if each is not None
        )
    return _plain(value)


def _plain(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{str(key).replace('_', ' ')} {_plain(each)}" for key, each in value.items())
    if isinstance(value, list):
        return "; ".join(_plain(each) for each in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def provenance(dataset: xr.Dataset, path: Path) -> Iterator[Markup]:
    """Yield where a cube comes from, so that it can be made again."""
    attributes = dataset.attrs
    pairs = [("file", f"{path.name}, {cube_bytes(path) / 1e6:.1f} MB")]
    for name, key in (("identifier", "id"), ("written", "date_created"), ("seed", "hcss_seed")):
        if key in attributes:
            pairs.append((name, str(attributes[key])))
    versions = json_attribute(dataset, "hcss_versions", {})
    if versions:
        pairs.append(("versions", ", ".join(f"{name} {version}" for name, version in versions.items())))
    yield facts(pairs)
    yield from origin(dataset)
    others = [
        (str(key), str(value))
        for key, value in attributes.items()
        if not str(key).startswith(_TOLD_APART) and value not in ("", "unknown")
    ]
    yield folded("All other global attributes", facts(others))


def origin(dataset: xr.Dataset) -> Iterator[Markup]:
    """Yield providers, hashes of the files read, and the scenario."""
    providers = json_attribute(dataset, "hcss_providers", {})
    if providers:
        rows = [
            [kind, *(str(each.get(key, "")) for key in ("name", "distribution", "version"))]
            for kind, each in providers.items()
        ]
        yield table(["kind", "provider", "distribution", "version"], rows, text_columns=4)
    hashes = json_attribute(dataset, "hcss_files_sha256", {})
    if hashes:
        rows = [[file, sha256] for file, sha256 in hashes.items()]
        yield folded("SHA-256 of the files that were read", table(["file", "SHA-256"], rows, text_columns=2))
    scenario = dataset.attrs.get(SCENARIO_ATTRIBUTE)
    if scenario is not None:
        yield folded(
            "The scenario with every default filled in (as a file NAME.json, hcss run makes the cube again)",
            preformatted(str(scenario)),
        )
