"""Predictive coverage of `hcss fit`: do its 90 % intervals hold what images show that it has not seen?

The population of a few images of one kind is fitted, images are drawn from it (a member of the population, then a
realisation), and every other image is compared with them: cloudy fraction, power in octaves of wavenumber, and
histogram of the grey levels of cloud. The fit has no say on grey levels: each drawn image takes the brightness exponent
that `hcss match` estimates from one of the fitted images.

Real images are those of HCSS_SAMPLE_DATA; `made` is the control, images that a population of fractal fields made: if
the method is right, its intervals hold 90 %.

    HCSS_SAMPLE_DATA=... python campaigns/predictive/predictive.py --write

Kinds that the table has are not computed again.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from hcss_evaluate.matching.search import brightness_exponent
from hcss_evaluate.matching.structure import LEVELS, CloudImage, grey_inputs
from hcss_evaluate.matching.target import Target
from hcss_evaluate.measures.power_spectrum import power_spectrum
from hcss_evaluate.posterior import chains
from hcss_evaluate.posterior.fit import fit_targets
from hcss_evaluate.posterior.fit_run import FitOptions, usual_priors
from hcss_evaluate.posterior.posterior_file import Posterior
from hcss_evaluate.posterior.priors import KINDS, Prior
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import Writing
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.imagery.cloudiness import Cloudiness, otsu_threshold

TABLE = Path(__file__).with_name("table.csv")
OCTAVES, GAMMA, MISFIT, SAMPLES = (0, 8), 2.0, 0.1, 200.0
DRAWS, FITTED = 400, 8
LOW, HIGH = 0.05, 0.95
BINS = 8
"""Of relative grey level, 0 to 1."""
SPECTRAL = 6
"""Octaves of wavenumber below .5 cycles per pixel, the finest first."""
FEWEST = 100
"""Cloudy, and clear, pixels that `hcss fit` needs."""

STOPPED_AT = {"goes": (25.0, 1.035)}
"""Autocorrelation times and R-hat at which chains end, instead of 50 and 1.01, which would take hours."""

NAMES = ("cover", *(f"spectrum {k}" for k in range(SPECTRAL)), *(f"histogram {k}" for k in range(BINS)))
GROUPS = ("cover", "spectrum", "histogram")


def cloud_image(level: Array, pixel_size_m: float) -> CloudImage | None:
    """Return cloud above Otsu's threshold of a cloudiness level (rows, columns), as `hcss fit` reads a file.

    None if too few pixels are cloudy or clear.
    """
    threshold = otsu_threshold(level)
    cloudy = level > threshold
    if min(np.count_nonzero(cloudy), np.count_nonzero(~cloudy)) < FEWEST:
        return None
    grey = np.zeros(level.shape, dtype=np.float32)
    grey[cloudy] = Cloudiness.thickness_of(Cloudiness.relative_grey(level[cloudy], threshold), *LEVELS)
    return CloudImage(grey, pixel_size_m)


def measured(image: CloudImage) -> list[float]:
    """Return cloudy fraction, log10 of the power in each octave, and the histogram of cloud: the numbers of ``NAMES``.

    Grey levels are those of cloud between its lowest and its 99.9th percentile, 0 where clear, in drawn images, too.
    """
    own = image.level[image.cloudy].astype(np.float64)
    relative = Cloudiness.relative_grey(own, float(own.min()))
    grey = np.zeros(image.level.shape)
    grey[image.cloudy] = relative
    found = power_spectrum(grey)
    octave = np.floor(np.log2(0.5 / found.wavenumber)).astype(int)
    power = []
    for k in range(SPECTRAL):
        ring = octave == k
        power.append(math.log10(float(found.power[ring] @ found.waves[ring] / found.waves[ring].sum())))
    counts, _ = np.histogram(relative, bins=BINS, range=(0.0, 1.0))
    return [image.coverage, *power, *(counts / own.size).tolist()]


def seviri(folder: Path) -> dict[str, CloudImage]:
    """Return the quarters of the sea blocks of SEVIRI at 10.8 um, 00:15 UTC: cold is cloud."""
    import xarray as xr

    with xr.open_dataset(next(iter(sorted((folder / "seviri").glob("sea-blocks*.nc"))))) as data:
        kelvin = data["ir_108"].isel(time=1).to_numpy()
        numbers = data["block"].to_numpy().tolist()
    found = {}
    for number, block in zip(numbers, kelvin, strict=True):
        for name, image in _tiles(-block, 128, 3000.0).items():
            found[f"block {number}: {name}"] = image
    return found


def goes(folder: Path) -> dict[str, CloudImage]:
    """Return parts of the image of GOES-16 at .865 um around a hurricane: bright is cloud."""
    import xarray as xr

    with xr.open_dataset(next(iter(sorted((folder / "images").glob("OR_ABI-L2-CMIPM2-M3C03*.nc"))))) as data:
        level = data["CMI"].to_numpy().astype(np.float64)
    return _tiles(level, 125, 1000.0)


def _tiles(level: Array, side: int, pixel_size_m: float) -> dict[str, CloudImage]:
    """Return the square parts of an image that have enough cloud and clear sky, by their place."""
    found = {}
    for row in range(0, level.shape[0] - side + 1, side):
        for column in range(0, level.shape[1] - side + 1, side):
            part = level[row : row + side, column : column + side]
            image = cloud_image(part, pixel_size_m) if np.all(np.isfinite(part)) else None
            if image is not None:
                found[f"row {row}, column {column}"] = image
    return found


MADE = {"H": (0.5, 0.1), "Lx": (math.log(1.0), 0.4), "Ly": (math.log(1.0), 0.4), "coverage": (0.0, 0.6)}
"""Mean and spread, on the parameters' scales, of the population of the control; cells per 16 km."""


