"""Size distribution of cloud particles: the modified gamma distribution.

n(r) = a r^alpha exp(-b r^nu) between two radii (D. Deirmendjian, Electromagnetic Scattering on Spherical
Polydispersions, 1969), the form below eq 9 of the HCSS paper. Radii are in micrometres, as b is; ``a`` follows from the
number density. All moments have closed forms in incomplete gamma functions, because t = b r^nu turns them into gamma
integrals. These are computed here, of single numbers, because importing scipy.special takes 0.1 s: below t = s + 1 by
the power series, above it by the continued fraction (DLMF 8.11.4 and 8.9.2; W. J. Lentz, Appl. Opt. 15, 668 (1976)).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import choose_from
from hcss_twin.providers import Microphysics

DENSITY_KG_M3 = {"water": 1000.0, "ice": 917.0}
"""Density of the materials whose particles need not state it."""

_NEGLIGIBLE = 1e-7
"""Fraction of the area below, and of the sixth moment above, the range of radii in the quadrature."""


def check(cloud: Microphysics) -> None:
    """Reject parameters for which the distribution cannot be normalised.

    Raises
    ------
    ValueError
        If alpha <= -1, b <= 0, nu <= 0, the number density is negative, or the radii do not increase.
    """
    r1, r2 = cloud.radius_range_um
    problems = [
        (not cloud.alpha > -1.0, f"alpha {cloud.alpha}: allowed above -1"),
        (not cloud.b > 0.0, f"b {cloud.b}: allowed above 0 (um^-nu)"),
        (not cloud.nu > 0.0, f"nu {cloud.nu}: allowed above 0"),
        (not cloud.number_density_m3 >= 0.0, f"number_density_m3 {cloud.number_density_m3}: allowed from 0"),
        (not 0.0 <= r1 < r2, f"radius_range_um {r1}, {r2}: needs 0 <= r1 < r2"),
    ]
    for wrong, message in problems:
        if wrong:
            raise ValueError(message)


def _log_incomplete(cloud: Microphysics, power: float) -> float:
    """Return ln of the integral of r^(alpha + power) exp(-b r^nu) over the radius range, times b^((alpha + 1)/nu).

    Without that factor, and without the logarithm, narrow distributions of small radii would underflow.
    """
    s = (cloud.alpha + power + 1.0) / cloud.nu
    if s <= 0.0:
        raise ValueError(f"power {power}: allowed above {-cloud.alpha - 1.0} for alpha {cloud.alpha}")
    t1, t2 = (cloud.b * radius**cloud.nu for radius in cloud.radius_range_um)
    (below_1, above_1), (below_2, above_2) = lower_and_upper(s, t1), lower_and_upper(s, t2)
    # Using the smaller of the two complementary tails avoids cancellation.
    share = above_1 - above_2 if t1 > s else below_2 - below_1
    if not share > 0.0:
        low, high = cloud.radius_range_um
        most = (s / cloud.b) ** (1.0 / cloud.nu)
        raise ValueError(
            f"radius_range_um {low:g}, {high:g}: contains no particles, whose radius is about {most:.3g} um; "
            "allowed: a range that contains them"
        )
    return math.log(share) + math.lgamma(s) - power / cloud.nu * math.log(cloud.b) - math.log(cloud.nu)


def density(cloud: Microphysics, radius_um: Array) -> Array:
    """Return the size distribution n(r), m-3 um-1, for radii of any shape; 0 outside the range."""
    from scipy.special import xlogy  # takes 0.1 s to import

    check(cloud)
    radius = np.asarray(radius_um, dtype=np.float64)
    scale = (cloud.alpha + 1.0) / cloud.nu * np.log(cloud.b) - _log_incomplete(cloud, 0.0)
    shape = np.exp(scale + xlogy(cloud.alpha, radius) - cloud.b * radius**cloud.nu)
    inside = (radius >= cloud.radius_range_um[0]) & (radius <= cloud.radius_range_um[1])
    result: Array = np.where(inside, cloud.number_density_m3 * shape, 0.0)
    return result


def mean_power(cloud: Microphysics, power: float) -> float:
    """Return the mean of r^power over the particles, um^power, in closed form.

    Raises
    ------
    ValueError
        If the distribution or the moment does not exist, or the range of radii holds no particles.
    """
    check(cloud)
    return float(np.exp(_log_incomplete(cloud, power) - _log_incomplete(cloud, 0.0)))


def effective_radius_um(cloud: Microphysics) -> float:
    """Area-weighted mean radius <r^3>/<r^2>, um (Hansen and Travis, Space Sci. Rev. 16, 527 (1974))."""
    return mean_power(cloud, 3.0) / mean_power(cloud, 2.0)


def effective_variance(cloud: Microphysics) -> float:
    """Width <r^4><r^2>/<r^3>^2 - 1 of the area-weighted distribution, dimensionless (same source)."""
    return mean_power(cloud, 4.0) * mean_power(cloud, 2.0) / mean_power(cloud, 3.0) ** 2 - 1.0


def projected_area_m1(cloud: Microphysics) -> float:
    """Geometric cross section per volume, N pi <r^2>, m-1; times Q_ext it is the extinction coefficient."""
    return cloud.number_density_m3 * np.pi * mean_power(cloud, 2.0) * 1e-12


def water_content_kg_m3(cloud: Microphysics) -> float:
    """Mass of particles per volume of cloud, kg m-3."""
    return (
        density_kg_m3(cloud.material, cloud.density_kg_m3)
        * cloud.number_density_m3
        * 4.0
        / 3.0
        * np.pi
        * mean_power(cloud, 3.0)
        * 1e-18
    )


def density_kg_m3(material: str, given: float | None) -> float:
    """Return the density of a material, kg m-3: the given one, or that of water or ice.

    Raises
    ------
    ValueError
        If neither is known.
    """
    if given is None and material not in DENSITY_KG_M3:
        raise ValueError(f"the density of '{material}' is unknown; {choose_from(material, DENSITY_KG_M3)}")
    return DENSITY_KG_M3[material] if given is None else given


WHOLE = (0.01, 10.0)
"""Radii, in effective radii, between which practically all of a gamma distribution lies."""


def gamma_distribution(
    material: str,
    radius_um: float,
    variance: float,
    content_kg_m3: float,
    radius_range_um: tuple[float, float] | None = None,
    density: float | None = None,
) -> Microphysics:
    """Return the gamma distribution with given effective radius, effective variance and water content.

    n(r) ~ r^(1/v - 3) exp(-r / (r_e v)), J. E. Hansen and L. D. Travis, Space Sci. Rev. 16, 527 (1974), eq 2.56.

    Parameters
    ----------
    material : str
        Of the particles.
    radius_um : float
        Of the whole distribution, above 0.
    variance : float
        Above 0 and below 0.5, at which the number of particles diverges.
    content_kg_m3 : float
        Mass of particles per volume of cloud, above 0; exact for the radii inside the range.
    radius_range_um : (float, float), optional
        Limits of integration; by default 0.01 to 10 effective radii.
    density : float, optional
        Of the material, kg m-3; by default 917 for ice, 1000 for water.

    Raises
    ------
    ValueError
        If a value is not allowed, or the range changes effective radius or variance by more than 1 percent.
    """
    if not radius_um > 0.0:
        raise ValueError(f"effective_radius_um {radius_um}: allowed above 0")
    if not 0.0 < variance < 0.5:
        raise ValueError(f"effective_variance {variance}: allowed above 0 and below 0.5")
    if not content_kg_m3 > 0.0:
        raise ValueError(f"water_content_kg_m3 {content_kg_m3}: allowed above 0")
    limits = radius_range_um or (WHOLE[0] * radius_um, WHOLE[1] * radius_um)
    alpha, b = 1.0 / variance - 3.0, 1.0 / (radius_um * variance)
    single = Microphysics(material, alpha, b, 1.0, 1.0, limits, density)
    check(single)
    for name, actual, wanted in (
        ("effective_radius_um", effective_radius_um(single), radius_um),
        ("effective_variance", effective_variance(single), variance),
    ):
        if not abs(actual - wanted) <= 0.01 * wanted:
            raise ValueError(
                f"radius_range_um {limits[0]:g}, {limits[1]:g}: is so narrow that {name} is {actual:.4g} instead "
                f"of {wanted:g}; allowed: a wider range; closest is {WHOLE[0] * radius_um:g}, "
                f"{WHOLE[1] * radius_um:g}"
            )
    return replace(single, number_density_m3=content_kg_m3 / water_content_kg_m3(single))


def quadrature(cloud: Microphysics, nodes: int) -> tuple[Array, Array]:
    """Return quadrature radii and number densities for integrals over n(r).

    Gauss-Legendre quadrature in the square root of r, a compromise between small spheres, which need equal steps of ln
    r, and large ones, whose resonances need equal steps of r. It covers the relevant part of the radius range: the
    omitted fraction is below 1e-7 of the area (small radii) and of the sixth moment (large radii).

    Parameters
    ----------
    cloud : Microphysics
        Particles.
    nodes : int
        Number of radii.

    Returns
    -------
    radius_um, number_m3 : ndarray (nodes,)
        Radii, ascending, and the number density that each represents: the integral of f(r) n(r) dr is
        ``sum(number_m3 * f(radius_um))``.
    """
    check(cloud)
    low, high = (float(np.sqrt(limit)) for limit in _limits(cloud))
    abscissa, weight = _roots(nodes)
    half = 0.5 * (high - low)
    root = low + half * (abscissa + 1.0)
    radius: Array = root**2
    return radius, weight * half * 2.0 * root * density(cloud, radius)


@cache
def _roots(nodes: int) -> tuple[Array, Array]:
    """Return Gauss-Legendre nodes on [-1, 1] and weights (nodes,), which take milliseconds to compute."""
    from scipy import special  # takes 0.1 s to import

    return special.roots_legendre(nodes)  # type: ignore[no-any-return]


def _limits(cloud: Microphysics) -> tuple[float, float]:
    """Return the limits (um) of the relevant radii."""
    from scipy import special  # takes 0.1 s to import

    r1, r2 = cloud.radius_range_um
    area = special.gammaincinv((cloud.alpha + 3.0) / cloud.nu, _NEGLIGIBLE)
    sixth = special.gammainccinv((cloud.alpha + 7.0) / cloud.nu, _NEGLIGIBLE)
    low = max(r1, float((area / cloud.b) ** (1.0 / cloud.nu)))
    high = min(r2, float((sixth / cloud.b) ** (1.0 / cloud.nu)))
    # For a range in a far tail, all of it is relevant.
    return (low, high) if low < high else (r1, r2)


_SMALLEST = 1e-300
"""Replaces zero denominators of the continued fraction."""

_LARGEST = 200.0
"""The expansions need about sqrt(s) terms and lose digits as s grows; above this, scipy.special is used."""


def lower_and_upper(s: float, t: float) -> tuple[float, float]:
    """Return P(s, t) = gamma(s, t) / Gamma(s) and Q = 1 - P for s > 0 and t >= 0.

    The smaller of the two has a relative error below 1e-12.
    """
    if s > _LARGEST:
        from scipy.special import gammainc, gammaincc

        return float(gammainc(s, t)), float(gammaincc(s, t))
    if t == 0.0:
        return 0.0, 1.0
    if math.isinf(t):
        return 1.0, 0.0
    front = math.exp(s * math.log(t) - t - math.lgamma(s))
    if t < s + 1.0:
        term = total = 1.0 / s
        number = s
        while term > total * 1e-17:
            number += 1.0
            term *= t / number
            total += term
        lower = min(front * total, 1.0)
        return lower, 1.0 - lower
    odd = t + 1.0 - s
    c, d = 1.0 / _SMALLEST, 1.0 / odd
    fraction, change, number = d, 0.0, 0.0
    while abs(change - 1.0) > 4e-16:
        number += 1.0
        even = number * (s - number)
        odd += 2.0
        d = 1.0 / (even * d + odd or _SMALLEST)
        c = even / c + odd or _SMALLEST
        change = c * d
        fraction *= change
    upper = min(front * fraction, 1.0)
    return 1.0 - upper, upper
