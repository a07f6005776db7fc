"""What skies played from films keep of the large-eddy simulation, and what is published of such clouds.

    python benchmarks/simulated_skies.py [laws classifier seams coherence] [--kinds cumulus,stratus]

Kinds are cloud types whose skies are films (``catalogs/cloud_types``), with the coverage that they have there.
References are the snapshots of the film itself (consistency, not accuracy) and published ranges; the control is the
fractal field that the type has without hcss-skies. No image of clouds at 20 to 300 m is at hand, so that the classifier
compares with the simulation, at its own 50 m and with radiances averaged to 300 m, where a patch is the whole box. It
is also asked to tell two half hours of the simulation from each other, and halves of it by chance: where it can tell
half hours, it says little about a sky. Brightness temperature is that of a grey cloud of one temperature: 12 K colder
than the sea where opaque, absorbing half of what the visible loses.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
from cloud_scenes import LEVELS
from hcss_evaluate.realism.classifiers import Classifier, auc, auc_interval, out_of_fold
from hcss_evaluate.realism.clouds import Clouds, size_exponent
from hcss_evaluate.realism.coherence import correlation_by_band
from hcss_evaluate.realism.features import all_features
from hcss_evaluate.realism.laws import PUBLISHED, Published, cloud_laws
from hcss_evaluate.realism.patches import z_scored
from hcss_skies.film import Film, read_film
from hcss_skies.library import shipped_films
from hcss_skies.parameters import SimulationParameters
from hcss_skies.simulation import SimulatedClouds, extinction_m1

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, CloudInputs, CloudLayer, Grid, Motion
from hcss_twin.scenario.cloud_types import resolve_layer
from hcss_twin.scenario.clouds import Layer

CATALOG = Catalog()
STILL, EVOLVING = (Motion(0.0, (0.0, 0.0), life_s, 1.0) for life_s in (np.inf, 1800.0))
BOX_M, FILM_M, FINE_M, COARSE_M = 9600.0, 50.0, 20.0, 300.0
CLOUD, OPAQUE_K, NOISE_K = 0.3, 12.0, 0.2
"""Optical thickness above which a pixel counts as cloud, contrast of opaque cloud, and noise."""
LATER = 100
"""From this number on, scenes of the simulation belong to its second piece."""
CLASSIFIERS: tuple[Classifier, ...] = ("forest", "boosting", "linear")
WAVES_M, LARGE_M = (200.0, 3200.0), 200.0
NEAR_AXIS_DEG = 5.0  # 40 of 360 degrees: .111 of the gradients of an isotropic field
SEEDS, SEEN, SPLITS, SEAM_SEEDS, SEAM_M = 10, 20, 5, 1000, 70.0
SLOPE, AXES, BEYOND = "slope of the spectrum", "gradients near the axes", "where not the least thickness"
ABOVE = "exponent of areas above 200 m"
RANGES = {
    **PUBLISHED,
    SLOPE: Published(
        -1.97, -1.37, "-5/3 +- .3: A. B. Davis et al., J. Atmos. Sci. 56, 1518 (1999); Marshak et al. 1997"
    ),
    ABOVE: PUBLISHED["exponent of areas"],
    AXES: Published(0.0, 0.13, "isotropic: .111"),
    BEYOND: Published(0.0, 0.13, "isotropic: .111"),
}


@dataclass(frozen=True)
class Kind:
    """A cloud type and the film that its sky is."""

    name: str
    film: str
    coverage: float

    @cache  # noqa: B019
    def read(self) -> Film:
        """Return the film."""
        return read_film(shipped_films()[self.film])

    @cache  # noqa: B019
    def resolved(self) -> Any:
        """Return the layer and the fractal parameters of the type."""
        return resolve_layer(Layer(type=self.name, coverage=self.coverage), CATALOG, "clouds", LEVELS)

    def simulated(self) -> list[tuple[int, Array]]:
        """Return optical thickness of snapshots of the simulation, and the five minutes that they belong to.

        Clouds are raised as in the sky, to its cover.
        """
        film, table, found = self.read(), self.table(), []
        for piece, ranks in enumerate(film.ranks):
            for number, frame in enumerate(ranks):
                found.append((LATER * piece + number // 5, table[frame]))
        return found

    def table(self) -> Array:
        """Return optical thickness at the ranks of the film, at the cover of the sky."""
        inputs = self.inputs(FILM_M, 1, 0)
        sky = SimulatedClouds(inputs, SimulationParameters(film=self.film))
        return extinction_m1(inputs.layer) * sky.thickness_of_ranks_m.astype(np.float64)

    def inputs(self, pixel_m: float, size: int, seed: int, motion: Motion = STILL) -> CloudInputs:
        """Return the inputs of a generator of this type."""
        resolved = self.resolved()
        layer = replace(resolved.layer, coverage_mode="field")
        return CloudInputs(layer, Grid(size, size, pixel_m), motion, seed, CATALOG, resolved.type_parameters)

    def sky(self, pixel_m: float, size: int, seed: int, times_s: tuple[float, ...] = (0.0,)) -> list[Array]:
        """Return optical thickness of a sky of the film at times."""
        inputs = self.inputs(pixel_m, size, seed, STILL if len(times_s) == 1 else EVOLVING)
        return _frames(SimulatedClouds(inputs, SimulationParameters(film=self.film)), inputs, times_s)

    def fractal(self, pixel_m: float, size: int, seed: int) -> Array:
        """Return optical thickness of the fractal field of the type."""
        inputs = self.inputs(pixel_m, size, seed)
        return _frames(FractalClouds(inputs, FractalParameters(), 1), inputs, (0.0,))[0]


KINDS = {
    kind.name: kind
    for kind in (
        Kind("cumulus", "trade-cumulus", 0.15),
        Kind("stratocumulus", "stratocumulus", 0.8),
        Kind("stratus", "stratocumulus", 0.99),
        Kind("altocumulus", "altocumulus", 0.8),
    )
}


@cache
def extinction(layer: CloudLayer) -> float:
    """Return the extinction of a layer, 1/m."""
    return extinction_m1(layer)


def _frames(clouds: Any, inputs: CloudInputs, times_s: tuple[float, ...]) -> list[Array]:
    every, per_m = slice(0, inputs.grid.rows), extinction(inputs.layer)
    return [per_m * clouds.thickness_m(time, every, every).astype(np.float64) for time in times_s]


def averaged(emissivity: Array, pixels: int) -> Array:
    """Return means over squares: radiances, not thickness, are averaged."""
    side = len(emissivity) // pixels
    cut = emissivity[: side * pixels, : side * pixels]
    return np.asarray(cut.reshape(side, pixels, side, pixels).mean(axis=(1, 3)))


def slope(frames: list[Array], pixel_m: float) -> float:
    """Return the exponent of one-dimensional spectra along rows and columns, of waves between ``WAVES_M``."""
    size = len(frames[0])
    lines = np.concatenate([np.concatenate((frame, frame.T)) for frame in frames])
    window = np.hanning(size)
    power = np.mean(np.abs(np.fft.rfft((lines - lines.mean(axis=1, keepdims=True)) * window)) ** 2, axis=0)
    k = np.fft.rfftfreq(size, pixel_m)
    kept = (k >= 1.0 / WAVES_M[1]) & (k <= 1.0 / WAVES_M[0])
    rings = np.floor(4 * np.log2(k[kept] * WAVES_M[1])).astype(np.intp)
    mean = [np.bincount(rings, values) / np.maximum(np.bincount(rings), 1) for values in (k[kept], power[kept])]
    some = np.bincount(rings) > 0
    return float(np.polyfit(*(np.log(values[some]) for values in mean), 1)[0])


def near_axes(frames: list[Array], above: float) -> float:
    """Return the share of gradients within 5 degrees of the axes of pixels, where the optical thickness is larger."""
    count = near = 0
    for frame in frames:
        along_y, along_x = frame[2:, 1:-1] - frame[:-2, 1:-1], frame[1:-1, 2:] - frame[1:-1, :-2]
        kept = (frame[1:-1, 1:-1] > above) & (np.hypot(along_y, along_x) > 0.0)
        angle = np.degrees(np.arctan2(along_y[kept], along_x[kept])) % 90.0
        count += angle.size
        near += np.count_nonzero(np.minimum(angle, 90.0 - angle) < NEAR_AXIS_DEG)
    return near / max(count, 1)


def statistics(frames: list[Array], pixel_m: float) -> dict[str, float | None]:
    """Return all statistics of frames of optical thickness."""
    masks = [frame > CLOUD for frame in frames]
    clouds = [Clouds.of(mask) for mask in masks]
    area, cut = (np.concatenate([getattr(of, name) for of in clouds]) for name in ("area", "truncated"))
    least = min(float(frame[frame > 0.0].min()) for frame in frames)
    found = {SLOPE: slope(frames, pixel_m), AXES: near_axes(frames, CLOUD), BEYOND: near_axes(frames, 1.01 * least)}
    return cloud_laws(masks, frames) | found | {ABOVE: size_exponent(area, cut, max(10.0, (LARGE_M / pixel_m) ** 2))}


def laws(kinds: list[Kind]) -> None:
    """Print statistics of the simulation at 50 m, of skies at 50 and 20 m, and of the fractal type at 20 m."""
    for kind in kinds:
        sides = {
            "simulation": statistics([frame for _, frame in kind.simulated()[::6]], FILM_M),
            "sky, 50 m": statistics([kind.sky(FILM_M, 192, seed)[0] for seed in range(SEEDS)], FILM_M),
            "sky, 20 m": statistics([kind.sky(FINE_M, 480, seed)[0] for seed in range(SEEDS)], FINE_M),
            "fractal": statistics([kind.fractal(FINE_M, 480, seed) for seed in range(SEEDS)], FINE_M),
        }
        print(f"{kind.name:34}" + "".join(f"{side:>13}" for side in sides) + "  published", flush=True)
        for name in next(iter(sides.values())):
            row = "".join(f"{'-' if (v := side[name]) is None else f'{v:.3f}':>13}" for side in sides.values())
            print(
                f"  {name:32}{row}  " + (f"{of.low:g} to {of.high:g}" if (of := RANGES.get(name)) else ""), flush=True
            )


def emissivities(kind: Kind, pixel_m: float) -> dict[str, list[tuple[int, Array]]]:
    """Return emissivities of patches with the number of their scene: simulation, sky, fractal type."""

    def patches(frames: Iterator[tuple[int, Array]]) -> list[tuple[int, Array]]:
        found = []
        for scene, frame in frames:
            emissivity = -np.expm1(-0.5 * frame)
            if pixel_m == FILM_M:
                found += [(scene, emissivity[i : i + 64, j : j + 64]) for i in (0, 64, 128) for j in (0, 64, 128)]
            else:
                found.append((scene, averaged(emissivity, round(pixel_m / FILM_M))))
        return found

    step = 5 if pixel_m == FILM_M else 1
    times = (0.0,) if pixel_m == FILM_M else (0.0, 1200.0, 2400.0)
    skies = ((1000 + seed, frame) for seed in range(SEEN) for frame in kind.sky(FILM_M, 192, seed, times))
    fractal = ((2000 + seed, kind.fractal(FILM_M, 192, seed)) for seed in range(SEEN * len(times)))
    simulated = ((scene, frame) for scene, frame in kind.simulated()[::step])
    sides = {"simulation": simulated, "sky": skies, "fractal": fractal}
    return {name: patches(frames) for name, frames in sides.items()}


def features(patches: list[tuple[int, Array]], cover: float | None) -> tuple[Array, Array]:
    """Return features and scenes: of masks of the most opaque pixels up to a cover, or of noisy temperatures."""
    fields, scenes = np.array([field for _, field in patches]), np.array([scene for scene, _ in patches])
    if cover is None:
        noise = np.random.default_rng(0).normal(0.0, NOISE_K, fields.shape)
        fields = 290.0 - OPAQUE_K * fields + noise
    else:
        fields = (fields > np.quantile(fields, 1.0 - cover)).astype(np.float64)
    share = np.mean(fields if cover is not None else np.array([field for _, field in patches]) > 0.14, axis=(1, 2))
    kept = (share > 0.03) & (share < (0.97 if cover is not None else 2.0))
    return np.nan_to_num(all_features(z_scored(fields[kept]))[1]), scenes[kept]


def told(first: tuple[Array, Array], second: tuple[Array, Array]) -> dict[str, tuple[float, float, float]]:
    """Return AUC with its interval by classifier."""
    values, scenes = np.concatenate([first[0], second[0]]), np.concatenate([first[1], second[1]])
    label = np.repeat([False, True], [len(first[1]), len(second[1])])
    found = {}
    for name in CLASSIFIERS:
        probability = out_of_fold(values, label, scenes, name, 0)
        found[name] = auc(probability, label), *auc_interval(probability, label, scenes, resamples=200, seed=0)
    return found


def halves(values: Array, scenes: Array, seed: int) -> list[tuple[Array, Array]]:
    """Return patches of the same scenes in two halves, by chance: nothing tells them apart."""
    chance = np.random.default_rng(seed).random(len(scenes)) < 0.5
    return [(values[chance == half], scenes[chance == half]) for half in (False, True)]


def classifier(kinds: list[Kind]) -> None:
    """Print how well classifiers tell skies, and controls, from the simulation, and kinds from each other."""
    of_kinds = {}
    for kind in kinds:
        for pixel_m in (FILM_M, COARSE_M):
            patches = emissivities(kind, pixel_m)
            cover = min(float(np.mean([field > 0.14 for _, field in side])) for side in patches.values())
            for what, given in (("masks", min(cover, 0.9)), ("noisy temperatures", None)):
                sides = {name: features(side, given) for name, side in patches.items()}
                if pixel_m == FILM_M and given is None:
                    of_kinds[kind.name] = sides["sky"]
                for name in ("sky", "fractal"):
                    scores = told(sides["simulation"], sides[name])
                    words = ", ".join(f"{c} {a:.2f} ({low:.2f} to {high:.2f})" for c, (a, low, high) in scores.items())
                    print(f"{kind.name}, {pixel_m:g} m, {what}, {name}: {words}", flush=True)
                values, scenes = sides["simulation"]
                later = scenes >= LATER
                scores = told((values[~later], scenes[~later]), (values[later], scenes[later]))
                words = ", ".join(f"{c} {a:.2f}" for c, (a, _, _) in scores.items())
                print(f"{kind.name}, {pixel_m:g} m, {what}, two half hours of the simulation: {words}", flush=True)
                same = [list(told(*halves(values, scenes, split)).values()) for split in range(SPLITS)]
                mean = np.mean(same, axis=0)[:, 0]
                words = ", ".join(f"{c} {a:.2f}" for c, a in zip(CLASSIFIERS, mean, strict=True))
                print(f"{kind.name}, {pixel_m:g} m, {what}, simulation, mean of {SPLITS} splits: {words}", flush=True)
    for one, other in combinations(of_kinds, 2):
        a, b = of_kinds[one], of_kinds[other]
        score = told(a, (b[0], b[1] + 5000))["forest"]
        print(f"{one}, {other}: {score[0]:.2f} ({score[1]:.2f} to {score[2]:.2f})", flush=True)


def seams(kinds: list[Kind]) -> None:
    """Print how far means over 1000 seeds at single places are from their mean, in standard errors."""
    for kind in kinds:
        total = squares = 0.0
        for seed in range(SEAM_SEEDS):
            (frame,) = kind.sky(SEAM_M, 110, seed)
            emissivity = -np.expm1(-0.5 * frame)
            total, squares = total + emissivity, squares + emissivity**2
        mean = total / SEAM_SEEDS
        spread = np.sqrt(squares / SEAM_SEEDS - mean**2)
        z = (mean - mean.mean()) / (spread.mean() / np.sqrt(SEAM_SEEDS))
        print(
            f"{kind.name}: mean emissivity of {SEAM_SEEDS} seeds at {mean.size} places {mean.mean():.3f}, largest "
            f"deviation {np.abs(z).max():.1f} standard errors, rms {z.std():.2f}",
            flush=True,
        )


def coherence(kinds: list[Kind]) -> None:
    """Print the correlation of windows of 3.2 km, moved onto each other, between frames."""
    for kind in kinds:
        film, table = kind.read(), kind.table()
        pairs: dict[str, list[tuple[Array, Array]]] = {"sky, 150 s": []}
        for seed in range(SEEDS):
            one, other = kind.sky(FILM_M, 192, seed, (1000.0, 1150.0))
            pairs["sky, 150 s"].append((one, other))
        for apart in (2, 3):
            steps = range(0, film.ranks.shape[1] - apart, 7)
            pairs[f"simulation, {apart * film.interval_s:g} s"] = [
                (table[ranks[n]], table[ranks[n + apart]]) for ranks in film.ranks for n in steps
            ]
        row = [f"{name} {np.mean([*map(float, windows(of))]):.2f}" for name, of in pairs.items()]
        print(f"{kind.name}: " + ", ".join(row), flush=True)


def windows(pairs: list[tuple[Array, Array]]) -> Iterator[float]:
    """Yield correlations of windows of 64 cells in which there is cloud at both times."""
    for one, other in pairs:
        for i in (0, 64, 128):
            for j in (0, 64, 128):
                two = [-np.expm1(-0.5 * frame[i : i + 64, j : j + 64]) for frame in (one, other)]
                if min(np.mean(frame > 0.14) for frame in two) > 0.03:
                    yield correlation_by_band(*two)[0]


WHAT = {"laws": laws, "classifier": classifier, "seams": seams, "coherence": coherence}


def main() -> None:
    """Parse arguments and print tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("what", nargs="*", choices=(*WHAT, []), default=list(WHAT))
    parser.add_argument("--kinds", default=",".join(KINDS))
    given = parser.parse_args()
    for name in given.what:
        WHAT[name]([KINDS[kind] for kind in given.kinds.split(",")])


if __name__ == "__main__":
    main()
