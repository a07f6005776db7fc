"""How the mean sunlight of broken cumulus in the tier source depends on the number of slices.

python plugins/hcss-light/benchmarks/halved_slices.py

Printed is the difference of means over the image from that with eight times as many slices.
"""

from __future__ import annotations

import numpy as np
from hcss_light.slices import Slices, slices_of
from hcss_light.source import Direction, Particles, Surroundings, sourced_radiance

POINTS, POINT_M, HIGHEST_M = 48, 100.0, 1500.0
PARTICLES = Particles(0.06, 0.9, np.array([1.0, 0.8]))
SUN = Direction(45.0, 100.0)
VIEWS = ((0.0, 0.0), (30.0, 20.0), (60.0, 110.0), (60.0, 290.0))
FACTORS = (1, 2, 4, 8)


def clouds() -> np.ndarray:
    """Return thicknesses (y, x), m, of clouds with a power spectrum of k^-3.4 over two fifths of an area."""
    waves = np.hypot(np.fft.fftfreq(POINTS)[:, None], np.fft.fftfreq(POINTS)[None])
    waves[0, 0] = 1.0
    noise = np.fft.fft2(np.random.default_rng(5).normal(size=waves.shape))
    field = np.fft.ifft2(noise * waves**-1.7).real
    above = np.maximum(field - np.quantile(field, 0.6), 0.0)
    thickness: np.ndarray = ((above / above.max()) ** 0.7 * HIGHEST_M).astype(np.float32)
    return thickness


def main() -> None:
    """Print the difference of means from that with eight times as many slices."""
    thickness, optical = clouds(), 5.0 / 3.0 * PARTICLES.scaled[0] * HIGHEST_M
    count = slices_of(0.0, HIGHEST_M, "base", POINT_M, 60.0, optical).count
    for zenith, azimuth in VIEWS:
        means = []
        for factor in FACTORS:
            slices = Slices(0.0, HIGHEST_M, factor * count, "base", POINT_M)
            nothing = np.zeros(slices.count)
            around = Surroundings(nothing, 0.0, 0.0, nothing + 1.0, nothing)
            density = slices.density(thickness, "adiabatic")
            seen = sourced_radiance(slices, density, PARTICLES, around, Direction(zenith, azimuth), SUN, 0.0)[1]
            means.append(seen.mean())
        errors = ", ".join(
            f"{100.0 * (own / means[-1] - 1.0):+.2f} % with {factor * count}"
            for factor, own in zip(FACTORS[:-1], means, strict=False)
        )
        print(f"zenith {zenith:g}, azimuth {azimuth:g} from the sun's {SUN.azimuth_deg:g}: {errors} slices")


if __name__ == "__main__":
    main()
