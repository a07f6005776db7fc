"""Simulation-based calibration of `hcss fit` on images of every cloud type: are its posteriors what they say?

Six sets of images, 128 x 128 pixels of the unbounded sky:

* ``prior``: parameters from the usual priors, octaves 0 to 8, which the fit knows; pixels of 20 m.
* ``named``: parameters from the priors of each cloud type, which the fit knows by ``cloud_type``.
* ``own``: the type's own H, gamma, L and octaves, with ``cloud_type``: what ``hcss run TYPE`` makes.
* ``unnamed``: the same images, and the fit is told nothing.
* ``surrogate``: surrogates of the three measured samples (extra ``samples``), with any coverage.
* ``example``: skies like each of the 15 examples in the library of hcss-skies.

Images of ``prior`` and ``named`` have parameters from the fit's own prior. If all is right the rank of the true value
among the draws is uniform, and a 90 % interval holds it nine times of ten (S. Talts et al., arXiv:1804.06788). Images
of the other two have the same parameters every time: there the intervals hold them nine times of ten where the image
determines them, and more often where the prior does. Images of the last two have no H, gamma or L. What a fit says of
them is their coverage, and the variogram that it predicts: of all sets, ``variogram_inside`` is the fraction of lags at
which another part of the same sky lies inside the predicted 90 %.

    python campaigns/calibration/calibration.py --images 10 --write

A run that was interrupted goes on where it was: rows of results.csv are not computed again. Chains end after 8
autocorrelation times, instead of 50: ranks need 99 draws, not 1000.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import math
import tempfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

import numpy as np
import xarray as xr
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.matching.dimension_range import type_parameters
from hcss_evaluate.matching.structure import CloudImage, grey_inputs, image_structure
from hcss_evaluate.matching.target import Target
from hcss_evaluate.posterior import chains
from hcss_evaluate.posterior.fit import fit_targets
from hcss_evaluate.posterior.fit_run import FitOptions, usual_priors
from hcss_evaluate.posterior.image_data import image_scores
from hcss_evaluate.posterior.priors import KINDS, Prior
from numpy.typing import NDArray
from scipy.stats import chi2, kstest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import Writing
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudGenerator, CloudInputs

RESULTS = Path(__file__).with_name("results.csv")
SETS = ("prior", "named", "own", "unnamed", "surrogate", "example")
TYPES = (
    "stratus", "cumulus", "cirrus", "simulated", "stratocumulus", "altocumulus", "altostratus", "fog", "deep-convection"
)  # fmt: skip
TYPES_OF = {
    "prior": ("",),
    "surrogate": ("modis-cumulus", "modis-hurricane", "seviri-atlantic"),
    "example": ("anvils", "closed-cells", "open-cells", "streets", "trade-cumulus"),
}
PIXELS_M = (20.0, 100.0, 500.0)
PIXELS_M_OF = {"prior": (20.0,), "example": (100.0, 500.0, 3000.0)}
EXAMPLES = 3
TORUS = 512
SIDE = 128
DRAWS, BINS = 99, 20
FEWEST = 20
QUICK = {"LONGEST": 8.0, "LARGEST_R_HAT": 1.05}
SAMPLES = 100.0

COLUMNS = (
    *("set", "type", "pixel_m", "index", "refused", "p_value", "unlikeness"),
    *(f"{name}_{what}" for name in KINDS for what in ("truth", "rank", "inside", "width", "doubted")),
    *("variogram_inside", "variogram_doubted"),
)


def cases(sets: Iterable[str], images: int) -> Iterator[tuple[str, str, float, int]]:
    """Yield set, type, pixel size and index; one of each kind after the other, so that any beginning is balanced."""
    for index in range(images):
        for which in sets:
            for pixel in PIXELS_M_OF.get(which, PIXELS_M):
                yield from ((which, kind, pixel, index) for kind in TYPES_OF.get(which, TYPES))


def options_of(which: str, cloud_type: str, pixel_m: float) -> FitOptions:
    """Return the options of a fit; coverage leaves frames without cloud, or without gaps, out."""
    priors = {"coverage": "uniform:0.1:0.9"}
    if which in ("named", "own"):
        return FitOptions(cloud_type=cloud_type, priors=priors).of_type()
    if which == "prior":
        return FitOptions(priors=priors | {"gamma": "loguniform:1.5:4"}, octaves=(0, 8))
    return FitOptions(priors=priors)


def draw_images(which: str, kind: str, pixel_m: float, index: int) -> tuple[dict[str, float], CloudImage, CloudImage]:
    """Draw what is true of a sky, and two images of it at the same instant and far apart, of equal coverage.

    What data are refused depends on the first image alone, so that it does not bias ranks of those accepted. In the
    second one, as many of the thickest pixels stay cloudy as in the first: a fit's variogram is that of one coverage.
    """
    # Images of `own` and `unnamed` are the same.
    rng = np.random.default_rng([zlib.crc32(f"{which.replace('unnamed', 'own')} {kind}".encode()), int(pixel_m), index])
    draw = {"surrogate": draw_surrogate, "example": draw_example}.get(which, draw_fractal)
    while True:
        truth, seed, sky = draw(which, kind, pixel_m, index, rng)
        level = sky(seed)
        cloudy = np.count_nonzero(level)
        if 100 <= cloudy <= level.size - 100:
            break
    while np.count_nonzero(elsewhere := sky(int(rng.integers(0, 2**31)))) < cloudy:
        pass
    least = np.partition(elsewhere, level.size - cloudy, axis=None)[level.size - cloudy]
    elsewhere = np.where(elsewhere >= least, elsewhere, np.float32(0.0))
    return truth, CloudImage(level, pixel_m), CloudImage(elsewhere, pixel_m)


Drawn = tuple[dict[str, float], int, Callable[[int], NDArray[np.float32]]]


def draw_fractal(which: str, cloud_type: str, pixel_m: float, index: int, rng: np.random.Generator) -> Drawn:
    """Draw parameters, a seed, and the sky that has them, with any brightness exponent."""
    options = options_of(which, cloud_type, pixel_m)
    usual = type_parameters(cloud_type, Catalog()) if cloud_type else FractalParameters()
    known = {"H": usual.H, "gamma": usual.gamma, "Lx": (usual.L or (0, 0))[0], "Ly": (usual.L or (0, 0))[1]}
    texts = usual_priors([(SIDE, SIDE, pixel_m)]) | options.priors
    truth = {}
    for name, kind in KINDS.items():
        drawn = float(Prior.parse(name, texts[name], kind.low, kind.high).quantile(rng.uniform()))
        truth[name] = float(options.fixed.get(name, drawn))
        if which in ("own", "unnamed"):
            truth[name] = float(known.get(name, drawn) or 0.0)
    shape = FractalParameters(
        gamma=truth["gamma"],
        H=truth["H"],
        L=(truth["Lx"], truth["Ly"]),
        k=usual.k or options.octaves,
        brightness_exponent=float(rng.uniform(0.5, 2.0)),
    )
    seed = int(rng.integers(0, 2**31))
    return (
        truth,
        seed,
        lambda seed: part_of(FractalClouds(inputs_of(truth["coverage"], pixel_m, seed), shape, threads=1)),
    )


def draw_surrogate(which: str, sample: str, pixel_m: float, index: int, rng: np.random.Generator) -> Drawn:
    """Draw coverage and seed of surrogates of a measured sample; needs hcss-skies and the extra ``samples``."""
    from hcss_evaluate.database.samples import samples
    from hcss_skies.surrogate.generator import SurrogateClouds
    from hcss_skies.surrogate.parameters import SurrogateParameters

    found = samples(Catalog())[sample]
    row, column, rows, columns = found.crop
    shape = SurrogateParameters(
        image=str(found.path()), reinterpret_pixel_size=True, method="coverage", row_origin=row, column_origin=column,
        crop_rows=rows,
        crop_columns=columns, period_rows=TORUS, period_columns=TORUS,
    )  # fmt: skip
    coverage = float(rng.uniform(0.1, 0.9))
    seed = int(rng.integers(0, 2**31))
    return (
        {"coverage": coverage},
        seed,
        lambda seed: part_of(SurrogateClouds(inputs_of(coverage, pixel_m, seed), shape)),
    )


def draw_example(which: str, kind: str, pixel_m: float, index: int, rng: np.random.Generator) -> Drawn:
    """Draw the seed of a sky like an example, whose coverage the example has at this pixel size; needs hcss-skies."""
    from hcss_skies.generator import ExampleClouds
    from hcss_skies.parameters import ExampleParameters

    shape = ExampleParameters(example=f"{kind}-{1 + index % EXAMPLES}", distribution="expected")
    coverage = ExampleClouds(inputs_of(0.5, pixel_m, 0), shape).image_coverage
    seed = int(rng.integers(0, 2**31))
    return {"coverage": coverage}, seed, lambda seed: part_of(ExampleClouds(inputs_of(0.5, pixel_m, seed), shape))


def inputs_of(coverage: float, pixel_m: float, seed: int) -> CloudInputs:
    """Return the inputs of a generator of grey levels whose coverage is that of the unbounded sky."""
    inputs = grey_inputs(coverage, SIDE, SIDE, pixel_m, seed)
    return dataclasses.replace(inputs, layer=dataclasses.replace(inputs.layer, coverage_mode="field"))


def part_of(clouds: CloudGenerator) -> NDArray[np.float32]:
    """Return the part of a sky in the middle of the scene."""
    return clouds.thickness_m(0.0, slice(0, SIDE), slice(0, SIDE))


def calibrate_one(which: str, cloud_type: str, pixel_m: float, index: int) -> dict[str, str]:
    """Return ranks of the true values among posterior draws, or why there is no posterior."""
    truth, image, elsewhere = draw_images(which, cloud_type, pixel_m, index)
    options = dataclasses.replace(
        options_of(which, cloud_type, pixel_m), seed=index, samples=SAMPLES, most_steps=10_000
    )
    row = {"set": which, "type": cloud_type, "pixel_m": f"{pixel_m:g}", "index": str(index)}
    with tempfile.TemporaryDirectory() as folder, patch.multiple(chains, **QUICK):
        try:
            found = fit_targets([Target(image, "image", ())], Path(folder) / "p.nc", [("image", "")], options)
            with xr.open_dataset(Path(folder) / "p.nc") as file:
                lags, predicted = file["lag"].values, file["variogram_predicted"].values
        except (HcssError, PosteriorError) as error:
            return row | {"refused": str(error).splitlines()[0]}
    row["p_value"] = f"{found.predictive_p_values[0][1]:.4f}"
    row["unlikeness"] = f"{np.atleast_1d(found.attributes['unlikeness'])[0]:.2f}"
    doubted = {name for each in found.doubts for name in each["parameters"]}
    structure = image_structure(image_scores(elsewhere.level), lags.tolist())
    observed = np.stack((structure.along_x, structure.along_y), axis=1)
    row["variogram_inside"] = f"{np.mean((observed >= predicted[0]) & (observed <= predicted[-1])):.3f}"
    row["variogram_doubted"] = str(int("H" in doubted))
    for name, drawn in found.samples.items():
        if name not in truth:
            continue
        some = drawn[np.linspace(0, drawn.size - 1, DRAWS).astype(int)]
        low, high = np.quantile(drawn, [0.05, 0.95])
        row |= {
            f"{name}_truth": f"{truth[name]:.5g}",
            f"{name}_rank": str(int(np.sum(some < truth[name]))),
            f"{name}_inside": str(int(low <= truth[name] <= high)),
            f"{name}_width": f"{high - low:.4g}",
            f"{name}_doubted": str(int(name in doubted)),
        }
    return row


def read(path: Path = RESULTS) -> list[dict[str, str]]:
    """Return the rows of the results."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write(rows: Sequence[Mapping[str, str]]) -> None:
    """Replace the results."""
    with Writing(RESULTS, PosteriorError) as draft, draft.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


