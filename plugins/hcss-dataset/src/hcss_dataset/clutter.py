"""How hard backgrounds are: slopes of spectra, jitter clutter, SCR, and rates of false alarms far beyond the sample.

Rates below one over the number of pixels follow from a fit of the tail: excesses over a high value have a generalised
Pareto distribution, whatever the distribution of all values (J. Pickands, Annals of Statistics 3, 119, 1975).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from hcss_dataset.baselines import BASELINES
from hcss_dataset.errors import DatasetError
from hcss_twin.providers import Array
from hcss_twin.reports.power_spectrum import Rings

FALSE_ALARMS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
"""Shares of pixels above a threshold at which the detection rate is stated."""

TAIL, LEAST, MOST = 1e-3, 200, 20_000
"""Share of the values that a tail consists of, and least and largest number of them."""

AROUND = 12
"""Pixels around a target that do not belong to the background."""

SHORTEST, LONGEST_SHARE = 0.125, 2.5
"""Wavenumbers of a slope: up to cycles per pixel, where optics hardly blur, and from waves per image side."""

_STEP, _EDGE = 0.25, 6
_RESAMPLED = 20


@dataclass(frozen=True)
class Tail:
    """Distribution of the values of a background above a high one.

    Attributes
    ----------
    over : float
        Value from which on the fit holds.
    share : float
        Share of all values that are above it.
    shape, scale : float
        Of the generalised Pareto distribution of the excesses.
    highest : float
        Of the sample.
    """

    over: float
    share: float
    shape: float
    scale: float
    highest: float

    @classmethod
    def of(cls, values: NDArray[Any]) -> Self:
        """Fit the tail of a sample by maximum likelihood.

        Raises
        ------
        DatasetError
            If the sample is too small.
        """
        from scipy import stats

        count = min(max(round(TAIL * values.size), LEAST), MOST)
        if 5 * count > values.size:
            raise DatasetError(
                f"{values.size} pixels of background; allowed: at least {5 * LEAST}, for a fit of the tail"
            )
        highest = np.partition(values.ravel(), values.size - count - 1)[values.size - count - 1 :]
        over = float(highest[0])
        excess = highest[1:] - over
        if not excess.max() > 0.0:
            raise DatasetError(
                f"the {count} highest values of the background are all {over:g}: there is no tail to fit"
            )
        shape, _, scale = stats.genpareto.fit(excess, floc=0.0, scale=float(excess.mean()))
        return cls(over, count / values.size, float(shape), float(scale), float(highest.max()))

    def threshold(self, share: float) -> float:
        """Return the value that a share of all values exceeds.

        Raises
        ------
        ValueError
            If the share is larger than that of the tail.
        """
        if not 0.0 < share <= self.share:
            raise ValueError(f"share = {share:g}; allowed: above 0 to {self.share:g}, the share of the tail")
        ratio = self.share / share
        if abs(self.shape) < 1e-9:
            return self.over + self.scale * math.log(ratio)
        return self.over + self.scale / self.shape * math.expm1(self.shape * math.log(ratio))


@dataclass(frozen=True)
class Clutter:
    """Clutter of a data set in one band.

    Attributes
    ----------
    slope : ndarray (F,)
        Of the power spectrum of each clean frame, power per area of the wavenumber plane against wavenumber; NaN for
        frames without structure.
    deviation, gradient : ndarray (F,)
        Standard deviation of each clean frame, and rms change along a pixel, both axes together; W m-2 sr-1.
    noise : ndarray (F,)
        Of the sensor, W m-2 sr-1.
    scr : ndarray (T,)
        Of targets that count.
    filtered : str
        Baseline whose output the tail is of.
    tail : Tail
        Of its output away from targets.
    response : ndarray (T,)
        Largest output near each target.
    points : list of dict
        False alarms, threshold with the deviation by resampled frames, and detection rate.
    pixels : int
        Number of pixels of the background.
    """

    slope: Array
    deviation: Array
    gradient: Array
    noise: Array
    scr: Array
    filtered: str
    tail: Tail
    response: Array
    points: list[dict[str, float]]
    pixels: int

    def jitter(self, pixels: float) -> float:
        """Return the rms clutter by a jitter of the line of sight, rms pixels along each axis: gradient x jitter."""
        return float(np.sqrt(np.mean(self.gradient**2))) * pixels

    def as_dict(self, jitter: float) -> dict[str, Any]:
        """Return plain values for JSON, with the clutter by a jitter in pixels."""
        return {
            "frames": int(self.slope.size),
            "spectral_slope": _quartiles(self.slope),
            "clutter": _quartiles(self.deviation),
            "noise": _quartiles(self.noise),
            "gradient_per_pixel": _quartiles(self.gradient),
            "jitter_pixels": jitter,
            "jitter_clutter": self.jitter(jitter),
            "scr": _quartiles(self.scr),
            "filter": self.filtered,
            "background_pixels": self.pixels,
            "tail": vars(self.tail),
            "points": self.points,
        }


def spectral_slope(image: NDArray[Any]) -> float:
    """Return the slope of the power spectrum of an image (y, x); NaN without structure.

    Power is per area of the wavenumber plane and averaged over rings; the line is through logarithms, from 2.5 waves
    over the longer side to .125 cycles per pixel.
    """
    if not np.ptp(image) > 0.0:
        return math.nan
    rings = Rings.of(image)
    inside = (rings.waves > 0) & (rings.wavenumber <= SHORTEST) & (rings.wavenumber >= LONGEST_SHARE / max(image.shape))
    inside &= rings.power > 0.0
    if np.count_nonzero(inside) < 2:
        return math.nan
    # the logarithm of a mean over n waves has the variance 1 / n
    weights = np.sqrt(rings.waves[inside])
    return float(np.polyfit(np.log(rings.wavenumber[inside]), np.log(rings.power[inside]), 1, w=weights)[0])


def gradient_rms(image: NDArray[Any]) -> float:
    """Return the root of the mean squared gradient of an image (y, x), per pixel, without its outer pixels.

    The derivative is that of a spline: differences of neighbours would halve that of waves of four pixels.
    """
    smooth = ndimage.spline_filter(image.astype(np.float64), order=5, mode="mirror")

    def moved(axis: int, by: float) -> Array:
        shift = [by if axis == n else 0.0 for n in range(2)]
        result: Array = ndimage.shift(smooth, shift, order=5, mode="mirror", prefilter=False)
        return result[_EDGE:-_EDGE, _EDGE:-_EDGE]

    changes = [(moved(axis, -_STEP) - moved(axis, _STEP)) / (2.0 * _STEP) for axis in range(2)]
    return math.sqrt(sum(float(np.mean(change**2)) for change in changes))


def measure_clutter(
    frames: Iterable[Any], baseline: str = "matched-filter", radius: float = 3.0, least_snr: float = 1.0, band: int = 0
) -> Clutter:
    """Measure the backgrounds of a data set and what a baseline makes of them.

    Parameters
    ----------
    frames : iterable of LabelledFrame
    baseline : str
        Name in :data:`~hcss_dataset.baselines.BASELINES`.
    radius : float
        Distance from a target within which the largest output is its response, pixels.
    least_snr : float
        Targets with less do not count.

    Raises
    ------
    DatasetError
        If there is too little background.
    """
    rows, backgrounds, scr, response = [], [], list[float](), list[float]()
    for frame in frames:
        labels = frame.labels
        clean = frame.radiance(frame.clean)[band]
        if min(clean.shape) <= 2 * AROUND:
            raise DatasetError(f"images of {clean.shape[0]} x {clean.shape[1]} pixels; allowed: more than {2 * AROUND}")
        rows.append((spectral_slope(clean), clean.std(), gradient_rms(clean), labels["noise"][band]))
        output = BASELINES[baseline](frame.image[band].astype(np.float64))
        backgrounds.append(output[_background(labels["targets"], clean.shape)])
        for target in labels["targets"]:
            if (target["snr"][band] or math.inf if target["peak"][band] else 0.0) >= least_snr:
                scr.append(math.inf if target["scr"][band] is None else target["scr"][band])
                response.append(_highest_near(output, target["centroid"], radius))
    if not rows:
        raise DatasetError("no frames; allowed: at least one")
    tail = Tail.of(np.concatenate(backgrounds))
    slope, deviation, gradient, noise = np.array(rows).T
    found = np.array(response)
    points = _points(tail, backgrounds, found)
    pixels = sum(each.size for each in backgrounds)
    return Clutter(slope, deviation, gradient, noise, np.array(scr), baseline, tail, found, points, pixels)


def _points(tail: Tail, backgrounds: Sequence[NDArray[Any]], response: Array) -> list[dict[str, float]]:
    """Return thresholds and detection rates, with the deviation of each threshold by resampled frames."""
    shares = [share for share in FALSE_ALARMS if share <= tail.share]
    random, drawn = np.random.default_rng(0), []
    # Frames, not pixels, are independent; the values below those of a tail change no fit.
    for _ in range(_RESAMPLED if len(backgrounds) > 1 else 0):
        chosen = random.integers(len(backgrounds), size=len(backgrounds))
        again = Tail.of(np.concatenate([backgrounds[number] for number in chosen]))
        drawn.append([again.threshold(share) if share <= again.share else math.nan for share in shares])
    spread = np.std(drawn, axis=0) if drawn else np.full(len(shares), math.nan)
    return [
        {
            "false_alarms_per_pixel": share,
            "threshold": tail.threshold(share),
            "threshold_deviation": float(deviation),
            "detection_rate": float(np.mean(response >= tail.threshold(share))) if response.size else math.nan,
        }
        for share, deviation in zip(shares, spread, strict=True)
    ]


def _background(targets: Iterable[Mapping[str, Any]], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return which pixels (y, x) are away from all targets."""
    free = np.ones(shape, dtype=np.bool_)
    for target in targets:
        near = tuple(
            slice(max(math.floor(at) - AROUND, 0), max(math.floor(at) + AROUND + 1, 0)) for at in target["place"]
        )
        free[near] = False
    return free


