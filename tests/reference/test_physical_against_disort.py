"""Columns of air, cloud and sea against discrete ordinates with 32 streams, where air is grey and plane-parallel."""

import dataclasses
import math

import numpy as np
import pytest
from PythonicDISORT.pydisort import pydisort

from hcss_twin.laws.samples import PlainOptics, PlainSea, sample_layer, sample_radiance_inputs
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.model import Physical
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereDeclaration, Sun, View, cloudy_columns

STREAMS = 32
HALF = STREAMS // 2
NU = np.array([2500.0])
SEA_K, EMISSIVITY, ALBEDO, G = 300.0, 0.9, 0.7, 0.8
ALTITUDE = np.array([0.0, 500.0, 1000.0, 1500.0, 2000.0, 4000.0, 8000.0, 16000.0, 30000.0])
TEMPERATURE = np.array([298.0, 295.0, 291.0, 288.0, 285.0, 270.0, 245.0, 215.0, 230.0])
DEPTH = np.array([0.1, 0.05, 0.0, 0.0, 0.1, 0.08, 0.05, 0.02])
"""Optical thickness of the gas in each layer; none between 1000 and 2000 m, where the cloud is."""


class PlaneGas:
    """Grey gas in plane-parallel layers; transmittances multiply."""

    declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1, paths):
        depth = [
            sum(
                np.sum(DEPTH * np.clip((leg.upper_m - ALTITUDE[:-1]) / np.diff(ALTITUDE), 0, 1))
                / math.cos(math.radians(leg.zenith_deg))
                - np.sum(DEPTH * np.clip((leg.lower_m - ALTITUDE[:-1]) / np.diff(ALTITUDE), 0, 1))
                / math.cos(math.radians(leg.zenith_deg))
                for leg in path.legs
            )
            for path in paths
        ]
        return np.exp(-np.array(depth))[:, None].repeat(wavenumber_cm1.size, axis=1)


PROFILE = Profile("grey", ALTITUDE, 1e5 * np.exp(-ALTITUDE / 8e3), TEMPERATURE)
LAYER = dataclasses.replace(sample_layer(), base_m=1000.0, top_m=2000.0, thickness_min_m=10.0, temperature_K=280.0)


class GlintingSea(PlainSea):
    """A sea that prefers the bearing away from the sun, with three azimuth modes: the Lambertian one, and two more."""

    LOBES = (1.5, 1.0)

    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        sines = np.sqrt((1.0 - mu_out**2) * (1.0 - mu_in**2))
        lobes = sum(
            lobe * sines**mode * np.cos(mode * (np.pi - relative_azimuth))
            for mode, lobe in enumerate(self.LOBES, start=1)
        )
        return super().brdf(wavenumber_cm1, mu_out, mu_in, relative_azimuth) * (1.0 + lobes)[:, None]


def lobe_modes(reflectance):
    """The same for the reference, which divides by pi."""

    def mode_of(mode, lobe):
        return lambda mu, mu_in: reflectance * lobe * np.sqrt(np.outer(1.0 - mu**2, 1.0 - mu_in**2)) ** mode

    return [mode_of(mode, lobe) for mode, lobe in enumerate(GlintingSea.LOBES, start=1)]


HIGH_LAYER = dataclasses.replace(LAYER, name="high", base_m=1600.0, top_m=2000.0)
LOW_LAYER = dataclasses.replace(LAYER, name="low", top_m=1500.0)


def ours(view_mu, thickness_m, sun, albedo, sea=None, layers=(LAYER,), **parameters):
    thickness = np.atleast_2d(thickness_m)
    inputs = sample_radiance_inputs(PROFILE, layers)
    setting = dataclasses.replace(
        inputs.setting,
        transmittance=PlaneGas(),
        sea=sea or PlainSea(EMISSIVITY),
        sea_temperature_K=SEA_K,
        view=View(math.degrees(math.acos(view_mu)), 30.0),
    )
    inputs = dataclasses.replace(inputs, setting=setting, optics=PlainOptics(1e-10, albedo, G))
    model = Physical(inputs, PhysicalParameters(**{"space_temperature": 0.0, "streams": 8, **parameters}))
    return {name: term[0] for name, term in cloudy_columns(model, setting.under(sun), NU, thickness).items()}


PARTS = 8
"""Parts of each layer of the reference, in which the Planck radiance is linear in optical thickness."""


def heights(levels):
    return np.interp(np.arange(PARTS * (levels.size - 1) + 1) / PARTS, np.arange(levels.size), levels)


def parts(depth):
    return np.repeat(depth, PARTS) / PARTS


