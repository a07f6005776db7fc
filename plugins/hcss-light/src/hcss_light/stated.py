"""Errors that the tiers state for a scene, from a table of measurements against Monte Carlo.

``benchmarks/tiers.py`` measures the table: pixels of 100 m, coverage .45, one sun for the day. Scenes get the row of
their cloud type (of other types the largest) and of the nearer band, between those of neighbouring view angles. What
the noise of Monte Carlo hides is not stated as zero.
"""

from __future__ import annotations

import csv
import math
from importlib.resources import files

import numpy as np

from hcss_twin.providers import Array

THERMAL_UM = 6.0
"""Wavelength that divides the two bands of the table."""

HIDDEN = 3.0
"""Rms that can hide in the noise of 24 to 48 pixels, in standard errors of their mean."""


MEASURED_M = 100.0
"""Pixels of the table."""

SCENES_DIFFER, STRONG_SCATTERING, STRONG_UM = 2.0, 2.0, 9.5
"""Factor by which scenes err more than those of the table: of random ones most are within it
(``benchmarks/estimates.py``). Another between 6 um and the last wavelength, where water clouds scatter more than at
10.8 um."""


def stated_errors(
    tier: str, kind: str, view_zenith_deg: float, sunlit: bool, wavelength_um: Array, point_m: float
) -> list[float]:
    """Return the error (B,) of a tier at some wavelengths: rms over pixels, relative to the mean radiance.

    It is a bound for most scenes, not their mean.
    """
    text = files("hcss_light").joinpath("errors.csv").read_text(encoding="utf-8")
    rows = [row for row in csv.DictReader(text.splitlines()) if row["tier"] == tier]
    rows = [row for row in rows if row["sun"] == ("day" if sunlit else "night")]
    errors = []
    for wavelength in wavelength_um.tolist():
        band = "lwir" if wavelength > THERMAL_UM else "mwir"
        own = [row for row in rows if row["band"] == band]
        own = [row for row in own if row["type"] == kind] or own
        measured: dict[float, float] = {}
        for row in own:
            view = float(row["view_deg"])
            measured[view] = max(measured.get(view, 0.0), _least(row, point_m))
        views = sorted(measured)
        factor = SCENES_DIFFER * (STRONG_SCATTERING if THERMAL_UM < wavelength < STRONG_UM else 1.0)
        errors.append(factor * float(np.interp(view_zenith_deg, views, [measured[each] for each in views])))
    return errors


def _least(row: dict[str, str], point_m: float) -> float:
    """Return what is stated for a row: means stay as they are in larger pixels, single pixels come nearer to them."""
    bias, rms = abs(float(row["bias"])), float(row["rms"])
    spread = math.sqrt(max(rms * rms - bias * bias, 0.0)) * min(MEASURED_M / point_m, 1.0)
    return max(math.hypot(bias, spread), HIDDEN * float(row["noise"]))
