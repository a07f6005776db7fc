"""The columns of :mod:`glint_scenes` in the product: their matter, and the radiance of the physical model."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from glint_references import ABOVE, COEFFICIENTS, Matter, mean_square_slope, sea_brdf_at
from glint_scenes import GlintScene

from hcss_twin.core.catalog import Catalog
from hcss_twin.laws.samples import sample_layer, sample_profile, sample_radiance_inputs
from hcss_twin.models.optics.mie import MieOptics
from hcss_twin.models.parameters import MieParameters, PhysicalParameters
from hcss_twin.models.radiance.physical.model import Physical
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import (
    AtmosphereDeclaration,
    CloudLayer,
    Microphysics,
    OpticsInputs,
    SeaDeclaration,
    Sun,
    View,
    cloudy_columns,
)

FINE = 200
"""Cosines, and azimuths, of the integrals over the sea's BRDF."""


class NoGas:
    """Air that neither absorbs nor emits."""

    declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1, paths):
        return np.ones((len(paths), wavenumber_cm1.size))


BASE_M, ABOVE_M = 200.0, 5000.0
"""Base of the cloud, and a height above all clouds."""


class LineGas:
    """A gas below the cloud and above ``ABOVE_M``, whose transmittance is a mean over absorption coefficients."""

    declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1, paths):
        crossed = [sum(self._crossed(leg) for leg in path.legs) for path in paths]
        mean = np.exp(-np.multiply.outer(crossed, COEFFICIENTS)).mean(axis=1)
        return np.repeat(mean[:, None], wavenumber_cm1.size, axis=1)

    def _crossed(self, leg):
        below = max(min(leg.upper_m, BASE_M) - leg.lower_m, 0.0) / BASE_M
        above = max(min(leg.upper_m - ABOVE_M, 1.0) - max(leg.lower_m - ABOVE_M, 0.0), 0.0)
        return (below + ABOVE * above) / math.cos(math.radians(leg.zenith_deg))


def layer_of(scene: GlintScene) -> CloudLayer:
    mode = scene.mode_radius_um
    droplets = Microphysics("water", 6.0, 6.0 / mode, 1.0, 1e8, (mode / 50.0, mode * 10.0), None)
    return replace(sample_layer(), microphysics=droplets, base_m=BASE_M, top_m=BASE_M + 1000.0, thickness_min_m=1.0)


def wavenumbers(scene: GlintScene) -> np.ndarray:
    return np.array([1e4 / scene.wavelength_um])


def matter_of(scene: GlintScene) -> Matter:
    """Moments and albedo of the droplets and the index of the sea, which the references take as given."""
    own = MieOptics(OpticsInputs(Catalog()), MieParameters()).single_scattering(
        layer_of(scene).microphysics, wavenumbers(scene)
    )
    index = load_refractive_index(Catalog(), "water").at(wavenumbers(scene))
    return Matter(float(own.albedo[0]), np.asarray(own.moments[:, 0]), complex(index[0]))


class OnceReflectingSea:
    """The sea of the references as a provider: what its BRDF does not reflect, it emits."""

    declares = SeaDeclaration(depends_on=frozenset())

    def __init__(self, scene: GlintScene) -> None:
        self._index = matter_of(scene).index
        self._slope = mean_square_slope(scene.wind_m_s)

    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        return sea_brdf_at(self._index, self._slope, mu_out, mu_in, relative_azimuth)[:, None]

    def emissivity(self, wavenumber_cm1, mu):
        return 1.0 - self.reflection_weights(wavenumber_cm1, mu, np.array([0.5]))[:, 0]

    def reflection_weights(self, wavenumber_cm1, mu, mu_nodes):
        """Integrate the BRDF times the polynomials that are 1 at one node and 0 at the others."""
        node, weight = np.polynomial.legendre.leggauss(FINE)
        into, azimuth = 0.5 * (node + 1.0), (np.arange(FINE) + 0.5) * np.pi / FINE
        mean = sea_brdf_at(self._index, self._slope, mu[:, None, None], into[:, None], azimuth).mean(axis=-1)
        shape = np.stack(
            [
                np.prod((into[:, None] - o) / (m - o), axis=1)
                for m, o in ((m, mu_nodes[mu_nodes != m]) for m in mu_nodes)
            ]
        )
        return ((np.pi * mean * weight * into) @ shape.T)[..., None]


def product(scene: GlintScene, level: int, sunlight_steps: int = 0, gas=None) -> tuple[float, float]:
    """Return sunlight over the irradiance on a horizontal plane, sr-1, and the share of sunlight in the radiance."""
    profile: Profile = sample_profile()
    layer = layer_of(scene)
    optics = MieOptics(OpticsInputs(Catalog()), MieParameters())
    extinction = optics.single_scattering(layer.microphysics, wavenumbers(scene)).extinction_m1[0]
    sample = sample_radiance_inputs(profile, (layer,))
    setting = replace(
        sample.setting,
        transmittance=gas or NoGas(),
        sea=OnceReflectingSea(scene),
        sea_temperature_K=288.0,
        view=View(math.degrees(math.acos(scene.mu_view)), 30.0),
    )
    inputs = replace(sample, setting=setting, optics=optics, numerical_level=level, sunlight_steps=sunlight_steps)
    model = Physical(inputs, PhysicalParameters(space_temperature=0.0))
    sun = Sun(math.degrees(math.acos(scene.mu_sun)), 30.0 + scene.azimuth_deg, 1.0)
    nu = wavenumbers(scene)
    thickness = np.array([[scene.optical_thickness / extinction]])
    terms = cloudy_columns(model, setting.under(sun), nu, thickness)
    solar = float(terms["cloud_reflected_sun"][0, 0] + terms["sea_reflected_sun"][0, 0])
    total = float(sum(each[0, 0] for each in terms.values()))
    received = scene.mu_sun * float(inputs.solar_irradiance(nu)[0])
    return solar / received, solar / total
