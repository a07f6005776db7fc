"""The realism test of two sets of images: :func:`compare`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from hcss_evaluate.realism.classifiers import Classifier, auc, auc_interval, out_of_fold, require_scikit_learn
from hcss_evaluate.realism.coherence import coherence
from hcss_evaluate.realism.copies import Example, largest_correlations
from hcss_evaluate.realism.features import all_features
from hcss_evaluate.realism.increments import LAGS, structure_function
from hcss_evaluate.realism.laws import Law, cloud_laws
from hcss_evaluate.realism.patches import COLDER_K, SIZE, Patches, colder_than_clear, cut_patches, z_scored
from hcss_evaluate.realism.spectrum import power_by_ring
from hcss_twin import ImageError
from hcss_twin.providers import Array

Scale = Literal["z-scored", "kelvin"]
Fields = Sequence[Array] | Array
Numbers = Sequence[int] | NDArray[np.int64]
Times = Sequence[float] | Array

CLASSIFIERS: tuple[Classifier, ...] = ("forest", "boosting")
SCALES: tuple[Scale, ...] = ("z-scored", "kelvin")


@dataclass(frozen=True)
class Score:
    """How well one classifier tells simulated from real patches: AUC .5 is chance, 1 is always right.

    ``low`` and ``high`` are the 95 % confidence interval (bootstrap over scenes).
    """

    classifier: Classifier
    scale: Scale
    auc: float
    low: float
    high: float


@dataclass(frozen=True)
class FeatureDifference:
    """How well one feature alone tells the sides apart.

    Attributes
    ----------
    auc : float
        Probability that a simulated patch has the larger value: .5 is no difference, 0 and 1 are complete.
    real, simulated : float
        Medians.
    """

    name: str
    scale: Scale
    auc: float
    real: float
    simulated: float


@dataclass(frozen=True)
class Copies:
    """Shares of simulated patches that are nearly pieces of real images, mirrored or not.

    Attributes
    ----------
    patches : int
        Number of simulated patches that were searched.
    examples : str
        The images in which they were searched.
    above_90, above_95 : float
        Shares with a correlation above .9 and .95.
    largest : float
        Largest correlation.
    """

    patches: int
    examples: str
    above_90: float
    above_95: float
    largest: float


@dataclass(frozen=True)
class Curve:
    """One statistic of both sides over a common axis."""

    axis: tuple[float, ...]
    real: tuple[float, ...]
    simulated: tuple[float, ...]


@dataclass(frozen=True)
class Realism:
    """Result of the realism test.

    Attributes
    ----------
    scores : tuple of Score
        Each classifier in each scale; the first is that of the forest with z-scored patches, if it ran.
    features : tuple of FeatureDifference
        Features, those that tell most first; in kelvin only those that the unit changes.
    copies : Copies or None
        None if not searched.
    spectrum : Curve
        Mean power spectral density, K^2 per (cycle per pixel)^2, over cycles per pixel.
    structure : Curve
        Second-order structure function, K^2, over pixels.
    laws : tuple of Law
        Statistics of clouds of both sides, all images pooled, beside their published ranges.
    coherence : dict of str to dict of float to tuple of float
        For "real" and "simulated", by lag in s: correlation of the whole field and of the bands 4-8, 8-16 and 16-32
        pixels of wavelength, after the motion between frames; empty without times.
    patches, left_out, scenes : tuple of (int, int)
        Numbers of the real and the simulated side.
    common_scenes : int
        Scenes that both sides have.
    notes : tuple of str
        What the caller should know of the files.
    """

    scores: tuple[Score, ...]
    features: tuple[FeatureDifference, ...]
    copies: Copies | None
    spectrum: Curve
    structure: Curve
    laws: tuple[Law, ...]
    coherence: dict[str, dict[float, tuple[float, ...]]]
    patches: tuple[int, int]
    left_out: tuple[int, int]
    scenes: tuple[int, int]
    common_scenes: int
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON."""
        return asdict(self)


