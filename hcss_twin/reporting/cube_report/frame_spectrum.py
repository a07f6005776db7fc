"""Power spectrum of frames, averaged over directions, by wavenumbers on the ground."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation import power_spectrum

Array = NDArray[np.float64]


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
    """Return the mean of the spectra of images of one shape (y, x), as :mod:`hcss_twin.evaluation.power_spectrum` has.

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
