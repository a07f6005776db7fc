"""What the gallery shows of each scenario: panels, and a few words on what there is to see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

Panel = tuple[str, str, dict[str, int]]
"""Title, variable and place along its axes."""


@dataclass(frozen=True)
class Entry:
    """One picture."""

    name: str
    words: str
    panels: tuple[Panel, ...]
    columns: int | None = None
    same_scale: tuple[int, ...] = ()
    """Number of the group of panels that share a scale, panel by panel; default: each has its own."""


def _bands(variable: str, *titles: str) -> Iterator[Panel]:
    for place, title in enumerate(titles):
        yield title, variable, {"time": 0, "band": place}


def _frames(band: int, *titles: str) -> Iterator[Panel]:
    for place, title in enumerate(titles):
        yield title, "radiance", {"time": place, "band": band}


def _layers(*panels: tuple[str, str]) -> Iterator[Panel]:
    for title, variable in panels:
        yield title, variable, {"time": 0, "band": 0}


def _named(title: str, *variables: str) -> Iterator[Panel]:
    """The radiance under a title, and variables under their own names."""
    yield from _layers((title, "radiance"), *((name, name) for name in variables))


ENTRIES = (
    Entry(
        "stratus-by-day",
        "Low water cloud over a sunlit sea. Sea in the glint outshines cloud in both short bands; in 8-14 "
        "um cloud differs from the sea by "
        "its temperature alone, a few kelvin. In 2.7-3.0 um water vapour lets very little through: mind "
        "the scale.",
        tuple(_bands("radiance", "2.7-3.0 um", "3-5 um", "8-14 um")),
    ),
    Entry(
        "push-broom",
        "The footprint runs east at 1 km/s; the clouds drift and change beneath it. All frames share one scale.",
        tuple(_frames(0, *(f"{second} s" for second in range(8)))),
        4,
        (0,) * 8,
    ),
    Entry(
        "cumulus-with-shadows",
        "The sun stands in the west and the sensor looks toward its glint: clouds are darker than the sea "
        "around them, and the shadows, which "
        "take the glint away, darker still. The masks say for each pixel what it is.",
        tuple(_named("radiance 3.4-4.1 um", "cloud_mask", "shadow_mask")),
    ),
    Entry(
        "waves-in-the-glint",
        "No cloud, 600 m of sea: waves longer than two pixels are drawn, shorter ones are in the "
        "statistics of each pixel. The slopes are "
        "truth layers.",
        tuple(
            _layers(("radiance 3-5 um", "radiance"), ("slope along x", "sea_slope_x"), ("slope along y", "sea_slope_y"))
        ),
    ),
    Entry(
        "stratocumulus-by-night",
        "No sun. Droplets emit less in 3.7 um than in 10.8 um, so the difference of both is more negative "
        "over thick low cloud than over the sea: what "
        "weather services use to find fog at night. Asked for with an accuracy in kelvin.",
        (*_bands("brightness_temperature", "3.7 um", "10.8 um"), ("3.7 um - 10.8 um", "difference", {})),
        None,
        (0, 0, 1),
    ),
    Entry(
        "sunset",
        "Clouds are frozen, so that only the light changes. In 3.7 um sunlight on the clouds fades and "
        "their own emission, weaker than the "
        "sea's, is left; 10.8 um does not care. One scale per band.",
        tuple(
            panel
            for band, name in enumerate(("3.7 um", "10.8 um"))
            for panel in _frames(band, *(f"{name}, {time}" for time in ("17:30", "18:10", "18:50", "19:30")))
        ),
        4,
        (0, 0, 0, 0, 1, 1, 1, 1),
    ),
    Entry(
        "cirrus",
        "Streaks of ice crystals. Ice absorbs more in 12.0 um than in 10.8 um, so thin cloud lets less of "
        "the warm sea through there: the "
        "difference tells it from the sea beneath.",
        (*_bands("brightness_temperature", "10.8 um", "12.0 um"), ("10.8 um - 12.0 um", "difference", {})),
        None,
        (0, 0, 1),
    ),
    Entry(
        "cirrus-over-cumulus",
        "Two cloud types, each with its own particles, and columns that hold both. A pixel is the mean of "
        "2 x 2 points of its footprint.",
        tuple(_bands("radiance", "3-5 um", "8-14 um")),
    ),
    Entry(
        "narrow-bands",
        "From the window at 3.7 um to the core of the CO2 band at 4.3 um, where the air hides everything "
        "(mind the scale), and through the "
        "ozone band at 9.7 um.",
        tuple(_bands("brightness_temperature", "3.7 um", "4.2-4.4 um", "4.5-4.8 um", "8.5 um", "9.7 um", "12.0 um")),
        3,
    ),
    Entry(
        "streets",
        "From one grey picture (left, drawn by `make.py`; a satellite image serves as well) any number of "
        "other skies with its look, "
        "evolving in time ([surrogates](surrogate-clouds.md)).",
        (("the picture", "template", {}), *_frames(0, "cloud at 0 min", "20 min", "40 min")),
        None,
        (0, 1, 1, 1),
    ),
    Entry(
        "terms",
        "The radiance is a sum of seven parts; six panels show it and its five largest. Glint makes the "
        "sea bright, scattered sun the "
        "clouds.",
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
        "What a detection algorithm is judged against, for every pixel of every frame. White where a "
        "temperature or an altitude does not "
        "exist.",
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
