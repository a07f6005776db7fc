"""Drawings of a scene: a side view with true zenith angles, and a compass with true bearings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from hcss_twin.reports.page import Markup
from hcss_twin.reports.scene_geometry import Layers, SceneGeometry, bearing_difference

_SUN, _SENSOR, _CLOUD, _SEA, _SOFT, _MOTION = "#b86e00", "#0b5c97", "#8795a3", "#2a6f97", "#5b6875", "#3d7a37"
_BOX = 'viewBox="0 0 460 320" role="img" font-family="system-ui, sans-serif" font-size="14" class="scene"'

Place2 = tuple[float, float]


def side_view(scene: SceneGeometry) -> Markup:
    """Return a drawing of sea, clouds, line of sight and sun with true zenith angles; altitudes are not to scale.

    The sensor is on the right; so is the sun where the two bearings differ by less than 90 degrees.
    """
    target = (230.0, 250.0)
    sea = target[1]
    zenith = scene.sun_zenith[0]
    same_side = scene.view_zenith == 0.0 or abs(bearing_difference(scene.sun_azimuth[0], scene.view_azimuth)) < 90.0
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
    if bearing_difference(*scene.sun_azimuth):
        first, last = (_at(centre, radius + 5, azimuth) for azimuth in scene.sun_azimuth)
        clockwise = int(bearing_difference(scene.sun_azimuth[1], scene.sun_azimuth[0]) > 0)
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
    return Markup.element("line", **ends, stroke=colour, stroke_width=f"{width:g}", stroke_dasharray=dash, class_=key)


def _text(point: Place2, text: str, colour: str, anchor: str = "start") -> Markup:
    # a white outline keeps the text readable on lines
    halo = {"stroke": "#fff", "stroke_width": "3", "paint_order": "stroke", "stroke_linejoin": "round"}
    return Markup.element(
        "text", text, x=f"{point[0]:.1f}", y=f"{point[1]:.1f}", fill=colour, text_anchor=anchor, **halo
    )


def _shape(name: str, **attributes: float | str) -> Markup:
    return Markup.element(
        name, **{key: value if isinstance(value, str) else f"{value:g}" for key, value in attributes.items()}
    )


def _drawing(title: str, parts: Sequence[Markup]) -> Markup:
    return Markup(f"<svg {_BOX}>{Markup.element('title', title)}{Markup.joined(parts)}</svg>")
