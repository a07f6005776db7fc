"""What aerosol scatters into the view of the sky, against multiple scattering and integrals by another quadrature."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.paths import SPACE, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.physics.thermal_scattering import backscattered
from hcss_twin.providers import AtmosphereDeclaration, AtmosphereInputs

NU = np.array([2700.0])
ALTITUDE = np.linspace(0.0, 2000.0, 9)
ISOTHERMAL = Profile("isothermal", ALTITUDE, 1e5 * np.exp(-ALTITUDE / 8e3), np.full(9, 288.0))


class Haze:
    """Grey air of the lowest 2 km, flat, that absorbs and scatters."""

    declares = AtmosphereDeclaration()

    def __init__(self, absorbed, scattered, asymmetry):
        self.absorbed, self.scattered, self.asymmetry = absorbed, scattered, asymmetry

    def absorber_amounts(self, paths):
        def share(leg):
            return (min(leg.upper_m, 2e3) - min(leg.lower_m, 2e3)) / 2e3 / math.cos(math.radians(leg.zenith_deg))

        return np.array([[sum(share(leg) for leg in path.legs)] for path in paths])

    def transmittance_of_amounts(self, wavenumber_cm1, amounts):
        return np.repeat(np.exp(-(self.absorbed + self.scattered) * amounts), wavenumber_cm1.size, axis=1)

    def transmittance(self, wavenumber_cm1, paths):
        return self.transmittance_of_amounts(wavenumber_cm1, self.absorber_amounts(paths))

    def scattering_of_amounts(self, wavenumber_cm1, amounts):
        depth = np.repeat(self.scattered * amounts, wavenumber_cm1.size, axis=1)
        return np.stack((depth, self.asymmetry * depth))


def sky(provider, profile, wavenumber, zenith, space_K=0.0):
    """Return the emission of the whole air as seen from the sea."""
    air = Air(provider, profile, wavenumber, space_K=space_K)
    ones = np.ones((1, wavenumber.size))
    return air.leg(air.crossed([[Path()]]), ones, (zenith,), (0.0,), (SPACE,), downward=False).emission[0]


@pytest.mark.parametrize("asymmetry", [0.0, 0.4, 0.7])
@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
def test_the_share_scattered_back_is_that_of_the_phase_function(cosine, asymmetry):
    sine = math.sqrt(1.0 - cosine**2)

    def phase(azimuth, other):
        scattering = -cosine * other + sine * math.sqrt(1.0 - other**2) * math.cos(azimuth)
        return (1.0 - asymmetry**2) / (4.0 * math.pi * (1.0 + asymmetry**2 - 2.0 * asymmetry * scattering) ** 1.5)

    known = dblquad(phase, 0.0, 1.0, 0.0, 2.0 * math.pi, epsabs=1e-7)[0]
    assert float(backscattered(np.array(cosine), np.array(asymmetry))) == pytest.approx(known, abs=0.005)


@pytest.mark.parametrize("zenith", [0.0, 40.0, 60.0])
@pytest.mark.parametrize(("absorbed", "scattered"), [(0.01, 0.03), (0.1, 0.05), (0.02, 0.2)])
def test_sky_over_a_black_sea_is_that_of_multiple_scattering(zenith, absorbed, scattered):
    """By Kirchhoff's law, isothermal haze over a black sea of its temperature shines with 1 - what it transmits."""
    depth = absorbed + scattered
    haze = Haze(absorbed, scattered, 0.65)
    cosine = math.cos(math.radians(zenith))
    known = solve_layers([[depth]], [scattered / depth], [[1.0], [0.65]], [cosine], streams=16)
    onward = 2.0 * np.pi * known.transmission[0, 0, 0] @ (known.mu * known.weight) + known.direct[0, 0, 0]
    found = sky(haze, ISOTHERMAL, NU, zenith)[0] / planck(NU, 288.0)[0]
    # to 4 % of what is emitted, 6 % where 0.2 is scattered
    assert found == pytest.approx(1.0 - onward, rel=0.065)
    # all extinction as emission would be far brighter
    assert 1.0 - math.exp(-depth / cosine) > 1.2 * found


def test_haze_in_an_enclosure_of_its_temperature_cannot_be_seen():
    found = sky(Haze(0.1, 0.2, 0.65), ISOTHERMAL, NU, 50.0, space_K=288.0)
    through = math.exp(-0.3 / math.cos(math.radians(50.0)))
    assert found[0] == pytest.approx((1.0 - through) * planck(NU, 288.0)[0], rel=1e-9)


@pytest.mark.parametrize("aerosol", ["rural", "maritime"])
def test_the_sky_of_the_band_model_contains_what_aerosol_absorbs_and_the_engine_adds_what_it_scatters(aerosol):
    catalog = Catalog()
    profile = load_profile("us-standard-1976", catalog)
    inputs = AtmosphereInputs(profile, catalog)
    hazy, clear = (BandModelTransmittance(inputs, BandModelParameters(aerosol=each)) for each in (aerosol, "none"))
    wavenumber, path = np.arange(2500.0, 2900.0, 25.0), [to_space(0.0, 40.0)]
    assert not hasattr(clear, "scattering_of_amounts")
    depth = hazy.scattering_of_amounts(wavenumber, hazy.absorber_amounts(path))[0][0]
    absorbed = hazy.sky_radiance(wavenumber, path)[0]
    whole = sky(hazy, profile, wavenumber, 40.0)
    all_extinction = absorbed + depth * planck(wavenumber, 288.15)
    assert np.all(absorbed > clear.sky_radiance(wavenumber, path)[0] * np.exp(-2.0 * depth))
    assert np.all(whole > absorbed)
    assert np.all(whole - absorbed < 0.5 * (all_extinction - absorbed))
