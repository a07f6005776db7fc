"""One solution of layers under the sun is what three separate ones are."""

import numpy as np
import pytest

from hcss_twin.physics.multiple_scattering.beams import transmit_beams
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun, solve_sunlit_layers

VIEW, SUN, AZIMUTH = 0.94, 0.6, 2.5


def layers():
    rng = np.random.default_rng(3)
    albedo = np.append(rng.uniform(0.3, 1.0, 11), 1.0)
    moments = rng.uniform(0.6, 0.9, 12) ** np.arange(40)[:, None]
    thickness = 2.0 ** np.arange(-18, 15)[:, None] * rng.uniform(0.5, 2.0, 12)
    return thickness, albedo, moments


def apart(tolerance):
    return (
        solve_layers(*layers(), np.array([VIEW, SUN]), 8),
        solve_sun(*layers(), np.array([VIEW]), SUN, np.array([AZIMUTH]), streams=8, modes=16, mode_tolerance=tolerance),
        transmit_beams(*layers(), np.array([VIEW, SUN]), 8, 8),
    )


def test_with_all_modes_one_solution_is_the_separate_ones():
    diffuse, (brdf, btdf), beams = apart(0.0)
    one = solve_sunlit_layers(*layers(), VIEW, SUN, AZIMUTH, 8, 16, 8, mode_tolerance=0.0)
    for name in ("reflection", "transmission", "direct", "emissivity", "far_share"):
        np.testing.assert_allclose(getattr(one.layers, name), getattr(diffuse, name), rtol=1e-9, atol=1e-13)
    np.testing.assert_allclose(one.brdf, brdf[..., 0], rtol=1e-9)
    np.testing.assert_allclose(one.btdf, btdf[..., 0], rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(one.beams, beams, rtol=1e-9, atol=1e-13)


def test_modes_that_are_left_out_are_negligible():
    _, (brdf, btdf), beams = apart(0.0)
    one = solve_sunlit_layers(*layers(), VIEW, SUN, AZIMUTH, 8, 16, 8, mode_tolerance=1e-5)
    np.testing.assert_allclose(one.brdf, brdf[..., 0], rtol=1e-4)
    np.testing.assert_allclose(one.btdf, btdf[..., 0], rtol=1e-4, atol=1e-7)
    assert np.max(np.abs(one.beams - beams)) < 1e-4 * np.max(beams)


@pytest.mark.parametrize("beam_modes", [0, 17])
def test_beams_cannot_have_more_modes_than_the_sun(beam_modes):
    with pytest.raises(ValueError, match="beam_modes"):
        solve_sunlit_layers(*layers(), VIEW, SUN, AZIMUTH, 8, 16, beam_modes)
