"""Coherence in time: how much of a sequence is still the same after a while, by scale."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, irfft2, rfft2, rfftfreq

from hcss_twin.providers import Array
from hcss_twin.reports.power_spectrum import Rings

WAVELENGTHS = (4.0, 8.0, 16.0, 32.0)
"""Edges of the bands of wavelength, pixels."""


def _waves(frame: Array) -> NDArray[np.complex128]:
    rows, columns = frame.shape
    window = Rings.hann(rows)[:, None] * Rings.hann(columns)
    waves: NDArray[np.complex128] = rfft2((frame - frame.mean()) * window)
    return waves


def motion(first: Array, second: Array) -> tuple[int, int]:
    """Return the motion between two frames (rows, columns) in whole pixels, at most a quarter of the frame."""
    correlation = irfft2(np.conj(_waves(first)) * _waves(second), first.shape)
    near = [np.arange(-(length // 4), length // 4 + 1) for length in first.shape]
    row, column = np.unravel_index(correlation[np.ix_(*near)].argmax(), [len(lags) for lags in near])
    return int(near[0][row]), int(near[1][column])


def _overlap(frame: Array, shift: tuple[int, int]) -> Array:
    """Return the part of a frame that is still in a frame ``shift`` pixels further on."""
    (row, column), (rows, columns) = shift, frame.shape
    return frame[max(0, row) : rows + min(0, row), max(0, column) : columns + min(0, column)]


def correlation_by_band(first: Array, second: Array, wavelengths: Sequence[float] = WAVELENGTHS) -> Array:
    """Return the correlation of two frames (rows, columns): whole field, then bands of wavelength, short first.

    The second frame is moved back by the whole pixels that make the frames most alike, so that wind does not count as
    change, but shear does. Both frames lose their mean and get a Hann window; bands are rings of waves between
    consecutive ``wavelengths`` (pixels).
    """
    row, column = motion(first, second)
    waves = [_waves(_overlap(first, (-row, -column))), _waves(_overlap(second, (row, column)))]
    rows, columns = _overlap(first, (row, column)).shape
    wavenumber = np.hypot(fftfreq(rows)[:, None], rfftfreq(columns)[None, :])
    # Waves that are stored without their opposites count twice.
    count = np.where((rfftfreq(columns) > 0.0) & (rfftfreq(columns) < 0.5), 2.0, 1.0)
    cross = (waves[0] * np.conj(waves[1])).real * count
    power = [np.abs(wave) ** 2 * count for wave in waves]
    bands = [wavenumber > 0.0]
    bands += [(wavenumber * short < 1.0) & (wavenumber * long >= 1.0) for short, long in pairwise(wavelengths)]
    return np.array([cross[band].sum() / np.sqrt(power[0][band].sum() * power[1][band].sum()) for band in bands])


def coherence(
    sequences: Iterable[tuple[Sequence[Array], Sequence[float]]], wavelengths: Sequence[float] = WAVELENGTHS
) -> dict[float, Array]:
    """Return the mean correlation by lag (s): whole field, then each band of wavelength, short ones first.

    Parameters
    ----------
    sequences : iterable of (frames, times)
        Frames (rows, columns) of one scene without missing values, and their times in s.
    wavelengths : sequence of float
        Edges of the bands, pixels, ascending.
    """
    found: dict[float, list[Array]] = {}
    for frames, times in sequences:
        order = np.argsort(times)
        for number, early in enumerate(order):
            for late in order[number + 1 :]:
                lag = round(float(times[late] - times[early]), 3)
                if lag > 0.0 and np.isfinite(frames[early]).all() and np.isfinite(frames[late]).all():
                    found.setdefault(lag, []).append(correlation_by_band(frames[early], frames[late], wavelengths))
    return {lag: np.mean(found[lag], axis=0) for lag in sorted(found)}
