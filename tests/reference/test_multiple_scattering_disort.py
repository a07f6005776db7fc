"""Random layers against the discrete ordinates of PythonicDISORT with 64 streams, 32 per hemisphere."""

from dataclasses import dataclass
from functools import lru_cache

import miepython
import numpy as np
import pytest
from PythonicDISORT.pydisort import pydisort
from PythonicDISORT.subroutines import interpolate

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import bulk_moments
from hcss_twin.models.optics.mie import BulkOptics, MieOptics
from hcss_twin.models.parameters import BulkParameters, MieParameters
from hcss_twin.models.radiance.physical.numerics import LEVELS
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.providers import OpticsInputs
from hcss_twin.scenario.cloud_types import load_cloud_type

STREAMS = 64
HALF = STREAMS // 2
AZIMUTH = np.linspace(0.0, np.pi, 7)
"""Relative azimuths of sensor and sun."""
SOME = 12
"""Zenith angles that are compared, or up to twice as many; neighbours among the ordinates are alike."""


@dataclass(frozen=True)
class Reference:
    """Emissivity (32,), brdf and btdf (32, 7) of a layer at the reference's own directions."""

    mu: np.ndarray
    emissivity: np.ndarray
    brdf: np.ndarray
    btdf: np.ndarray


def reference(tau: float, albedo: float, moments: np.ndarray, mu_sun: float, streams: int = STREAMS) -> Reference:
    """Solve one layer; ``moments`` are all that matter."""
    thick, w, chi = np.array([tau]), np.array([albedo]), moments[np.newaxis]
    scaling = {"NLeg": streams, "f_arr": max(moments[streams], 0.0)}
    # Its isotropic source is multiplied by 1 - albedo inside.
    source = np.array([[1.0]])
    mu, _, _, mean = pydisort(thick, w, streams, chi, mu_sun, 0.0, 0.0, NFourier=1, s_poly_coeffs=source, **scaling)[:4]
    # At its own directions, where nothing is interpolated, with the same exact single scattering.
    sunlit = pydisort(thick, w, streams, chi, mu_sun, 1.0, 0.0, NFourier=streams, NT_cor=True, **scaling)[4]
    radiance = sunlit(np.array([0.0, tau]), np.pi - AZIMUTH) / mu_sun
    half = streams // 2
    return Reference(mu[:half], mean(0.0)[:half], radiance[:half, 0], radiance[half:, 1])


@dataclass(frozen=True)
class Errors:
    """Largest errors of one layer; brdf over its largest value, btdf over the largest of both."""

    emissivity: float
    brdf: float
    btdf: float


