"""The abstract's three numbers, from the printed tables and from what is computed here."""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.paper.fitted import fitted
from hcss_twin.paper.item import Check, Reproduction, Row
from hcss_twin.paper.published import printed_row, published
from hcss_twin.paper.radiance_over_views import CLOUD_CHOICES
from hcss_twin.paper.scene import BANDS, black_surface, columns_over_views
from hcss_twin.paper.tables_8_and_9 import eq_24_percent
from hcss_twin.paper.verdict import judged

CLAIMED = {"3.0-5.0": 12.3, "8.0-14.0": 3.7, "shape": 8.3}
"""Percent; abstract and section VI."""

_LARGEST_VIEW_DEG = 60.0
_ROUNDING = 0.05
_LARGEST = 0.5


def headline(seed: int) -> Reproduction:
    """Return the errors that the abstract claims."""
    del seed  # nothing is drawn
    rows: list[Row] = []
    checks: list[Check] = []
    inputs = ["sea temperature", "glint scale"]
    upto = np.array(published()["view_zenith_deg"]) <= _LARGEST_VIEW_DEG
    for place, band in enumerate(BANDS):
        if band not in CLAIMED:
            continue
        name = f"Table IV, {band.replace('.0', '')} um"
        cover, surface = f"cover of {name}", f"MODTRAN surface of {name}"
        inputs += [cover, surface]
        claimed = CLAIMED[band]
        printed = _rms(printed_row("table_4", band)[upto], printed_row("table_4", band, "Modtran")[upto])
        black = black_surface(BANDS[band]).radiance(fitted(surface))[upto]
        ours, physical = (
            _rms(columns_over_views(model).mixed(fitted(cover), place)[upto], black)
            for model in ("as-printed", "physical")
        )
        rows += [
            Row(f"{band} um, from the printed rows", "%", claimed, printed),
            Row(f"{band} um, from the rows computed here", "%", claimed, ours, physical),
        ]
        checks += [
            _close(f"{band} um, rms over 0-60 deg of the printed rows", printed, claimed, _ROUNDING),
            _close(f"{band} um, the same of the rows computed here", ours, claimed, _LARGEST),
        ]
    table = published()["table_9"]["rows"]
    found = [eq_24_percent(table["real"][1:5], table[name][1:5])[1] for name in ("Image1", "Image2", "Image3")]
    mean = float(np.mean(found))
    rows += [Row("shape, mean of Table IX's three RMSE", "%", CLAIMED["shape"], mean)]
    checks.append(_close("mean of Table IX's three RMSE", mean, CLAIMED["shape"], _ROUNDING))
    return judged(
        rows,
        checks,
        holds="All three follow from the tables. What they say is another matter: see the notes.",
        fails="A claimed number does not follow from the tables.",
        inputs=inputs,
        notes=(
            "12.3 and 3.7 % compare a sunlit scene with thermal runs above a black surface, whose temperature is "
            "free. They measure how far the two scenes differ, not an error of either.",
            "8.3 % counts two images that were made with random cloud masks as controls; the image that was meant "
            f"to agree has {found[0]:.1f} %.",
        ),
        choices=CLOUD_CHOICES,
    )


def _rms(one: Array, other: Array) -> float:
    return 100.0 * float(np.sqrt(np.mean((one / other - 1.0) ** 2)))


def _close(what: str, found: float, claimed: float, limit: float) -> Check:
    off = abs(found - claimed)
    return Check(f"{what}: {found:.2f} %, claimed {claimed:g} %, off by at most {limit:.2g}", off <= limit)
