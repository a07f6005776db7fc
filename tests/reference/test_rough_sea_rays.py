"""The rough sea against rays followed over a surface, and against facets drawn at random."""

from functools import cache

import numpy as np
import pytest
from numba import njit
from textbook_fresnel import real_fresnel

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.providers import SeaInputs

WAVELENGTH_UM = np.array([3.7, 10.8, 12.0])
N = 1024


def sea(wind, **parameters):
    plain = {"foam": False, "salinity_psu": 0.0, "water_temperature": False}
    return RoughSea(SeaInputs(wind, 0.0, 298.15, Catalog()), RoughSeaParameters(**(plain | parameters)))


def water():
    index = load_refractive_index(Catalog(), "water").at(1e4 / WAVELENGTH_UM[::-1])[::-1]
    return [(value.real, value.imag) for value in index]


@njit(cache=True)
def facet(surface, x, y):
    """Height and slopes of the triangle above (x, y); the surface repeats."""
    i, j = int(np.floor(y)), int(np.floor(x))
    u, v = x - j, y - i
    i0, j0, i1, j1 = i % 1024, j % 1024, (i + 1) % 1024, (j + 1) % 1024
    a, b, c, d = surface[i0, j0], surface[i0, j1], surface[i1, j0], surface[i1, j1]
    if u + v < 1.0:
        return a + u * (b - a) + v * (c - a), b - a, c - a
    return d + (1.0 - u) * (c - d) + (1.0 - v) * (b - d), d - c, d - b


@njit(cache=True)
def follow(surface, top, start, azimuth, zenith, step):
    """Cosines of incidence of up to three hits (R, 3), 0 where there is none, and the rays' last elevation."""
    cosines = np.zeros((start.shape[0], 3))
    left = np.zeros(start.shape[0])
    for r in range(start.shape[0]):
        dx, dy = -np.sin(zenith) * np.cos(azimuth[r]), -np.sin(zenith) * np.sin(azimuth[r])
        dz = -np.cos(zenith)
        x, y, z = start[r, 0], start[r, 1], top
        hit = 0
        while hit < 3:
            found = False
            while True:
                x, y, z = x + step * dx, y + step * dy, z + step * dz
                if dz > 0.0 and z > top:
                    break
                if z < facet(surface, x, y)[0]:
                    found = True
                    break
            if not found:
                break
            low, high = -step, 0.0
            for _ in range(30):
                half = 0.5 * (low + high)
                if z + half * dz < facet(surface, x + half * dx, y + half * dy)[0]:
                    high = half
                else:
                    low = half
            x, y, z = x + low * dx, y + low * dy, z + low * dz
            _, sx, sy = facet(surface, x + high * dx - low * dx, y + high * dy - low * dy)
            area = np.sqrt(1.0 + sx * sx + sy * sy)
            cosine = (sx * dx + sy * dy - dz) / area
            if cosine <= 0.0:
                break
            cosines[r, hit] = cosine
            dx, dy = dx - 2.0 * cosine * sx / area, dy - 2.0 * cosine * sy / area
            dz = dz + 2.0 * cosine / area
            hit += 1
        left[r] = dz
    return cosines, left


@cache
def surface_with(mean_square_slope):
    """A Gaussian surface of Gaussian correlation, its facets' mean-square slope exactly as asked."""
    k = 2.0 * np.pi * np.fft.fftfreq(N)
    filtered = np.exp(-0.125 * 18.0**2 * (k[:, None] ** 2 + k[None, :] ** 2))
    noise = np.fft.fft2(np.random.default_rng(4).normal(size=(N, N)))
    surface = np.fft.ifft2(noise * filtered).real
    slope = sum(np.mean((np.roll(surface, -1, axis) - surface) ** 2) for axis in (0, 1))
    surface *= np.sqrt(mean_square_slope / slope)
    return surface - surface.mean()


def traced(wind, zenith_deg, rays=30_000):
    surface = surface_with(0.003 + 0.00512 * wind)
    random = np.random.default_rng(8)
    start, azimuth = random.uniform(0, N, (rays, 2)), random.uniform(0.0, 2.0 * np.pi, rays)
    return follow(surface, surface.max() + 0.01, start, azimuth, np.radians(zenith_deg), 0.3)


def emissivity_of(cosines, n, k):
    """Emission of each hit, mirrored by those before it."""
    through, emitted = np.ones(cosines.shape[0]), np.zeros(cosines.shape[0])
    for hit in cosines.T:
        reflectance = np.where(hit > 0.0, real_fresnel(n, k, np.maximum(hit, 1e-9)), 1.0)
        emitted += through * (1.0 - reflectance)
        through *= reflectance
    return emitted.mean()


