"""The controls of the page: which keys of a scenario they set, and what a typed value means."""

from __future__ import annotations

import datetime
import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

from hcss_explore.keys import Raw, value_of
from hcss_twin import Scenario
from hcss_twin.cli.options import Shared
from hcss_twin.providers import Catalog

Control = dict[str, Any]
"""``key``, ``label`` and ``kind`` ("text", "choice", "many", "time"), and what that kind needs besides."""

OWN, OFF = "as in the scenario", "off"
"""Choices of the sensor that are no names."""

CLEAR = "none (clear sky)"
"""Choice of the cloud type."""

OTHERS = "others"
"""Key of the text with assignments of other keys."""

_OF_CAMERAS = ("camera", "orbit", "attitude", "jitter")
"""Sections that say where a camera looks; a scenario with an instrument lacks some of them."""

_SKIPPED = ("provider",)
"""Keys of other packages' sections that have no control."""


def controls(raw: Raw, scenario: Scenario, catalog: Catalog) -> list[dict[str, Any]]:
    """Return the groups of controls for a scenario: a title, and the controls.

    Parameters
    ----------
    raw : dict
        Its keys as given.
    scenario : Scenario
        The same, whose defaults are shown where nothing is given.
    """
    known, camera = json.loads(scenario.to_json()), has_camera(scenario)

    def text(key: str, label: str, unit: str = "", slider: tuple[float, float, float] | None = None) -> Control:
        # A scenario may write its only layer as [clouds]; all that is known of it is that of the first of the layers.
        of_known = key if key.startswith("clouds.layers[") else key.replace("clouds.", "clouds.layers[0].", 1)
        given, default = value_of(raw, key), value_of(known, of_known)
        return {
            "key": key,
            "label": label,
            "kind": "text",
            "unit": unit,
            "value": "" if given is None else _shown(given),
            "default": "" if default is None else _shown(default),
            "slider": slider,
        }

    groups = [
        (
            "Time and place",
            [
                {**text("time", "Start"), "kind": "time"},
                text("place.latitude", "Latitude", "deg N"),
                text("place.longitude", "Longitude", "deg E"),
                text("seed", "Seed"),
            ],
        ),
        ("View", [*_view(raw, camera, text)]),
        *_layers(raw, text, catalog),
        (
            "Sea",
            [
                text("sea.temperature", "Temperature", "K", (270.0, 306.0, 0.5)),
                text("sea.wind_speed", "Wind at 10 m", "m/s", (0.0, 25.0, 0.5)),
            ],
        ),
        ("Bands", [_bands(known, catalog)]),
        ("Sensor", [_sensor(raw, catalog)]),
        (
            "Image and frames",
            [
                *(text(key, label, unit) for key, label, unit in _image(raw, camera)),
                text("frames.count", "Frames"),
                text("frames.interval", "Time between", "s"),
                text("accuracy", "Accuracy"),
            ],
        ),
    ]
    return [{"title": title, "controls": members} for title, members in groups if members]


def has_camera(scenario: Scenario) -> bool:
    """Return whether a camera takes the images: one that is written, or one that follows from an instrument."""
    return "camera" in scenario.sections


def typed(key: str, given: Any) -> Any:
    """Return the value of a key for what its control holds; None where nothing is given.

    Text that is no number stays text, which the scenario reads as a quantity with a unit, or refuses.
    """
    if key == "sensor":
        return None if given == OFF else {"name": given}
    if not isinstance(given, str):
        return given or None
    text = given.strip()
    if not text or text == CLEAR:
        return None
    if key == "time":
        with suppress(ValueError):
            return datetime.datetime.fromisoformat(text)
    for number in (int, float):
        with suppress(ValueError):
            return number(text)
    return text