def _highest_near(output: Array, place: Sequence[float], radius: float) -> float:
    """Return the largest value of an image within a distance of a place; 0 if that is outside."""
    y, x = np.ogrid[: output.shape[0], : output.shape[1]]
    near = np.hypot(y + 0.5 - place[0], x + 0.5 - place[1]) <= max(radius, 0.75)
    return float(output[near].max()) if near.any() else 0.0


def _quartiles(values: Array) -> dict[str, float | None]:
    """Return median, quartiles and extremes of the finite values."""
    finite = values[np.isfinite(values)]
    names = ("lowest", "lower_quartile", "median", "upper_quartile", "highest")
    if not finite.size:
        return dict.fromkeys(names)
    return {
        name: float(value) for name, value in zip(names, np.quantile(finite, [0.0, 0.25, 0.5, 0.75, 1.0]), strict=True)
    }


def clutter_text(measured: Clutter, jitter: float) -> str:
    """Return the measures as lines of text."""
    about = measured.as_dict(jitter)

    def line(name: str, key: str) -> str:
        values = about[key]
        if values["median"] is None:
            return f"{name:<36}none"
        shown = "  ".join(f"{values[each]:<9.4g}" for each in values)
        return f"{name:<36}{shown}".rstrip()

    lines = [
        f"{about['frames']} frames".ljust(36) + "lowest     quartile   median     quartile   highest",
        line("slope of the power spectrum", "spectral_slope"),
        line("clutter, W m-2 sr-1", "clutter"),
        line("noise, W m-2 sr-1", "noise"),
        line("gradient, W m-2 sr-1 per pixel", "gradient_per_pixel"),
        line("SCR of targets", "scr"),
        f"clutter by a jitter of {jitter:g} pixel rms: {about['jitter_clutter']:.4g} W m-2 sr-1",
        f"{measured.filtered}: tail of {measured.tail.share * measured.pixels:.0f} of {measured.pixels} pixels without "
        f"targets, shape {measured.tail.shape:.3f}",
        "false alarms a pixel  threshold           detection rate",
    ]
    for point in measured.points:
        beyond = "  beyond the sample" if point["false_alarms_per_pixel"] * measured.pixels < 1.0 else ""
        threshold = f"{point['threshold']:.4g} +- {point['threshold_deviation']:.2g}"
        rate = f"{point['detection_rate']:.3f}" if math.isfinite(point["detection_rate"]) else "no targets"
        lines.append(f"{point['false_alarms_per_pixel']:<20g}  {threshold:<18}  {rate}{beyond}")
    return "\n".join(lines)
