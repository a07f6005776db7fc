"""Sunlight that thick ice reflects near the glory does not depend on the number of streams, however many."""

import numpy as np

from hcss_twin import Scenario, make_plan
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun


def test_many_streams_agree_with_fewer_over_thick_ice() -> None:
    """Their twice-scattered light needs as many more moments: 48 and 64 streams were 4 and 13 % from 24."""
    layer = make_plan(Scenario.load("cirrus", {"output.certificate": 0})).assembly
    particles = layer.optics.single_scattering(layer.layers[0].microphysics, np.array([3510.0]))
    view, sun = np.cos(np.radians([6.1, 10.8]))
    few, many = (
        solve_sun([[2.0], [7.0]], particles.albedo, particles.moments, [view], sun, [np.pi - 0.05], streams, moments,
                  kept_moments=moments)[0]
        for streams, moments in ((24, 36), (64, 96))
    )  # fmt: skip
    np.testing.assert_allclose(few, many, rtol=8e-3)