def compare(
    real: Fields,
    simulated: Fields,
    real_scene: Numbers | None = None,
    simulated_scene: Numbers | None = None,
    *,
    real_time_s: Times | None = None,
    simulated_time_s: Times | None = None,
    seed: int = 0,
    size: int = SIZE,
    blur_pixels: float = 0.65,
    noise_k: float = 0.2,
    classifiers: Sequence[Classifier] = CLASSIFIERS,
    scales: Sequence[Scale] = SCALES,
    resamples: int = 500,
    copies: int = 100,
) -> Realism:
    """Try to tell simulated from real images of brightness temperature, patch by patch.

    The simulated images are blurred as a sensor does, both sides get white noise, and both are cut into patches.
    Patches without cloud are left out. Classifiers then learn from features of the patches of some scenes, and are
    asked about those of the others.

    Parameters
    ----------
    real, simulated : ndarray (N, rows, columns), or sequences of ndarray (rows, columns)
        Brightness temperature, K, with the same pixel size; NaN where missing.
    real_scene, simulated_scene : sequence of int (N,), optional
        Scene of each image; default: each image is a scene of its own. A simulation that was made from a real scene has
        the number of that scene: no classifier is then asked about a scene that it learnt from.
    real_time_s, simulated_time_s : sequence of float (N,), optional
        Time of each image, s: images of one scene form a sequence whose coherence is measured.
    seed : int
        Of noise, folds, classifiers and bootstrap.
    size : int
        Side of the patches, pixels.
    blur_pixels : float
        Standard deviation of the Gaussian blur of simulated images, pixels; 0 for images that have a sensor's blur.
    noise_k : float
        Standard deviation of the white noise, K.
    classifiers, scales : sequence of str
        "forest", "boosting", "linear"; "z-scored", "kelvin".
    resamples : int
        Number of bootstrap resamples.
    copies : int
        Number of simulated patches to search in real images: in those of their scene, if there are any, else in all.

    Returns
    -------
    Realism

    Raises
    ------
    ImageError
        If a side has no patch with cloud, fewer than two scenes, or images that are too small or not in kelvin.
    HcssError
        If scikit-learn is missing.
    """
    require_scikit_learn()
    real_number, simulated_number = _scenes(real, simulated, real_scene, simulated_scene)
    streams = np.random.default_rng(seed).spawn(3)
    sides = (
        cut_patches("real", real, real_number, size=size, blur_pixels=0.0, noise_k=noise_k, rng=streams[0]),
        cut_patches(
            "simulated",
            simulated,
            simulated_number,
            size=size,
            blur_pixels=blur_pixels,
            noise_k=noise_k,
            rng=streams[1],
        ),
    )
    scene = np.concatenate([side.scene for side in sides])
    label = np.repeat([False, True], [len(side.scene) for side in sides])
    scores: list[Score] = []
    differences: list[FeatureDifference] = []
    for scale in scales:
        patches = np.concatenate([side.noisy for side in sides])
        names, values = all_features(z_scored(patches) if scale == "z-scored" else patches)
        for name in classifiers:
            probability = out_of_fold(values, label, scene, name, seed)
            interval = auc_interval(probability, label, scene, resamples=resamples, seed=seed)
            scores.append(Score(name, scale, auc(probability, label), *interval))
        # Most features do not depend on the unit.
        known = {(difference.name, difference.auc) for difference in differences}
        found = _differences(names, values, label, scale)
        differences += [difference for difference in found if (difference.name, difference.auc) not in known]
    differences.sort(key=lambda difference: -abs(difference.auc - 0.5))
    wavenumber, density, _ = power_by_ring(sides[0].kelvin)
    both = (density, power_by_ring(sides[1].kelvin)[1])
    times = {"real": (real, real_number, real_time_s), "simulated": (simulated, simulated_number, simulated_time_s)}
    return Realism(
        scores=tuple(scores),
        features=tuple(differences),
        copies=_copies(sides[1], real, real_number, copies, size, streams[2]) if copies else None,
        spectrum=_curve(wavenumber, *(power.mean(axis=0) for power in both)),
        structure=_curve(np.array(LAGS, dtype=np.float64), *(structure_function(side.kelvin) for side in sides)),
        laws=_laws(real, simulated, blur_pixels),
        coherence={side: _coherence(*given) for side, given in times.items()},
        patches=(len(sides[0].scene), len(sides[1].scene)),
        left_out=(sides[0].cut - len(sides[0].scene), sides[1].cut - len(sides[1].scene)),
        scenes=(len(set(sides[0].scene)), len(set(sides[1].scene))),
        common_scenes=len(set(sides[0].scene) & set(sides[1].scene)),
    )


