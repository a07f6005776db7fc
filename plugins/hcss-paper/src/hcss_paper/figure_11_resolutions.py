"""Fig 11: one cloud field with pixels of 5, 20 and 50 m."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hcss_paper.figure_base import (
    PHYSICAL_NOTE,
    RADIANCE,
    RADIANCE_SHOWN,
    blank,
    image_panel,
    radiance_inputs,
    simulated,
)
from hcss_paper.inputs import in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.scene import Model
from hcss_twin.providers import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SIDE_M = 4000.0
FINEST_M = 5.0
PIXELS_M = (5.0, 20.0, 50.0)
COARSEST_M = 100.0
"""The text states resolutions of 20 to 100 m."""

TYPE, COVERAGE, BAND = "cumulus", 0.4, "mwir"

LARGEST_OFF = {"as-printed": 2e-3, "physical": 2e-2}
"""Relative: twice the accuracy of the simulated images."""


def image(model: Model, pixel_m: float, seed: int) -> Array:
    """Return radiance (rows, columns) of the same 4 km scene; each pixel is the mean over points 5 m apart."""
    side = round(SIDE_M / pixel_m)
    cube = simulated(
        TYPE,
        model,
        {
            "bands": [BAND],
            "image": {
                "rows": side,
                "columns": side,
                "pixel_size": pixel_m,
                "samples_per_pixel": round(pixel_m / FINEST_M),
            },
            "clouds.coverage": COVERAGE,
            "clouds.coverage_mode": "field",
            "seed": seed,
        },
    )
    values: Array = cube.radiance[0, 0].to_numpy().astype(np.float64)
    return values


def block_means(values: Array, factor: int) -> Array:
    """Return means over blocks of ``factor`` x ``factor`` pixels, which must divide the image."""
    rows, columns = (side // factor for side in values.shape)
    means: Array = values.reshape(rows, factor, columns, factor).mean(axis=(1, 3))
    return means


def figure_11(seed: int) -> Reproduction:
    """Return one cloud field at three resolutions, and at 100 m."""
    sizes = (*PIXELS_M, COARSEST_M)
    images = {size: image("as-printed", size, seed) for size in sizes}
    corrected = {size: image("physical", size, seed) for size in PIXELS_M}
    rows = []
    for size in sizes:
        other = corrected.get(size)
        rows += [
            Row(f"{size:g} m, pixels along a side", "1", None, float(images[size].shape[0])),
            Row(
                f"{size:g} m, mean",
                RADIANCE,
                None,
                float(images[size].mean()),
                None if other is None else float(other.mean()),
            ),
            Row(
                f"{size:g} m, standard deviation",
                RADIANCE,
                None,
                float(images[size].std()),
                None if other is None else float(other.std()),
            ),
        ]
    return judged(
        rows,
        checks_of(images, LARGEST_OFF["as-printed"]),
        holds="Pixels of any size sample the same cloud field: coarse images equal the block means of the fine "
        "image, as after down-sampling, but are computed directly.",
        fails="Images of different resolution do not show the same cloud field.",
        chosen=(
            *in_words(f"type {TYPE}, coverage {COVERAGE:.0%}, band 3-5 um, {SIDE_M / 1e3:g} km scene: not stated"),
            *radiance_inputs(BAND),
        ),
        notes=(
            "The paper resamples images. Here each resolution is computed from the points of the 5 m image "
            "within each pixel.",
            PHYSICAL_NOTE,
        ),
        drawings=(
            Drawing(
                "A 4 km scene and its central 1 km, with pixels of 5, 20 and 50 m, 3-5 um",
                _drawn([("as-printed", images), ("as-printed", _middle(images)), ("physical", _middle(corrected))]),
                "Three rows of three images of the same dark clouds with grey edges, increasingly coarse: the whole "
                "scene, its centre, and the centre with the corrected physics.",
            ),
        ),
    )


def _middle(images: dict[float, Array]) -> dict[float, Array]:
    """Return the central kilometre of images by pixel size in m."""
    first, last = 0.5 * SIDE_M - 500.0, 0.5 * SIDE_M + 500.0
    found = {}
    for size, values in images.items():
        part = slice(round(first / size), round(last / size))
        found[size] = values[part, part]
    return found


def checks_of(images: dict[float, Array], allowed: float) -> list[Check]:
    """Compare images by pixel size in m with the block means of the finest; ``allowed`` is relative."""
    checks = []
    fine = images[FINEST_M]
    for size in sorted(images)[1:]:
        means = block_means(fine, round(size / FINEST_M))
        off = float(np.max(np.abs(images[size] / means - 1.0)))
        checks.append(
            Check(
                f"{size:g} m against block means of 5 m: largest relative difference {off:.1e}, at most {allowed:g}",
                off <= allowed,
                "section IV-C",
            )
        )
    spreads = [float(images[size].std()) for size in sorted(images)]
    checks.append(Check("standard deviation decreases with pixel size", bool(np.all(np.diff(spreads) < 0))))
    return checks


def _drawn(rows: list[tuple[str, dict[float, Array]]]) -> Figure:
    figure = blank(8.0, 8.2)
    for axes, (model, images) in zip(figure.subplots(len(rows), len(PIXELS_M)), rows, strict=True):
        limits = (float(images[FINEST_M].min()), float(images[FINEST_M].max()))
        for letter, axis, size in zip("abc", axes, PIXELS_M, strict=True):
            shown = image_panel(
                axis, images[size], f"({letter}) {size:g} m, {model}, {size * len(images[size]) / 1e3:g} km", limits
            )
        figure.colorbar(shown, ax=list(axes), shrink=0.9, label=RADIANCE_SHOWN)
    return figure
