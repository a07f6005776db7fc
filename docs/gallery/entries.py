"""Panels and caption of each gallery image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

Panel = tuple[str, str, dict[str, int]]
"""Title, variable and index along its axes; ``"scene"`` 1 is the second scene."""


@dataclass(frozen=True)
class Entry:
    """One image."""

    name: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int | None = None
    same_scale: tuple[int, ...] = ()
    """Group number of each panel; panels of a group share a scale. By default each panel has its own."""
    second: Mapping[str, Any] = field(default_factory=dict)
    """Keys of the second scene that differ from the file."""


def _bands(variable: str, *titles: str) -> Iterator[Panel]:
    for place, title in enumerate(titles):
        yield title, variable, {"time": 0, "band": place}


def _frames(band: int, step: int, *titles: str) -> Iterator[Panel]:
    for place, title in enumerate(titles):
        yield title, "brightness_temperature", {"time": step * place, "band": band}


def _layers(*panels: tuple[str, str]) -> Iterator[Panel]:
    for title, variable in panels:
        yield title, variable, {"time": 0, "band": 0}


def _named(title: str, *variables: str) -> Iterator[Panel]:
    """The radiance with a title, then variables with their own names."""
    yield from _layers((title, "radiance"), *((name, name) for name in variables))


ENTRIES = (
    Entry(
        "stratus-by-day",
        "Low water cloud over a sunlit sea. In the glint the sea is brighter than the cloud in both short-wave "
        "bands; in 8-14 um the cloud differs from the sea only in temperature, by a few kelvin. In 2.7-3.0 "
        "um water vapour absorbs most of the radiance: note the scale.",
        tuple(_bands("radiance", "2.7-3.0 um", "3-5 um", "8-14 um")),
    ),
    Entry(
        "push-broom",
        "The field of view moves east at 1 km/s while the clouds drift and evolve. All frames share one scale.",
        tuple(_frames(0, 3, "10.8 um, 0 s", "3 s", "6 s")),
        3,
        (0,) * 3,
    ),
    Entry(
        "cumulus-with-shadows",
        "The sun is in the west and the sensor looks toward its glint. Clouds are darker than the glint, "
        "and cloud shadows, which remove the glint, are darker still.",
        tuple(_named("radiance 3.4-4.1 um", "cloud_mask", "shadow_mask")),
    ),
    Entry(
        "waves-in-the-glint",
        "Cloud-free sea, 600 m wide. Waves longer than two pixels are resolved; shorter ones enter the "
        "statistics of each pixel. The wave slopes are truth layers.",
        tuple(
            _layers(("radiance 3-5 um", "radiance"), ("slope along x", "sea_slope_x"), ("slope along y", "sea_slope_y"))
        ),
    ),
    Entry(
        "stratocumulus-by-night",
        "Droplets emit less at 3.7 um than at 10.8 um, so the difference is more negative over thick low "
        "cloud than over the sea. Weather services use it to detect fog at night.",
        (*_bands("brightness_temperature", "3.7 um", "10.8 um"), ("3.7 um - 10.8 um", "difference", {})),
        None,
        (0, 0, 1),
    ),
    Entry(
        "deep-convection",
        "Systems of deep convection over 600 km, with pixels of 3 km. Their cores are as cold as the air at 14 km; "
        "thin anvils let the warm sea through, more of it at 10.8 um than at 12.0 um.",
        tuple(_bands("brightness_temperature", "10.8 um", "12.0 um")),
        None,
        (0, 0),
    ),
    Entry(
        "sunset",
        "The clouds are frozen, so only the light changes. At 3.7 um the scattered sunlight fades and the "
        "weaker emission of the clouds remains; 10.8 um is unaffected. All frames of a band share one scale.",
        tuple(
            panel
            for band, name in enumerate(("3.7 um", "10.8 um"))
            for panel in _frames(band, 3, *(f"{name}, {time}" for time in ("17:30", "19:30")))
        ),
        4,
        (0, 0, 1, 1),
    ),
    Entry(
        "cirrus",
        "Ice absorbs more at 12.0 um than at 10.8 um, so thin cloud transmits less of the warm sea's "
        "radiance there. The difference separates cirrus from sea.",
        (*_bands("brightness_temperature", "10.8 um", "12.0 um"), ("10.8 um - 12.0 um", "difference", {})),
        None,
        (0, 0, 1),
    ),
    Entry(
        "cirrus-over-cumulus",
        "Each layer has its own particles, and some columns contain both layers. Each pixel is the mean of "
        "2 x 2 points.",
        tuple(_bands("brightness_temperature", "3-5 um", "8-14 um")),
    ),
    Entry(
        "three-layers",
        "Cirrus over altocumulus over cumulus. At 3.7-4.2 um the sun glint is warmest; in the shadows of water clouds "
        "it is gone, and cirrus weakens it. At 10.3-11.3 um shadows are not seen.",
        (*_bands("brightness_temperature", "3.7-4.2 um", "10.3-11.3 um"), *_layers(("shadow_mask", "shadow_mask"))),
    ),
    Entry(
        "coast-from-two-orbits",
        "Two cameras at an altitude of 700 km see one sky at one time from the west (left) and from the east (right: "
        "`--set 'orbit.above=[36.7, -4.66]'`), at zenith angles of 14 degrees. Coast and ship, 2.5 km west and 1 km "
        "south of the middle, stay in place; cirrus at 9 km moves by 9 km x 2 tan 14 degrees = 4.5 km. Needs "
        "[hcss-payload](../plugins/hcss-payload/README.md) and [hcss-examples](../plugins/hcss-examples/README.md).",
        tuple(
            (f"{band}, from the {side}", "brightness_temperature", {"time": 0, "band": number, "scene": scene})
            for number, band in enumerate(("3.7-4.2 um", "8-14 um"))
            for scene, side in enumerate(("west", "east"))
        ),
        2,
        (0, 0, 1, 1),
        {"orbit.above": [36.7, -4.66]},
    ),
    Entry(
        "narrow-bands",
        "The bands range from the window at 3.7 um to the core of the CO2 band at 4.3 um, where the "
        "atmosphere is opaque, and the ozone band at 9.7 um. Note the scales.",
        tuple(_bands("brightness_temperature", "3.7 um", "4.2-4.4 um", "4.5-4.8 um", "8.5 um", "9.7 um", "12.0 um")),
        3,
    ),
    Entry(
        "streets",
        "One grey image (left; a satellite image works too) yields any number of evolving cloud "
        "fields with similar texture ([surrogates](how-to/clouds-from-images.md), `pip install ./plugins/hcss-skies`).",
        (("the picture", "template", {}), *_frames(0, 1, "10.8 um, 0 min", "20 min", "40 min")),
        None,
        (0, 1, 1, 1),
    ),
    Entry(
        "terms",
        "The total radiance and its five largest terms out of seven. Glint dominates over the sea, "
        "scattered sunlight over the clouds.",
        tuple(
            _layers(
                ("total", "radiance"),
                ("emitted by the sea", "radiance_sea_emission"),
                ("sunlight reflected by the sea", "radiance_sea_reflected_sun"),
                ("emitted by the clouds", "radiance_cloud_emission"),
                ("sunlight scattered by the clouds", "radiance_cloud_reflected_sun"),
                ("emitted by the air", "radiance_path_emission"),
            )
        ),
        3,
    ),
    Entry(
        "truth",
        "Reference data for testing a detection algorithm, for every pixel of every frame. White: the "
        "temperature or altitude is undefined.",
        tuple(
            _named(
                "radiance 8-14 um",
                "cloud_fraction",
                "cloud_thickness",
                "cloud_top_altitude",
                "cloud_top_temperature",
                "cloud_optical_thickness",
            )
        ),
        3,
    ),
)