def errors(tau, albedo, given, mu_sun, exact: Reference, streams: int, least_mu: float) -> Errors:
    """Compare some directions with cosines from ``least_mu``; ``given`` are the moments given to the solver."""
    every = np.flatnonzero(exact.mu >= least_mu)
    seen = every[:: max(every.size // SOME, 1)]  # the most slanted one among them
    mu = exact.mu[seen]
    layer = solve_layers([[tau]], [albedo], given, mu, streams)
    emissivity = np.abs(layer.emissivity[0, 0, : mu.size] - exact.emissivity[seen]).max()
    views, azimuth = np.repeat(mu, AZIMUTH.size), np.tile(AZIMUTH, mu.size)
    brdf, btdf = solve_sun([[tau]], [albedo], given, views, mu_sun, azimuth, streams, 2 * streams)
    back = np.abs(brdf[0, 0].reshape(mu.size, -1) - exact.brdf[seen]).max()
    through = np.abs(btdf[0, 0].reshape(mu.size, -1) - exact.btdf[seen]).max()
    largest = exact.brdf[every].max()
    return Errors(emissivity, back / largest, through / max(largest, exact.btdf[every].max()))


def random_layers(count: int):
    """Thickness, albedo, asymmetry and sun of clouds in the infrared."""
    rng = np.random.default_rng(64)
    for _ in range(count):
        yield 10 ** rng.uniform(-2, 2), rng.uniform(0.3, 1.0), rng.uniform(0.7, 0.95), rng.uniform(0.1, 1.0)


def check(count: int) -> None:
    """All layers, also those with sharp peaks, thin layers and grazing views.

    What the streams cannot resolve is the share of the phase function beyond their moments. The layers that missed 2 %
    of the largest brdf are those in which it is large: g^16 = 0.27 and 0.41, for instance. It bounds the error of all.
    """
    for tau, albedo, g, mu_sun in random_layers(count):
        exact = reference(tau, albedo, g ** np.arange(600), mu_sun)
        # 8 streams up to a view zenith of 75 degrees, 16 and 24 up to 87.
        for streams, least_mu, emissivity in ((8, 0.259, 0.001), (16, 0.05, 0.003), (24, 0.05, 0.001)):
            found = errors(tau, albedo, np.array([[1.0], [g]]), mu_sun, exact, streams, least_mu)
            assert found.emissivity < emissivity
            assert found.btdf < 0.02
            assert found.brdf < 0.5 * g ** (2 * streams) + 0.001


def test_as_many_streams_give_the_same_radiances() -> None:
    for tau, albedo, g, mu_sun in random_layers(3):
        exact = reference(tau, albedo, g ** np.arange(600), mu_sun)
        given = np.array([[1.0], [g]])
        mu = exact.mu[12:]
        layer = solve_layers([[tau]], [albedo], given, mu, HALF)
        np.testing.assert_allclose(layer.emissivity[0, 0, : mu.size], exact.emissivity[12:], atol=1e-9)
        views, azimuth = np.repeat(mu, 7), np.tile(AZIMUTH, mu.size)
        brdf, btdf = solve_sun(
            [[tau]], [albedo], given, views, mu_sun, azimuth, HALF, STREAMS, None, 0.0, exact_orders=1
        )
        largest = exact.brdf.max()
        np.testing.assert_allclose(brdf[0, 0].reshape(-1, 7), exact.brdf[12:], atol=1e-8 * largest)
        # The forward peak beyond 64 moments, of which the reference corrects the second order only.
        np.testing.assert_allclose(btdf[0, 0].reshape(-1, 7), exact.btdf[12:], atol=1e-4 * exact.btdf.max())


@pytest.mark.long
def test_random_layers_agree_with_discrete_ordinates() -> None:
    check(5)


@pytest.mark.campaign
def test_many_random_layers_agree_with_discrete_ordinates() -> None:
    check(500)


@lru_cache
def droplets(wavelength_um: float, index: complex) -> tuple[float, np.ndarray]:
    """Albedo and Legendre moments of water droplets of 10 um effective radius and variance 0.1."""
    radius, step = np.linspace(1.0, 35.0, 50, retstep=True)
    number = radius ** (1 / 0.1 - 3) * np.exp(-radius / (10.0 * 0.1))
    cosine, weight = np.polynomial.legendre.leggauss(300)
    scattered = extinct = 0.0
    phase = np.zeros_like(cosine)
    for r, n in zip(radius, number * step, strict=True):
        x = 2 * np.pi * r / wavelength_um
        q_ext, q_sca, _, _ = miepython.efficiencies_mx(index, x)
        extinct += n * np.pi * r**2 * q_ext
        scattered += n * np.pi * r**2 * q_sca
        phase += n * np.pi * r**2 * q_sca * miepython.i_unpolarized(index, x, cosine, norm="4pi")
    phase *= 2.0 / (phase @ weight)
    moments = np.array([0.5 * weight @ (phase * p) for p in legendre_polynomials(cosine, 200)])
    return float(scattered / extinct), moments / moments[0]


def legendre_polynomials(x: np.ndarray, count: int) -> list[np.ndarray]:
    found = [np.ones_like(x), x]
    for degree in range(1, count - 1):
        found.append(((2 * degree + 1) * x * found[degree] - degree * found[degree - 1]) / (degree + 1))
    return found


@pytest.mark.parametrize(("wavelength_um", "index"), [(10.8, 1.166 - 0.082j), (3.7, 1.374 - 0.0036j)])
@pytest.mark.parametrize("tau", [0.3, 3.0, 30.0])
def test_droplets_agree_with_discrete_ordinates(wavelength_um, index, tau) -> None:
    albedo, moments = droplets(wavelength_um, index)
    exact = reference(tau, albedo, moments, 0.6)
    found = errors(tau, albedo, moments[:, np.newaxis], 0.6, exact, 8, 0.259)
    assert found.btdf < 0.01
    assert found.emissivity < 5e-4
    assert found.brdf < 0.012


@lru_cache
def scattering(kind: str, wavelength_um: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Albedo of particles of the catalog, the moments (K, 1) that the provider gives, and all moments (L,)."""
    provider, name = kind.split(" ")
    kept = load_cloud_type(name, Catalog())
    cloud, wavenumber = kept.microphysics.particles(kept.layer.material), np.array([1e4 / wavelength_um])
    make, parameters = {"mie": (MieOptics, MieParameters()), "bulk": (BulkOptics, BulkParameters())}[provider]
    found = make(OpticsInputs(Catalog()), parameters).single_scattering(cloud, wavenumber)
    given = found.moments[:, 0]
    if given.size == 2:
        every = given[1] ** np.arange(1500)
    elif provider == "bulk" or cloud.material == "water":  # 128 moments of droplets and 512 of crystals are all
        every = np.concatenate((given, np.zeros(100)))
    else:
        every = bulk_moments(cloud, load_refractive_index(Catalog(), "ice"), np.array([wavelength_um]), 250, 900)[:, 0]
    return float(found.albedo[0]), found.moments, every


warned = pytest.mark.filterwarnings("ignore:Some delta-scaled", "ignore:.NFourier. is large")
"""The reference warns of sharp peaks and of many modes."""

KINDS = ("bulk stratus", "bulk cumulus", "bulk cirrus", "mie cirrus")
"""Stratocumulus has the particles of stratus, ``simulated`` those of cumulus."""


def check_catalog(kind: str, wavelength_um: float, tau: float, mu_sun: float, streams=(8, 16), albedo=None) -> None:
    """All directions and azimuths of a layer of the catalog's particles, thermal and sunlit.

    ``peak`` is the share of the phase function beyond the moments of the streams: at 2.8 um more than half of it with 8
    streams. Reflection is bounded by three times this share (Mie theory has a glory, Henyey and Greenstein have none).
    In the transmission of a sharp peak the reference errs itself: it corrects the second order of the aureole only, and
    its difference from ours falls from 0.49 to 0.01 if its streams are doubled. The 128 moments that ``mie`` gives for
    ice spheres lack part of the peak, ``cut``, and so does the aureole: with 600 moments the same layers agree within
    0.0005 instead of 0.6.
    """
    own, given, every = scattering(kind, wavelength_um)
    own = own if albedo is None else albedo
    most = STREAMS if every[STREAMS] < 0.05 else 2 * STREAMS
    cut = every[given.shape[0]] if given.shape[0] > 2 else 0.0  # two moments stand for all
    exact = reference(tau, own, every, mu_sun, most)
    for count in streams:
        usual = count == 8  # 8 streams up to a view zenith of 75 degrees, more up to 87
        found = errors(tau, own, given, mu_sun, exact, count, 0.259 if usual else 0.05)
        peak = max(every[2 * count], 0.0)
        assert found.emissivity < (0.001 if usual else 0.005)
        assert found.brdf < 3.0 * peak + 0.001
        assert found.btdf < 0.04 + 0.5 * every[most] + 10.0 * cut


@warned
def test_droplets_that_do_not_absorb_agree_with_discrete_ordinates() -> None:
    check_catalog("bulk stratus", 3.7, 10.0, 0.6, albedo=1.0 - 1e-6)


WAVELENGTHS, THICKNESSES, SUNS = (2.8, 3.7, 11.0), (0.03, 0.3, 3.0, 30.0), (0.2, 0.6, 0.95)


def catalog_cases():
    """In CI each kind and each thickness once, each wavelength and each sun; in the campaign all."""
    for n, i, j, k in np.ndindex(4, 3, 4, 3):
        usual = j == (n + 2) % 4 and i == n % 3 and k == (2 - 2 * n) % 3
        mark = pytest.mark.long if usual else pytest.mark.campaign
        yield pytest.param(KINDS[n], WAVELENGTHS[i], THICKNESSES[j], SUNS[k], marks=mark)


@warned
@pytest.mark.parametrize(("kind", "wavelength_um", "tau", "mu_sun"), list(catalog_cases()))
def test_layers_of_particles_of_the_catalog_agree_with_discrete_ordinates(kind, wavelength_um, tau, mu_sun) -> None:
    check_catalog(kind, wavelength_um, tau, mu_sun, (8, 16, 24))


@lru_cache
def droplets_of_stratus(wavelength_um: float) -> tuple[float, np.ndarray, np.ndarray, Reference]:
    """Albedo, moments that are given, all of them, and a layer of them; 128 ordinates resolve all their moments."""
    albedo, given, every = scattering("mie stratus", wavelength_um)
    return albedo, given, every, reference(5.0, albedo, every, 0.91, 128)


@pytest.mark.long
@warned
def test_where_the_peak_is_not_resolved_n_streams_with_n_moments_are_nearer_the_truth_than_with_2_n() -> None:
    """Droplets of stratus. Where 64 moments suffice, 64 streams are exact."""
    found = {}
    for wavelength_um in (2.87, 3.7):
        albedo, given, _, exact = droplets_of_stratus(wavelength_um)
        seen = exact.mu >= 0.3
        mu = exact.mu[seen]
        views, azimuth = np.repeat(mu, AZIMUTH.size), np.tile(AZIMUTH, mu.size)
        for streams, kept in ((8, 16), (8, 8), (16, 32), (16, 16), (64, 64)):
            where = views, 0.91, azimuth, streams, kept
            brdf, _ = solve_sun([[5.0]], [albedo], given, *where, kept_moments=kept, exact_orders=1)
            away = np.abs(brdf[0, 0].reshape(mu.size, -1) - exact.brdf[seen])
            found[wavelength_um, streams, kept] = float(np.median(away / exact.brdf[seen]))
    for streams in (8, 16):  # 0.015 and 0.012, against 0.046 and 0.037
        assert found[2.87, streams, streams] < 0.5 * found[2.87, streams, 2 * streams]
    assert found[3.7, 64, 64] < 1e-6


@pytest.mark.long
@warned
@pytest.mark.parametrize(
    ("wavelength_um", "median", "largest"), [(2.87, (3e-3, 2e-3, 1.5e-3), 0.03), (3.7, (1.5e-3, 4e-4, 1e-4), 0.01)]
)
def test_light_scattered_twice_in_closed_form_makes_few_streams_as_good_as_many(wavelength_um, median, largest) -> None:
    """Droplets of stratus in all directions, glory and cloudbow among them."""
    albedo, _, every, exact = droplets_of_stratus(wavelength_um)
    seen = exact.mu >= 0.3
    views, azimuth = np.repeat(exact.mu[seen], AZIMUTH.size), np.tile(AZIMUTH, np.count_nonzero(seen))

    def errors_of(streams: int, kept: int, exact_orders: int) -> np.ndarray:
        where = views, 0.91, azimuth, streams, kept
        brdf, _ = solve_sun([[5.0]], [albedo], every[:, None], *where, kept_moments=kept, exact_orders=exact_orders)
        return np.abs(brdf[0, 0] / exact.brdf[seen].ravel() - 1.0)

    for streams, allowed in zip((8, 16, 24), median, strict=True):
        once, twice = errors_of(streams, streams, 1), errors_of(streams, 3 * streams // 2, 2)
        assert np.median(twice) < allowed  # with light scattered once alone 2 to 12 times as much
        assert np.median(twice) < 0.65 * np.median(once)
        assert np.max(twice) < min(largest, 0.7 * np.max(once))


@pytest.mark.filterwarnings("ignore:NT corrections were requested")  # where all moments fit, none are needed
@warned
@pytest.mark.parametrize(
    ("kind", "wavelength_um", "tau", "degrees"),
    [
        pytest.param("bulk cirrus", 4.0, 3.0, (45.0, 23.0, 117.0), id="ice", marks=pytest.mark.long),
        pytest.param("bulk stratus", 3.7, 5.0, (36.0, 33.0, 1.0), id="glory"),
        pytest.param("bulk cumulus", 2.95, 5.0, (79.0, 69.0, 162.0), id="grazing"),
    ],
)
def test_the_finest_level_of_a_plan_agrees_with_ordinates_that_resolve_the_phase_function(
    kind, wavelength_um, tau, degrees
) -> None:
    """Zenith angles of view and sun, and azimuth; toward the very view. ``benchmarks/thirty_layers.py`` has more."""
    albedo, given, every = scattering(kind, wavelength_um)
    view, sun, _ = np.cos(np.radians(degrees))
    every, azimuth = np.append(every, np.zeros(400)), np.radians(degrees[2])

    def ordinates(streams: int) -> float:
        # Modes beyond the last moment vanish.
        modes = min(streams, given.shape[0])
        sizes = {"NLeg": streams, "NFourier": modes, "f_arr": max(every[streams], 0.0)}
        field = pydisort(tau, albedo, streams, every[np.newaxis], sun, 1.0, 0.0, **sizes)[4]
        return float(interpolate(field, "eval")(view, 0.0, np.pi - azimuth)) / sun

    def ours(kept: int, orders: int) -> float:
        sizes = {"streams": LEVELS[-2].sun_streams, "modes": kept, "kept_moments": kept, "exact_orders": orders}
        return float(solve_sun([[tau]], [albedo], given, [view], sun, [azimuth], **sizes)[0][0, 0, 0])

    exact = ordinates(256)
    assert ours(LEVELS[-2].sun_moments, 2) == pytest.approx(exact, rel=5e-5)
    assert abs(ours(16, 1) / exact - 1.0) > 5e-4  # what few moments and light scattered once alone leave
