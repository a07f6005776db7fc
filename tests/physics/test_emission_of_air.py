"""The emission of air against an integral over height by another quadrature."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.physics.paths import SPACE, Path
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereDeclaration

NU = np.array([2700.0])
SCALE_M = 2000.0
ALTITUDE = np.array([0.0, 1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 7000.0, 9000.0, 11000.0, 15000.0, 20000.0])
TEMPERATURE = np.interp(ALTITUDE, [0.0, 2000.0, 11000.0, 20000.0], [300.0, 288.0, 225.0, 225.0])
PROFILE = Profile("moist", ALTITUDE, 1e5 * np.exp(-ALTITUDE / 8e3), TEMPERATURE)


class ExponentialGas:
    """Grey gas whose density falls exponentially; ``depth`` is that of the whole atmosphere."""

    declares = AtmosphereDeclaration()

    def __init__(self, depth):
        self.depth = depth

    def transmittance(self, wavenumber_cm1, paths):
        depth = [
            sum(
                self.depth
                * (math.exp(-leg.lower_m / SCALE_M) - math.exp(-min(leg.upper_m, 1e9) / SCALE_M))
                / math.cos(math.radians(leg.zenith_deg))
                for leg in path.legs
            )
            for path in paths
        ]
        return np.exp(-np.array(depth))[:, None]


def emission(depth, zenith, downward, sublayers):
    air = Air(ExponentialGas(depth), PROFILE, NU, sublayers)
    front = air.crossed([[Path()]])
    return air.leg(
        front, np.ones((1, 1)), (zenith,), (300.0,), (SPACE,), downward, 0 if downward else sublayers
    ).emission[0, 0]


def exact(depth, zenith, downward):
    slant = depth / math.cos(math.radians(zenith))
    top = float(ALTITUDE[-1])

    def source(z):
        density = math.exp(-z / SCALE_M)
        between = density if downward else math.exp(-300.0 / SCALE_M) - density
        through = math.exp(-slant * between)
        return planck(NU, float(PROFILE.temperature_at(z)))[0] * through * slant * density / SCALE_M

    return quad(source, 300.0, top, points=ALTITUDE[1:-1], epsabs=0.0, epsrel=1e-9, limit=400)[0]


@pytest.mark.parametrize("depth", [0.05, 1.0])
@pytest.mark.parametrize("zenith", [0.0, 70.0])
@pytest.mark.parametrize("downward", [True, False])
def test_emission_converges_with_the_fourth_power_of_the_layers(depth, zenith, downward):
    known = exact(depth, zenith, downward)
    errors = [abs(emission(depth, zenith, downward, parts) / known - 1.0) for parts in (2, 4, 8)]
    # Mean pressure-weighted temperatures, exact to second order only, leave 5e-6.
    assert errors[0] < 7e-4
    assert errors[1] < max(errors[0] / 10.0, 5e-6)
    assert errors[2] < max(errors[1] / 10.0, 5e-6)