def discrete_ordinates(thickness_m, sun, albedo, emissivity=EMISSIVITY, lobes=()):
    """Upward radiance at the top: a function of relative azimuth giving (16,) at the reference's cosines."""
    above, below = heights(ALTITUDE[:3:-1]), heights(ALTITUDE[2::-1])
    extinction = LAYER.microphysics.number_density_m3 * 1e-10
    tau = np.concatenate((parts(DEPTH[:3:-1]), [max(extinction * thickness_m, 1e-9)], parts(DEPTH[1::-1])))
    cloud = above.size - 1
    w, chi = np.zeros(tau.size), np.zeros((tau.size, 600))
    chi[:, 0] = 1.0
    w[cloud], chi[cloud] = (albedo if thickness_m else 0.0), G ** np.arange(600)
    of_cloud = planck(NU, 280.0) if thickness_m else np.zeros(1)
    black = [np.array([planck(NU, t)[0] for t in np.interp(z, ALTITUDE, TEMPERATURE)]) for z in (above, below)]
    upper, lower = (np.concatenate((black[0][ends], of_cloud, black[1][ends])) for ends in (np.s_[:-1], np.s_[1:]))
    slope = (lower - upper) / tau
    sources = np.stack((upper - slope * (np.cumsum(tau) - tau), slope), axis=1)
    f = np.zeros(tau.size)
    f[cloud] = G**STREAMS
    mu_sun, beam = (0.5, 0.0) if sun is None else (math.cos(math.radians(sun.zenith_deg)), 0.01)
    result = pydisort(
        np.cumsum(tau),
        w,
        STREAMS,
        chi,
        mu_sun,
        beam,
        0.0,
        NLeg=STREAMS,
        f_arr=f,
        NT_cor=sun is not None,
        NFourier=STREAMS if sun is not None else 1,
        b_pos=emissivity * planck(NU, SEA_K)[0],
        BDRF_Fourier_modes=[1.0 - emissivity, *lobes],  # it divides by pi
        s_poly_coeffs=sources,
    )
    mu, field = result[0][:HALF], result[-1]
    if sun is None:
        return mu, lambda azimuth: result[3](0.0)[:HALF]
    return mu, lambda azimuth: field(0.0, math.pi - azimuth)[:HALF]


@pytest.mark.parametrize("thickness", [0.0, 10.0, 60.0, 200.0, 1000.0])
def test_thermal_radiance_of_a_column(thickness):
    mu, exact = discrete_ordinates(thickness, None, ALBEDO)
    for index in np.flatnonzero(mu > 0.2)[::4]:
        found = sum(ours(mu[index], thickness, None, ALBEDO).values())[0]
        assert found == pytest.approx(exact(0.0)[index], rel=1e-3)


@pytest.mark.parametrize("thickness", [0.0, 10.0, 60.0, 200.0, 1000.0])
@pytest.mark.parametrize("albedo", [0.7, 0.98])
def test_sunlit_radiance_of_a_column(thickness, albedo):
    sun = Sun(40.0, 30.0 + 70.0, 1.0)
    azimuth = math.radians(70.0)
    mu, exact = discrete_ordinates(thickness, sun, albedo)
    _, dark = discrete_ordinates(thickness, None, albedo)
    for index in np.flatnonzero(mu > 0.2)[::4]:
        terms = ours(mu[index], thickness, sun, albedo)
        solar = terms["cloud_reflected_sun"][0] + terms["sea_reflected_sun"][0]
        expected = exact(azimuth)[index] - dark(0.0)[index]
        # Light exchanged between cloud and sea is a mean over azimuth.
        assert solar == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("thickness", "turn_deg"),
    [
        (60.0, 0.0),
        (10.0, 180.0),
        (60.0, 180.0),
        (30.0, 90.0),
        (200.0, 0.0),
        *(pytest.param(*each, marks=pytest.mark.campaign) for each in ((30.0, 0.0), (30.0, 180.0), (200.0, 90.0))),
    ],
)
def test_sunlight_between_cloud_and_a_glinting_sea_keeps_its_bearing(thickness, turn_deg):
    sun, emissivity = Sun(40.0, 30.0 + turn_deg, 1.0), 0.5
    lobes = lobe_modes(1.0 - emissivity)
    mu, exact = discrete_ordinates(thickness, sun, 0.98, emissivity, lobes)
    _, dark = discrete_ordinates(thickness, None, 0.98, emissivity)
    for index in np.flatnonzero(mu > 0.4)[::3]:
        terms = ours(mu[index], thickness, sun, 0.98, GlintingSea(emissivity))
        solar = terms["cloud_reflected_sun"][0] + terms["sea_reflected_sun"][0]
        expected = exact(math.radians(turn_deg))[index] - dark(0.0)[index]
        assert solar == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("high", "low", "turn_deg"),
    [
        (30.0, 10.0, 180.0),
        (60.0, 60.0, 180.0),
        (60.0, 60.0, 0.0),
        (20.0, 400.0, 90.0),
        *(pytest.param(*each, marks=pytest.mark.campaign) for each in ((150.0, 60.0, 180.0), (20.0, 400.0, 180.0))),
    ],
)
def test_sunlight_between_two_clouds_and_a_glinting_sea_keeps_its_bearing(high, low, turn_deg):
    # Without gas between them, two clouds of the same particles are one; with two, the lower one also reflects.
    sun, emissivity = Sun(40.0, 30.0 + turn_deg, 1.0), 0.5
    lobes = lobe_modes(1.0 - emissivity)
    mu, exact = discrete_ordinates(high + low, sun, 0.98, emissivity, lobes)
    _, dark = discrete_ordinates(high + low, None, 0.98, emissivity)
    for index in np.flatnonzero(mu > 0.4)[::3]:
        layers = LOW_LAYER, HIGH_LAYER
        terms = ours(mu[index], (low, high), sun, 0.98, GlintingSea(emissivity), layers)
        solar = terms["cloud_reflected_sun"][0] + terms["sea_reflected_sun"][0]
        expected = exact(math.radians(turn_deg))[index] - dark(0.0)[index]

        assert solar == pytest.approx(expected, rel=0.02)
