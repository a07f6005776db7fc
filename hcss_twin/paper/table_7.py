"""Table VII: radiance over cloud coverage."""

from __future__ import annotations

import numpy as np

from hcss_twin.paper.fitted import fitted
from hcss_twin.paper.item import Check, Reproduction, Row
from hcss_twin.paper.published import published
from hcss_twin.paper.radiance_over_views import CLOUD_CHOICES, PHYSICAL_NOTE, UNIT
from hcss_twin.paper.scene import BANDS, columns_over_views
from hcss_twin.paper.verdict import deviation_check, judged

LIMIT = 0.0034
"""Largest rms of differences that counts as reproduced: what a straight line leaves over."""


def table_7(seed: int) -> Reproduction:
    """Return the printed trend beside that of the columns of Tables II and IV."""
    del seed  # nothing is drawn
    table = published()["table_7"]
    coverage = np.array(table["coverage_pct"], dtype=np.float64) / 100.0
    printed = np.array(table["radiance"], dtype=np.float64)
    band = list(BANDS).index("3.0-5.0")
    view = published()["view_zenith_deg"].index(int(published()["baseline_geometry"]["view_zenith"]))
    found, physical = columns_over_views("as-printed"), columns_over_views("physical")

    def over_coverage(clear: float, opaque: float) -> np.ndarray:
        return (1.0 - coverage) * clear + coverage * opaque

    clear, opaque = float(found.clear[view, band]), float(found.opaque[view, band])
    computed = over_coverage(clear, opaque)
    corrected = over_coverage(float(physical.clear[view, band]), float(physical.opaque[view, band]))
    level, slope = fitted("Table VII without cloud"), fitted("Table VII per coverage")
    line = level + slope * coverage
    rows = [
        Row(f"{100 * share:g} %, columns of Tables II and IV", UNIT, *map(float, values))
        for share, *values in zip(coverage, printed, computed, corrected, strict=True)
    ]
    rows += [
        Row(f"{100 * share:g} %, straight line", UNIT, float(value), float(on_line))
        for share, value, on_line in zip(coverage, printed, line, strict=True)
    ]
    falls = bool(np.all(np.diff(printed) < 0) and np.all(np.diff(computed) < 0))
    checks = (
        Check("radiance falls with coverage, in print and in the columns of Tables II and IV", falls),
        deviation_check(f"straight line {level:.3f} - {-slope:.3f} C", line, printed, LIMIT, UNIT),
        deviation_check("columns of Tables II and IV", computed, printed, LIMIT, UNIT),
    )
    return judged(
        rows,
        checks,
        holds="The columns of Tables II and IV, mixed with the printed coverages, give the table.",
        fails=f"Radiance falls with coverage, as printed, but by {-slope:.2f} {UNIT} from clear to overcast, where "
        f"the columns that give Tables II and IV fall by {clear - opaque:.2f}. No input is shared; a straight line, "
        "two free numbers for five, describes the table and explains nothing.",
        inputs=["sea temperature", "glint scale", "Table VII without cloud", "Table VII per coverage"],
        notes=(
            "Opaque cloud at 6 km seen at 20 deg. Between Scenario3 and Scenario4 of Table II, too, the effective "
            "cover rises by far less than the printed coverage.",
            PHYSICAL_NOTE,
        ),
        choices=CLOUD_CHOICES,
    )