@pytest.mark.parametrize("zenith_deg", [0.0, 30.0, 45.0, 60.0])
@pytest.mark.parametrize("wind", [0.0, 5.0, 15.0])
def test_emissivity_agrees_with_rays_over_a_surface_within_0_003(wind, zenith_deg):
    mu = np.array([np.cos(np.radians(zenith_deg))])
    found = sea(wind).emissivity(1e4 / WAVELENGTH_UM[::-1], mu)[0, ::-1]
    cosines, _ = traced(wind, zenith_deg)
    for value, (n, k) in zip(found, water(), strict=True):
        assert value == pytest.approx(emissivity_of(cosines, n, k), abs=0.003)


@pytest.mark.parametrize(("wind", "zenith_deg"), [(5.0, 80.0), (15.0, 75.0), (30.0, 70.0)])
def test_beyond_60_degrees_the_second_reflection_is_what_the_rays_show(wind, zenith_deg):
    mu, (n, k) = np.array([np.cos(np.radians(zenith_deg))]), water()[1]
    cosines, _ = traced(wind, zenith_deg)
    wavenumber = 1e4 / WAVELENGTH_UM[1:2]
    expected = emissivity_of(cosines, n, k)
    alone = sea(wind, re_reflection=False).emissivity(wavenumber, mu).item()
    assert sea(wind).emissivity(wavenumber, mu).item() == pytest.approx(expected, abs=0.002)
    assert alone < expected - 0.015


@pytest.mark.parametrize(("wind", "zenith_deg"), [(0.0, 60.0), (15.0, 60.0), (15.0, 75.0)])
def test_the_sky_seen_in_the_sea_is_the_one_the_rays_reach(wind, zenith_deg):
    """A sky that brightens toward the horizon, as a thin atmosphere does."""
    (n, k), nodes = water()[1], np.linspace(0.002, 1.0, 500)
    cosines, elevation = traced(wind, zenith_deg)
    reflectance = np.prod(np.where(cosines > 0.0, real_fresnel(n, k, np.maximum(cosines, 1e-9)), 1.0), axis=1)
    up = elevation > 0.0
    expected = np.mean(reflectance[up] * -np.expm1(-0.3 / elevation[up])) * up.mean()
    mu = np.array([np.cos(np.radians(zenith_deg))])
    weights = sea(wind).reflection_weights(1e4 / WAVELENGTH_UM[1:2], mu, nodes, "linear")[0, :, 0]
    found = weights @ -np.expm1(-0.3 / nodes)
    assert found == pytest.approx(expected, rel=0.03)
    assert found == pytest.approx(expected, abs=0.0015)


def test_gauss_nodes_carry_the_sky_as_well_as_250_do():
    mu = np.cos(np.radians([0.0, 30.0, 60.0, 75.0]))
    x, _ = np.polynomial.legendre.leggauss(8)
    fine, gauss = np.linspace(0.004, 1.0, 250), 0.5 * (x + 1.0)
    wavenumber = 1e4 / WAVELENGTH_UM[::-1]
    for wind in (0.0, 1.0, 10.0):
        many = sea(wind).reflection_weights(wavenumber, mu, fine, "linear")
        few = sea(wind).reflection_weights(wavenumber, mu, gauss)
        skies = [-np.expm1(-0.3 / nodes) for nodes in (fine, gauss)]
        found, expected = (np.einsum("mnv,n->mv", w, s) for w, s in zip((few, many), skies[::-1], strict=True))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=3e-4)


def main():
    """Print model minus rays at 10.8 um, with the second reflection and for the first hit alone."""
    nu, (n, k) = 1e4 / WAVELENGTH_UM[1:2], water()[1]
    for wind in (0.0, 5.0, 15.0, 30.0):
        for zenith_deg in (0.0, 45.0, 60.0, 70.0, 75.0, 80.0, 85.0):
            cosines, _ = traced(wind, zenith_deg)
            mu = np.array([np.cos(np.radians(zenith_deg))])
            whole = sea(wind).emissivity(nu, mu).item() - emissivity_of(cosines, n, k)
            first = sea(wind, re_reflection=False).emissivity(nu, mu).item() - emissivity_of(cosines[:, :1], n, k)
            hit = [np.mean(cosines[:, i] > 0.0) for i in (1, 2)]
            print(
                f"{wind:3.0f} m/s {zenith_deg:3.0f} deg: {whole:+.4f}, first hit alone {first:+.4f}; "
                f"{hit[0]:.3f} hit again, {hit[1]:.3f} a third time"
            )


if __name__ == "__main__":
    main()