def made(_: Path) -> dict[str, CloudImage]:
    """Return images of a population of fractal fields, with one brightness exponent for each."""
    rng = np.random.default_rng(18)
    images: dict[str, CloudImage] = {}
    while len(images) < 48:
        values = {n: float(KINDS[n].scale.back(np.array(rng.normal(*MADE[n])))) for n in MADE}
        if not 0.02 < values["H"] < 0.98:
            continue
        image = drawn_image(values, float(rng.uniform(0.7, 1.5)), (128, 128), 1000.0, int(rng.integers(2**31)))
        if image is not None:
            images[f"image {len(images)}"] = image
    return images


KINDS_OF_IMAGES: Mapping[str, Callable[[Path], dict[str, CloudImage]]] = {"made": made, "seviri": seviri, "goes": goes}


def drawn_image(
    values: Mapping[str, float], exponent: float, shape: tuple[int, int], pixel_size_m: float, seed: int
) -> CloudImage | None:
    """Return an image of the unbounded sky with these parameters; None if `hcss fit` would not take it."""
    parameters = FractalParameters(
        gamma=GAMMA,
        H=values["H"],
        L=(values["Lx"], values["Ly"]),
        k=OCTAVES,
        brightness_exponent=min(max(exponent, 0.05), 20.0),
    )
    inputs = grey_inputs(values["coverage"], *shape, pixel_size_m, seed)
    layer = replace(inputs.layer, coverage_mode="field")
    clouds = FractalClouds(replace(inputs, layer=layer), parameters, threads=1)
    level = clouds.thickness_m(0.0, slice(0, shape[0]), slice(0, shape[1]))
    cloudy = np.count_nonzero(level)
    return CloudImage(level, pixel_size_m) if FEWEST <= cloudy <= level.size - FEWEST else None


def members(
    found: Posterior, limits: Mapping[str, Prior], rng: np.random.Generator, count: int
) -> list[dict[str, float]]:
    """Draw members of the population: a draw of its mean and spread, then parameters within the limits of the prior."""
    drawn: list[dict[str, float]] = []
    total = found.samples["mean_H"].size
    while len(drawn) < count:
        at, own = int(rng.integers(total)), {}
        for name, prior in limits.items():
            scale = KINDS[name].scale
            mean = float(scale.of(found.samples[f"mean_{name}"].ravel()[at]))
            spread = float(found.samples[f"spread_{name}"].ravel()[at])
            value = math.nan
            while not prior.low < value < prior.high:
                value = float(scale.back(np.array(rng.normal(mean, spread))))
            own[name] = value
        drawn.append(own)
    return drawn


