"""Examples with known fields, and generators of them."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import sample_cloud_inputs
from hcss_author.own_cache import own_cache  # noqa: F401
from hcss_skies.example import make_example, write_example
from hcss_skies.generator import ExampleClouds
from hcss_skies.parameters import ExampleParameters

from hcss_twin.providers import Catalog, Grid, Motion

FROZEN = Motion(0.0, (0.0, 0.0), np.inf, 1.0)
EVOLVING = Motion(0.0, (0.0, 0.0), 1800.0, 1.0)


def cloud_field(side, seed=3):
    """Heights (side, side) in m with a power spectrum k^-3 and a skewed distribution, 0 to 3000 m."""
    rng = np.random.default_rng(seed)
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(side), np.fft.rfftfreq(side), indexing="ij"))
    spectrum = np.fft.rfft2(rng.standard_normal((side, side))) * np.maximum(k, 8 / side) ** -1.5
    spectrum[0, 0] = 0.0
    field = np.fft.irfft2(spectrum, (side, side))
    return 3000.0 * (np.argsort(np.argsort(field.ravel())) / field.size).reshape(side, side) ** 2


def rough_field(side, density=2.9, seed=5):
    """A normal field (side, side) with the power spectral density k^-density in two dimensions, as measured."""
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(side), np.fft.rfftfreq(side), indexing="ij"))
    white = np.fft.rfft2(np.random.default_rng(seed).standard_normal((side, side)))
    field = np.fft.irfft2(white * np.maximum(k, 2.0 / side) ** (-0.5 * density), (side, side))
    return (field - field.mean()) / field.std()


def power_law(shape, beta=3.0, seed=0, *, stretch=1.0, cutoff=0.0):
    """Periodic normal field whose power falls as k^-beta; stretched structures along x, no waves longer than a cutoff.

    The cutoff is in cycles along the longer side.
    """
    frequency = np.hypot(np.fft.fftfreq(shape[0])[:, None], stretch * np.fft.rfftfreq(shape[1])[None, :])
    frequency[0, 0] = np.inf
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=shape))
    field = np.fft.irfft2(white * frequency ** (-beta / 2) * (frequency > cutoff / max(shape)), s=shape)
    return field / field.std()


def octave_power(field):
    """Power in octaves of the wavenumber, in units of the variance: 1-2, 2-4, ... cycles."""
    ky, kx = (np.fft.fftfreq(size) * size for size in field.shape)
    wavenumber = np.hypot(ky[:, None], kx[None, :])
    power = np.abs(np.fft.fft2(field - field.mean())) ** 2
    edges = 2.0 ** np.arange(int(np.log2(min(field.shape))))
    return np.array([power[(wavenumber >= low) & (wavenumber < 2 * low)].sum() for low in edges]) / power.sum()


@pytest.fixture
def make(tmp_path):
    """Return a function that makes generators: of an image, a scene, an example with so many pixels, parameters."""

    def of(
        pixel_m=3000.0,
        size=64,
        *,
        seed=1,
        motion=FROZEN,
        inversion=None,
        side=256,
        least=1e-3,
        layer=None,
        **parameters,
    ):
        folder = tmp_path / "skies"
        folder.mkdir(exist_ok=True)
        if not (folder / f"own{side}.nc").exists():
            field = cloud_field(side)
            example = make_example(
                field, 0.5 * field[::-1], pixel_size_m=3000.0, clear_m=300.0, kind="test", source="test", licence="none"
            )
            write_example(folder / f"own{side}.nc", example)
        inputs = sample_cloud_inputs(seed=seed, catalog=Catalog(base=tmp_path))
        of_layer = replace(inputs.layer, thickness_min_m=least, **(layer or {}))
        inputs = replace(inputs, grid=Grid(size, size, pixel_m), motion=motion, layer=of_layer, inversion=inversion)
        return ExampleClouds(inputs, ExampleParameters(**{"example": f"own{side}", **parameters}))

    return of


def whole(provider, size, time_s=0.0):
    """Return a frame in double precision."""
    return provider.thickness_m(time_s, slice(0, size), slice(0, size)).astype(float)
