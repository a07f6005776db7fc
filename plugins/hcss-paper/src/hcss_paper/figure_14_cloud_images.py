"""Fig 14: a real and a simulated cloud image, as grey levels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from hcss_evaluate.measures.histogram_metrics import to_grey_levels
from hcss_evaluate.measures.morphology import Morphology, morphology
from matplotlib.colors import LogNorm
from numpy.typing import NDArray

from hcss_paper.eq_5 import cloudy_pixels, fraction_value
from hcss_paper.figure_base import blank, image_panel
from hcss_paper.inputs import assumed, fitted, published
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.tables_8_and_9 import MEASURES, cloud_field

if TYPE_CHECKING:
    from matplotlib.figure import Figure


CHECKED = {"Den": 0.03, "DP": 0.03, "FD": 0.05}
"""Largest relative difference of each measure for an individual image; EV is not checked (see table-8)."""


def grey_levels(values: NDArray[np.float64], cloudy: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return grey levels as in the paper: clear pixels 0, cloudy pixels 1 to 255 between minimum and maximum."""
    return to_grey_levels(values, float(values[cloudy].min()), float(values[cloudy].max()), mask=cloudy)


def figure_14(seed: int) -> Reproduction:
    """Return a simulated image, and its measures compared with those of the printed one."""
    table = published()["table_8"]
    printed = dict(zip(MEASURES, map(float, table["sim"]), strict=True))
    real = dict(zip(MEASURES, map(float, table["real"]), strict=True))
    field = cloud_field("paper-simulated", seed)
    values = fraction_value(field.astype(np.float64))
    cloudy = cloudy_pixels(field, fitted("coverage of Table VIII"))
    found = measures(morphology(values, cloudy))
    image = grey_levels(values, cloudy)
    rows = [Row(f"(b) simulated image, {name}", _unit(name), printed[name], found[name]) for name in MEASURES]
    rows += [Row(f"(a) real image, {name}", _unit(name), real[name], None) for name in MEASURES]
    rows.append(Row("clear pixels, black", "1", None, float(np.mean(image == 0))))
    return judged(
        rows,
        checks_of(found, printed),
        holds="A simulated image of the same type agrees with the printed one in Den, DP and FD.",
        fails="A simulated image of the same type differs from the printed one in Den, DP or FD.",
        missing="The real image (a) is not published.",
        chosen=assumed(["coverage of Table VIII"]),
        notes=(
            "Individual images: other seeds differ by about 1 % in Den and DP and .03 in FD. table-8 compares means "
            "over several images; no variant of EV that was tried reproduces the printed value.",
            "These results do not depend on the radiance model.",
        ),
        drawings=(
            Drawing(
                "(b) Simulated cloud image, and its 2-D histogram of neighbours",
                _drawn(image),
                "Left, light clouds on black; right, counts of pairs of neighbouring grey levels, a narrow band along "
                "the diagonal.",
            ),
        ),
    )


def measures(found: Morphology) -> dict[str, float]:
    """Return EV, Den, DP and FD as the paper prints them; its Den is ten times that of eq 22."""
    values = (found.entropy, 10.0 * found.density, found.diagonal_peak, found.fractal_dimension)
    return dict(zip(MEASURES, map(float, values), strict=True))


def checks_of(found: dict[str, float], printed: dict[str, float]) -> list[Check]:
    """Compare the measures of an image with the printed ones."""
    checks = []
    for name, limit in CHECKED.items():
        off = abs(found[name] / printed[name] - 1.0)
        checks.append(
            Check(
                f"{name} of the simulated image: difference {100 * off:.1f} %, at most {100 * limit:g} %", off <= limit
            )
        )
    return checks


def _unit(name: str) -> str:
    return "bit" if name == "EV" else "1"


def _drawn(image: NDArray[np.uint8]) -> Figure:
    figure = blank(9.0, 4.7)
    left, right = figure.subplots(1, 2)
    image_panel(left, image, "grey levels, 800 x 800 pixels", (0.0, 255.0), most=400)
    pairs: Any = np.histogram2d(image[:, :-1].ravel(), image[:, 1:].ravel(), bins=128, range=[[0, 256], [0, 256]])[0]
    shown = right.imshow(
        np.ma.masked_equal(pairs.T, 0), origin="lower", extent=(0, 256, 0, 256), norm=LogNorm(), cmap="viridis"
    )
    right.set(xlabel="grey level", ylabel="of the pixel to its right", title="pairs, in cells of 2 x 2 levels")
    figure.colorbar(shown, ax=right, label="count")
    return figure
