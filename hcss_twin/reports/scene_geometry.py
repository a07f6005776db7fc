"""Scene geometry of a cube: a side view with true zenith angles, a compass with true bearings, and a description."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.errors import HcssError
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.reports.page import Block, Markup, beside, element, facts, joined
from hcss_twin.reports.provenance import json_attribute

if TYPE_CHECKING:
    import xarray as xr


_SUN, _SENSOR, _CLOUD, _SEA, _SOFT, _MOTION = "#b86e00", "#0b5c97", "#8795a3", "#2a6f97", "#5b6875", "#3d7a37"
_BOX = 'viewBox="0 0 460 320" role="img" font-family="system-ui, sans-serif" font-size="14" class="scene"'

Layers = list[tuple[str, float | None, float | None]]
Place2 = tuple[float, float]


@dataclass(frozen=True)
class SceneGeometry:
    """Angles of a scene, degrees; bearings from the surface point, clockwise from north.

    Attributes
    ----------
    view_zenith, view_azimuth : float
    sun_zenith, sun_azimuth : tuple of float
        In the first and the last frame.
    layers : list of (name, base, top)
        Cloud layers from the lowest; altitudes in m, None where the cube does not state them.
    sensor_altitude_m : float or None
    wind_from : float or None
        Bearing from which the wind that carries the clouds blows.
    footprint_moves_m : float
        Eastward displacement from the first frame to the last, m.
    """

    view_zenith: float
    view_azimuth: float
    sun_zenith: tuple[float, float]
    sun_azimuth: tuple[float, float]
    layers: Layers
    sensor_altitude_m: float | None
    wind_from: float | None
    footprint_moves_m: float


def geometry_of(dataset: xr.Dataset) -> SceneGeometry | None:
    """Return the angles of a cube, or None if it lacks them."""
    names = ("sensor_zenith_angle", "sensor_azimuth_angle", "solar_zenith_angle", "solar_azimuth_angle")
    if any(name not in dataset.coords for name in names):
        return None
    zenith, azimuth, sun_zenith, sun_azimuth = (np.atleast_1d(dataset[name].to_numpy()) for name in names)
    motion = _scenario_section(dataset, "motion")
    displacement = np.atleast_1d(dataset["centre_displacement"]) if "centre_displacement" in dataset.coords else [0]
    return SceneGeometry(
        float(zenith[0]),
        float(azimuth[0]),
        (float(sun_zenith[0]), float(sun_zenith[-1])),
        (float(sun_azimuth[0]), float(sun_azimuth[-1])),
        layers_of(dataset),
        float(dataset["sensor_altitude"]) if "sensor_altitude" in dataset.coords else None,
        float(motion["wind_from"]) if motion.get("wind_speed") and "wind_from" in motion else None,
        float(displacement[-1] - displacement[0]),
    )


def _scenario_section(dataset: xr.Dataset, name: str) -> Mapping[str, Any]:
    section = json_attribute(dataset.attrs, SCENARIO_ATTRIBUTE, {}).get(name)
    return section if isinstance(section, dict) else {}


def layers_of(dataset: xr.Dataset) -> Layers:
    """Return name, base and top of the cloud layers, from the lowest.

    Altitudes come from the cube, its scenario, or a catalog cloud type whose file still has the recorded hash.
    """
    if "layer_base" in dataset.coords:
        names, bases, tops = (dataset[name].to_numpy() for name in ("layer", "layer_base", "layer_top"))
        return [(str(name), float(base), float(top)) for name, base, top in zip(names, bases, tops, strict=True)]
    hashes = json_attribute(dataset.attrs, "hcss_files_sha256", {})
    layers: Layers = []
    for section in _scenario_section(dataset, "clouds").get("layers") or []:
        base, top = section.get("base"), section.get("top")
        if base is None or top is None:
            of_type = _type_altitudes(str(section.get("type")), hashes)
            base, top = (of_type[0] if base is None else base, of_type[1] if top is None else top)
        layers.append((str(section.get("type")), base, top))
    return sorted(layers, key=lambda layer: np.inf if layer[1] is None else layer[1])


def _type_altitudes(name: str, hashes: Mapping[str, str]) -> tuple[float | None, float | None]:
    from hcss_twin.core.catalog import Catalog
    from hcss_twin.scenario.cloud_types import load_cloud_type

    catalog = Catalog()
    try:
        usual = load_cloud_type(name, catalog).layer
    except HcssError:
        return None, None
    same = all(hashes.get(file) == sha256 for file, sha256 in catalog.used.items())
    return (usual.base, usual.top) if same else (None, None)


def scene_blocks(dataset: xr.Dataset) -> Iterator[Block]:
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
        yield beside(
            element("figure", side_view(scene), element("figcaption", caption)),
            element("figure", plan_view(scene), element("figcaption", plan)),
        )
    yield facts(_facts(dataset, scene))


def side_view(scene: SceneGeometry) -> Markup:
    """Return a drawing of sea, clouds, line of sight and sun with true zenith angles; altitudes are not to scale.

    The sensor is on the right; so is the sun where the two bearings differ by less than 90 degrees.
    """
    target = (230.0, 250.0)
    sea = target[1]
    zenith = scene.sun_zenith[0]
    same_side = scene.view_zenith == 0.0 or abs(_difference(scene.sun_azimuth[0], scene.view_azimuth)) < 90.0
    parts = [
        _shape("rect", x=0, y=sea, width=460, height=70, fill="#dcebf5"),
        _line((0, sea), (460, sea), _SEA, 2),
        _text((8, sea + 60), "sea", _SEA),
        *_clouds(scene.layers, sea),
        _line(target, (target[0], 22), _SOFT, 1, dash="3 4"),
        _text((target[0], 16), "zenith", _SOFT, "middle"),
        *_ray(target, scene.view_zenith, 195.0, _SENSOR, "sensor", "view-ray"),
        *_ray(target, zenith, 160.0 if zenith < 90.0 else 60.0, _SUN, "sun", "sun-ray", same_side),
    ]
    return _drawing(f"side view: view {scene.view_zenith:g}° and sun {zenith:g}° from the zenith", parts)


def _clouds(layers: Layers, sea: float) -> Iterator[Markup]:
    highest = max((top for _, _, top in layers if top is not None), default=0.0)
    for number, (name, base, top) in enumerate(layers):
        if base is None or top is None or highest <= 0.0:
            low, high = 40.0 + 55.0 * number, 65.0 + 55.0 * number
            label = f"{name}, altitude unknown"
        else:
            low, high = (18.0 + 112.0 * altitude_m / highest for altitude_m in (base, top))
            label = f"{name} {base:g} to {top:g} m"
        height = max(high - low, 5.0)
        yield _shape("rect", x=0, y=sea - high, width=460, height=height, fill=_CLOUD, fill_opacity=0.35, rx=4)
        yield _text((8, sea - high + min(height, 30.0) / 2 + 5), label, "#3c4a57")


def _ray(
    target: Place2, zenith: float, length: float, colour: str, name: str, key: str, to_the_right: bool = True
) -> list[Markup]:
    """Return a line at an angle from the zenith, labelled at the far end; the sun's arrow starts there."""
    side = 1.0 if to_the_right else -1.0
    end = _at(target, length, side * zenith)
    dash = None if zenith < 90.0 else "4 4"
    if name == "sun":
        disc = _shape("circle", cx=end[0], cy=end[1], r=9, fill="#f2b33d", stroke=colour)
        parts = [*_arrow(end, target, colour, key, dash), disc]
    else:
        parts = _arrow(target, end, colour, key, dash)
    # keep the label within the drawing, next to the end of the line
    anchor, x, y = "start" if to_the_right else "end", end[0] + side * 14, end[1] + 5
    if x > 350 if to_the_right else x < 110:
        anchor, x, y = ("end", 456.0, end[1] - 14) if to_the_right else ("start", 4.0, end[1] - 14)
    return [*parts, _text((x, y), f"{name} {zenith:.2f}°", colour, anchor)]


