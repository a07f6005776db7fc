"""Fig 17: cirrus in 2.7-3.0 um with blur and noise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from hcss_evaluate.measures.degradation import Degradation, estimate_degradation
from scipy.ndimage import gaussian_filter

from hcss_paper.figure_base import PHYSICAL_NOTE, RADIANCE, SHORT_WAVE, blank, radiance_inputs, scenario_of, shades
from hcss_paper.inputs import in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.scene import Model
from hcss_twin import sense, simulate
from hcss_twin.providers import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


CUT = slice(330, 430), slice(360, 460)
"""Rows and columns of the enlarged part."""

SCENARIO = "degraded-cirrus"

SIGMA_PIXELS = 1.5
NOISE: dict[Model, float] = {"as-printed": 5e-5, "physical": 7e-4}
"""W m-2 sr-1: about a quarter of the clean image's standard deviation, so that both are visible."""
BORDER_PIXELS = 10
"""Margin excluded from the comparison with another code's blur, because values outside the image are unknown."""


def cubes(model: Model, seed: int) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the clean cube of the shipped scenario and the measured cube of its sensor."""
    blurred = {"psf": "gaussian", "psf_sigma": SIGMA_PIXELS, "noise": "ner", "ner": NOISE[model]}
    scenario = scenario_of(SCENARIO, model, {"bands": [SHORT_WAVE], "seed": seed, "sensor.parameters": blurred})
    clean = simulate(scenario)
    return clean, sense(clean, scenario)


def frame(cube: xr.Dataset) -> Array:
    """Return radiance (rows, columns) of the first frame and band."""
    values: Array = cube.radiance.isel(time=0, band=0).to_numpy().astype(np.float64)
    return values


def figure_17(seed: int) -> Reproduction:
    """Return the degraded image, with blur and noise checked separately, and both found again in the image."""
    clean, measured = cubes("as-printed", seed)
    sharp, seen = frame(clean), frame(measured)
    physical = cubes("physical", seed)
    corrected = [frame(cube) for cube in physical]
    noise = NOISE["as-printed"]
    # The spectrum of the scene is that of other cirrus, because the clean image of a real one is not known.
    estimates = [estimate_degradation(seen, frame(cubes("as-printed", seed + 1)[0]))]
    estimates += [estimate_degradation(corrected[1], frame(cubes("physical", seed + 1)[0]))]
    assumed_law = estimate_degradation(seen).blur_sigma_pixels
    cover = float((clean.cloud_mask[0] > 0).mean())
    rows = [
        Row("shortest wavelength", "um", 2.7, float(clean.wavelength_bounds[0].min())),
        Row("longest wavelength", "um", 3.0, float(clean.wavelength_bounds[0].max())),
        Row("coverage", "%", 100.0, 100.0 * cover),
        Row("clean, mean", RADIANCE, None, float(sharp.mean()), float(corrected[0].mean())),
        Row("clean, standard deviation", RADIANCE, None, float(sharp.std()), float(corrected[0].std())),
        Row("degraded, mean", RADIANCE, None, float(seen.mean()), float(corrected[1].mean())),
        Row("degraded, standard deviation", RADIANCE, None, float(seen.std()), float(corrected[1].std())),
        Row("blur found in the image", "pixels", None, *(estimate.blur_sigma_pixels for estimate in estimates)),
        Row("noise found in the image", RADIANCE, None, *(estimate.noise for estimate in estimates)),
    ]
    return judged(
        rows,
        [
            Check(
                f"band 2.7-3.0 um, coverage {cover:.2%}", cover == 1.0 and not any(row.difference for row in rows[:2])
            ),
            *checks_of(sharp, seen, SIGMA_PIXELS, noise),
            *checks_of_estimates(estimates[0], SIGMA_PIXELS, noise),
        ],
        holds="Band, cloud type and coverage are the printed ones, and the image is degraded by a blur kernel and "
        "noise of the requested size.",
        fails="Band or coverage differ, or blur and noise do not have the requested size.",
        chosen=(
            *in_words(
                f"blur kernel: Gaussian of {SIGMA_PIXELS:g} pixels; the paper's on-orbit kernel is not published",
                f"noise: white, {1e3 * noise:g} mW m-2 sr-1 (physical: {1e3 * NOISE['physical']:g}); not published",
            ),
            *radiance_inputs(SHORT_WAVE),
        ),
        notes=(
            PHYSICAL_NOTE,
            "Blur and noise are found in the image with the spectrum of clean cirrus of another seed. With a power law "
            f"as spectrum the blur is {assumed_law:.2f} pixels, too much, because that of the clouds has steps.",
        ),
        drawings=(
            Drawing(
                "Cirrus in 2.7-3.0 um, as-printed",
                drawn(clean, measured, noise),
                "Top: sharp streaks of cirrus and a 2 km section of them; bottom: the same with blur and noise.",
            ),
            Drawing(
                "The same scene with the corrected physics: cirrus reflects sunlight",
                drawn(*physical, NOISE["physical"]),
                "The same four panels.",
            ),
        ),
    )


def checks_of(sharp: Array, seen: Array, sigma: float, noise: float) -> list[Check]:
    """Check that ``seen`` is ``sharp`` with a Gaussian blur (``sigma`` pixels) and white noise (``noise``)."""
    inner = (slice(BORDER_PIXELS, -BORDER_PIXELS),) * 2
    left = (seen - gaussian_filter(sharp, sigma, truncate=6.0))[inner]
    unlike = (seen - sharp)[inner]
    deviation = float(left.std())
    beside = float(np.corrcoef(left[:, 1:].ravel(), left[:, :-1].ravel())[0, 1])
    count = left.size
    offset = float(left.mean())
    return [
        Check(
            f"after subtraction of an independent Gaussian blur the noise is {1e3 * deviation:.4f} mW m-2 sr-1, "
            f"requested {1e3 * noise:g}: within 1 %",
            abs(deviation / noise - 1.0) < 0.01,
        ),
        Check(
            f"its mean is {offset / noise:.1e} of its standard deviation, within 5 standard errors of 0",
            abs(offset) < 5.0 * noise / count**0.5,
        ),
        Check(
            f"the noise of neighbouring pixels is independent: correlation {beside:.1e}, within 5 standard errors of 0",
            abs(beside) < 5.0 / count**0.5,
        ),
        Check(
            f"without subtraction of the blur the residual is larger: {1e3 * float(unlike.std()):.4f} mW m-2 sr-1",
            float(unlike.std()) > deviation,
        ),
    ]


def checks_of_estimates(found: Degradation, sigma: float, noise: float) -> list[Check]:
    """Check that the blur and the noise of an image were found again in it."""
    return [
        Check(
            f"the image alone gives a blur of {found.blur_sigma_pixels:.2f} pixels, requested {sigma:g}: within 10 %",
            abs(found.blur_sigma_pixels / sigma - 1.0) < 0.1,
        ),
        Check(
            f"and a noise of {1e3 * found.noise:.4f} mW m-2 sr-1, requested {1e3 * noise:g}: within 1 %",
            abs(found.noise / noise - 1.0) < 0.01,
        ),
    ]


def drawn(clean: xr.Dataset, measured: xr.Dataset, noise: float) -> Figure:
    """Draw the whole image and a part of it, clean (top) and measured (bottom); ``noise`` is in W m-2 sr-1."""
    figure = blank(8.6, 7.4)
    axes = figure.subplots(2, 2)
    frames = [1e3 * frame(cube) for cube in (clean, measured)]
    low, high = np.percentile(frames[0], (0.5, 99.5))
    margin = 0.1 * (high - low)
    x, y = (clean[name].to_numpy() / 1e3 for name in ("x", "y"))
    names = ("clean", "blurred and noisy")
    figure.suptitle(
        f"blur: Gaussian, {SIGMA_PIXELS:g} pixels; noise: {1e3 * noise:g} mW m$^{{-2}}$ sr$^{{-1}}$", fontsize=10
    )
    image: Any = None
    for (whole, part), values, name in zip(axes, frames, names, strict=True):
        for axis, (rows, columns) in ((whole, (slice(None), slice(None))), (part, CUT)):
            image = axis.imshow(
                values[rows, columns],
                origin="lower",
                extent=(x[columns][0], x[columns][-1], y[rows][0], y[rows][-1]),
                cmap=shades(),
                vmin=low - margin,
                vmax=high + margin,
                interpolation="nearest",
            )
            axis.set_xlabel("x (km, east)")
            axis.set_ylabel("y (km, north)")
        whole.set_title(name, fontsize=10)
        part.set_title("2 km section", fontsize=10)
    bar = figure.colorbar(image, ax=axes.ravel().tolist(), shrink=0.7, extend="both")
    bar.set_label("radiance, 2.7-3.0 um (mW m$^{-2}$ sr$^{-1}$)")
    return figure
