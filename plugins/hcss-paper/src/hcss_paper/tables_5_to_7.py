"""Tables V to VII: sun angles and radiance over places and months, and radiance over cloud coverage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hcss_paper.fits import column_terms, fit_shared, printed_shared_rows, shared_rows
from hcss_paper.inputs import cover_names, effective_cover, published, sun_at_baseline, suns_of_table_5, suns_of_table_6
from hcss_paper.reproduction import Check, Reproduction, Row, judged, largest_check
from hcss_paper.scene import BANDS, columns_over_suns, columns_over_views
from hcss_paper.tables_2_and_4 import CLOUD_CHOICES, COVER_CHOICE, PHYSICAL_NOTE, UNIT
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
    choices = (
        "the year 2024 for January to April, although 2019 is printed",
        "coverage 30 %, that of Scenario3, whose radiance at nadir is the one printed for April",
        COVER_CHOICE,
    )
    return _suns("Table VI", labels, printed, suns_of_table_6(), choices, notes)


def _suns(
    name: str,
    labels: Sequence[str],
    printed: Sequence[Any],
    suns: tuple[Sun, ...],
    choices: tuple[str, ...],
    notes: tuple[str, ...],
) -> Reproduction:
    cover = effective_cover(name)
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
        "agrees within rounding with the sea temperature and the factor on the glint of Tables II, IV and VII.",
        fails="The difference of an angle or a radiance exceeds its rounding.",
        inputs=["sea temperature", "glint scale", *cover_names(name)],
        notes=(
            *notes,
            f"With the true distance of the sun the largest difference of radiance is {off:.1g}.",
            PHYSICAL_NOTE,
        ),
        choices=(*choices, NADIR_CHOICE, "the sun at 1 au on every day", *CLOUD_CHOICES),
    )


NADIR_CHOICE = "nadir view, although section IV-A states 20 deg"
LARGEST_RATIO = 1.3
"""Of the residual to that of the best straight line, which no mixture of two columns can go below."""


def table_7(seed: int) -> Reproduction:
    """Compare the printed trend with the columns of the other tables, mixed by the printed coverage."""
    del seed  # no random numbers are used
    table = published()["table_7"]
    coverage = np.array(table["coverage_pct"], dtype=np.float64) / 100.0
    printed = np.array(table["radiance"], dtype=np.float64)
    band = list(BANDS).index("3.0-5.0")
    covers = np.array([effective_cover("Table VII", coverage=float(each)) for each in coverage])
    computed, corrected = (
        (1.0 - covers) * found.clear[0, band] + covers * found.opaque[0, band]
        for found in (columns_over_views("as-printed"), columns_over_views("physical"))
    )
    on_line = np.polyval(np.polyfit(coverage, printed, 1), coverage)
    rows = [
        Row(f"{100 * share:g} %", UNIT, *map(float, values))
        for share, *values in zip(coverage, printed, computed, corrected, strict=True)
    ]
    left_out = rows_left_out()
    rows += [
        Row(f"{name} predicted from the other rows, rms of differences", "%", None, each)
        for name, each in left_out.items()
    ]
    best, found = (float(np.sqrt(np.mean((each - printed) ** 2))) for each in (on_line, computed))
    falls = bool(np.all(np.diff(printed) < 0) and np.all(np.diff(computed) < 0))
    checks = (
        Check("radiance falls with coverage, in print and computed", falls),
        Check(
            f"rms of differences {found:.4f} {UNIT}, that of the best straight line {best:.4f}: at most "
            f"{LARGEST_RATIO:g} times as large",
            found <= LARGEST_RATIO * best,
        ),
        Check(
            f"left out of the fit and predicted from the other rows: {left_out['Table VII']:.2f} %, at most "
            f"{LARGEST_LEFT_OUT_PERCENT:g} %",
            left_out["Table VII"] <= LARGEST_LEFT_OUT_PERCENT,
        ),
    )
    return judged(
        rows,
        checks,
        holds="The columns of Tables II and IV, seen from above and mixed by an effective cover that is linear in the "
        "printed coverage, give Table VII, Scenario3, Scenario4 and Table VI together.",
        fails="The columns of the other tables, mixed by an effective cover that is linear in the printed coverage, do "
        "not give Table VII.",
        inputs=["sea temperature", "glint scale", *cover_names("Table VII")],
        notes=(
            "Nine inputs give the 85 radiances of Tables II, IV (3-5 and 8-14 um), V, VI and VII. Each row was also "
            "left out of the fit and predicted: the rows above without a printed number. A row's own cover is then "
            "fitted to it alone.",
            "The printed values leave the best straight line by up to "
            f"{float(np.max(np.abs(on_line - printed))):.4f} {UNIT}: they fall by .018 from 30 to 40 % and by .002 "
            "from 40 to 50 %. The text calls the coverages approximate.",
            PHYSICAL_NOTE,
        ),
        choices=(NADIR_CHOICE, COVER_CHOICE, *CLOUD_CHOICES),
    )


LARGEST_LEFT_OUT_PERCENT = 1.2
"""Of Table VII: twice the relative residual of the best straight line, rounded up."""


def rows_left_out() -> dict[str, float]:
    """Return the rms of the relative differences, in percent, of each row predicted from the others."""
    terms, printed = column_terms(), printed_shared_rows()
    found = {}
    for name, values in printed.items():
        inputs = np.array(list(fit_shared(terms, name).values()))
        found[name] = 100.0 * float(np.sqrt(np.mean((shared_rows(terms, inputs)[name] / values - 1.0) ** 2)))
    return found
