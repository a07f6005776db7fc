"""Tables V to VII: sun angles and radiance over places and months, and radiance over cloud coverage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hcss_paper.inputs import fitted, published, sun_at_baseline, suns_of_table_5, suns_of_table_6
from hcss_paper.reproduction import Check, Reproduction, Row, deviation_check, judged, largest_check
from hcss_paper.scene import BANDS, columns_over_suns, columns_over_views
from hcss_paper.tables_2_and_4 import CLOUD_CHOICES, PHYSICAL_NOTE, UNIT
from hcss_twin.providers import Sun

LARGEST_ANGLE_DEG = 6e-4
LARGEST_RADIANCE = 6e-4
"""Slightly more than the printed rounding, .0005."""


def table_5(seed: int) -> Reproduction:
    """Return Table V."""
    del seed  # no random numbers are used
    printed = published()["table_5"]["rows"]
    labels = [f"Scenario{row[0]}, {abs(row[1])} {'NS'[row[1] < 0]} {row[2]} E" for row in printed]
    notes = (
        "12:30 on 20 April 2019. The change with longitude in the table is the difference between clock time and "
        "solar time within a zone: at the same solar time there would be almost none.",
    )
    choices = ("time zone: the whole-hour zone nearest to the longitude",)
    return _suns("Table V", labels, printed, suns_of_table_5(), choices, notes)


def table_6(seed: int) -> Reproduction:
    """Return Table VI."""
    del seed
    printed = published()["table_6"]["rows"]
    labels = [f"Scenario{row[0]}, {row[1]}" for row in printed]
    true = sun_at_baseline(2019, 4, 20)
    notes = (
        "At 12:30 on 20 April 2019 the sun's angles over this place are "
        f"{true.zenith_deg:.3f} and {true.azimuth_deg:.3f} deg.",
        "Only the sun's angle changes over the year: air, sea temperature and cloud are those of one day.",
    )
    choices = ("the year 2024 for January to April, although 2019 is printed",)
    return _suns("Table VI", labels, printed, suns_of_table_6(), choices, notes)


def _suns(
    name: str,
    labels: Sequence[str],
    printed: Sequence[Any],
    suns: tuple[Sun, ...],
    choices: tuple[str, ...],
    notes: tuple[str, ...],
) -> Reproduction:
    cover = fitted(f"cover of {name}")
    radiance = columns_over_suns("as-printed", suns).mixed(cover)
    physical = columns_over_suns("physical", suns).mixed(cover)
    zenith, azimuth, stated = np.array([row[-3:] for row in printed], dtype=np.float64).T
    found_zenith = np.array([sun.zenith_deg for sun in suns])
    found_azimuth = np.array([sun.azimuth_deg for sun in suns])
    rows = []
    for place, label in enumerate(labels):
        rows += [
            Row(f"{label}, solar zenith", "deg", float(zenith[place]), float(found_zenith[place])),
            Row(f"{label}, solar azimuth", "deg", float(azimuth[place]), float(found_azimuth[place])),
            Row(f"{label}, radiance", UNIT, float(stated[place]), float(radiance[place]), float(physical[place])),
        ]
    seasonal = columns_over_suns("as-printed", suns, one_distance=False).mixed(cover)
    off = float(np.max(np.abs(seasonal - stated)))
    checks = (
        largest_check("solar zenith", found_zenith, zenith, LARGEST_ANGLE_DEG, "deg"),
        largest_check("solar azimuth", found_azimuth, azimuth, LARGEST_ANGLE_DEG, "deg"),
        largest_check("radiance", radiance, stated, LARGEST_RADIANCE, UNIT),
    )
    return judged(
        rows,
        checks,
        holds="Every sun angle agrees to the printed digits (NREL algorithm, refracted zenith). The radiance "
        "agrees within rounding with an effective cover for this table and a factor on the glint that is common "
        "to Tables V and VI.",
        fails="The difference of an angle or a radiance exceeds its rounding.",
        inputs=["sea temperature", "nadir glint scale", f"cover of {name}"],
        notes=(
            *notes,
            f"With the true distance of the sun the largest difference of radiance is {off:.1g}.",
            PHYSICAL_NOTE,
        ),
        choices=(
            *choices,
            "nadir view, although section IV-A states 20 deg",
            "the sun at 1 au on every day",
            *CLOUD_CHOICES,
        ),
    )


LIMIT = 0.0034
"""Largest rms of differences of a reproduced row: the residual of a straight line."""


def table_7(seed: int) -> Reproduction:
    """Compare the printed trend with that of the columns of Tables II and IV."""
    del seed  # no random numbers are used
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
        holds="The columns of Tables II and IV, mixed with the printed coverages, reproduce the table.",
        fails=f"From clear to overcast, the printed radiance falls by {-slope:.2f} {UNIT}, that of the columns for "
        f"Tables II and IV by {clear - opaque:.2f}. No common input fits both; a straight line (two parameters for "
        "five values) fits the table but does not explain it.",
        inputs=["sea temperature", "glint scale", "Table VII without cloud", "Table VII per coverage"],
        notes=(
            "Opaque cloud at 6 km viewed at 20 deg. Between Scenario3 and Scenario4 of Table II the effective cover "
            "also rises by far less than the printed coverage.",
            PHYSICAL_NOTE,
        ),
        choices=CLOUD_CHOICES,
    )
