"""The scene of a cube: its geometry from coordinates and scenario, drawn and in words."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.errors import HcssError
from hcss_twin.reporting.cube_report.scene_drawing import Geometry, plan_view, side_view
from hcss_twin.reporting.page.blocks import beside, facts
from hcss_twin.reporting.page.markup import Markup, element

if TYPE_CHECKING:
    import xarray as xr

Layers = list[tuple[str, float | None, float | None]]


def scenario_of(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the scenario of a cube as plain values; empty where it carries none that is JSON."""
    try:
        found = json.loads(str(dataset.attrs.get(SCENARIO_ATTRIBUTE, "{}")))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def geometry_of(dataset: xr.Dataset) -> Geometry | None:
    """Return the angles of a cube, or None where it does not hold them."""
    names = ("sensor_zenith_angle", "sensor_azimuth_angle", "solar_zenith_angle", "solar_azimuth_angle")
    if any(name not in dataset.coords for name in names):
        return None
    zenith, azimuth, sun_zenith, sun_azimuth = (np.atleast_1d(dataset[name].to_numpy()) for name in names)
    motion = _section(scenario_of(dataset), "motion")
    displacement = (
        np.atleast_1d(dataset["centre_displacement"]) if "centre_displacement" in dataset.coords else [0]
    )
    return Geometry(
        float(zenith[0]),
        float(azimuth[0]),
        (float(sun_zenith[0]), float(sun_zenith[-1])),
        (float(sun_azimuth[0]), float(sun_azimuth[-1])),
        layers_of(dataset),
        float(dataset["sensor_altitude"]) if "sensor_altitude" in dataset.coords else None,
        float(motion["wind_from"]) if motion.get("wind_speed") and "wind_from" in motion else None,
        float(displacement[-1] - displacement[0]),
    )


def layers_of(dataset: xr.Dataset) -> Layers:
    """Return name, base and top of the cloud layers, from the lowest.

    Altitudes are those of the cube, of its scenario, or of a cloud type of the catalog that is still the file with the
    hash that the cube carries.
    """
    if "layer_base" in dataset.coords:
        return [
            (str(name), float(base), float(top))
            for name, base, top in zip(
                dataset["layer"].to_numpy(),
                dataset["layer_base"].to_numpy(),
                dataset["layer_top"].to_numpy(),
                strict=True,
            )
        ]
    sections = _section(scenario_of(dataset), "clouds").get("layers") or []
    hashes = json_attribute(dataset, "hcss_files_sha256", {})
    found: Layers = []
    for section in sections:
        base, top = section.get("base"), section.get("top")
        if base is None or top is None:
            of_type = _of_type(str(section.get("type")), hashes)
            base, top = (of_type[0] if base is None else base, of_type[1] if top is None else top)
        found.append((str(section.get("type")), base, top))
    return sorted(found, key=lambda each: np.inf if each[1] is None else each[1])


def _of_type(name: str, hashes: Mapping[str, str]) -> tuple[float | None, float | None]:
    from hcss_twin.catalog import Catalog
    from hcss_twin.scenario.cloud_types import load_cloud_type

    catalog = Catalog()
    try:
        usual = load_cloud_type(name, catalog).layer
    except HcssError:
        return None, None
    same = all(hashes.get(file) == sha256 for file, sha256 in catalog.used.items())
    return (usual.base, usual.top) if same else (None, None)


def scene_blocks(dataset: xr.Dataset) -> Iterator[Markup]:
    """Yield the drawings and the facts of the scene."""
    scene = geometry_of(dataset)
    if scene is not None:
        caption = (
            "Zenith angles are true; altitudes are not to scale with the distance of sensor and sun. The sun is on the "
            "sensor's side where their bearings differ by less than 90°."
        )
        if scene.sun_zenith[0] >= 90.0:
            caption += " The sun is below the horizon."
        plan = "Bearings from the surface point are true, north is up."
        if scene.sun_azimuth[0] != scene.sun_azimuth[1]:
            plan += " The arc is the way of the sun from the first to the last frame."
        yield beside(
            element("figure", side_view(scene), element("figcaption", caption)),
            element("figure", plan_view(scene), element("figcaption", plan)),
        )
    yield facts(_facts(dataset, scene))


def _facts(dataset: xr.Dataset, scene: Geometry | None) -> Iterator[tuple[str, str]]:
    attributes = dataset.attrs
    if "time_coverage_start" in attributes:
        yield "time", f"{attributes['time_coverage_start']} to {attributes.get('time_coverage_end', '?')}"
    count = dataset.sizes.get("time", 0)
    interval = (
        f", {attributes['time_coverage_resolution']} apart"
        if count > 1 and "time_coverage_resolution" in attributes
        else ""
    )
    yield "frames", f"{count}{interval}"
    if {"latitude", "longitude"} <= set(dataset.coords):
        yield "place", f"{float(dataset['latitude']):.5g}° N, {float(dataset['longitude']):.6g}° E"
    if {"y", "x"} <= set(dataset.sizes):
        size = f" of {float(dataset['x'][1] - dataset['x'][0]):g} m" if dataset.sizes["x"] > 1 else ""
        yield "image", f"{dataset.sizes['y']} rows x {dataset.sizes['x']} columns{size}"
    window = json_attribute(dataset, "hcss_window", {})
    if window:
        yield "window", ", ".join(f"{key} {value}" for key, value in window.items())
    if scene is not None:
        yield "view", f"zenith {scene.view_zenith:.4g}°, bearing {scene.view_azimuth:.5g}°"
        if scene.sensor_altitude_m is not None:
            yield "sensor", f"{scene.sensor_altitude_m / 1e3:.6g} km above the ellipsoid"
        yield "sun", f"zenith {_span(scene.sun_zenith)}°, bearing {_span(scene.sun_azimuth)}°"
        relative = abs((scene.view_azimuth - scene.sun_azimuth[0] + 180.0) % 360.0 - 180.0)
        yield "relative azimuth", f"{relative:.4g}° (0: sensor on the sun's side)"
    if "wavelength_bounds" in dataset.coords:
        bounds = dataset["wavelength_bounds"].to_numpy()
        names = dataset["band"].to_numpy()
        yield (
            "bands",
            ", ".join(
                f"{name} {low:g} to {high:g} µm" for name, (low, high) in zip(names, bounds, strict=True)
            ),
        )
    for particle in json_attribute(dataset, "hcss_particles", []):
        told = (
            f"{particle['phase']}, effective radius {particle['effective_radius_um']:.4g} µm, water content "
            f"{particle['water_content_g_m3']:.3g} g m⁻³, extinction {particle['large_particle_extinction_m1']:.3g} m⁻¹"
        )
        yield f"particles of {particle['name']}", told
    if "hcss_significant_wave_height_m" in attributes:
        yield "significant wave height", f"{float(attributes['hcss_significant_wave_height_m']):.3g} m"


def _span(values: tuple[float, float]) -> str:
    first, last = (f"{value:.3f}" for value in values)
    return first if first == last else f"{first} to {last}"


def _section(plain: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = plain.get(name)
    return found if isinstance(found, dict) else {}


def json_attribute(dataset: xr.Dataset, name: str, default: Any) -> Any:
    """Return a global attribute that holds JSON, or what stands for none where it is absent or no JSON."""
    try:
        return json.loads(str(dataset.attrs[name]))
    except (KeyError, ValueError):
        return default
