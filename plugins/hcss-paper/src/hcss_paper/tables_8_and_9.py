"""Tables VIII and IX: measures of cloud images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from hcss_evaluate.measures.morphology import Morphology, morphology, relative_errors, root_mean_square
from numpy.typing import NDArray

from hcss_paper.eq_5 import cloudy_pixels, fraction_value
from hcss_paper.ev_readings import Reading, readings
from hcss_paper.inputs import fitted, published
from hcss_paper.reproduction import Check, Reproduction, Row, judged
from hcss_twin import Scenario, make_plan

SEED = 1
"""Seed of the images to which inputs are fitted, and the default of the command."""

IMAGES = 8
"""Number of images averaged; the standard deviation of an individual one is 1 % in Den and DP and .03 in FD."""

MEASURES = ("EV", "Den", "DP", "FD")


@lru_cache(maxsize=2 * IMAGES)
def cloud_field(cloud_type: str, seed: int) -> NDArray[Any]:
    """Return eqs 2 and 3 for 800 x 800 pixels of 20 m, (800, 800)."""
    loaded = Scenario.load(
        "baseline", {"clouds.type": cloud_type, "seed": seed, "frames.count": 1, "output.variables": ["cloud_mask"]}
    )
    generator: Any = make_plan(loaded).assembly.generators[0]
    rows, columns = loaded.image.rows, loaded.image.columns
    field: NDArray[Any] = generator.field(0.0, slice(0, rows), slice(0, columns))
    return field


def cloud_mask(cloud_type: str, coverage: float, seed: int) -> NDArray[np.bool_]:
    """Return the cloudy pixels of one cloud field."""
    mask: NDArray[np.bool_] = cloudy_pixels(cloud_field(cloud_type, seed), coverage)
    return mask


@lru_cache(maxsize=8 * IMAGES)
def measured(cloud_type: str, coverage: float, seed: int) -> Morphology:
    """Return the measures of one cloud field."""
    field = cloud_field(cloud_type, seed)
    return morphology(fraction_value(field), cloudy_pixels(field, coverage))


def mean_measures(cloud_type: str, coverage: float, seed: int) -> dict[str, float]:
    """Return EV, Den, DP and FD as the paper prints them, as means over :data:`IMAGES` seeds from ``seed`` on.

    The paper prints ten times the density of eq 22, which cannot exceed 1.
    """
    found = [measured(cloud_type, coverage, seed + number) for number in range(IMAGES)]
    return {
        "EV": float(np.mean([measures.entropy for measures in found])),
        "Den": 10.0 * float(np.mean([measures.density for measures in found])),
        "DP": float(np.mean([measures.diagonal_peak for measures in found])),
        "FD": float(np.mean([measures.fractal_dimension for measures in found])),
    }


UNITS = {"EV": "bit", "Den": "1", "DP": "1", "FD": "1"}

# A single image of this type has a standard deviation of 1 % in Den and DP and of .03 in FD.
LARGEST = {"EV": ("share", 0.05), "Den": ("share", 0.03), "DP": ("share", 0.03), "FD": ("absolute", 0.06)}
"""Largest difference of a reproduced measure, relative or absolute."""

# Half a unit of the last printed digit of EV, Den, DP and FD, and of percentages.
_HALF_8 = (5e-4, 5e-4, 0.5, 5e-4)
_HALF_9 = (5e-4, 5e-4, 5e-3, 5e-4)
_HALF_PERCENTAGE = 5e-3

_NOTES = (
    f"Computed: means over {IMAGES} images of type simulated, 800 x 800 pixels of 20 m, 256 grey levels. The paper's "
    "own images, real or simulated, are not published.",
    "Den is printed ten times too large: eq 22 cannot exceed 1. DP is divided by W - 1, as printed.",
)

_CHOICES = (
    "FD: a box count of the volume below the grey-level surface, the only interpretation of eq 6 that gives the "
    "printed values",
    "L of Table III: lattice cells per 16 km, the interpretation that gives the printed Den of Table VIII",
)


def eq_24_percent(real: Sequence[float], simulated: Sequence[float]) -> tuple[tuple[float, ...], float]:
    """Return the errors of eq 24 and their RMSE in percent, as the tables print them."""
    errors = tuple(100.0 * error for error in relative_errors(real, simulated))
    return errors, root_mean_square(errors)


def eq_24_limits(
    real: Sequence[float], simulated: Sequence[float], half: Sequence[float]
) -> tuple[tuple[tuple[float, float], ...], tuple[float, float]]:
    """Return the smallest and largest errors and RMSE, in percent, for entries known within their rounding.

    Parameters
    ----------
    real, simulated : sequence of float
        As printed.
    half : sequence of float
        Half a unit of the last printed digit of each measure.
    """
    errors = tuple(
        (
            100.0 * max(0.0, abs(one - other) - 2.0 * off) / (other + off),
            100.0 * (abs(one - other) + 2.0 * off) / (other - off),
        )
        for one, other, off in zip(real, simulated, half, strict=True)
    )
    return errors, (root_mean_square([low for low, _ in errors]), root_mean_square([high for _, high in errors]))


def table_8(seed: int) -> Reproduction:
    """Return Table VIII except EV."""
    table = published()["table_8"]
    coverage = fitted("coverage of Table VIII")
    printed = dict(zip(MEASURES, table["sim"], strict=True))
    rows, checks = _measures(
        "simulated image", printed, mean_measures("paper-simulated", coverage, seed), ("Den", "DP", "FD")
    )
    errors, rmse = eq_24_percent(table["real"], table["sim"])
    rows += [
        Row(f"error of {name}", "%", float(stated), found)
        for name, stated, found in zip(MEASURES, table["err_pct"], errors, strict=True)
    ]
    rows.append(Row("RMSE", "%", table["rmse_pct"], rmse))
    limits, of_rmse = eq_24_limits(table["real"], table["sim"], _HALF_8)
    checks += [
        _within(f"error of {name}", float(stated), *limit)
        for name, stated, limit in zip(MEASURES, table["err_pct"], limits, strict=True)
    ]
    checks.append(_within("RMSE", table["rmse_pct"], *of_rmse))
    return judged(
        rows,
        checks,
        holds="Eq 24 gives the printed errors and their RMSE from the printed entries, and clouds of type "
        "simulated reproduce Den, DP and FD of the printed image at one coverage.",
        fails="A measure of clouds of type simulated, or eq 24, differs from the printed values.",
        inputs=["coverage of Table VIII"],
        choices=_CHOICES,
        notes=(*_NOTES, "EV is a separate item; it is not reproduced."),
    )


def table_9(seed: int) -> Reproduction:
    """Return Table IX except EV and Den."""
    table = published()["table_9"]["rows"]
    real = table["real"][1:5]
    rows: list[Row] = []
    checks: list[Check] = []
    for name in ("Image1", "Image2", "Image3"):
        coverage, *printed, stated = table[name]
        found = mean_measures("paper-simulated", coverage / 100.0, seed)
        more_rows, more_checks = _measures(
            f"{name}, coverage {coverage:g} %", dict(zip(MEASURES, printed, strict=True)), found, ("DP", "FD")
        )
        _, rmse = eq_24_percent(real, printed)
        rows += [*more_rows, Row(f"{name}, RMSE", "%", stated, rmse)]
        _, limits = eq_24_limits(real, printed, _HALF_9)
        checks += [*more_checks, _within(f"{name}, RMSE", stated, *limits)]
    return judged(
        rows,
        checks,
        holds="Eq 24 gives all three RMSE from the printed entries, and clouds of type simulated have the printed "
        "DP and FD at the printed coverages.",
        fails="A measure of clouds of type simulated, or eq 24, differs from the printed values.",
        choices=_CHOICES,
        notes=(*_NOTES, "EV and Den are a separate item; they are not reproduced."),
    )


def table_8_entropy(seed: int) -> Reproduction:
    """Return EV of Table VIII."""
    printed = dict(zip(MEASURES, published()["table_8"]["sim"], strict=True))
    found = mean_measures("paper-simulated", fitted("coverage of Table VIII"), seed)
    rows, checks = _measures("simulated image", printed, found, ("EV",))
    return _missed(rows, checks, "EV", ["coverage of Table VIII"], seed)


def table_9_entropy(seed: int) -> Reproduction:
    """Return EV and Den of Table IX."""
    table = published()["table_9"]["rows"]
    rows: list[Row] = []
    checks: list[Check] = []
    for name in ("Image1", "Image2", "Image3"):
        coverage, *printed, _ = table[name]
        found = mean_measures("paper-simulated", coverage / 100.0, seed)
        label = f"{name}, coverage {coverage:g} %"
        more = _measures(label, dict(zip(MEASURES, printed, strict=True)), found, ("EV", "Den"))
        rows += more[0]
        checks += more[1]
    return _missed(rows, checks, "EV and Den (off by about 6 %)", (), seed)


LARGEST_OFF_OF_READING = 0.05


@lru_cache(maxsize=2)
def _readings_of_ev(seed: int) -> tuple[str, float]:
    """Return what other readings of EV give for all four printed images, and the largest error of the best one."""
    table = published()["table_9"]["rows"]
    printed = [(fitted("coverage of Table VIII"), published()["table_8"]["sim"][:2])]
    printed += [(table[name][0] / 100.0, table[name][1:3]) for name in ("Image1", "Image2", "Image3")]
    field = cloud_field("paper-simulated", seed).astype(np.float64)
    found = [readings(field, coverage) for coverage, _ in printed]
    off = {
        reading: tuple(
            max(
                abs(readings[which][reading] / values[which] - 1.0)
                for readings, (_, values) in zip(found, printed, strict=True)
            )
            for which in (0, 1)
        )
        for reading in found[0][0]
    }
    best = min(off, key=lambda reading: off[reading][0])
    good = [den for ev, den in off.values() if ev <= LARGEST_OFF_OF_READING]
    of_eq_21 = off[Reading("p of eq 5", "clouds", 256, "pairs", "bit")][0]
    told = (
        f"Of {len(off)} readings of EV (what grey levels are proportional to, their number and stretch, what is "
        f"counted, unit), {len(good)} give the EV of all four images of Tables VIII and IX within "
        f"{100 * LARGEST_OFF_OF_READING:g} %, where eq 21 as printed is off by up to {100 * of_eq_21:.0f} %. The best "
        f"is off by at most {100 * off[best][0]:.1f} % (grey levels: {best.grey}, {best.levels} over the "
        f"{best.stretch}; counted: {best.counted}; unit: {best.unit}), but its Den by up to {100 * off[best][1]:.0f} %"
        + (f"; the least Den error of these {len(good)} is {100 * min(good):.0f} %." if good else ".")
    )
    both = min(max(pair) for pair in off.values())
    return f"{told} The smallest error that a reading has for EV and Den together is {100 * both:.0f} %.", both


def _missed(rows: list[Row], checks: list[Check], what: str, inputs: Sequence[str], seed: int) -> Reproduction:
    told, both = _readings_of_ev(seed)
    return judged(
        rows,
        [
            *checks,
            Check(
                f"a reading of EV gives EV and Den of all four images within {100 * LARGEST_OFF_OF_READING:g} %: the "
                f"best within {100 * both:.0f} %",
                both <= LARGEST_OFF_OF_READING,
            ),
        ],
        holds=f"Clouds of type simulated have the printed {what}.",
        fails=f"Clouds of type simulated at the same coverage do not reproduce {what}; the images from which it was "
        f"computed are not published. {told}",
        inputs=inputs,
        notes=_NOTES,
        choices=_CHOICES[1:],
    )


def _measures(
    label: str, printed: Mapping[str, float], found: Mapping[str, float], names: Sequence[str]
) -> tuple[list[Row], list[Check]]:
    rows, checks = [], []
    for name in names:
        rows.append(Row(f"{label}, {name}", UNITS[name], float(printed[name]), found[name]))
        kind, limit = LARGEST[name]
        if kind == "share":
            off = abs(found[name] / printed[name] - 1.0)
            told_off = f"{100 * off:.2g} % off, at most {100 * limit:g} %"
        else:
            off = abs(found[name] - printed[name])
            told_off = f"{off:.2g} off, at most {limit:g}"
        checks.append(Check(f"{label}, {name}: {told_off}", off <= limit))
    return rows, checks


def _within(label: str, stated: float, low: float, high: float) -> Check:
    """Compare a printed percentage with the range that eq 24 gives for entries within their rounding."""
    return Check(
        f"{label}, printed {stated:.2f} %: eq 24 gives {low:.2f} to {high:.2f} % for the printed entries "
        "within their rounding",
        low - _HALF_PERCENTAGE <= stated <= high + _HALF_PERCENTAGE,
    )