def predicted(
    fitted: Sequence[CloudImage],
    seed: int,
    samples: float = SAMPLES,
    draws: int = DRAWS,
    stopped_at: tuple[float, float] = (chains.LONGEST, chains.LARGEST_R_HAT),
) -> tuple[NDArray[np.float64], dict[str, Any]]:
    """Fit a population and measure images drawn from it: (draw, NAMES), and what the fit found."""
    frames = [(*image.level.shape, image.pixel_size_m) for image in fitted]
    usual = usual_priors(frames)
    limits = {n: Prior.parse(n, usual[n], KINDS[n].low, KINDS[n].high) for n in KINDS if n != "gamma"}
    options = FitOptions(fixed={"gamma": GAMMA}, octaves=OCTAVES, misfit=MISFIT, seed=seed, samples=samples)
    targets = [Target(image, str(number), ()) for number, image in enumerate(fitted)]
    began = time.perf_counter()
    with (
        tempfile.TemporaryDirectory() as folder,
        patch.multiple(chains, LONGEST=stopped_at[0], LARGEST_R_HAT=stopped_at[1]),
    ):
        path = Path(folder) / "posterior.nc"
        found = fit_targets(targets, path, [(each.source, "") for each in targets], options)
    rng = np.random.default_rng([seed, 1])
    exponents = [brightness_exponent(image) for image in fitted]
    shape, size = fitted[0].level.shape, fitted[0].pixel_size_m
    rows: list[list[float]] = []
    refused = 0
    while len(rows) < draws:
        (own,) = members(found, limits, rng, 1)
        exponent = exponents[int(rng.integers(len(exponents)))]
        image = drawn_image(own, exponent, (shape[0], shape[1]), size, int(rng.integers(2**31)))
        if image is None:
            refused += 1
            continue
        rows.append(measured(image))
    about = {
        "population": {
            name: np.quantile(values, [LOW, 0.5, HIGH]).round(5).tolist()
            for name, values in found.samples.items()
            if name.startswith(("mean_", "spread_"))
        },
        "chains_end_at": {"autocorrelation_times": stopped_at[0], "r_hat": stopped_at[1]},
        "predictive_p_value": [round(float(p), 4) for p in np.atleast_1d(found.attributes["predictive_p_value"])],
        "drawn_images_without_enough_cloud_or_clear_sky": refused,
        "seconds": round(time.perf_counter() - began, 1),
    }
    return np.array(rows), about


def whole(name: str) -> str:
    """Return the name of the image that an image is a part of; of those, none is both fitted and predicted."""
    return name.partition(":")[0]


def split(names: Sequence[str], count: int = FITTED) -> tuple[list[str], list[str]]:
    """Return images to fit, by chance and each from another whole image, and those of no whole image among these."""
    order = [names[i] for i in np.random.default_rng(1).permutation(len(names))]
    first = {whole(name): name for name in reversed(order)}
    fitted = sorted(first[each] for each in list(dict.fromkeys(map(whole, order)))[:count])
    seen = set(map(whole, fitted))
    return fitted, [name for name in names if whole(name) not in seen]


def compared(images: Mapping[str, CloudImage], kind: str, seed: int = 3) -> dict[str, Any]:
    """Fit some images of a kind and predict the others; rows hold what was measured in each of these."""
    fitted, unseen = split(list(images))
    ends = {"stopped_at": STOPPED_AT[kind]} if kind in STOPPED_AT else {}
    drawn, about = predicted([images[name] for name in fitted], seed, **ends)
    quantiles = {
        name: np.quantile(drawn, share, axis=0).round(6).tolist()
        for name, share in (("low", LOW), ("median", 0.5), ("high", HIGH))
    }
    rows = [{"image": name, "measured": np.round(measured(images[name]), 6).tolist()} for name in unseen]
    return {"fitted": fitted, **about, "predicted": quantiles, "rows": rows}


