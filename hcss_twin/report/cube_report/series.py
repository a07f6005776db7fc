"""Power spectrum of frames, averaged over directions, by wavenumbers on the ground.

What is kept of a quantity in one band: pictures, numbers of each shown frame, histogram, spectrum.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.analysis.measures import power_spectrum
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageError
from hcss_twin.report.cube_report.content import Quantity, Reader
from hcss_twin.report.cube_report.scale import Scale


@dataclass(frozen=True)
class Spectrum:
    """Power against wavenumber.

    Attributes
    ----------
    cycles_per_km : ndarray (K,)
        Mean wavenumber of each ring, four rings per octave.
    power : ndarray (K,)
        Mean power density in the ring, units of the image squared times km squared: its integral over the plane of
        wavenumbers is the variance.
    """

    cycles_per_km: Array
    power: Array


def frame_spectrum(images: Iterable[NDArray[Any]], pixel_size_m: float) -> Spectrum | None:
    """Return the mean of the spectra of images of one shape (y, x), as
    :mod:`hcss_twin.analysis.measures.power_spectrum` has.

    Images that have none do not count: below 32 x 32 pixels, with values that do not exist, or planes.

    Returns
    -------
    Spectrum or None
        None where no image has one.
    """
    found = []
    for image in images:
        try:
            found.append(power_spectrum.power_spectrum(image))
        except ImageError:
            continue
    mean = power_spectrum.mean_spectrum(found)
    if mean is None:
        return None
    pixel_km = pixel_size_m / 1e3
    return Spectrum(mean.wavenumber / pixel_km, mean.power * pixel_km**2)


HISTOGRAM_BINS = 120


@dataclass(frozen=True)
class FrameNumbers:
    """Of the pixels of one frame that were read; NaN where none has a value.

    Attributes
    ----------
    mean, lowest, highest : float
    """

    mean: float
    lowest: float
    highest: float

    @classmethod
    def of(cls, plane: NDArray[Any]) -> FrameNumbers:
        """Return those of a plane."""
        known = plane[np.isfinite(plane)] if plane.dtype.kind == "f" else plane.ravel()
        if not known.size:
            return cls(np.nan, np.nan, np.nan)
        return cls(float(known.mean(dtype=np.float64)), float(known.min()), float(known.max()))


@dataclass(frozen=True)
class Series:
    """A quantity in one band or layer.

    Attributes
    ----------
    quantity : Quantity
    part : str
        Name of the band or layer, or empty.
    frames : tuple of int
        Numbers in the cube of the frames shown.
    scale : Scale
    pictures : tuple of bytes
        A PNG for each of them.
    numbers : tuple of FrameNumbers
    histogram : (counts, edges) or None
        Of all values that were read, of radiation.
    spectrum : Spectrum or None
        Mean over the frames, of radiation.
    """

    quantity: Quantity
    part: str
    frames: tuple[int, ...]
    scale: Scale
    pictures: tuple[bytes, ...]
    numbers: tuple[FrameNumbers, ...]
    histogram: tuple[NDArray[Any], NDArray[Any]] | None
    spectrum: Spectrum | None


def read_series(
    reader: Reader, quantity: Quantity, part: int, frames: Sequence[int], binning: int, curves: bool
) -> Series:
    """Read some frames of one part of a quantity.

    Parameters
    ----------
    reader : Reader
    quantity : Quantity
    part : int
    frames : sequence of int
    binning : int
        Pictures show means over so many pixels squared; of flags every so many.
    curves : bool
        Whether histogram and spectrum are wanted.
    """
    planes = np.stack([reader.plane(quantity, part, frame) for frame in frames])
    shown = [binned(plane, binning, bool(quantity.flags)) for plane in planes]
    scale = Scale.of(quantity, np.stack(shown))
    spectrum = None
    if curves:
        size = float(reader.dataset["x"][1] - reader.dataset["x"][0]) if planes.shape[2] > 1 else np.nan
        spectrum = frame_spectrum((reader.window(quantity, part, frame) for frame in frames), size)
    return Series(
        quantity,
        quantity.parts[part],
        tuple(frames),
        scale,
        tuple(scale.png(plane) for plane in shown),
        tuple(FrameNumbers.of(plane) for plane in planes),
        _histogram(planes) if curves else None,
        spectrum,
    )


def binned(plane: NDArray[Any], binning: int, flags: bool) -> NDArray[Any]:
    """Return means over squares of pixels, those at the upper edges over what there is; of flags every n-th.

    Values that do not exist do not count; a square without any has none.
    """
    if binning == 1:
        return plane
    if flags:
        return plane[::binning, ::binning]
    starts = [np.arange(0, size, binning) for size in plane.shape]

    def sums(values: NDArray[Any]) -> NDArray[Any]:
        partial = np.add.reduceat(values.astype(np.float64), starts[0], axis=0)
        total: NDArray[Any] = np.add.reduceat(partial, starts[1], axis=1)
        return total

    known = np.isfinite(plane)
    count = sums(known)
    with np.errstate(invalid="ignore"):
        return np.asarray(sums(np.where(known, plane, 0.0)) / np.where(count > 0, count, np.nan))


def _histogram(planes: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]] | None:
    known = planes[np.isfinite(planes)].astype(np.float64)
    if not known.size or not known.max() > known.min():
        return None
    counts, edges = np.histogram(known, HISTOGRAM_BINS)
    return counts, edges