def plan_view(scene: SceneGeometry) -> Markup:
    """Return a compass with the bearings of sensor and sun and the motion of wind and footprint, north at the top."""
    centre, radius = (230.0, 160.0), 118.0
    parts = [_shape("circle", cx=centre[0], cy=centre[1], r=radius, fill="#f4f7fa", stroke=_SOFT, stroke_width=1.2)]
    for bearing in range(0, 360, 30):
        tick = 9 if bearing % 90 == 0 else 5
        parts.append(_line(_at(centre, radius - tick, bearing), _at(centre, radius, bearing), _SOFT, 1))
    for name, bearing in (("N", 0), ("E", 90), ("S", 180), ("W", 270)):
        x, y = _at(centre, radius - 20, bearing)
        parts.append(_text((x, y + 5), name, _SOFT, "middle"))
    if scene.wind_from is not None:
        start, end = (_at((52, 262), length, scene.wind_from) for length in (20, -20))
        parts += [*_arrow(start, end, _SOFT, "wind", dash="5 3"), _text((52, 304), "wind", _SOFT, "middle")]
    if scene.footprint_moves_m:
        half = math.copysign(22.5, scene.footprint_moves_m)
        parts += _arrow((402 - half, 280), (402 + half, 280), _MOTION, "footprint")
        parts.append(_text((402, 304), "footprint", _MOTION, "middle"))
    parts += _bearing(centre, radius, scene.sun_azimuth[0], _SUN, "sun", "sun-bearing")
    if _difference(*scene.sun_azimuth):
        first, last = (_at(centre, radius + 5, azimuth) for azimuth in scene.sun_azimuth)
        clockwise = int(_difference(scene.sun_azimuth[1], scene.sun_azimuth[0]) > 0)
        size = f"{radius + 5:g} {radius + 5:g}"
        arc = f"M{first[0]:.2f} {first[1]:.2f} A{size} 0 0 {clockwise} {last[0]:.2f} {last[1]:.2f}"
        parts.append(_shape("path", d=arc, fill="none", stroke=_SUN, stroke_width=3))
    if scene.view_zenith > 0.0:
        parts += _bearing(centre, radius, scene.view_azimuth, _SENSOR, "sensor", "view-bearing")
    else:
        parts.append(_text((centre[0], centre[1] - 8), "sensor overhead", _SENSOR, "middle"))
    parts.append(_shape("circle", cx=centre[0], cy=centre[1], r=3.5, fill="#1c2733"))
    words = f"sensor at bearing {scene.view_azimuth:g}°, sun at {scene.sun_azimuth[0]:g}°"
    return _drawing(f"plan view: {words}", parts)


