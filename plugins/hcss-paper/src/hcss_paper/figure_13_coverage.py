"""Fig 13: images with coverages of 10 to 50 %."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from hcss_paper.cubes import NADIR_CHOICE, scene_inputs
from hcss_paper.figure_base import PHYSICAL_NOTE, RADIANCE, RADIANCE_SHOWN, blank, image_panel, simulated
from hcss_paper.fits import fitted_mixture
from hcss_paper.inputs import published
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged, largest_share_check, rms_percent
from hcss_paper.scene import Model
from hcss_paper.tables_2_and_4 import MIXTURE_NOTE, rows_of
from hcss_paper.tables_5_to_7 import LARGEST_OF_COVERAGES
from hcss_twin.providers import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


BAND = "mwir"
SIDE_PIXELS = 800


def images(model: Model, coverages: list[float], seed: int, size: int = SIDE_PIXELS) -> tuple[Array, Array]:
    """Return radiance (coverages, rows, columns) and cloudy fraction (coverages,) of one cloud field."""
    cubes = [
        simulated(
            "baseline",
            model,
            {
                "bands": [BAND],
                "view.zenith": 0.0,
                "clouds.coverage": coverage,
                "image": {"rows": size, "columns": size, "pixel_size": 20.0},
                "seed": seed,
            },
        )
        for coverage in coverages
    ]
    radiance = np.stack([cube.radiance[0, 0].to_numpy().astype(np.float64) for cube in cubes])
    return radiance, np.array([float((cube.cloud_mask[0] > 0).mean()) for cube in cubes])


def figure_13(seed: int, size: int = SIDE_PIXELS) -> Reproduction:
    """Return one cloud field at five coverages, and the mean radiance compared with Table VII."""
    table = published()["table_7"]
    coverages = [percent / 100.0 for percent in table["coverage_pct"]]
    printed = np.array(table["radiance"], dtype=np.float64)
    found, shares = images("as-printed", coverages, seed, size)
    corrected, _ = images("physical", coverages, seed, size)
    means, other = found.mean(axis=(1, 2)), corrected.mean(axis=(1, 2))
    rows = [
        Row(f"({letter}) coverage", "%", 100 * wanted, 100 * float(share))
        for letter, wanted, share in zip("abcde", coverages, shares, strict=True)
    ]
    rows += rows_of(
        [f"({letter}) mean radiance" for letter in "abcde"], printed, means, other, fitted_mixture()["Table VII"]
    )
    return judged(
        rows,
        [
            *checks_of(found, shares, coverages),
            largest_share_check("mean radiance, Table VII", means, printed, LARGEST_OF_COVERAGES),
        ],
        holds="Coverages agree with the captions, and mean radiance, which is Table VII, with the printed one: rms of "
        f"differences {rms_percent(means, printed):.2f} %.",
        fails="A coverage or a mean radiance differs from the printed one.",
        chosen=scene_inputs(NADIR_CHOICE),
        notes=(
            "Physical: clouds reflect sunlight, but radiance still falls, because they hide the brighter glint.",
            MIXTURE_NOTE,
            PHYSICAL_NOTE,
        ),
        drawings=(
            Drawing(
                "Coverage 10 to 50 %, 3-5 um: as-printed (top) and physical (bottom)",
                _drawn([found, corrected], coverages),
                "Two rows of five images with increasing dark cloud on a bright sea; thin edges are grey.",
            ),
        ),
    )


def checks_of(found: Array, shares: Array, coverages: list[float]) -> list[Check]:
    """Check the statements of captions and text for radiance (coverages, rows, columns)."""
    off = float(np.max(np.abs(shares - coverages)))
    pixel = 1.0 / found[0].size
    means = found.mean(axis=(1, 2))
    grows = all(np.all(more <= less * (1.0 + 2e-3)) for less, more in itertools.pairwise(found))
    return [
        Check(f"coverage exact to one pixel: difference {off:.1e}, at most {0.5 * pixel:.1e}", off <= 0.51 * pixel),
        Check(
            f"mean radiance falls with every step, {means[0]:.3f} to {means[-1]:.3f} {RADIANCE}",
            bool(np.all(np.diff(means) < 0)),
            "section IV-D",
        ),
        Check("no pixel becomes brighter as coverage increases", bool(grows)),
    ]


def _drawn(rows: list[Array], coverages: list[float]) -> Figure:
    figure = blank(10.4, 4.6)
    for axes, stack in zip(figure.subplots(len(rows), len(coverages)), rows, strict=True):
        limits = (float(stack.min()), float(stack.max()))
        for letter, axis, image, coverage in zip("abcde", axes, stack, coverages, strict=True):
            shown = image_panel(axis, image, f"({letter}) {coverage:.0%}", limits, most=160)
        figure.colorbar(shown, ax=list(axes), shrink=0.9, label=RADIANCE_SHOWN)
    return figure
