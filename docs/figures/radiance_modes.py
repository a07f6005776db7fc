"""Compare the two radiance models term by term on the baseline scene, as Markdown.

::

    python docs/figures/radiance_modes.py            # prints the tables of docs/development/radiance.md
    python docs/figures/radiance_modes.py --write    # puts them into docs/development/radiance.md
    python docs/figures/radiance_modes.py --check    # fails where the page differs by more than 2 percent

Geometry, atmosphere and wind are those of the shipped scenario ``baseline``. The clouds are opaque, with the top at
6 km and the profile's temperature, the sea has 291.4 K, and the as-printed model has eqs 16 and 18 unscaled: the
scenario's fits to the paper's tables would hide differences.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

import numpy as np

from hcss_twin import Scenario, make_plan

PAGE = Path(__file__).parents[1] / "development" / "radiance.md"
BEGIN, END = "<!-- made by docs/figures/radiance_modes.py -->\n", "<!-- end -->\n"
BANDS = ("swir-2.7-3.0", "mwir", "lwir")
THIN_M = 100.0

AS_PRINTED = {"radiance.model": "as-printed", "radiance.parameters": {}}
PHYSICAL = {
    "radiance.model": "physical",
    "radiance.parameters": {},
    "sea.model": "rough-sea",
    "optics.provider": "bulk",
    "optics.parameters": {},
}

TERMS = (
    "cloud_emission",
    "cloud_reflected_sun",
    "sea_emission",
    "sea_reflected_sun",
    "path_emission",
    "reflected_air_emission",
    "path_scattered_sun",
)
TERMS_AT_ZENITH_DEG = 20.0


def columns(overrides: dict[str, object], zenith: float) -> list[dict[str, np.ndarray]]:
    """Band radiances (B,) of each term for the clear, thin and opaque column."""
    common = {
        "view.zenith": zenith,
        "bands": list(BANDS),
        "frames.count": 1,
        "clouds": {"type": "simulated", "coverage": 0.3, "top": 6000.0, "anchor": "top"},
        "sea.temperature": 291.4,
        "motion.platform_speed": 0.0,
    }
    plan = make_plan(Scenario.load("baseline", common | overrides))
    sun = plan.sun_track.at(0.0)
    nu, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1.T
    thick = plan.layers[0].thickness_max_m
    cloudy = plan.assembly.cloudy(nu, np.array([[THIN_M], [thick]]), sun)
    found = [{name: term @ weights for name, term in plan.assembly.clear(nu, sun).items()}]
    found += [{name: term[row] @ weights for name, term in cloudy.items()} for row in (0, 1)]
    return found


def cell(values: np.ndarray) -> str:
    return " / ".join(f"{value:.3g}" if abs(value) >= 1e-9 else "0" for value in values)


def tables() -> str:
    names = ("clear", f"cloud {THIN_M:g} m thick", "opaque cloud")
    terms, totals = (
        [],
        ["### Totals", "", "| view zenith, deg | column | as-printed | physical |", "|---|---|---|---|"],
    )
    nothing = np.zeros(len(BANDS))
    for zenith in (0.0, 20.0, 60.0):
        printed, physical = columns(AS_PRINTED, zenith), columns(PHYSICAL, zenith)
        for name, ours, paper in zip(names, physical, printed, strict=True):
            if zenith == TERMS_AT_ZENITH_DEG and name == names[1]:
                terms += [f"### Terms at view zenith {zenith:g} deg, {name}", "", "| term | as-printed | physical |"]
                terms += ["|---|---|---|"]
                terms += [f"| `{term}` | {cell(paper.get(term, nothing))} | {cell(ours[term])} |" for term in TERMS]
                terms += [""]
            old, new = (np.sum(list(each.values()), axis=0) for each in (paper, ours))
            totals.append(f"| {zenith:g} | {name} | {cell(old)} | {cell(new)} |")
    return "\n".join([*terms, *totals]) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    made = tables()
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    old, after = rest.split(END)
    if options.write:
        PAGE.write_text(before + BEGIN + made + END + after, encoding="utf-8")
    elif options.check:
        return 0 if _alike(old, made) else 1
    else:
        print(made)
    return 0


def _alike(old: str, new: str) -> bool:
    """Whether two pages differ in numbers by less than 2 percent or 1e-4, and in nothing else."""
    number = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
    if number.sub("#", old) != number.sub("#", new):
        return False
    a, b = (np.array([float(x) for x in number.findall(text)]) for text in (old, new))
    return bool(np.all(np.abs(a - b) <= np.maximum(0.02 * np.abs(a), 1e-4)))


if __name__ == "__main__":
    sys.exit(main())