def summarise(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return, for each group of numbers, the fraction inside the intervals, and by which factor they are too narrow.

    The factor widens the intervals about their medians until they hold 90 %; ``below`` and ``above`` are the fractions
    beyond either end (5 % each if all is right). Numbers of one image are correlated, and so are parts of one image:
    the standard error is that of the mean over whole images.
    """
    values = np.array([row["measured"] for row in found["rows"]])
    low, median, high = (np.array(found["predicted"][name]) for name in ("low", "median", "high"))
    inside = (values >= low) & (values <= high)
    distance = np.abs(values - median) / np.maximum(np.where(values > median, high - median, median - low), 1e-12)
    wholes, place = np.unique([whole(row["image"]) for row in found["rows"]], return_inverse=True)
    summary: dict[str, Any] = {}
    for group in GROUPS:
        own = [i for i, name in enumerate(NAMES) if name == group or name.split()[0] == group]
        each = np.bincount(place, inside[:, own].mean(axis=1)) / np.bincount(place)
        summary[group] = {
            "numbers": int(inside[:, own].size),
            "inside": round(float(inside[:, own].mean()), 4),
            "standard_error": round(float(each.std(ddof=1) / math.sqrt(wholes.size)), 4),
            "below": round(float(np.mean(values[:, own] < low[own])), 4),
            "above": round(float(np.mean(values[:, own] > high[own])), 4),
            "factor": round(float(np.quantile(distance[:, own], 0.9)), 3),
        }
    return summary


FIELDS = ("kind", "group", "numbers", "inside", "standard_error", "below", "above", "factor")
WORDS = {
    "made": "made by a population of fractal fields",
    "seviri": "SEVIRI at 10.8 um, quarters of sea blocks",
    "goes": "GOES-16 at 0.865 um, parts of a hurricane scene",
}


def table(rows: Sequence[Mapping[str, str]]) -> str:
    """Return the table of the page docs/development/uncertainty.md."""
    lines = [
        "| images | predicted | numbers | inside 90 % intervals | below | above | intervals to be widened by |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        inside, error, below, above = (f"{float(row[name]):.0%}" for name in FIELDS[3:7])
        found = f"{row['numbers']} | {inside} ± {error} | {below} | {above} | {float(row['factor']):.2f}"
        lines.append(f"| {WORDS[row['kind']]} | {row['group']} | {found} |")
    return "\n".join(lines)


def read() -> list[dict[str, str]]:
    """Return the committed rows, one for each kind of images and group of numbers."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true", help="Write table.csv; without it, print.")
    parser.add_argument("--only", choices=tuple(KINDS_OF_IMAGES), help="One kind of images.")
    parser.add_argument("--again", action="store_true", help="Compute kinds that the table has, too.")
    given = parser.parse_args()
    folder = Path(os.environ.get("HCSS_SAMPLE_DATA", ""))
    rows = read() if TABLE.exists() else []
    for kind, images_of in KINDS_OF_IMAGES.items():
        if given.only not in (None, kind) or (any(row["kind"] == kind for row in rows) and not given.again):
            continue
        found = compared(images_of(folder), kind)
        print(json.dumps({name: value for name, value in found.items() if name not in ("rows", "predicted")}))
        rows = [row for row in rows if row["kind"] != kind]
        for group, summary in summarise(found).items():
            rows.append({"kind": kind, "group": group, **{name: str(value) for name, value in summary.items()}})
        rows.sort(key=lambda row: list(WORDS).index(row["kind"]))
        if given.write:
            with Writing(TABLE, HcssError) as draft, draft.open("w", newline="", encoding="utf-8") as file:
                lines = csv.DictWriter(file, FIELDS, lineterminator="\n")
                lines.writeheader()
                lines.writerows(rows)
    print(table(rows))


if __name__ == "__main__":
    main()
