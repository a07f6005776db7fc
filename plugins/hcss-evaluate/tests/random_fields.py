"""Gaussian random fields with a power-law spectrum."""

import numpy as np
from scipy.fft import fftfreq, irfft2, rfftfreq


def power_law(rng, slope, size=256, spread_k=3.0, mean_k=285.0):
    """Return a periodic field (size, size) in K whose spectral density goes as wavenumber^slope."""
    wavenumber = np.hypot(fftfreq(size)[:, None], rfftfreq(size)[None, :])
    wavenumber[0, 0] = np.inf
    amplitude = wavenumber ** (slope / 2.0)
    waves = amplitude * (rng.standard_normal(amplitude.shape) + 1j * rng.standard_normal(amplitude.shape))
    field = irfft2(waves, (size, size))
    return mean_k + spread_k * (field - field.mean()) / field.std()
