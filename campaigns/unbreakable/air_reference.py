"""Absorber amounts along refracted rays by adaptive integration over height, which shares nothing with the package."""

import itertools

import numpy as np
from scipy.integrate import quad


def vertical_amount(altitude_m, density, lower_m, upper_m):
    """Return the integral (per km) of a density that is exponential between levels where it falls, else linear."""
    return _by_pieces(altitude_m, lower_m, upper_m, lambda at: _density(altitude_m, density, at))


def slant_amount(altitude_m, density, refractivity, radius_m, lower_m, upper_m, zenith_deg):
    """Return the same along the ray that starts at ``lower_m`` toward a zenith angle at the surface point.

    ds = dr / cos(zenith), and n r sin(zenith) is constant. None for a ray that the air bends back, or
    that comes close to it: its cos^2(zenith) falls below a quarter of the straight ray's.
    """
    log = np.log(refractivity)

    def times_radius(at):
        return (1.0 + np.exp(np.interp(at, altitude_m, log))) * (radius_m + at)

    invariant = times_radius(lower_m) / (radius_m + lower_m) * radius_m * np.sin(np.radians(zenith_deg))
    inside = altitude_m[(altitude_m > lower_m) & (altitude_m < upper_m)]
    dense = np.concatenate([np.linspace(a, b, 40) for a, b in itertools.pairwise([lower_m, *inside, upper_m])])
    bent, straight = invariant / times_radius(dense), radius_m * np.sin(np.radians(zenith_deg)) / (radius_m + dense)
    if np.any((1.0 - bent) * (1.0 + bent) < 0.25 * (1.0 - straight) * (1.0 + straight)):
        return None

    def along(at):
        sine = invariant / times_radius(at)
        return _density(altitude_m, density, at) / np.sqrt((1.0 - sine) * (1.0 + sine))

    return _by_pieces(altitude_m, lower_m, upper_m, along)


def _by_pieces(altitude_m, lower_m, upper_m, function):
    inside = altitude_m[(altitude_m > lower_m) & (altitude_m < upper_m)]
    ends = [lower_m, *inside, upper_m]
    pieces = [quad(function, a, b, epsrel=1e-8, limit=200)[0] for a, b in itertools.pairwise(ends)]
    return 1e-3 * float(np.sum(pieces))


def _density(altitude_m, density, at):
    layer = min(max(int(np.searchsorted(altitude_m, at, side="right")) - 1, 0), altitude_m.size - 2)
    low, high = density[layer], density[layer + 1]
    share = (at - altitude_m[layer]) / (altitude_m[layer + 1] - altitude_m[layer])
    return low * (high / low) ** share if 0.0 < high < low else low + share * (high - low)
