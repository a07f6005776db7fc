"""Propagated spread against brute force: 200 scenes made one by one, with draws of their own.

    python benchmarks/propagation.py [--draws 200] [--pairs 4] [--write]

A posterior is made up; clouds and the temperature of the sea are uncertain. ``hcss_twin.propagate`` is one side. The
other draws its own numbers, calls ``hcss_twin.simulate`` for each, and takes moments and quantiles of the cubes with
numpy; it shares no code with the first but the simulation itself. Both are drawn several times anew: what is wrong
stays, what is chance does not.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from agreement import QUANTILES, STATISTICS, Sides, by_bootstrap, by_permutation, statistics
from hcss_evaluate.posterior.posterior_file import Diagnostic, read_posterior, write_posterior
from numpy.typing import NDArray
from page import put
from scipy import ndimage, stats

import hcss_twin
from hcss_twin.core.cache import private_cache

PAGE = Path(__file__).parents[1] / "docs" / "development" / "uncertainty.md"
SCENE: dict[str, Any] = {
    "radiance.model": "as-printed",
    "sea.model": "cox-munk",
    "optics.provider": "mie",
    "image.rows": 64,
    "image.columns": 64,
    "frames.count": 1,
    "clouds.coverage_mode": "field",
}
SEA = "sea.temperature"
LOW, HIGH = 289.0, 293.0
CLASSES = ("all", "clear", "thin", "edge", "thick")
OUTPUTS = ("radiance", "brightness_temperature")
PARAMETERS = ("H", "Lx", "Ly", "coverage")

Array = NDArray[np.float64]


def made_up_posterior(path: Path) -> Path:
    """Write a posterior of four free parameters, two of them dependent on each other."""
    rng = np.random.default_rng(0)
    shape = (8, 250)
    size = rng.normal(0.0, 0.15, shape)
    chains = {
        "H": rng.normal(0.7, 0.04, shape),
        "Lx": 8.0 * np.exp(size + rng.normal(0.0, 0.1, shape)),
        "Ly": 8.0 * np.exp(size + rng.normal(0.0, 0.1, shape)),
        "coverage": np.clip(rng.normal(0.5, 0.06, shape), 0.05, 0.95),
    }
    told = Diagnostic("made up", "none", 1.0)
    write_posterior(
        path,
        title="made up",
        inputs=[],
        chains=chains,
        log_probability=np.zeros(shape),
        diagnostics=dict.fromkeys(chains, told),
        fixed={"gamma": 3.0},
        priors=dict.fromkeys(chains, "none"),
        seed=0,
    )
    return path


def brute_force(posterior: Path, draws: int, seed: int) -> dict[str, Array]:
    """Simulate so many scenes one by one, and return class means (draw, band, class)."""
    rng = np.random.default_rng(seed)
    samples = read_posterior(posterior).samples
    # Without replacement their means scatter less by 1 in 20 than those of the propagation: tests are a little lenient.
    rows = rng.choice(samples["H"].size, size=draws, replace=False)
    found: dict[str, list[Array]] = {name: [] for name in OUTPUTS}
    for row in rows:
        h, length_x, length_y, coverage = (float(samples[name][row]) for name in PARAMETERS)
        overrides = {
            **SCENE,
            "clouds.parameters.H": h,
            "clouds.parameters.gamma": 3.0,
            "clouds.parameters.L": [length_x, length_y],
            "clouds.coverage": coverage,
            SEA: float(rng.uniform(LOW, HIGH)),
            "seed": int(rng.integers(2**62)),
            "output.variables": [*OUTPUTS, "cloud_thickness"],
            "output.certificate": 0,
        }
        cube = hcss_twin.simulate(hcss_twin.Scenario.load("stratus", overrides))
        masks = _masks(cube["cloud_thickness"].values[0])
        for name, each in found.items():
            values = cube[name].values[0].astype(np.float64)
            each.append(np.stack([_mean(values[:, mask]) for mask in masks], axis=1))
    return {name: np.stack(each) for name, each in found.items()}


def _masks(thickness: NDArray[np.float32]) -> list[NDArray[np.bool_]]:
    cloudy = thickness > 0
    inner = ndimage.binary_erosion(cloudy, ndimage.generate_binary_structure(2, 1), border_value=1)
    thick = thickness >= np.sqrt(10.0 * (1000.0 - 33.0))  # limits of the type stratus
    return [np.ones_like(cloudy), ~cloudy, inner & ~thick, cloudy & ~inner, inner & thick]


def _mean(values: Array) -> Array:
    return values.mean(axis=1) if values.shape[1] else np.full(values.shape[0], np.nan)


def sides(data: Any, brute: dict[str, Array]) -> Sides:
    """Put all outputs beside each other; what is told comes from the file of the propagation."""
    told, error = [], []
    for output in OUTPUTS:
        for end, kept in (("", told), ("_error", error)):
            moments = [data[f"{output}_{name}{end}"].values[None] for name in ("mean", "standard_deviation")]
            several = data[f"{output}_quantile{end}"].sel(quantile=list(QUANTILES)).values
            kept.append(np.concatenate([*moments, several]).reshape(len(STATISTICS), -1))
    scenes = [data[output].values[:2].reshape(2, data.sizes["draw"], -1) for output in OUTPUTS]
    others = [brute[output].reshape(brute[output].shape[0], -1) for output in OUTPUTS]
    return Sides(*(np.concatenate(each, axis=-1) for each in (scenes, others, told, error)))


def same_distribution(data: Any, brute: dict[str, Array]) -> dict[tuple[str, str], float]:
    """Return p of the two-sample Kolmogorov-Smirnov test of mean brightness temperature, by band and class."""
    name = "brightness_temperature"
    own = data[name].values[0]
    return {
        (str(data["band"].values[band]), CLASSES[kind]): float(
            stats.ks_2samp(_known(own[:, band, kind]), _known(brute[name][:, band, kind])).pvalue
        )
        for band, kind in np.ndindex(own.shape[1:])
    }


def _known(values: Array) -> Array:
    return values[np.isfinite(values)]


def agreement(
    pairs: list[Sides],
    bands: list[str],
    alike: dict[tuple[str, str], float],
    seconds: dict[str, float],
    tables: dict[str, Any],
) -> str:
    """The tables of the page."""
    draws = pairs[0].others.shape[0]
    first, every = by_bootstrap(pairs[:1]), by_bootstrap(pairs)
    cells = [(output, band, kind) for output in OUTPUTS for band in bands for kind in CLASSES]
    spread = STATISTICS.index("sd")
    lines = [
        f"| standard deviation over {draws} draws of mean brightness temperature, K | propagated | brute force | "
        f"difference, standard errors | the same of all {len(pairs)} pairs | same distribution, p |",
        "|---|---|---|---|---|---|",
    ]
    other = statistics(pairs[0].others)
    lines += [
        f"| {band}, {kind} | {pairs[0].told[spread, at]:.3f} | {other[spread, at]:.3f} | {first.z[spread, at]:+.1f} | "
        f"{every.z[spread, at]:+.1f} | {alike[band, kind]:.2f} |"
        for at, (output, band, kind) in enumerate(cells)
        if output == "brightness_temperature" and kind == "all"
    ]
    lines += [
        "",
        f"| {first.z.size} differences | within one standard error (in 95 % of repetitions) | within two | largest "
        "(95 % stay below) | p, bootstrap | p, permutation: mean square | p, permutation: largest |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [_row(f"pair {number + 1}", [pair]) for number, pair in enumerate(pairs)]
    lines.append(_row(f"all {len(pairs)} pairs", pairs))
    lines += [
        "",
        f"Being correlated, the {first.z.size} differences of a pair count as "
        f"{first.independent:.0f} independent ones.",
        "",
        "| | scenes | sets of tables | processor, s |",
        "|---|---|---|---|",
    ]
    lines += [f"| {name} | {tables[name][0]} | {tables[name][1]} | {seconds[name]:.0f} |" for name in seconds]
    return "\n".join(lines)


def _row(name: str, pairs: list[Sides]) -> str:
    found = by_bootstrap(pairs)
    parts = [f"{part:.0%} ({low:.0%} to {high:.0%})" for part, low, high in map(found.within, (1.0, 2.0))]
    squares, farthest = by_permutation(pairs)
    largest = f"{found.largest[0]:.1f} ({found.largest[1]:.1f})"
    cells = [name, *parts, largest, f"{found.probability:.2f}", f"{squares:.2f}", f"{farthest:.2f}"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Run both sides and print, or write to the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--pairs", type=int, default=4, help="how often both sides are drawn anew")
    parser.add_argument("--write", action="store_true", help="write to the page")
    options = parser.parse_args()
    seconds: dict[str, float] = {}
    tables: dict[str, Any] = {}
    pairs: list[Sides] = []
    alike: dict[tuple[str, str], float] = {}
    bands: list[str] = []
    for number in range(options.pairs):
        with tempfile.TemporaryDirectory() as name, private_cache(Path(name)):
            posterior = made_up_posterior(Path(name) / "posterior.nc")
            hcss_twin.simulate(hcss_twin.Scenario.load("stratus", SCENE))  # compiles kernels
            scene = SCENE | {"seed": 1 + number}
            begin = time.process_time()
            if number == 0:
                clouds = hcss_twin.propagate("stratus", draws=options.draws, posterior=posterior, overrides=scene)
                seconds["propagated, clouds uncertain"] = time.process_time() - begin
                tables["propagated, clouds uncertain"] = clouds.tables.scenes, clouds.tables.sets
                begin = time.process_time()
            made = hcss_twin.propagate(
                "stratus",
                draws=options.draws,
                posterior=posterior,
                uncertain={SEA: f"uniform:{LOW}:{HIGH}"},
                overrides=scene,
            )
            middle = time.process_time()
            brute = brute_force(posterior, options.draws, 2024 + number)
        pairs.append(sides(made.dataset, brute))
        if number == 0:
            seconds["propagated, clouds and sea uncertain"] = middle - begin
            tables["propagated, clouds and sea uncertain"] = made.tables.scenes, made.tables.sets
            seconds["`simulate` in a loop, clouds and sea uncertain"] = time.process_time() - middle
            tables["`simulate` in a loop, clouds and sea uncertain"] = options.draws, options.draws
            alike = same_distribution(made.dataset, brute)
            bands = [str(band) for band in made.dataset["band"].values]
    text = agreement(pairs, bands, alike, seconds, tables)
    print(text)
    if options.write:
        put("propagation", text, PAGE)


if __name__ == "__main__":
    main()
