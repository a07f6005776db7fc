"""From images to a state, and from a state and the next image to the next one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import numpy as np
from hcss_skies.missing import filled
from hcss_skies.split_window import height_above_opaque_m
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from hcss_follow.bands import smooth
from hcss_follow.motion import flow_between, moved
from hcss_follow.state import MAX_SIDE, MIN_SIDE, Field, State
from hcss_twin.providers import ImageError

LAPSE_K_M = 6.5e-3
"""Lapse rate with which heights are told from brightness temperatures."""

KELVIN_RANGE = 150.0, 340.0

MAX_MISSING = 0.05
"""Largest share of missing pixels, which are interpolated."""

LEAST_AGREEMENT = 0.6
"""Images that agree less show other skies."""

LONGEST_S = 3600.0
"""Longest time between images: beyond, clouds are others."""

_SMOOTH = 16.0
"""Standard deviation in pixels of what counts as smooth in the agreement."""

_CLEAR_WINDOW, _CLEAR_SMOOTH, _CLEAR_K = 24, 24.0, 2.0
"""Of the map of clear sky: half a window and the smoothing in pixels, and how far it is below the warmest pixels."""

_UNTOLD_M, _TOLD_M = 1000.0, 3000.0
"""Excess of cloud tops that the noise of two channels gives to opaque low cloud, too; and what it cannot give.

Without that, low cloud counts as thin and is 0.3 K too cold at 12.0 um.
"""


@dataclass(frozen=True)
class Image:
    """One image, rows northward and columns eastward.

    Attributes
    ----------
    kelvin : ndarray (rows, columns)
        Brightness temperature near 10.8 um; NaN where missing.
    time : datetime
        With its time zone.
    second_K : ndarray (rows, columns), optional
        Near 12.0 um.
    """

    kelvin: NDArray[np.floating]
    time: datetime
    second_K: NDArray[np.floating] | None = None


def analyse(
    images: Sequence[Image], *, pixel_size_m: float, latitude: float, longitude: float, source: str = "",
    rights: str = "",
) -> State:  # fmt: skip
    """Return the state after images in the order of their times.

    Raises
    ------
    ImageError
        If there is none, or one does not fit: see :func:`advance`.
    """
    if not images:
        raise ImageError("images: none given; allowed: one or more")
    first = images[0]
    kelvin = _known(first.kelvin, None)
    still = np.zeros_like(kelvin)
    excess, clear = _heights(kelvin, first)
    state = State(
        kelvin, still, np.stack([still, still]), excess, clear, first.time.astimezone(UTC), float("nan"), float("nan"),
        float(pixel_size_m), float(latitude), float(longitude), 1, first.second_K is not None, source, rights,
    )  # fmt: skip
    for image in images[1:]:
        state = advance(state, image)
    return state


def advance(state: State, image: Image) -> State:
    """Return the state after the next image of the same place; the same bits each time.

    Raises
    ------
    ImageError
        If its size or its values are wrong, or it is no later than the state.
    """
    time = image.time.astimezone(UTC)
    if not time > state.time:
        raise ImageError(f"time: {time.isoformat()}; allowed: later than the state's {state.time.isoformat()}")
    kelvin = _known(image.kelvin, state.shape)
    interval_s = (time - state.time) / timedelta(seconds=1)
    displacement = flow_between(state.kelvin, kelvin)
    velocity = (displacement / np.float32(interval_s)).astype(np.float32)
    along = moved(state.kelvin, velocity, interval_s)
    excess, clear = _heights(kelvin, image)
    return replace(
        state, kelvin=kelvin, tendency_K=kelvin - along, flow_m_s=velocity * np.float32(state.pixel_size_m),
        excess_m=excess, clear_K=clear, time=time, interval_s=interval_s, agreement=_agreement(kelvin, along),
        number=state.number + 1, two_channels=image.second_K is not None,
    )  # fmt: skip


def doubts(state: State) -> tuple[str, ...]:
    """Return why the latest images may not show one sky; mostly empty."""
    if state.number < 2:
        return ("One image: motion and change are not known; the sky stands still.",)
    notes = []
    if not state.agreement >= LEAST_AGREEMENT:
        notes.append(
            f"The last two images do not show one sky: moved along, they agree to {state.agreement:.2f}; "
            f"expected: {LEAST_AGREEMENT:g} or more. The forecast is not to be trusted."
        )
    if state.interval_s > LONGEST_S:
        notes.append(
            f"The last two images are {state.interval_s / 60.0:.0f} min apart; expected: {LONGEST_S / 60.0:.0f} min or "
            "less, in which clouds are recognised. The forecast is not to be trusted."
        )
    return tuple(notes)


def _known(given: NDArray[np.floating], shape: tuple[int, int] | None) -> Field:
    """Return an image without missing pixels."""
    if given.ndim != 2 or not all(MIN_SIDE <= side <= MAX_SIDE for side in given.shape):
        raise ImageError(f"image: {given.shape} pixels; allowed: two sides of {MIN_SIDE} to {MAX_SIDE}")
    if shape is not None and given.shape != shape:
        raise ImageError(f"image: {given.shape} pixels; allowed: those of the state, {shape}")
    missing = ~np.isfinite(given)
    share = float(missing.mean())
    if share > MAX_MISSING:
        raise ImageError(f"image: {share:.1%} of the pixels are missing; allowed: {MAX_MISSING:.0%}")
    known = given[~missing]
    low, high = KELVIN_RANGE
    if known.min() < low or known.max() > high:
        raise ImageError(
            f"image: values of {known.min():g} to {known.max():g}; allowed: brightness temperatures, "
            f"{low:g} to {high:g} K"
        )
    whole = filled(given.astype(np.float64)) if share else given
    return np.ascontiguousarray(whole, dtype=np.float32)


def _heights(kelvin: Field, image: Image) -> tuple[Field, Field]:
    """Return the excess of cloud tops, and the map of the clear sky."""
    clear = clear_map(kelvin)
    if image.second_K is None:
        return np.zeros_like(kelvin), clear
    second = _known(image.second_K, (kelvin.shape[0], kelvin.shape[1]))
    excess = height_above_opaque_m(
        kelvin.astype(np.float64), second.astype(np.float64), float(np.percentile(kelvin, 99.0)), LAPSE_K_M
    )
    share = np.clip((excess - _UNTOLD_M) / (_TOLD_M - _UNTOLD_M), 0.0, 1.0)
    return (excess * share * share * (3.0 - 2.0 * share)).astype(np.float32), clear


def clear_map(kelvin: Field) -> Field:
    """Return the brightness temperature of the clear sky: the warmest pixels nearby, smooth.

    Where cloud hides the sea over a whole window, the warmest pixels of the image limit how cold it may be.
    """
    warmest = np.float32(np.percentile(kelvin, 99.0))
    envelope = maximum_filter(smooth(kelvin, 1.0), 2 * _CLEAR_WINDOW + 1, mode="nearest")
    return smooth(np.maximum(envelope, warmest - np.float32(_CLEAR_K)), _CLEAR_SMOOTH)


def _agreement(kelvin: Field, along: Field) -> float:
    """Return the correlation of two images without what is smooth."""
    one, two = (image - smooth(image, _SMOOTH) for image in (kelvin, along))
    scale = float(np.sqrt(np.mean(one * one) * np.mean(two * two)))
    return float(np.mean(one * two)) / scale if scale > 0.0 else 1.0
