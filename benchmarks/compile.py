"""Compiling scenes: wavenumbers taken, what leaving out the others costs, and time against taking all.

    python benchmarks/compile.py                 # shipped scenarios at three accuracies
    python benchmarks/compile.py --all-times     # also without choosing wavenumbers (minutes)

Errors are those of random columns that the choice did not know, relative to what the tables may lose by it.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from hcss_twin.engine import compile as compiling
from hcss_twin.engine.tables.spectrum import Spectrum, choose_spectrum
from hcss_twin.models.radiance.spectral_grid import all_nodes
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.scenario.scenario import Scenario

SCENES = ("baseline", "stratus", "cumulus", "simulated", "cirrus", "cirrus-over-cumulus")
RANDOM_COLUMNS = 40


def random_thickness(plan: Plan, random: np.random.Generator) -> np.ndarray:
    """Thicknesses (N, L) spread by factors and by metres, in one layer or in all."""
    rows = []
    for columns in [*np.eye(len(plan.layers), dtype=bool), np.ones(len(plan.layers), dtype=bool)]:
        share = random.random((RANDOM_COLUMNS, len(plan.layers)))
        low = np.array([layer.thickness_min_m for layer in plan.layers])
        high = np.array([layer.thickness_max_m for layer in plan.layers])
        spread = np.where(random.random(share.shape) < 0.5, low * (high / low) ** share, low + (high - low) * share)
        rows.append(spread * columns)
    return np.concatenate(rows)


def error_over_tolerance(plan: Plan, spectrum: Spectrum, tolerance: float) -> float:
    """Largest error of the total of a band in random columns at random frames."""
    random = np.random.default_rng(0)
    grid, worst = plan.spectral_grid, 0.0
    kept = np.searchsorted(grid.wavenumber_cm1, spectrum.nodes.wavenumber_cm1)
    for frame in random.integers(0, plan.frame_times_s.size, 2):
        sun = plan.sun_at(float(plan.frame_times_s[frame]))
        terms = plan.assembly.model.cloudy(grid.wavenumber_cm1, random_thickness(plan, random), sun)
        total = np.sum([np.asarray(each) for each in terms.values()], axis=0)
        exact = total @ grid.weights_cm1.T
        worst = max(worst, float(np.max(np.abs(total[:, kept] @ spectrum.nodes.weights_cm1.T / exact - 1.0))))
    return worst / tolerance


def timed_compile(plan: Plan, spectrum: Spectrum) -> float:
    """Seconds to compile the tables of a plan with a given spectrum."""
    chosen = compiling.choose_spectrum
    compiling.choose_spectrum = lambda plan, tolerance: spectrum
    try:
        start = time.perf_counter()
        compiling.compile_tables(plan)
        return time.perf_counter() - start
    finally:
        compiling.choose_spectrum = chosen


def row(name: str, model: str, accuracy: float, all_times: bool) -> str:
    """One line of the table."""
    overrides = {"accuracy": accuracy}
    if name != "baseline":
        overrides["radiance.model"] = model
    plan = make_plan(Scenario.load(name, overrides))
    tolerance = plan.budget.wavenumbers
    plan.assembly.model.clear(plan.spectral_grid.wavenumber_cm1, None)  # what is read and compiled once
    start = time.perf_counter()
    spectrum = choose_spectrum(plan, tolerance)
    choosing = time.perf_counter() - start
    size = spectrum.nodes.wavenumber_cm1.size
    error = error_over_tolerance(plan, spectrum, tolerance)
    compiled = timed_compile(make_plan(Scenario.load(name, overrides)), spectrum)
    last = "-"
    if all_times:
        everything = Spectrum(all_nodes(plan.spectral_grid), spectrum.dense, 0.0)
        whole = timed_compile(make_plan(Scenario.load(name, overrides)), everything)
        last = f"{whole / (choosing + compiled):.1f}"
    return (
        f"| {name} | {model} | {accuracy:g} | {size} of {spectrum.dense} | {error:.2f} "
        f"| {choosing:.2f} | {compiled:.2f} | {last} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all-times", action="store_true", help="also compile with every wavenumber")
    parser.add_argument("--scenes", nargs="*", default=SCENES)
    arguments = parser.parse_args()
    heads = ("scene", "model", "accuracy", "wavenumbers", "error over tolerance", "s to choose", "s after", "all over")
    print("| " + " | ".join(heads) + " |")
    print("|---|---|---|---|---|---|---|---|")
    for name in arguments.scenes:
        for model in ("as-printed",) if name == "baseline" else ("as-printed", "physical"):
            for accuracy in (1e-2, 1e-3, 1e-4):
                print(row(name, model, accuracy, arguments.all_times and accuracy == 1e-3), flush=True)


if __name__ == "__main__":
    main()
