"""Amplitudes of an image in bands of scale, imposed on a field: where change is rare in the image, it is rare in both.

D. Heeger and J. Bergen, "Pyramid-based texture analysis/synthesis", Proc. SIGGRAPH 95, 229-238 (1995), with bands of
one octave, not reduced in resolution, in all directions together.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, irfft2, rfft2, rfftfreq

from hcss_skies.surrogate.amplitude_adjusted import match_ranks


class BandAmplitudes:
    """Amplitudes of an image in octaves of the wavenumber, for a plane of any size.

    The filters of the bands and of what is larger have squares that sum to 1: filtered twice, they add up to the field.

    Parameters
    ----------
    image : ndarray (rows, columns)
        16 x 16 pixels or more. It is continued by its mirror images, which have no jumps; the bands have no direction.
    shape : (int, int)
        Rows and columns of the plane.

    Attributes
    ----------
    count : int
        Number of bands, from the finest to half of the image's shorter side.
    """

    def __init__(self, image: NDArray[Any], shape: tuple[int, int]) -> None:
        rows, columns = image.shape
        self.count = int(np.log2(min(rows, columns))) - 2
        self._shape = shape
        self._larger, self._filters = _octaves(shape, self.count)
        mirrored = np.pad(image.astype(np.float64), ((0, rows), (0, columns)), mode="symmetric")
        transform = rfft2(mirrored)
        number = shape[0] * shape[1]
        quantile = (2 * np.arange(number, dtype=np.int64) + 1) * image.size // (2 * number)
        self._ascending = []
        for filtered in _octaves(mirrored.shape, self.count)[1]:
            band = irfft2(transform * filtered, s=mirrored.shape)[:rows, :columns]
            self._ascending.append(np.sort(band, axis=None)[quantile].astype(np.float32))

    def impose(self, coefficients: NDArray[np.complex64]) -> NDArray[np.complex64]:
        """Return the transform of a field with these amplitudes by rank in each band, from that of any field.

        Bands overlap, so that those of the result have the amplitudes only nearly.

        Parameters
        ----------
        coefficients : ndarray (rows, columns // 2 + 1)
            ``rfft2`` of the field.
        """
        result = coefficients * self._larger**2
        for filtered, ascending in zip(self._filters, self._ascending, strict=True):
            band = irfft2(coefficients * filtered, s=self._shape)
            result += rfft2(match_ranks(band, ascending)) * filtered
        return np.asarray(result, dtype=np.complex64)


def _octaves(shape: tuple[int, ...], count: int) -> tuple[NDArray[np.float32], list[NDArray[np.float32]]]:
    """Return the filter of all that is larger than the bands, and those of the bands, finest first.

    Edges are a quarter of a cosine over one octave around .25, .125, ... cycles per pixel.
    """
    frequency = np.hypot(fftfreq(shape[0])[:, None], rfftfreq(shape[1])[None, :])
    with np.errstate(divide="ignore"):
        octave = np.log2(frequency) + 1.5
    squares = [np.cos(0.5 * np.pi * np.clip(octave + n, 0.0, 1.0)) ** 2 for n in range(1, count + 1)]
    bands = [np.sqrt(np.maximum(wide - narrow, 0.0)) for wide, narrow in pairwise([np.ones_like(octave), *squares])]
    return np.sqrt(squares[-1]).astype(np.float32), [band.astype(np.float32) for band in bands]
