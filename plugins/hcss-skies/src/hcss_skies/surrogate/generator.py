"""Surrogates of a measured cloud image: exact amplitudes, close spectrum, different shapes."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, irfft2, rfft2, rfftfreq

from hcss_skies.surrogate.amplitude_adjusted import AdjustedSpectrum, adjust_amplitudes, match_ranks
from hcss_skies.surrogate.bands import BandAmplitudes
from hcss_skies.surrogate.evolution import NEAREST_FROM, EvolvingNoise
from hcss_skies.surrogate.parameters import SurrogateParameters
from hcss_skies.surrogate.template import (
    Template,
    periodic_component,
    plane_magnitude,
    read_template,
    underlying_magnitude,
)
from hcss_twin.providers import CloudDeclaration, CloudInputs, Grid, Problem, ScenarioError

EVOLVING_ITERATIONS = 4
"""Default number for every frame of evolving clouds.

With more iterations the spectrum is closer, but frames differ more, and sparse clouds jump: near convergence each frame
tends to a different one of many solutions."""

FROZEN_ITERATIONS = 200
"""Default limit for frozen clouds, which are iterated once."""

MAX_PIXELS = 2**28
"""Maximum for the torus (16384 x 16384), whose entire spectrum is held in memory."""


class SurrogateClouds:
    """Surrogates of a measured cloud image, evolving in time.

    The template is the thickness that the ``imagery`` generator extracts from the image (eq 7 of the HCSS paper; 0
    where clear). Each frame is computed on a torus:

    1. White noise in Fourier space, interpolated in time (:class:`EvolvingNoise`), times the magnitudes of the Gaussian
       field that underlies the template (:func:`underlying_magnitude`).
    2. Amplitude-adjusted iterations with the magnitudes of the template's periodic component
       (:func:`adjust_amplitudes`); frozen clouds are iterated once, until the misfit no longer decreases.
       With ``structure`` "bands", one more iteration imposes the amplitudes of the template's bands of scale
       (:class:`BandAmplitudes`) in place of the magnitudes.
    3. Shift by the motion: whole pixels by indices, fractions by phases.
    4. Amplitudes of the template by rank.

    With ``coverage_mode`` "frame", step 4 ranks the pixels of the frame, which has exactly the template's amplitudes
    and coverage; with "field", it ranks those of the torus, so that all windows and sensors agree.

    The scene moves over the torus by (v_platform - v_x) t along x and -v_y t along y; the torus repeats.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed and the catalog that records the file.
    parameters : SurrogateParameters
        The image, its crop, and the iteration.

    Attributes
    ----------
    template : Template
        Thickness of the crop.
    period : (int, int)
        Rows and columns of the torus.
    image_coverage : float or None
        Coverage of the template; None if the scenario sets it (method "coverage").
    skipped : tuple of (str, str)
        Approximations and their effects.

    Raises
    ------
    CatalogError
        If the file is missing or not a usable image.
    ScenarioError
        If image, crop, period and scene do not match, or the layer has tapered edges.
    """

    declares: CloudDeclaration
    honours = ("coverage_mode",)

    def __init__(self, inputs: CloudInputs, parameters: SurrogateParameters) -> None:
        grid, motion, layer = inputs.grid, inputs.motion, inputs.layer
        if layer.edge_taper != 0.0:
            message = f"{layer.edge_taper:g} given; surrogate clouds have the edges of their image; allowed: 0"
            raise ScenarioError([Problem("clouds.edge_taper", message)], origin="surrogate clouds")
        self._grid = grid
        self._whole_plane = layer.coverage_mode == "field"
        self.template = read_template(inputs, parameters)
        self.image_coverage = None if parameters.method == "coverage" else self.template.coverage
        self.period = _period(grid, self.template, parameters)
        wind_x, wind_y = motion.cloud_velocity_m_s
        # Along rows (y) and columns (x).
        self._speed = (-wind_y, motion.platform_speed_m_s - wind_x)
        ranked = self.period if self._whole_plane else (grid.rows, grid.columns)
        coverage = layer.coverage if self.image_coverage is None else self.image_coverage
        self._amplitudes = self.template.amplitudes(ranked[0] * ranked[1], coverage)
        thickness = self.template.thickness_m.astype(np.float64)
        component = periodic_component(thickness)
        magnitude = plane_magnitude(component, self.period)
        self._evolves = math.isfinite(motion.evolution_time_s)
        self._iterations = parameters.iterations
        if self._iterations is None:
            self._iterations = EVOLVING_ITERATIONS if self._evolves else FROZEN_ITERATIONS
        # The crop is all clear or of uniform thickness, and so are all frames.
        self._is_flat = np.ptp(self._amplitudes) == 0.0
        if not self._is_flat and not magnitude.any():
            message = f"{coverage:g} given, but all pixels of the image's crop have the same value; allowed: 0 or 1"
            raise ScenarioError([Problem("clouds.coverage", message)], origin="surrogate clouds")
        self._noise: EvolvingNoise | None = None
        self._bands: BandAmplitudes | None = None
        self._frozen: AdjustedSpectrum | None = None
        skipped: list[tuple[str, str]] = []
        if not self._is_flat:
            self._plane_amplitudes = self.template.amplitudes(self.period[0] * self.period[1], coverage)
            # The misfit compares magnitudes: the variances must agree.
            self._magnitude = (magnitude * float(self._plane_amplitudes.std())).astype(np.float32)
            self._underlying = underlying_magnitude(
                magnitude, self.period, self._plane_amplitudes.astype(np.float64)
            ).astype(np.float32)
            if parameters.structure == "bands":
                self._bands = BandAmplitudes(thickness, self.period)
            self._noise = EvolvingNoise(
                self.period, inputs.seed, _dominant_frequency(magnitude, self.period), motion.evolution_time_s,
                parameters.evolution_exponent, motion.frame_interval_s,
            )  # fmt: skip
            first = self._adjusted(self._noise, 0.0, 0.0 if self._evolves else parameters.tolerance)
            if not self._evolves:
                self._frozen = first
            share = float(component.var() / thickness.var())
            skipped = _approximations(self._noise, first, self._evolves, share, self.period, thickness.shape)
        self.skipped = tuple(skipped)
        changes = not self._is_flat and (self._evolves or any(self._speed))
        self.declares = CloudDeclaration(
            depends_on=frozenset({"time"}) if changes else frozenset(),
            evolves=self._evolves and not self._is_flat,
            tileable=self._whole_plane,
            notes=self._notes(parameters, layer.coverage),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres of a window at ``time_s``; 0 is clear sky.

        The whole torus is computed, whatever the window.

        Raises
        ------
        ValueError
            If the time is not finite or the window is not inside the scene.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        window = self._grid.inside(rows, columns)
        if self._noise is None:
            shape = (self._grid.rows, self._grid.columns)
            return np.full(shape, self._amplitudes[0], dtype=np.float32)[window]
        adjusted = self._frozen or self._adjusted(self._noise, time_s, 0.0)
        coefficients = adjusted.coefficients
        (rows_on_torus, phases_y), (columns_on_torus, phases_x) = (self._along(axis, time_s) for axis in (0, 1))
        if phases_y is not None:
            coefficients = coefficients * phases_y[:, None]
        if phases_x is not None:
            coefficients = coefficients * phases_x[None, :]
        field = irfft2(coefficients, s=self.period)
        y, x = np.ix_(rows_on_torus, columns_on_torus)
        if self._whole_plane:
            return match_ranks(field, self._amplitudes)[y, x][window]
        return match_ranks(field[y, x], self._amplitudes)[window]

    def _adjusted(self, noise: EvolvingNoise, time_s: float, tolerance: float) -> AdjustedSpectrum:
        start = noise.coefficients(time_s) * self._underlying
        adjusted = adjust_amplitudes(
            start, self.period, self._plane_amplitudes, self._magnitude, self._iterations or 0, tolerance
        )
        if self._bands is None:
            return adjusted
        # More iterations cost as much again as all others, and classifiers tell the clouds as well without them.
        field = match_ranks(irfft2(adjusted.coefficients, s=self.period), self._plane_amplitudes)
        return dataclasses.replace(adjusted, coefficients=self._bands.impose(rfft2(field)))

    def _along(self, axis: int, time_s: float) -> tuple[NDArray[np.int64], NDArray[np.complex64] | None]:
        """Return the torus indices of the scene pixels, and the phases of a subpixel shift."""
        size = (self._grid.rows, self._grid.columns)[axis]
        period = self.period[axis]
        shift = self._grid.displacement_pixels(self._speed[axis], time_s)
        whole = math.floor(shift + 0.5)
        indices = (np.arange(size, dtype=np.int64) + whole % period) % period
        if shift == whole:
            return indices, None
        frequency = fftfreq(period) if axis == 0 else rfftfreq(period)
        return indices, np.exp(2j * np.pi * frequency * (shift - whole)).astype(np.complex64)

    def _notes(self, parameters: SurrogateParameters, coverage: float) -> tuple[str, ...]:
        if self.image_coverage is None:
            source = f"Coverage is {coverage:g}, by a threshold on the image"
        else:
            source = (
                f"Coverage is {self.image_coverage:.4g}, that of the image's crop by the method "
                f"'{parameters.method}'; the scenario's coverage, {coverage:g}, is not used"
            )
        where = (
            "on average over the whole cloud field, not in each frame"
            if self._whole_plane
            else "exact in each frame, so that a pixel depends on the rest of its frame"
        )
        size = self._grid.pixel_size_m
        rows, columns = self.period
        return (
            f"{source}; {where}.",
            f"The cloud field repeats after {columns} columns ({columns * size / 1e3:.4g} km) and {rows} rows "
            f"({rows * size / 1e3:.4g} km): a footprint that moves by that much sees the same clouds again, "
            "except for their evolution, and where the scene is as large its opposite edges fit together.",
            *self.template.notes,
        )


def _period(grid: Grid, template: Template, parameters: SurrogateParameters) -> tuple[int, int]:
    """Return the rows and columns of the torus."""
    problems = []
    sizes = []
    for axis, of_scene, of_crop in zip(
        ("rows", "columns"), (grid.rows, grid.columns), template.thickness_m.shape, strict=True
    ):
        least = max(of_scene, of_crop)
        given = getattr(parameters, f"period_{axis}")
        sizes.append(least if given is None else given)
        if given is not None and given < least:
            problems.append(
                Problem(
                    f"clouds.parameters.period_{axis}",
                    f"{given} is less than the {of_scene} {axis} of the scene or the {of_crop} of the crop; "
                    f"allowed: {least} or more, closest is {least}",
                )
            )
    if sizes[0] * sizes[1] > MAX_PIXELS:
        problems.append(
            Problem(
                "image.rows",
                f"a periodic field of {sizes[0]} x {sizes[1]} pixels, computed as a whole; allowed: at most "
                f'{MAX_PIXELS} pixels, closest is {max(1, MAX_PIXELS // sizes[1])} rows; or generator = "fractal"',
            )
        )
    if problems:
        raise ScenarioError(problems, origin="surrogate clouds")
    return sizes[0], sizes[1]


def _dominant_frequency(magnitude: NDArray[np.float64], shape: tuple[int, int]) -> float:
    """Return the power-weighted mean frequency in cycles per pixel."""
    power = magnitude**2
    frequency = np.hypot(fftfreq(shape[0])[:, None], rfftfreq(shape[1])[None, :])
    return float((power * frequency).sum() / power.sum())


def _approximations(
    noise: EvolvingNoise, first: AdjustedSpectrum, evolves: bool, periodic_share: float, period: tuple[int, int],
    crop: tuple[int, ...],
) -> list[tuple[str, str]]:  # fmt: skip
    misfit = f"rms spectral misfit {first.misfit[-1]:.2g}" if first.misfit else "no iteration"
    skipped = [
        (
            "smooth component of the image",
            "jumps across opposite borders of the image are not cloud structure; the periodic component with "
            f"{periodic_share:.0%} of the variance is scaled to all of it",
        )
    ]
    if period != crop:
        effect = f"the spectrum of {crop[0]} x {crop[1]} pixels is interpolated to {period[0]} x {period[1]}"
        skipped.append(("structures larger than the image", effect))
    if not evolves:
        effect = f"shapes are frozen: {len(first.misfit)} iterations once, {misfit}"
        return [*skipped, ("iterations of later frames", effect)]
    effect = f"a fixed number, {len(first.misfit)}, lets frames follow each other smoothly; at the start {misfit}"
    skipped.append(("iterations until nothing improves", effect))
    nearest = [ring.number for ring in noise.rings if ring.nearest]
    if nearest:
        what = f"interpolation in time of octaves {', '.join(map(str, nearest))}"
        effect = f"frames are {NEAREST_FROM:g} or more cells apart, taken as independent: neglects correlations "
        skipped.append((what, f"{effect}of -.11 to .01"))
    return skipped
