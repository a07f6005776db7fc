"""Multiplication of an image by a transfer function, with edges mirrored."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

Array = NDArray[np.float64]

Transfer = Callable[[Array, Array], Array]
"""Maps frequencies along y (Y, 1) and x (1, X), in cycles per pixel, to a real factor; 1 at frequency 0."""


def apply_transfer(image: Array, transfer: Transfer) -> Array:
    """Return an image whose frequencies are multiplied by a transfer function.

    The scene beyond the image is unknown and taken to be its mirror image, edge pixels twice (... c b a | a b c ...).
    For a function that is real and even the cosine transform, a Fourier transform of the image with its mirror images,
    does that exactly and without a padded copy; the mean of the image stays what it is.

    Parameters
    ----------
    image : ndarray (Y, X)
    transfer : callable
        Its values count at the frequencies an image has, up to half a cycle per pixel.
    """
    rows, columns = image.shape
    along_y = np.arange(rows, dtype=np.float64)[:, None] / (2 * rows)
    along_x = np.arange(columns, dtype=np.float64)[None, :] / (2 * columns)
    spectrum = dctn(image, type=2, norm="ortho")
    spectrum *= transfer(along_y, along_x)
    result: Array = idctn(spectrum, type=2, norm="ortho", overwrite_x=True)
    return result
