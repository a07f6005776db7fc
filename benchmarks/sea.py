"""Measured figures of the rough sea: the tables of docs/development/optics-sea-and-air.md.

::

    python benchmarks/sea.py
"""

from __future__ import annotations

import time
from itertools import product

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.slope_statistics import resolved_variances
from hcss_twin.models.sea.wave_field import WaveField, cutoff_frequency_rad_s, thermal_contrast_bound
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.providers import SeaInputs

Array = NDArray[np.float64]

WINDS = (0.0, 5.0, 15.0)
LWIR, MWIR = np.array([1e4 / 10.8]), np.array([1e4 / 3.7])


def sea(wind: float, temperature_K: float = 298.15, **parameters: object) -> RoughSea:
    """Return a sea without foam and salt unless asked for."""
    chosen = {"foam": False, "salinity_psu": 0.0, **parameters}
    return RoughSea(SeaInputs(wind, 0.0, temperature_K, Catalog()), RoughSeaParameters.model_validate(chosen))


def cosines(*zenith_deg: float) -> Array:
    """Return cosines of angles in degrees."""
    return np.asarray(np.cos(np.radians(zenith_deg)), dtype=np.float64)


def directional_hemispherical(model: RoughSea, mu: float, wavenumber: Array) -> float:
    """Integrate the BRDF over the directions it sends light from."""
    x, w = np.polynomial.legendre.leggauss(400)
    y, v = np.polynomial.legendre.leggauss(200)
    grid, azimuth = np.meshgrid(0.5 * (x + 1.0), 0.5 * np.pi * (y + 1.0), indexing="ij")
    weight = (grid * (0.5 * w)[:, None] * (np.pi * v)[None, :]).ravel()
    kernel = model.brdf(wavenumber, np.full(grid.size, mu), grid.ravel(), azimuth.ravel())[:, 0]
    return float(weight @ kernel)


def emissivities() -> None:
    """Print emissivity with and without the second reflection."""
    print("emissivity at 3.7, 10.8 and 12 um (25 degC, fresh, no foam); 10.8 um without second reflection")
    nu = 1e4 / np.array([12.0, 10.8, 3.7])
    for zenith, wind in product((0.0, 40.0, 60.0, 70.0, 80.0), WINDS):
        found = sea(wind).emissivity(nu, cosines(zenith))[0, ::-1]
        alone = sea(wind, re_reflection=False).emissivity(LWIR, cosines(zenith)).item()
        print(f"{zenith:4.0f} deg {wind:4.0f} m/s  " + "  ".join(f"{e:.4f}" for e in found) + f"  {alone:.4f}")


def balance() -> None:
    """Print emissivity plus integral of the BRDF."""
    print("emissivity + integral of the BRDF at 10.8 um: shadowing none, separable, height-correlated")
    for zenith, wind in product((40.0, 60.0, 70.0, 75.0, 80.0, 85.0), WINDS):
        mu = cosines(zenith)
        sums = []
        for shadowing in ("none", "separable", "height-correlated"):
            model = sea(wind, shadowing=shadowing)
            sums.append(model.emissivity(LWIR, mu).item() + directional_hemispherical(model, float(mu[0]), LWIR))
        print(f"{zenith:4.0f} deg {wind:4.0f} m/s  " + "  ".join(f"{total:.4f}" for total in sums))


def water() -> None:
    """Print what temperature, salt, foam and the wind's bearing change."""
    mu = cosines(0.0, 55.0)
    nu = np.array([800.0, 926.0, 1e4 / 3.7])
    base = sea(5.0).emissivity(nu, mu)
    for name, other in (
        ("0 degC", sea(5.0, 273.15)),
        ("30 degC", sea(5.0, 303.15)),
        ("35 psu", sea(5.0, salinity_psu=35.0)),
    ):
        change = other.emissivity(nu, mu) - base
        print(f"{name}: change at 800, 926, 2703 cm-1, nadir {change[0].round(4)}, 55 deg {change[1].round(4)}")
    for wind in (5.0, 10.0, 15.0, 20.0):
        model = sea(wind, foam=True)
        change = model.emissivity(LWIR, mu) - sea(wind).emissivity(LWIR, mu)
        print(f"foam at {wind:g} m/s: {model.foam_coverage:.4f} covered, change {change.ravel().round(4)}")
    bearings = np.array([0.0, 0.5 * np.pi, np.pi])
    for slopes in ("upwind-crosswind", "gram-charlier"):
        found = sea(10.0, slopes=slopes).emissivity(LWIR, cosines(70.0, 70.0, 70.0), bearings)[:, 0]
        print(f"{slopes}, 70 deg, 10 m/s: upwind, crosswind, downwind {found.round(4)}")
    print(f"isotropic: {sea(10.0).emissivity(LWIR, cosines(70.0)).item():.4f}")


