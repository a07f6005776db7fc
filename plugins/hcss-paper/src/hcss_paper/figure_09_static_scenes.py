"""Fig 9: the six static scenes of Table I as a function of view angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from hcss_paper.cubes import scene_inputs
from hcss_paper.figure_base import (
    BANDS,
    PHYSICAL_NOTE,
    RADIANCE,
    SHORT_WAVE,
    blank,
    image_panel,
    radiance_by_band,
    simulated,
)
from hcss_paper.inputs import assumed, in_words, printed_row, published
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.scene import Model
from hcss_paper.static_clouds import StaticClouds, in_place_of_images, static_clouds
from hcss_twin.providers import Array, Catalog

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SATELLITES = {"New Technology": 0.30, "Qilu-2": 0.47}
"""Coverage of the two images according to Table I."""

SCENARIOS = tuple((band, satellite) for band in BANDS for satellite in SATELLITES)
"""Scenario1 to Scenario6."""

SHORT_WAVE_RANGE = (0.0005, 0.0025)
"""Printed as .001 to .002, rounded."""

PHYSICAL_SATELLITE = "Qilu-2"
INNER_PIXELS = 6
"""Pixels farther than this from clear sky are the inside of a cloud."""


@dataclass(frozen=True)
class Stack:
    """Simulated images of one satellite image at all view angles.

    Attributes
    ----------
    cloudy : ndarray of bool (rows, columns)
    radiance : dict of str to ndarray (views, rows, columns)
        By band, W m-2 sr-1.
    """

    cloudy: NDArray[np.bool_]
    radiance: dict[str, NDArray[np.float32]]

    def means(self, band: str) -> Array:
        """Mean radiance (views,)."""
        result: Array = self.radiance[band].mean(axis=(1, 2), dtype=np.float64)
        return result

    def parts(self, band: str) -> tuple[Array, Array, Array]:
        """Return the mean radiance (views,) of the sea, of the cloud edges and of the cloud interior."""
        edge = self.cloudy & ~binary_erosion(self.cloudy)
        inside = binary_erosion(self.cloudy, iterations=INNER_PIXELS)
        images = self.radiance[band]
        sea, rim, core = (images[:, mask].mean(axis=1, dtype=np.float64) for mask in (~self.cloudy, edge, inside))
        return sea, rim, core

    def contrast(self, band: str) -> Array:
        """Return the relative difference (views,) between the cloud interior and the sea."""
        sea, _, core = self.parts(band)
        return np.abs(core / sea - 1.0)


def stack(model: Model, clouds: StaticClouds, views_deg: list[float]) -> Stack:
    """Simulate clouds at each view angle, in the three bands."""
    found: dict[str, list[NDArray[np.float32]]] = {band: [] for band in BANDS}
    for view in views_deg:
        images = radiance_by_band("baseline", model, {**clouds.scene, "view.zenith": view})
        for band in BANDS:
            found[band].append(images[band][0].astype(np.float32))
    mask = simulated("baseline", model, {**clouds.scene, "output.variables": ["cloud_mask"]}).cloud_mask[0].to_numpy()
    return Stack(mask > 0, {band: np.stack(images) for band, images in found.items()})


def figure_9(seed: int) -> Reproduction:
    """Return the six scenes at view zenith angles of 0 to 70 degrees."""
    del seed  # the clouds are those of images, or of the database
    views = [float(view) for view in published()["view_zenith_deg"]]
    with static_clouds() as clouds:
        stacks = {name: stack("as-printed", clouds[name], views) for name in SATELLITES}
        corrected = stack("physical", clouds[PHYSICAL_SATELLITE], views)
        grey = {name: cloud.entry.image[::-1] for name, cloud in clouds.items()}
    rows = []
    for number, (band, satellite) in enumerate(SCENARIOS, start=1):
        name = f"Scenario{number}"
        printed = (
            [None] * len(views) if band == SHORT_WAVE else [float(value) for value in printed_row("table_2", name)]
        )
        physical = corrected.means(band) if satellite == PHYSICAL_SATELLITE else [None] * len(views)
        rows += [
            Row(f"{name}, {BANDS[band]}, {view:g} deg, mean", RADIANCE, stated, float(mean), _number(other))
            for view, stated, mean, other in zip(views, printed, stacks[satellite].means(band), physical, strict=True)
        ]
    checks = [check for name, found in stacks.items() for check in checks_of(name, found, SATELLITES[name], views)]
    return judged(
        rows,
        checks,
        holds="The statements of the text about the scenes hold for other clouds of the same coverage.",
        fails="A statement of the text about the scenes does not hold for other clouds of the same coverage.",
        missing="The satellite images (Qilu-2, New Technology) are not published, so the pictures cannot be compared.",
        chosen=(
            *in_words(f"clouds: {in_place_of_images(Catalog())}"),
            *scene_inputs(),
            *assumed(["short-wave glint scale"]),
        ),
        notes=(
            "The scene is that of table-2. Means of these images are within "
            f"{100 * _largest_share(rows):.2g} % of Table II, whose clouds are unknown.",
            "With the corrected physics clouds reflect sunlight: in 2.7-3.0 um they are darker than the glint, and "
            "brighter than the sea beyond 60 deg.",
            PHYSICAL_NOTE,
        ),
        drawings=(
            Drawing(
                "Clouds of scenarios 1, 3, 5 (left) and 2, 4, 6 (right), in place of the satellite images",
                _side_by_side(grey),
                "Two grey pictures side by side, cloud bright.",
            ),
            Drawing(
                "Static scenes, as-printed; each row has its own grey scale",
                _drawn([(f"({n})", stacks[sat].radiance[band]) for n, (band, sat) in enumerate(SCENARIOS, 1)], views),
                "Six rows of eight images: the 2.7-3.0 um rows are brightest at 20 and 30 degrees, clouds are dark in "
                "3-5 and 8-14 um, and all fade at 70 degrees.",
            ),
            Drawing(
                "Scenarios 2, 4 and 6 with the corrected physics",
                _drawn([(f"({n})", corrected.radiance[band]) for n, band in zip((2, 4, 6), BANDS, strict=True)], views),
                "Three rows of eight images; in 2.7-3.0 um dark clouds have little contrast at 60 degrees and are "
                "brighter than the sea at 70; in 3-5 and 8-14 um they are dark at all angles.",
            ),
        ),
    )


def checks_of(name: str, found: Stack, coverage: float, views_deg: list[float]) -> list[Check]:
    """Return the statements of the text about the scenes of one satellite image, as checks."""
    share = float(found.cloudy.mean())
    short, middle, long = (found.means(band) for band in BANDS)
    brightest = sorted(views_deg[index] for index in np.argsort(short)[-2:])
    sea, rim, core = found.parts("mwir")
    contrasts = found.contrast("lwir") / found.contrast("mwir")
    falls = [-np.diff(values) for values in (middle, long)]
    low, high = SHORT_WAVE_RANGE
    return [
        Check(
            f"{name}: coverage {share:.4f}, printed {coverage:g}",
            abs(share - coverage) < 1.5 / np.sqrt(found.cloudy.size),
        ),
        Check(
            f"{name}: 2.7-3.0 um brightest at {brightest[0]:g} and {brightest[1]:g} deg, printed 20 and 30",
            brightest == [20.0, 30.0],
        ),
        Check(
            f"{name}: 2.7-3.0 um means {short.min():.4f} to {short.max():.4f}, printed .001 to .002 (rounded)",
            bool(low <= short.min() and short.max() <= high),
        ),
        Check(f"{name}: clouds are dark in 3-5 um at every angle", bool(np.all(core < sea))),
        Check(
            f"{name}: their thin edges are brighter than their interior in 3-5 um, by "
            f"{100 * np.min(rim / core - 1):.0f} % or more",
            bool(np.all(rim > core)),
        ),
        Check(
            f"{name}: contrast of cloud and sea in 8-14 um at most {contrasts.max():.2f} of that in 3-5 um",
            bool(np.all(contrasts < 1.0)),
        ),
        Check(
            f"{name}: the steepest fall in 3-5 and 8-14 um is to 70 deg",
            all(fall[-1] > 0.0 and fall[-1] == fall.max() for fall in falls),
        ),
    ]


def _largest_share(rows: list[Row]) -> float:
    """Return the largest relative difference from the printed numbers."""
    return max(abs(row.difference / row.published) for row in rows if row.difference is not None and row.published)


def _number(value: Any) -> float | None:
    return None if value is None else float(value)


def _side_by_side(images: dict[str, NDArray[np.uint8]]) -> Figure:
    figure = blank(7.0, 3.6)
    for axis, (name, image) in zip(figure.subplots(1, len(images)), images.items(), strict=True):
        image_panel(axis, image, f"in place of {name}")
    return figure


def _drawn(stacks: list[tuple[str, NDArray[np.float32]]], views_deg: list[float]) -> Figure:
    figure = blank(10.0, 1.33 * len(stacks) + 0.2)
    axes = figure.subplots(len(stacks), len(views_deg))
    for number, (row, (label, images)) in enumerate(zip(axes, stacks, strict=True)):
        limits = (float(np.quantile(images, 0.002)), float(np.quantile(images, 0.998)))
        for axis, image, view in zip(row, images, views_deg, strict=True):
            image_panel(axis, image, f"{view:g}°" if number == 0 else "", limits, most=80)
        row[0].set_ylabel(label, rotation=0, labelpad=12)
    return figure
