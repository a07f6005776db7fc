"""Errors that the tiers state for a scene, from a table of measurements against Monte Carlo.

``benchmarks/tiers.py`` measures the table: pixels of 100 m, coverage .45, one sun for the day. Scenes get the row of
their cloud type (of other types the largest), of the next larger view angle, and of the nearer band. What the noise of
Monte Carlo hides is not stated as zero.
"""

from __future__ import annotations

import csv
from importlib.resources import files

import numpy as np

from hcss_twin.providers import Array

THERMAL_UM = 6.0
"""Wavelength that divides the two bands of the table."""

HIDDEN = 3.0
"""Rms that can hide in the noise of 24 to 48 pixels, in standard errors of their mean."""


def stated_errors(
    tier: str, kind: str, view_zenith_deg: float, sunlit: bool, wavelength_um: Array
) -> list[float]:  # fmt: skip
    """Return the error (B,) of a tier at some wavelengths: rms over pixels, relative to the mean radiance."""
    text = files("hcss_light").joinpath("errors.csv").read_text(encoding="utf-8")
    rows = [row for row in csv.DictReader(text.splitlines()) if row["tier"] == tier]
    rows = [row for row in rows if row["sun"] == ("day" if sunlit else "night")]
    errors = []
    for band in np.where(wavelength_um > THERMAL_UM, "lwir", "mwir"):
        own = [row for row in rows if row["band"] == band]
        own = [row for row in own if row["type"] == kind] or own
        views = sorted({float(row["view_deg"]) for row in own})
        view = next((each for each in views if each >= view_zenith_deg - 1e-6), views[-1])
        errors.append(max(_least(row) for row in own if float(row["view_deg"]) == view))
    return errors


def _least(row: dict[str, str]) -> float:
    return max(float(row["rms"]), abs(float(row["bias"])), HIDDEN * float(row["noise"]))
