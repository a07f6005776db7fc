"""The section of a page that shows the scene of a cube: drawings, and a description in words and numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from hcss_twin.reports.page import Markup
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.scene_drawings import plan_view, side_view
from hcss_twin.reports.scene_geometry import SceneGeometry, bearing_difference, geometry_of

if TYPE_CHECKING:
    import xarray as xr


def scene_blocks(dataset: xr.Dataset) -> Iterator[Markup.Block]:
    """Yield the drawings and the description of the scene."""
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
            plan += " The arc is the path of the sun from the first to the last frame."
        yield Markup.beside(
            Markup.element("figure", side_view(scene), Markup.element("figcaption", caption)),
            Markup.element("figure", plan_view(scene), Markup.element("figcaption", plan)),
        )
    yield Markup.facts(_facts(dataset, scene))


def _facts(dataset: xr.Dataset, scene: SceneGeometry | None) -> Iterator[tuple[str, str]]:
    attributes, sizes, coords = dataset.attrs, dataset.sizes, dataset.coords
    if "time_coverage_start" in attributes:
        yield "time", f"{attributes['time_coverage_start']} to {attributes.get('time_coverage_end', '?')}"
    count, interval = sizes.get("time", 0), attributes.get("time_coverage_resolution")
    yield "frames", f"{count}, {interval} apart" if count > 1 and interval is not None else str(count)
    if {"latitude", "longitude"} <= set(coords):
        yield "place", f"{float(dataset['latitude']):.5g}° N, {float(dataset['longitude']):.6g}° E"
    if {"y", "x"} <= set(sizes):
        on_ground = sizes["x"] > 1 and dataset["x"].attrs.get("units") == "m"
        size = f" of {float(dataset['x'][1] - dataset['x'][0]):g} m" if on_ground else ""
        yield "image", f"{sizes['y']} rows x {sizes['x']} columns{size}"
    window = Provenance.value(attributes, "hcss_window", {})
    if window:
        yield "window", ", ".join(f"{key} {value}" for key, value in window.items())
    if scene is not None:
        yield "view", f"zenith {scene.view_zenith:.4g}°, bearing {scene.view_azimuth:.5g}°"
        if scene.sensor_altitude_m is not None:
            yield "sensor", f"{scene.sensor_altitude_m / 1e3:.6g} km above the ellipsoid"
        yield "sun", f"zenith {_span(scene.sun_zenith)}°, bearing {_span(scene.sun_azimuth)}°"
        relative = abs(bearing_difference(scene.view_azimuth, scene.sun_azimuth[0]))
        yield "relative azimuth", f"{relative:.4g}° (0: sensor on the sun's side)"
    if "wavelength_bounds" in coords:
        bands = zip(dataset["band"].to_numpy(), dataset["wavelength_bounds"].to_numpy(), strict=True)
        yield "bands", ", ".join(f"{name} {low:g} to {high:g} µm" for name, (low, high) in bands)
    for particle in Provenance.value(attributes, "hcss_particles", []):
        content, extinction = (particle[key] for key in ("water_content_g_m3", "large_particle_extinction_m1"))
        yield (
            f"particles of {particle['name']}",
            f"{particle['material']}, effective radius {particle['effective_radius_um']:.4g} µm, water content "
            f"{content:.3g} g m⁻³, extinction {extinction:.3g} m⁻¹",
        )
    if "hcss_significant_wave_height_m" in attributes:
        yield "significant wave height", f"{float(attributes['hcss_significant_wave_height_m']):.3g} m"


def _span(values: tuple[float, float]) -> str:
    first, last = (f"{value:.3f}" for value in values)
    return first if first == last else f"{first} to {last}"
