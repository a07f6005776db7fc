"""Laws of a sensor that measures part of an image: blur reaches so far and no farther, random numbers go by place."""

import numpy as np
import pytest
from scipy import special

from hcss_twin.models.sensor.blur import smear_mtf
from hcss_twin.models.sensor.point_spread import airy_mtf, gaussian_mtf, line_kernel, plane_kernel

ROWS, COLUMNS = 110, 130
TRANSFERS = {
    "gaussian": lambda f: gaussian_mtf(f, 1.3),
    "sharp": lambda f: gaussian_mtf(f, 0.4),
    "wide": lambda f: gaussian_mtf(f, 40.0),
    "smear": lambda f: smear_mtf(f, 3.7),
    "none": lambda f: smear_mtf(f, 0.0),
}


@pytest.mark.parametrize("name", sorted(TRANSFERS))
def test_a_kernel_that_is_cut_has_the_transfer_it_was_made_for(name):
    kernel, cut = line_kernel(TRANSFERS[name])
    assert kernel.sum() == pytest.approx(1.0, abs=1e-12)
    assert 0.0 <= cut <= 2e-3
    assert kernel.size == 1 if name == "none" else kernel.size % 2 == 1
    frequency = np.linspace(0.0, 0.5, 41)
    place = np.arange(kernel.size) - kernel.size // 2
    found = np.cos(2.0 * np.pi * frequency[:, None] * place) @ kernel
    np.testing.assert_allclose(found, TRANSFERS[name](frequency), atol=2.0 * cut + 1e-12)


def test_the_kernel_of_a_round_aperture_is_its_diffraction_pattern():
    # (2 J1(v) / v)^2 with v = pi r f_c, for optics that pass nothing beyond half a cycle per pixel
    cutoff = 0.4
    kernel, cut = plane_kernel(lambda y, x: airy_mtf(np.hypot(y, x), cutoff))
    assert cut <= 2e-3
    middle = kernel.shape[0] // 2
    radius = np.hypot(*np.indices((25, 25)))
    v = np.pi * radius * cutoff
    pattern = np.ones_like(v)
    pattern[v > 0] = (2.0 * special.j1(v[v > 0]) / v[v > 0]) ** 2
    pattern *= np.pi * cutoff**2 / 4.0  # its sum over the plane is 1
    found = kernel[middle : middle + 25, middle : middle + 25]
    np.testing.assert_allclose(found, pattern, atol=2.5e-3 * pattern.max())
