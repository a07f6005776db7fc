"""Drawing of the scene's geometry: a side view with true zenith angles, and a compass with true bearings.

The scene of a cube: its geometry from coordinates and scenario, drawn and in words.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.errors import HcssError
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.report.page.page import Markup, beside, element, facts, joined

if TYPE_CHECKING:
    import xarray as xr


_SUN, _SENSOR, _CLOUD, _SEA, _SOFT = "#b86e00", "#0b5c97", "#8795a3", "#2a6f97", "#5b6875"

_LETTERS = 'font-family="system-ui, sans-serif" font-size="14"'


@dataclass(frozen=True)
class Geometry:
    """Angles of a scene, degrees; bearings from the surface point, clockwise from north.

    Attributes
    ----------
    view_zenith, view_azimuth : float
    sun_zenith, sun_azimuth : tuple of float
        In the first and the last frame.
    layers : sequence of (name, base, top)
        Cloud layers from the lowest; altitudes in m, None where the cube does not tell.
    sensor_altitude_m : float or None
    wind_from : float or None
        Bearing the wind that carries the clouds blows from.
    footprint_moves_m : float
        Toward the east, from the first frame to the last.
    """

    view_zenith: float
    view_azimuth: float
    sun_zenith: tuple[float, float]
    sun_azimuth: tuple[float, float]
    layers: Sequence[tuple[str, float | None, float | None]] = ()
    sensor_altitude_m: float | None = None
    wind_from: float | None = None
    footprint_moves_m: float = 0.0


def side_view(scene: Geometry) -> Markup:
    """Return sea, clouds, lines of sight and of the sun, with true zenith angles; altitudes are not to scale.

    The sensor is on the right; the sun is there, too, where the two bearings differ by less than 90 degrees.
    """
    centre, sea = 230.0, 250.0
    zenith = scene.sun_zenith[0]
    apart = _between(scene.sun_azimuth[0], scene.view_azimuth)
    same_side = scene.view_zenith == 0.0 or abs(apart) < 90.0
    parts = [
        _shape("rect", x=0, y=sea, width=460, height=70, fill="#dcebf5"),
        _line(0, sea, 460, sea, _SEA, 2),
        _text(8, sea + 60, "sea", _SEA),
    ]
    parts += _clouds(scene.layers, sea)
    parts.append(_line(centre, sea, centre, 22, _SOFT, 1, dash="3 4"))
    parts.append(_text(centre, 16, "zenith", _SOFT, "middle"))
    parts += _ray(centre, sea, scene.view_zenith, 1.0, 195.0, _SENSOR, "sensor", "view-ray", toward_target=False)
    sun_side = 1.0 if same_side else -1.0
    length = 160.0 if zenith < 90.0 else 60.0
    parts += _ray(centre, sea, zenith, sun_side, length, _SUN, "sun", "sun-ray", toward_target=True)
    told = f"view {scene.view_zenith:g}° and sun {zenith:g}° from the zenith"
    return _drawing("0 0 460 320", f"side view: {told}", parts)


def plan_view(scene: Geometry) -> Markup:
    """Return the bearings toward sensor and sun, and where wind and footprint move, with north at the top."""
    x, y, radius = 230.0, 160.0, 118.0
    parts = [_shape("circle", cx=x, cy=y, r=radius, fill="#f4f7fa", stroke=_SOFT, stroke_width=1.2)]
    for bearing in range(0, 360, 30):
        inner = radius - (9 if bearing % 90 == 0 else 5)
        parts.append(_line(*_at(x, y, inner, bearing), *_at(x, y, radius, bearing), _SOFT, 1))
    for name, bearing in (("N", 0), ("E", 90), ("S", 180), ("W", 270)):
        place = _at(x, y, radius - 20, bearing)
        parts.append(_text(place[0], place[1] + 5, name, _SOFT, "middle"))
    if scene.wind_from is not None:
        start, end = _at(52, 262, 20, scene.wind_from), _at(52, 262, -20, scene.wind_from)
        parts += _arrow(*start, *end, _SOFT, "wind", dash="5 3")
        parts.append(_text(52, 304, "wind", _SOFT, "middle"))
    if scene.footprint_moves_m:
        way = math.copysign(45.0, scene.footprint_moves_m)
        parts += _arrow(402 - way / 2, 280, 402 + way / 2, 280, "#3d7a37", "footprint")
        parts.append(_text(402, 304, "footprint", "#3d7a37", "middle"))
    parts += _bearing(x, y, radius, scene.sun_azimuth[0], _SUN, "sun", "sun-bearing")
    if _between(*scene.sun_azimuth):
        first, last = (_at(x, y, radius + 5, each) for each in scene.sun_azimuth)
        sweep = 1 if _between(scene.sun_azimuth[1], scene.sun_azimuth[0]) > 0 else 0
        arc = f"M{first[0]:.2f} {first[1]:.2f} A{radius + 5:g} {radius + 5:g} 0 0 {sweep} {last[0]:.2f} {last[1]:.2f}"
        parts.append(_shape("path", d=arc, fill="none", stroke=_SUN, stroke_width=3))
    if scene.view_zenith > 0.0:
        parts += _bearing(x, y, radius, scene.view_azimuth, _SENSOR, "sensor", "view-bearing")
    else:
        parts.append(_text(x, y - 8, "sensor overhead", _SENSOR, "middle"))
    parts.append(_shape("circle", cx=x, cy=y, r=3.5, fill="#1c2733"))
    told = f"sensor at bearing {scene.view_azimuth:g}°, sun at {scene.sun_azimuth[0]:g}°"
    return _drawing("0 0 460 320", f"plan view: {told}", parts)


def _between(bearing: float, other: float) -> float:
    """Difference of two bearings, -180 to 180."""
    return (bearing - other + 180.0) % 360.0 - 180.0


def _clouds(layers: Sequence[tuple[str, float | None, float | None]], sea: float) -> list[Markup]:
    tops = [top for _, _, top in layers if top is not None]
    highest = max(tops, default=0.0)
    parts = []
    for number, (name, base, top) in enumerate(layers):
        if base is None or top is None or highest <= 0.0:
            low, high = 40.0 + 55.0 * number, 65.0 + 55.0 * number
            told = f"{name}, altitude not told"
        else:
            low, high = (18.0 + 112.0 * each / highest for each in (base, top))
            told = f"{name} {base:g} to {top:g} m"
        height = max(high - low, 5.0)
        parts.append(_shape("rect", x=0, y=sea - high, width=460, height=height, fill=_CLOUD, fill_opacity=0.35, rx=4))
        parts.append(_text(8, sea - high + min(height, 30.0) / 2 + 5, told, "#3c4a57"))
    return parts


def _ray(
    x: float, y: float, zenith: float, side: float, length: float, colour: str, name: str, key: str, toward_target: bool
) -> list[Markup]:
    """Return a line at an angle from the zenith with its name and angle at the far end."""
    sine, cosine = math.sin(math.radians(zenith)), math.cos(math.radians(zenith))
    end = (x + side * length * sine, y - length * cosine)
    dash = None if zenith < 90.0 else "4 4"
    if toward_target:
        parts = _arrow(*end, x, y, colour, key, dash)
        parts.append(_shape("circle", cx=end[0], cy=end[1], r=9, fill="#f2b33d", stroke=colour))
    else:
        parts = _arrow(x, y, *end, colour, key, dash)
    # words stay within the drawing, beside the end of the line
    anchor = "start" if side > 0 else "end"
    text = f"{name} {zenith:.2f}°"
    place = end[0] + side * 14
    if side > 0 and place > 350:
        anchor, place = "end", 456.0
        return [*parts, _text(place, end[1] - 14, text, colour, anchor)]
    if side < 0 and place < 110:
        return [*parts, _text(4.0, end[1] - 14, text, colour, "start")]
    return [*parts, _text(place, end[1] + 5, text, colour, anchor)]


def _bearing(x: float, y: float, radius: float, bearing: float, colour: str, name: str, key: str) -> list[Markup]:
    parts = _arrow(x, y, *_at(x, y, radius, bearing), colour, key)
    place = _at(x, y, radius + 14, bearing)
    side = math.sin(math.radians(bearing))
    anchor = "start" if side > 0.25 else "end" if side < -0.25 else "middle"
    return [*parts, _text(place[0], place[1] + 5, f"{name} {bearing % 360.0:.2f}°", colour, anchor)]


def _at(x: float, y: float, radius: float, bearing: float) -> tuple[float, float]:
    return x + radius * math.sin(math.radians(bearing)), y - radius * math.cos(math.radians(bearing))


def _arrow(x1: float, y1: float, x2: float, y2: float, colour: str, key: str, dash: str | None = None) -> list[Markup]:
    away = math.atan2(y2 - y1, x2 - x1)
    head = " ".join(
        f"{x2 - 10 * math.cos(away + turn):.2f},{y2 - 10 * math.sin(away + turn):.2f}" for turn in (-0.4, 0.4)
    )
    return [
        _line(x1, y1, x2, y2, colour, 2.2, dash, key),
        _shape("polygon", points=f"{x2:.2f},{y2:.2f} {head}", fill=colour),
    ]


def _line(
    x1: float,
    y1: float,
    x2: float,
    y2: float,
    colour: str,
    width: float,
    dash: str | None = None,
    key: str | None = None,
) -> Markup:
    ends = {"x1": f"{x1:.3f}", "y1": f"{y1:.3f}", "x2": f"{x2:.3f}", "y2": f"{y2:.3f}"}
    return element("line", **ends, stroke=colour, stroke_width=f"{width:g}", stroke_dasharray=dash, class_=key)


def _text(x: float, y: float, text: str, colour: str, anchor: str = "start") -> Markup:
    # white around the letters keeps them readable on lines
    halo = {"stroke": "#fff", "stroke_width": "3", "paint_order": "stroke", "stroke_linejoin": "round"}
    return element("text", text, x=f"{x:.1f}", y=f"{y:.1f}", fill=colour, text_anchor=anchor, **halo)


def _shape(name: str, **attributes: float | str) -> Markup:
    return element(
        name, **{key: value if isinstance(value, str) else f"{value:g}" for key, value in attributes.items()}
    )


def _drawing(box: str, told: str, parts: Sequence[Markup]) -> Markup:
    opening = f'<svg viewBox="{box}" role="img" {_LETTERS} class="scene">'
    return Markup(f"{opening}{element('title', told)}{joined(parts)}</svg>")


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
    displacement = np.atleast_1d(dataset["centre_displacement"]) if "centre_displacement" in dataset.coords else [0]
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
    from hcss_twin.core.catalog import Catalog
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
            ", ".join(f"{name} {low:g} to {high:g} µm" for name, (low, high) in zip(names, bounds, strict=True)),
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