@dataclasses.dataclass(frozen=True)
class Summary:
    """Of one parameter: ranks (n,), fraction inside 90 % intervals, doubted, and wrong without a doubt; mean width."""

    ranks: np.ndarray
    inside: float
    doubted: float
    wrong_and_sure: float

    @property
    def counts(self) -> np.ndarray:
        """Numbers of ranks in each of ``BINS`` bins."""
        return np.bincount(self.ranks * BINS // (DRAWS + 1), minlength=BINS)

    @property
    def chi_squared_p(self) -> float:
        """p of uniform ranks by chi squared."""
        expected = self.ranks.size / BINS
        return float(chi2.sf(np.sum((self.counts - expected) ** 2) / expected, BINS - 1))

    @property
    def kolmogorov_p(self) -> float:
        """p of uniform ranks by Kolmogorov and Smirnov."""
        return float(kstest((self.ranks + 0.5) / (DRAWS + 1), "uniform").pvalue)


def summarise(rows: Sequence[Mapping[str, str]], name: str) -> Summary | None:
    """Summarise one parameter; None if it is free in no row."""
    good = [row for row in rows if row.get(f"{name}_rank", "") != ""]
    if not good:
        return None
    ranks, inside, doubted = (
        np.array([int(row[f"{name}_{what}"] or 0) for row in good]) for what in ("rank", "inside", "doubted")
    )
    return Summary(ranks, float(inside.mean()), float(doubted.mean()), float(np.mean((inside == 0) & (doubted == 0))))


def table(rows: Sequence[Mapping[str, str]]) -> str:
    """Return the table of docs/development/uncertainty.md: inside, doubted, and wrong without a doubt.

    Of variograms elsewhere: the fraction of lags inside, and of images whose H is doubted.
    """
    names = (*KINDS, "variogram elsewhere")
    lines = ["| images | number (refused) | " + " | ".join(names) + " |", "|---|---|" + "---|" * len(names)]
    for which in SETS:
        of_set = [row for row in rows if row["set"] == which]
        groups = [(f"`{which}`", of_set)]
        if which != "prior":
            groups += [
                (f"`{which}`, {kind}", [row for row in of_set if row["type"] == kind])
                for kind in TYPES_OF.get(which, TYPES)
            ]
            for pixel in PIXELS_M_OF.get(which, PIXELS_M):
                groups.append((f"`{which}`, {pixel:g} m", [row for row in of_set if float(row["pixel_m"]) == pixel]))
        for words, group in groups:
            # Fractions of a few images say nothing.
            if len(group) >= (FEWEST if group is not of_set else 1):
                refused = sum(1 for row in group if row["refused"])
                cells = [_cell(summarise(group, name), which) for name in KINDS]
                lines.append(
                    f"| {words} | {len(group)} ({refused}) | " + " | ".join([*cells, _elsewhere(group)]) + " |"
                )
    return "\n".join(lines)


def _cell(found: Summary | None, which: str) -> str:
    if found is None:
        return ""
    if which == "prior":  # whose doubts were not recorded
        return f"{found.inside:.0%}"
    return f"{found.inside:.0%}, {found.doubted:.0%}, {found.wrong_and_sure:.0%}"


def _elsewhere(rows: Sequence[Mapping[str, str]]) -> str:
    known = [row for row in rows if row.get("variogram_inside")]
    if len(known) < FEWEST:
        return ""
    inside, doubted = (np.mean([float(row[f"variogram_{what}"]) for row in known]) for what in ("inside", "doubted"))
    return f"{inside:.0%}, {doubted:.0%} of {len(known)}"


def draw_figure(rows: Sequence[Mapping[str, str]], path: Path) -> None:
    """Draw the cumulative ranks less those of a uniform distribution, by set, type and parameter, of enough images."""
    from matplotlib.figure import Figure

    shown = [which for which in SETS if sum(row["set"] == which for row in rows) >= FEWEST]
    figure = Figure((9.0, 1.2 + 1.8 * len(shown)), layout="constrained")
    axes = figure.subplots(len(shown), len(KINDS), sharex=True, sharey=True, squeeze=False)
    grid = (np.arange(DRAWS + 1) + 0.5) / (DRAWS + 1)
    for line, which in zip(axes, shown, strict=True):
        own = [row for row in rows if row["set"] == which]
        for axis, name in zip(line, KINDS, strict=True):
            everything = summarise(own, name)
            axis.set_title(f"{which}: {name}", fontsize=9)
            if everything is None:
                axis.text(0.5, 0.0, "none" if which in TYPES_OF else "fixed", ha="center", va="center")
                continue
            band = 1.36 / math.sqrt(everything.ranks.size)
            axis.axhspan(-band, band, color="0.9")
            for number, kind in enumerate(TYPES_OF.get(which, TYPES)):
                found = summarise([row for row in own if row["type"] == kind], name)
                if found is not None and found.ranks.size >= FEWEST:
                    axis.plot(grid, _excess(found.ranks), lw=0.7, color=f"C{number}", label=kind)
            axis.plot(grid, _excess(everything.ranks), color="black", lw=1.6, label="all")
    for axis in axes[-1]:
        axis.set_xlabel("rank of the true value")
    for axis in axes[:, 0]:
        axis.set_ylabel("excess, cumulative")
    axes[0, 0].set_ylim(-0.25, 0.25)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)
    figure.savefig(path, dpi=110)


def _excess(ranks: np.ndarray) -> np.ndarray:
    cumulative = np.cumsum(np.bincount(ranks, minlength=DRAWS + 1)) / ranks.size
    return cumulative - np.arange(1, DRAWS + 2) / (DRAWS + 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--images", type=int, default=0, help="Of each type, pixel size and set.")
    parser.add_argument("--sets", nargs="+", choices=SETS, default=["named", "own", "unnamed"])
    parser.add_argument("--write", action="store_true", help="Write results.csv after each image.")
    parser.add_argument("--figure", type=Path, help="Also draw the ranks.")
    given = parser.parse_args()
    rows = read()
    known = {(row["set"], row["type"], row["pixel_m"], row["index"]) for row in rows}
    for case in cases(given.sets, given.images):
        which, cloud_type, pixel, index = case
        if (which, cloud_type, f"{pixel:g}", str(index)) in known:
            continue
        rows.append(calibrate_one(*case))
        print(rows[-1], flush=True)
        if given.write:
            write(rows)
    print(table(rows))
    if given.figure is not None:
        draw_figure(rows, given.figure)


if __name__ == "__main__":
    main()