def _bearing(centre: Place2, radius: float, bearing: float, colour: str, name: str, key: str) -> list[Markup]:
    x, y = _at(centre, radius + 14, bearing)
    side = math.sin(math.radians(bearing))
    anchor = "start" if side > 0.25 else "end" if side < -0.25 else "middle"
    label = _text((x, y + 5), f"{name} {bearing % 360.0:.2f}°", colour, anchor)
    return [*_arrow(centre, _at(centre, radius, bearing), colour, key), label]


def _difference(bearing: float, other: float) -> float:
    """Difference of two bearings, -180 to 180 degrees."""
    return (bearing - other + 180.0) % 360.0 - 180.0


def _at(start: Place2, length: float, angle: float) -> Place2:
    """Return the point at a distance and an angle from upward, degrees clockwise."""
    return start[0] + length * math.sin(math.radians(angle)), start[1] - length * math.cos(math.radians(angle))


def _arrow(start: Place2, end: Place2, colour: str, key: str, dash: str | None = None) -> list[Markup]:
    away = math.atan2(end[1] - start[1], end[0] - start[0])
    barbs = ((end[0] - 10 * math.cos(away + turn), end[1] - 10 * math.sin(away + turn)) for turn in (-0.4, 0.4))
    corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in (end, *barbs))
    return [_line(start, end, colour, 2.2, dash, key), _shape("polygon", points=corners, fill=colour)]


def _line(
    start: Place2, end: Place2, colour: str, width: float, dash: str | None = None, key: str | None = None
) -> Markup:
    ends = {
        f"{axis}{number}": f"{at:.3f}" for number, p in ((1, start), (2, end)) for axis, at in zip("xy", p, strict=True)
    }
    return element("line", **ends, stroke=colour, stroke_width=f"{width:g}", stroke_dasharray=dash, class_=key)


def _text(point: Place2, text: str, colour: str, anchor: str = "start") -> Markup:
    # a white outline keeps the text readable on lines
    halo = {"stroke": "#fff", "stroke_width": "3", "paint_order": "stroke", "stroke_linejoin": "round"}
    return element("text", text, x=f"{point[0]:.1f}", y=f"{point[1]:.1f}", fill=colour, text_anchor=anchor, **halo)


def _shape(name: str, **attributes: float | str) -> Markup:
    return element(
        name, **{key: value if isinstance(value, str) else f"{value:g}" for key, value in attributes.items()}
    )


def _drawing(title: str, parts: Sequence[Markup]) -> Markup:
    return Markup(f"<svg {_BOX}>{element('title', title)}{joined(parts)}</svg>")


def _facts(dataset: xr.Dataset, scene: SceneGeometry | None) -> Iterator[tuple[str, str]]:
    attributes, sizes, coords = dataset.attrs, dataset.sizes, dataset.coords
    if "time_coverage_start" in attributes:
        yield "time", f"{attributes['time_coverage_start']} to {attributes.get('time_coverage_end', '?')}"
    count, interval = sizes.get("time", 0), attributes.get("time_coverage_resolution")
    yield "frames", f"{count}, {interval} apart" if count > 1 and interval is not None else str(count)
    if {"latitude", "longitude"} <= set(coords):
        yield "place", f"{float(dataset['latitude']):.5g}° N, {float(dataset['longitude']):.6g}° E"
    if {"y", "x"} <= set(sizes):
        size = f" of {float(dataset['x'][1] - dataset['x'][0]):g} m" if sizes["x"] > 1 else ""
        yield "image", f"{sizes['y']} rows x {sizes['x']} columns{size}"
    window = json_attribute(attributes, "hcss_window", {})
    if window:
        yield "window", ", ".join(f"{key} {value}" for key, value in window.items())
    if scene is not None:
        yield "view", f"zenith {scene.view_zenith:.4g}°, bearing {scene.view_azimuth:.5g}°"
        if scene.sensor_altitude_m is not None:
            yield "sensor", f"{scene.sensor_altitude_m / 1e3:.6g} km above the ellipsoid"
        yield "sun", f"zenith {_span(scene.sun_zenith)}°, bearing {_span(scene.sun_azimuth)}°"
        relative = abs(_difference(scene.view_azimuth, scene.sun_azimuth[0]))
        yield "relative azimuth", f"{relative:.4g}° (0: sensor on the sun's side)"
    if "wavelength_bounds" in coords:
        bands = zip(dataset["band"].to_numpy(), dataset["wavelength_bounds"].to_numpy(), strict=True)
        yield "bands", ", ".join(f"{name} {low:g} to {high:g} µm" for name, (low, high) in bands)
    for particle in json_attribute(attributes, "hcss_particles", []):
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
