"""Propagated spread against brute force: 200 scenes made one by one, with draws of their own.

    python benchmarks/propagation.py [--draws 200] [--write]

A posterior is made up; clouds and the temperature of the sea are uncertain. ``hcss_twin.propagate`` is one side. The
other draws its own numbers, calls ``hcss_twin.simulate`` for each, and takes moments and quantiles of the cubes with
numpy; it shares no code with the first but the simulation itself.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from page import put
from scipy import ndimage, stats

import hcss_twin
from hcss_twin.benchmarking.private_cache import private_cache
from hcss_twin.uncertainty.posterior_file import Diagnostic, read_posterior, write_posterior

PAGE = Path(__file__).parents[1] / "docs" / "uncertainty.md"
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
QUANTILES = (0.05, 0.5, 0.95)
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
    told = Diagnostic("made up", "none", 1.0, float(size.size), 1.0)
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


def brute_force(posterior: Path, draws: int) -> dict[str, Array]:
    """Simulate so many scenes one by one, and return class means (draw, band, class)."""
    rng = np.random.default_rng(2024)
    samples = read_posterior(posterior).samples
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


def standard_error(values: Array, statistic: Any) -> Array:
    """Bootstrap of the brute force's own draws."""
    rng = np.random.default_rng(1)
    found = [statistic(values[rng.integers(values.shape[0], size=values.shape[0])]) for _ in range(300)]
    return np.asarray(np.std(found, axis=0))


def compared(data: Any, brute: dict[str, Array]) -> list[tuple[str, str, str, str, float, float, float]]:
    """Return band, class, output, statistic, both values, and their difference in standard errors."""
    found = []
    statistics = {
        "mean": (lambda values: np.nanmean(values, axis=0), "mean"),
        "sd": (lambda values: np.nanstd(values, axis=0, ddof=1), "standard_deviation"),
        **{
            f"{100 * share:g} %": (lambda values, share=share: np.nanquantile(values, share, axis=0), share)
            for share in QUANTILES
        },
    }
    for output in OUTPUTS:
        for name, (statistic, key) in statistics.items():
            if isinstance(key, float):
                own, error = (
                    data[f"{output}_quantile{suffix}"].sel(quantile=key).values for suffix in ("", "_error")
                )
            else:
                own, error = (data[f"{output}_{key}{suffix}"].values for suffix in ("", "_error"))
            other = statistic(brute[output])
            sigma = np.hypot(error, standard_error(brute[output], statistic))
            for band, kind in np.ndindex(own.shape):
                z = (own[band, kind] - other[band, kind]) / sigma[band, kind]
                names = str(data["band"].values[band]), CLASSES[kind]
                found.append(
                    (*names, output, name, float(own[band, kind]), float(other[band, kind]), float(z))
                )
    return found


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
    rows: list[Any],
    alike: dict[tuple[str, str], float],
    draws: int,
    seconds: dict[str, float],
    tables: dict[str, Any],
) -> str:
    """The table of the page."""
    far = np.abs([row[-1] for row in rows])
    farthest = max(rows, key=lambda row: abs(row[-1]))
    lines = [
        f"| standard deviation over {draws} draws of mean brightness temperature, K | propagated | brute force | "
        "difference, standard errors | same distribution, p |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {band}, {kind} | {own:.3f} | {other:.3f} | {z:+.1f} | {alike[band, kind]:.2f} |"
        for band, kind, output, name, own, other, z in rows
        if output == "brightness_temperature" and name == "sd"
    ]
    lines += [
        "",
        f"Of all {far.size} comparisons (mean, standard deviation, 5, 50 and 95 % of radiance and brightness "
        f"temperature; many depend on each other) {np.mean(far < 1.0):.0%} lie within one standard error, "
        f"{np.mean(far < 2.0):.0%} within two; the largest is {far.max():.1f} ({farthest[3]} of "
        f"{farthest[2].replace('_', ' ')}, {farthest[0]}, {farthest[1]}: {farthest[4]:.5g} and {farthest[5]:.5g}).",
        "",
        "| | scenes | sets of tables | processor, s |",
        "|---|---|---|---|",
    ]
    lines += [f"| {name} | {tables[name][0]} | {tables[name][1]} | {seconds[name]:.0f} |" for name in seconds]
    return "\n".join(lines)


def main() -> None:
    """Run both sides and print, or write to the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--write", action="store_true", help="write to the page")
    options = parser.parse_args()
    seconds: dict[str, float] = {}
    tables: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as name, private_cache(Path(name)):
        posterior = made_up_posterior(Path(name) / "posterior.nc")
        hcss_twin.simulate(hcss_twin.Scenario.load("stratus", SCENE))  # compiles kernels
        begin = time.process_time()
        clouds = hcss_twin.propagate("stratus", draws=options.draws, posterior=posterior, overrides=SCENE)
        seconds["propagated, clouds uncertain"] = time.process_time() - begin
        tables["propagated, clouds uncertain"] = clouds.tables.scenes, clouds.tables.sets
        begin = time.process_time()
        made = hcss_twin.propagate(
            "stratus",
            draws=options.draws,
            posterior=posterior,
            uncertain={SEA: f"uniform:{LOW}:{HIGH}"},
            overrides=SCENE,
        )
        seconds["propagated, clouds and sea uncertain"] = time.process_time() - begin
        tables["propagated, clouds and sea uncertain"] = made.tables.scenes, made.tables.sets
        begin = time.process_time()
        brute = brute_force(posterior, options.draws)
        seconds["`simulate` in a loop, clouds and sea uncertain"] = time.process_time() - begin
        tables["`simulate` in a loop, clouds and sea uncertain"] = options.draws, options.draws
    alike = same_distribution(made.dataset, brute)
    text = agreement(compared(made.dataset, brute), alike, options.draws, seconds, tables)
    print(text)
    if options.write:
        put("propagation", text, PAGE)


if __name__ == "__main__":
    main()