def changes_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes of keys for what the page holds: by key, and assignments of other keys as lines of text.

    Raises
    ------
    click.BadParameter
        If a line is no assignment.
    """
    changes = {key: typed(key, value) for key, value in given.items() if key != OTHERS and value != OWN}
    lines = [line.strip() for line in str(given.get(OTHERS) or "").splitlines()]
    assignments = ["=".join(side.strip() for side in line.split("=", 1)) for line in lines if line]
    return changes | Shared.assigned(assignments, "Other keys")


def _shown(value: Any) -> str:
    if isinstance(value, datetime.datetime):
        return value.isoformat()
    return value if isinstance(value, str) else json.dumps(value)


def _view(raw: Raw, camera: bool, text: Any) -> Iterator[Control]:
    if camera:
        for section in _OF_CAMERAS:
            for key, value in raw.get(section, {}).items():
                if key not in _SKIPPED and isinstance(value, int | float | str):
                    yield text(f"{section}.{key}", f"{section}: {key.replace('_', ' ')}")
        return
    platform = raw.get("platform", {})
    if "longitude" in platform:
        yield text("platform.longitude", "Geostationary at", "deg E", (-180.0, 180.0, 1.0))
        return
    if "altitude" in platform:
        yield text("platform.altitude", "Altitude", "m")
    if "off_nadir" in platform:
        yield text("platform.off_nadir", "Off nadir", "deg", (0.0, 60.0, 0.5))
    else:
        yield text("view.zenith", "Zenith angle", "deg", (0.0, 75.0, 1.0))
    yield text("view.azimuth", "Toward the sensor", "deg", (0.0, 355.0, 5.0))


def _image(raw: Raw, camera: bool) -> Iterator[tuple[str, str, str]]:
    if camera or "instrument" in raw:
        return
    yield "image.rows", "Rows", ""
    yield "image.columns", "Columns", ""
    if not {"focal_length", "detector_pitch"} & set(raw.get("platform", {})):
        yield "image.pixel_size", "Pixel", "m"


def _layers(raw: Raw, text: Any, catalog: Catalog) -> Iterator[tuple[str, list[Control]]]:
    clouds = raw.get("clouds", {})
    layers = clouds.get("layers") if isinstance(clouds, dict) else None
    names = catalog.names("cloud_types", ".toml")
    many = isinstance(layers, list)
    for number in range(len(layers) if isinstance(layers, list) else 1):
        where = f"clouds.layers[{number}]" if many else "clouds"
        kind = text(f"{where}.type", "Type")
        if not many and not clouds:
            kind["value"] = CLEAR
        choices = [*names] if many or clouds else [CLEAR, *names]
        given = kind["value"] or kind["default"]
        if given not in choices:
            choices = [given, *choices]
        yield (
            f"Clouds, layer {number + 1}" if many and len(layers or ()) > 1 else "Clouds",
            [
                {**kind, "kind": "choice", "choices": choices, "value": given},
                text(f"{where}.coverage", "Cover", "", (0.0, 1.0, 0.01)),
            ],
        )


def _bands(known: Raw, catalog: Catalog) -> Control:
    shipped = catalog.toml(catalog.root / "bands.toml")["bands"]
    choices = [
        {"name": name, "text": f"{band['limits_um'][0]:g} to {band['limits_um'][1]:g} um", "value": name}
        for name, band in shipped.items()
    ]
    given = known["bands"]
    own = [
        {"name": band["name"] if isinstance(band, dict) else _shown(band), "text": "of this scenario", "value": band}
        for band in given
        if not isinstance(band, str)
    ]
    return {"key": "bands", "label": "Bands", "kind": "many", "choices": own + choices, "value": given}


def _sensor(raw: Raw, catalog: Catalog) -> Control:
    own = "sensor" in raw or "instrument" in raw
    choices = [OWN] * own + ([] if "instrument" in raw else [OFF, *catalog.names("instruments", ".toml")])
    return {"key": "sensor", "label": "Sensor", "kind": "choice", "choices": choices, "value": choices[0]}
