"""Tables V to VII: sun angles and radiance over places and months, and radiance over cloud coverage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hcss_paper.fits import column_terms, fit_shared, printed_shared_rows, shared_rows
from hcss_paper.inputs import (
    cover_names,
    effective_cover,
    fitted,
    published,
    sun_at_baseline,
    suns_of_table_5,
    suns_of_table_6,
)
from hcss_paper.reproduction import Check, Reproduction, Row, judged, largest_check
from hcss_paper.scene import BANDS, black_surface, columns_over_suns, columns_over_views
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
    choices = (ZONE_CHOICE,)
    return _suns("Table V", labels, printed, suns_of_table_5(), choices, notes)


def table_6(seed: int) -> Reproduction:
    """Return Table VI."""
    del seed
    printed = published()["table_6"]["rows"]
    labels = [f"Scenario{row[0]}, {row[1]}" for row in printed]
    notes = ("Only the sun's angle changes over the year: air, sea temperature and cloud are those of one day.",)
    choices = (
        YEAR_CHOICE,
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
    stated = np.array([row[-1] for row in printed], dtype=np.float64)
    rows = [
        Row(f"{label}, radiance", UNIT, *map(float, values))
        for label, *values in zip(labels, stated, radiance, physical, strict=True)
    ]
    seasonal = columns_over_suns("as-printed", suns, one_distance=False).mixed(cover)
    off = float(np.max(np.abs(seasonal - stated)))
    checks = (largest_check("radiance", radiance, stated, LARGEST_RADIANCE, UNIT),)
    return judged(
        rows,
        checks,
        holds="The radiance agrees within rounding with the sea temperature and the factor on the glint of Tables II, "
        "IV and VII.",
        fails="The difference of a radiance exceeds its rounding.",
        inputs=["sea temperature", "glint scale", *cover_names(name)],
        notes=(
            *notes,
            f"With the true distance of the sun the largest difference of radiance is {off:.1g}.",
            PHYSICAL_NOTE,
        ),
        choices=(*choices, NADIR_CHOICE, "the sun at 1 au on every day", *CLOUD_CHOICES),
    )


ZONE_CHOICE = "time zone: the whole-hour zone nearest to the longitude"
YEAR_CHOICE = "the year 2024 for January to April, although 2019 is printed"


def sun_angles(seed: int) -> Reproduction:
    """Return the sun angles of Tables V and VI and of the baseline scene, which no fitted number enters."""
    del seed
    rows = [
        (f"Scenario{row[0]}", row[-3:-1], sun)
        for table, suns in (("table_5", suns_of_table_5()), ("table_6", suns_of_table_6()))
        for row, sun in zip(published()[table]["rows"], suns, strict=True)
    ]
    place = published()["baseline_geometry"]
    rows.append(("Baseline", (place["solar_zenith"], place["solar_azimuth"]), sun_at_baseline(2024, 4, 20)))
    printed = np.array([angles for _, angles, _ in rows], dtype=np.float64)
    found = np.array([(sun.zenith_deg, sun.azimuth_deg) for *_, sun in rows])
    true = sun_at_baseline(2019, 4, 20)
    return judged(
        [
            Row(f"{label}, solar {name}", "deg", float(printed[index, column]), float(found[index, column]))
            for index, (label, *_) in enumerate(rows)
            for column, name in enumerate(("zenith", "azimuth"))
        ],
        (
            largest_check("Tables V and VI", found[:-1], printed[:-1], LARGEST_ANGLE_DEG, "deg"),
            largest_check("baseline scene, two decimals", found[-1], printed[-1], 0.0055, "deg"),
        ),
        holds="All angles agree to the printed digits (NREL algorithm, refracted zenith).",
        fails="The difference of an angle exceeds its rounding.",
        choices=(ZONE_CHOICE, YEAR_CHOICE),
        notes=(
            "At 12:30 on 20 April 2019 the sun's angles over the baseline place are "
            f"{true.zenith_deg:.3f} and {true.azimuth_deg:.3f} deg.",
        ),
    )


FIXED_MODTRAN = 0.5757
"""Radiance of MODTRAN in the sensitivity analysis (section V-C), W m-2 sr-1, 3-5 um."""
RANGES = {"coverage, 10 to 50 %": (0.648, 0.604), "months": (0.608, 0.639), "places": (0.613, 0.630)}
"""First and last, or least and largest, radiance of section V-C."""


def sensitivity(seed: int) -> Reproduction:
    """Return the sensitivity analysis of section V-C: ranges over coverage, months and places, and MODTRAN's value."""
    del seed
    found = columns_over_views("as-printed")
    band = list(BANDS).index("3.0-5.0")
    covers = np.array([effective_cover("Table VII", coverage=share) for share in (0.1, 0.5)])
    of_coverage = (1.0 - covers) * found.clear[0, band] + covers * found.opaque[0, band]
    months, places = (
        columns_over_suns("as-printed", suns).mixed(effective_cover(name))
        for name, suns in (("Table VI", suns_of_table_6()), ("Table V", suns_of_table_5()))
    )
    ends = (of_coverage, np.array([months.min(), months.max()]), np.array([places.min(), places.max()]))
    surface = "MODTRAN surface of Scenario3"
    fixed = float(black_surface(BANDS["3.0-5.0"]).radiance(fitted(surface))[0])
    rows, checks = [], []
    for (name, printed), values in zip(RANGES.items(), ends, strict=True):
        rows += [
            Row(f"{name}, {end}", UNIT, *map(float, pair))
            for end, *pair in zip(("first", "last"), printed, values, strict=True)
        ]
        change, stated = float(np.ptp(values)), abs(printed[1] - printed[0])
        checks.append(
            Check(
                f"change with {name}: {change:.4f} {UNIT}, printed {stated:.3f}, at most a quarter off",
                abs(change / stated - 1.0) <= 0.25,
            )
        )
    rows.append(Row("MODTRAN, whatever the sun and the coverage", UNIT, FIXED_MODTRAN, fixed))
    share = abs(fixed / FIXED_MODTRAN - 1.0)
    checks.append(
        Check(
            f"black surface of Scenario3's MODTRAN column seen from above: {fixed:.4f} {UNIT}, printed "
            f"{FIXED_MODTRAN}: {100 * share:.1f} % off, at most 1 %",
            share <= 0.01,
        )
    )
    return judged(
        rows,
        checks,
        holds="The ranges follow from the inputs of Tables V to VII, and MODTRAN's value is that of clear air above "
        "the black surface of Scenario3's MODTRAN column, which no sun and no cloud can change.",
        fails="A range, or MODTRAN's value, does not follow from the inputs of the other tables.",
        inputs=["sea temperature", "glint scale", *cover_names("Table VII"), "cover of Table V", surface],
        choices=(NADIR_CHOICE, COVER_CHOICE, *CLOUD_CHOICES),
        notes=("MODTRAN is insensitive because the runs have neither sun nor cloud, not because of its physics.",),
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
