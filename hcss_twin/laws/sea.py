"""Laws of sea models that need no reference: closure by direction, the side of the glint, sizes of waves."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, near, range_ends, require
from hcss_twin.providers import Array, SeaInputs, SeaModel
from hcss_twin.providers.common import FRACTION_TOLERANCE

MU_OUT, MU_IN = np.array([1.0, 0.95, 0.9, 0.7, 0.5, 0.8]), np.array([0.9, 0.9, 0.5, 0.75, 0.5, 0.3])
AZIMUTH = np.array([0.0, np.pi, 2.5, 3.0, np.pi, 1.0])
"""Pairs of directions."""

LEAST_REFLECTED = 0.7
"""Integral of the BRDF at least, over 1 - emissivity; facet models lose light that is reflected twice."""


def albedo_and_emissivity_sum_to_one(provider: SeaModel, wavenumber_cm1: Array) -> None:
    """What is not emitted toward a direction is reflected there, within 30 % of it."""
    for view in (1.0, 0.8, 0.6):
        left = 1.0 - provider.emissivity(wavenumber_cm1, np.array([view]))[0]
        reflected = hemispherical_integral(provider, wavenumber_cm1, view)[0]
        at_least(f"albedo at mu = {view}", reflected, LEAST_REFLECTED * left - 1e-6)


def brdf_is_reciprocal(provider: SeaModel, wavenumber_cm1: Array, reciprocity: float = 0.02) -> None:
    """f(out, in) = f(in, out), Helmholtz."""
    one = provider.brdf(wavenumber_cm1, MU_OUT, MU_IN, AZIMUTH)
    other = provider.brdf(wavenumber_cm1, MU_IN, MU_OUT, AZIMUTH)
    near("BRDF with exchanged directions", one, other, rtol=reciprocity, atol=1e-9)


def no_more_is_reflected_than_is_not_emitted(provider: SeaModel, wavenumber_cm1: Array) -> None:
    """The hemispherical integral of the BRDF does not exceed 1 - emissivity (Kirchhoff), within 2 %."""
    for view in (1.0, 0.8, 0.5):
        left = 1.0 - provider.emissivity(wavenumber_cm1, np.array([view]))[0]
        reflected = hemispherical_integral(provider, wavenumber_cm1, view)[0]
        at_most(f"albedo at mu = {view}", reflected, 1.02 * left + 1e-6)


def what_is_not_emitted_is_reflected(provider: Any, wavenumber_cm1: Array) -> None:
    """Nor does it fall short of 1 - emissivity by more than 0.1, where the engine has to integrate it."""
    if hasattr(provider, "reflection_weights"):
        raise Inapplicable("the model provides its own reflection weights")
    for view in (1.0, 0.8, 0.5):
        left = 1.0 - provider.emissivity(wavenumber_cm1, np.array([view]))[0]
        reflected = hemispherical_integral(provider, wavenumber_cm1, view)[0]
        at_least(f"albedo at mu = {view}", reflected, left - 0.1)


def sea_emits_most_upward(provider: SeaModel, wavenumber_cm1: Array) -> None:
    """Emissivity at the zenith is not below that near the horizon, and differs if it depends on the view."""
    zenith, slant, horizon = provider.emissivity(wavenumber_cm1, np.array([1.0, 0.6, 0.25]))
    at_least("emissivity at the zenith", zenith, horizon - 1e-9)
    if "view_zenith" in (provider.declares.depends_on or ()):
        require(np.any(zenith != horizon), "declares view_zenith, which does not matter")
    if np.any(zenith != horizon):
        at_least("emissivity at mu = 0.6", slant, horizon - 1e-9)


def sunlight_is_reflected_to_the_side_of_the_glint(provider: SeaModel, wavenumber_cm1: Array) -> None:
    """At equal zenith angles the BRDF is greatest at relative azimuth pi, if it depends on the azimuth."""
    declared = provider.declares.depends_on
    azimuth = np.linspace(0.0, np.pi, 9)
    mu = np.full(azimuth.size, 0.6)
    brdf = provider.brdf(wavenumber_cm1, mu, mu, azimuth)
    if "relative_azimuth" not in declared if declared is not None else np.all(brdf == brdf[0]):
        raise Inapplicable("the BRDF does not depend on the azimuth")
    least = np.maximum(1.05 * brdf[:-2].max(axis=0), 1e-300)
    at_least("BRDF at relative azimuth 180 deg, with 1.05 times that elsewhere,", brdf[-1], least)


def grazing_light_is_emitted_and_reflected(provider: SeaModel, wavenumber_cm1: Array) -> None:
    """Near the horizon, to a cosine of 0.001, emissivity is in [0, 1], and the BRDF finite and not negative."""
    grazing = np.array([1e-3, 0.01, 0.03, 0.1])
    emissivity = provider.emissivity(wavenumber_cm1, grazing)
    near("emissivity near the horizon", emissivity, 0.5, atol=0.5 + FRACTION_TOLERANCE)
    for mu_out, mu_in in ((grazing, grazing), (grazing, np.full(4, 0.8)), (np.full(4, 0.8), grazing)):
        brdf = provider.brdf(wavenumber_cm1, mu_out, mu_in, np.array([0.0, 1.0, 2.5, np.pi]))
        at_least("BRDF near the horizon", brdf, 0.0)
        require(np.isfinite(brdf), "BRDF near the horizon is not finite")


def weights_see_the_sky_that_the_brdf_sees(provider: Any, wavenumber_cm1: Array) -> None:
    """The mean cosine of reflected light is the same by the weights and by the BRDF, within 0.2."""
    if not hasattr(provider, "reflection_weights"):
        raise Inapplicable("the model has no reflection_weights")
    views, nodes = np.array([1.0, 0.6]), 0.5 * (np.polynomial.legendre.leggauss(8)[0] + 1.0)
    weights = provider.reflection_weights(wavenumber_cm1, views, nodes)
    by_weights = np.einsum("mnv,n->mv", weights, nodes) / weights.sum(axis=1)
    for row, view in enumerate(views.tolist()):
        total, moment = hemispherical_integral(provider, wavenumber_cm1, view)
        near("mean cosine of the weights", by_weights[row], moment / np.maximum(total, 1e-300), atol=0.2)


def waves_are_of_a_sea(provider: Any, inputs: SeaInputs) -> None:
    """Mean square slope and significant wave height are not above three times those of usual seas, if given."""
    wind = inputs.wind_speed_m_s
    slope = getattr(provider, "mean_square_slope", 0.0)
    at_most("mean square slope", slope, 3.0 * (0.003 + 0.00512 * wind))
    height = getattr(provider, "significant_wave_height_m", 0.0)
    at_most("significant wave height in m", height, 3.0 * (0.1 + 0.025 * wind**2))


def declared_range_is_usable_to_its_ends(provider: SeaModel) -> None:
    """The lowest and highest declared wavenumbers give emissivity and BRDF."""
    ends, mu = range_ends(provider.declares), np.array([0.8])
    require(np.isfinite(provider.emissivity(ends, mu)), "emissivity is not finite")
    require(np.isfinite(provider.brdf(ends, mu, mu, np.array([np.pi]))), "BRDF is not finite")


def hemispherical_integral(provider: SeaModel, wavenumber_cm1: Array, view: float) -> tuple[Array, Array]:
    """Return the integrals of BRDF times mu, and times mu squared, over the hemisphere, each (V,)."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    mu, mu_weight = (nodes + 1.0) / 2.0, weights / 2.0
    azimuth = (np.arange(96) + 0.5) * np.pi / 96
    grid_mu, grid_azimuth = (coordinate.ravel() for coordinate in np.meshgrid(mu, azimuth, indexing="ij"))
    share = np.repeat(mu_weight * 2.0 * np.pi / azimuth.size, azimuth.size) * grid_mu
    kernel = provider.brdf(wavenumber_cm1, np.full(grid_mu.size, view), grid_mu, grid_azimuth)
    return share @ kernel, (share * grid_mu) @ kernel


LAWS: tuple[Law, ...] = (
    albedo_and_emissivity_sum_to_one,
    brdf_is_reciprocal,
    no_more_is_reflected_than_is_not_emitted,
    what_is_not_emitted_is_reflected,
    sea_emits_most_upward,
    sunlight_is_reflected_to_the_side_of_the_glint,
    grazing_light_is_emitted_and_reflected,
    weights_see_the_sky_that_the_brdf_sees,
    waves_are_of_a_sea,
    declared_range_is_usable_to_its_ends,
)