def _scenes(
    real: Fields, simulated: Fields, real_scene: Numbers | None, simulated_scene: Numbers | None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the scene of each image; those that are not given are different from all others."""
    found: list[NDArray[np.int64]] = []
    for side, fields, given in (("real", real, real_scene), ("simulated", simulated, simulated_scene)):
        if given is None:
            taken = (
                found[0] if found else np.asarray([] if simulated_scene is None else simulated_scene, dtype=np.int64)
            )
            number = np.arange(len(fields), dtype=np.int64) + (int(taken.max()) + 1 if taken.size else 0)
        else:
            number = np.asarray(given, dtype=np.int64)
        if number.shape != (len(fields),):
            raise ImageError(f"{side}_scene: shape {number.shape}, allowed: ({len(fields)},), one for each image")
        found.append(number)
    return found[0], found[1]


def _differences(names: list[str], values: Array, label: NDArray[np.bool_], scale: Scale) -> list[FeatureDifference]:
    return [
        FeatureDifference(
            name, scale, auc(column, label), *(float(np.median(column[label == side])) for side in (False, True))
        )
        for name, column in zip(names, values.T, strict=True)
    ]


def _curve(axis: Array, real: Array, simulated: Array) -> Curve:
    return Curve(*(tuple(map(float, values)) for values in (axis, real, simulated)))


def _laws(real: Fields, simulated: Fields, blur_pixels: float) -> tuple[Law, ...]:
    """Measure clouds of both sides in whole images; those of the simulated side are blurred as their patches are."""
    found = []
    for fields, blur in ((real, 0.0), (simulated, blur_pixels)):
        images = [np.asarray(field, dtype=np.float64) for field in fields]
        blurred = [gaussian_filter(image, blur, mode="nearest") if blur else image for image in images]
        contrasts = [colder_than_clear(image) for image in blurred]
        found.append(cloud_laws([contrast > COLDER_K for contrast in contrasts], contrasts))
    return tuple(Law.of(name, value, found[1][name]) for name, value in found[0].items())


def _copies(
    simulated: Patches, real: Fields, real_scene: NDArray[np.int64], count: int, size: int, rng: np.random.Generator
) -> Copies:
    """Search up to ``count`` random simulated patches in the real images of their scene, else in all of them."""
    chosen = np.sort(rng.permutation(len(simulated.scene))[:count])
    common = np.isin(simulated.scene[chosen], real_scene)
    if common.any():
        chosen = chosen[common]
    largest = np.empty(len(chosen))
    for number in np.unique(simulated.scene[chosen]):
        at = simulated.scene[chosen] == number
        fields = [field for field, scene in zip(real, real_scene, strict=True) if scene == number or not common.any()]
        largest[at] = largest_correlations(simulated.kelvin[chosen[at]], [Example(field, size) for field in fields])
    return Copies(
        patches=len(chosen),
        examples="real images of the same scene" if common.any() else "all real images",
        above_90=float(np.mean(largest > 0.9)),
        above_95=float(np.mean(largest > 0.95)),
        largest=float(largest.max()),
    )


def _coherence(fields: Fields, scene: NDArray[np.int64], times: Times | None) -> dict[float, tuple[float, ...]]:
    if times is None:
        return {}
    members = [np.flatnonzero(scene == number).tolist() for number in np.unique(scene)]
    found = coherence(([fields[index] for index in at], [times[index] for index in at]) for at in members)
    return {lag: tuple(map(float, values)) for lag, values in found.items()}