def sky_weights() -> None:
    """Print how well 8 nodes carry a sky, and what the weights cost."""
    nodes = 0.5 * (np.polynomial.legendre.leggauss(8)[0] + 1.0)
    fine, mu = np.linspace(0.002, 1.0, 500), cosines(0.0, 40.0, 60.0, 75.0, 85.0)
    for wind, depth in product((0.0, 1.0, 10.0), (0.1, 0.3, 1.0)):
        line = []
        for basis in ("lagrange", "linear"):
            few = sea(wind).reflection_weights(LWIR, mu, nodes, basis)[..., 0] @ -np.expm1(-depth / nodes)
            many = sea(wind).reflection_weights(LWIR, mu, fine, "linear")[..., 0] @ -np.expm1(-depth / fine)
            line.append(f"{basis} " + " ".join(f"{error:8.1e}" for error in few - many))
        print(f"sky of zenith depth {depth:g}, {wind:g} m/s, error at 0 40 60 75 85 deg: " + "; ".join(line))
    nu = np.linspace(700.0, 1250.0, 500)
    for slopes in ("isotropic", "upwind-crosswind"):
        model = sea(10.0, slopes=slopes)
        times = []
        for _ in range(4):
            start = time.perf_counter()
            model.reflection_weights(nu, nodes, nodes)
            times.append(time.perf_counter() - start)
        print(f"weights 8 views x 8 nodes x 500, {slopes}: {times[0]:.3f} s once, {min(times[1:]):.4f} s after")


def resolved_waves() -> None:
    """Print resolved slopes and the bounds on their contrast."""
    mu = cosines(0.0, 20.0, 40.0, 60.0)
    for name, pixel in product(("pierson-moskowitz", "jonswap"), (1.0, 5.0, 20.0, 100.0)):
        spectrum = WaveSpectrum("jonswap" if name == "jonswap" else "pierson-moskowitz", 10.0)
        resolved = spectrum.resolved_mean_square_slope(cutoff_frequency_rad_s(pixel))
        slope, total = resolved_variances(spectrum, pixel)[0] ** 0.5, sea(10.0).mean_square_slope
        bounds = [thermal_contrast_bound(sea(10.0), nu, mu, slope)[:, 0].round(5) for nu in (MWIR, LWIR)]
        print(f"{name}, {pixel:g} m: slope^2 {resolved:.2g} of {total:.4f}; MWIR {bounds[0]} LWIR {bounds[1]}")
    field = WaveField(WaveSpectrum("pierson-moskowitz", 10.0), 30.0, 5.0, seed=1)
    seconds = []
    for _ in range(5):
        start = time.process_time()
        field.slopes(0.0, slice(0, 800), slice(0, 800))
        seconds.append(time.process_time() - start)
    print(f"slopes of 800 x 800 pixels, 512 waves: {min(seconds) / 800**2 * 1e9:.0f} ns a pixel")
    for wind in (5.0, 10.0, 20.0):
        heights = [WaveSpectrum("jonswap", wind, f).significant_wave_height_m for f in (10e3, 100e3)]
        whole = WaveSpectrum("pierson-moskowitz", wind).significant_wave_height_m
        print(f"Hs at {wind:g} m/s: P-M {whole:.2f}; JONSWAP 10 km {heights[0]:.2f}, 100 km {heights[1]:.2f}")


if __name__ == "__main__":
    for part in (emissivities, balance, water, sky_weights, resolved_waves):
        part()
        print()
