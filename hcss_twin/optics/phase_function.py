"""Phase functions of homogeneous spheres: scattering amplitudes, and Legendre moments of many spheres together.

The intensity that a sphere scatters is a polynomial of the cosine of the scattering angle, of twice the degree of
its last multipole. Gauss-Legendre quadrature with enough nodes therefore gives its moments exactly, and sums over
multipoles at all nodes and all spheres are products of matrices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.optics.spheres import multipoles

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_SPHERES_AT_ONCE = 1024
"""Spheres that share one angular grid: each group takes no more angles than its largest sphere needs."""

_GRID_GROWTH = 1.15
"""Ratio of successive grid sizes; grids are shared by groups whose needs lie between two of them."""


def amplitudes(
    refractive_index: complex, size_parameter: float, mu: Array
) -> tuple[ComplexArray, ComplexArray]:
    """Amplitudes S1 and S2 of one sphere at cosines ``mu`` (J,) of the scattering angle.

    Returns
    -------
    s1, s2 : ndarray (J,), complex
        For light polarised perpendicular and parallel to the scattering plane.

    References
    ----------
    Bohren and Huffman (1983), eq 4.74. Their code BHMIE has the same sign of the phase.
    """
    a, b = _coefficients(np.array([refractive_index], dtype=np.complex128), np.array([size_parameter]))
    plus, minus = _angular(np.asarray(mu, dtype=np.float64), a.shape[1])
    sum_, difference = ((a + b) @ plus)[0], ((a - b) @ minus)[0]
    return 0.5 * (sum_ + difference), 0.5 * (sum_ - difference)


def _coefficients(index: ComplexArray, size: Array) -> tuple[ComplexArray, ComplexArray]:
    """Mie coefficients (M, N) of spheres sorted by descending size, 0 past the last order of each."""
    rows = list(multipoles(index, size))
    a = np.zeros((size.size, len(rows)), dtype=np.complex128)
    b = np.zeros_like(a)
    for n, m, electric, magnetic in rows:
        a[:m, n - 1], b[:m, n - 1] = electric, magnetic
    return a, b


def _angular(mu: Array, orders: int) -> tuple[Array, Array]:
    """(2n + 1)/(n(n + 1)) (pi_n + tau_n) and the same of pi_n - tau_n, (orders, J) each.

    Bohren and Huffman (1983), eqs 4.46 and 4.47. With them S1 + S2 and S1 - S2 are sums of a + b and a - b.
    """
    plus, minus = np.empty((orders, mu.size)), np.empty((orders, mu.size))
    before, pi = np.zeros_like(mu), np.ones_like(mu)
    for n in range(1, orders + 1):
        tau = n * mu * pi - (n + 1) * before
        factor = (2 * n + 1) / (n * (n + 1))
        plus[n - 1], minus[n - 1] = factor * (pi + tau), factor * (pi - tau)
        before, pi = pi, ((2 * n + 1) * mu * pi - (n + 1) * before) / n
    return plus, minus


def legendre_polynomials(mu: Array, count: int) -> Array:
    """P_l(mu) for l = 0 to count - 1, (count, J)."""
    result = np.empty((count, mu.size))
    before, current = np.zeros_like(mu), np.ones_like(mu)
    for degree in range(count):
        result[degree] = current
        before, current = current, ((2 * degree + 1) * mu * current - degree * before) / (degree + 1)
    return result


def phase_function(moments: Array, mu: Array) -> Array:
    """Phase function (J, V) from Legendre moments (K, V) at cosines ``mu`` (J,); its mean over the sphere is 1."""
    degree = np.arange(moments.shape[0])
    result: Array = legendre_polynomials(mu, degree.size).T @ ((2 * degree + 1)[:, np.newaxis] * moments)
    return result


class MomentSums:
    """Legendre moments of the light that spheres scatter, summed over spheres.

    Parameters
    ----------
    count : int
        Number K of moments.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._grids: dict[int, tuple[Array, Array, Array, int]] = {}

    def __call__(self, refractive_index: complex, size_parameter: Array, weight: Array) -> Array:
        """Moments (K,) of the phase function of spheres with ``size_parameter`` and ``weight`` (M,) together.

        ``weight`` is their number; what a sphere scatters follows from its amplitudes. The result is divided by
        its moment of degree 0.
        """
        order = np.argsort(-size_parameter, kind="stable")
        sums = np.zeros(self._count)
        for start in range(0, order.size, _SPHERES_AT_ONCE):
            part = order[start : start + _SPHERES_AT_ONCE]
            size = size_parameter[part]
            a, b = _coefficients(np.full(size.size, refractive_index), size)
            plus, minus, projection, grid_orders = self._grid(a.shape[1])
            orders = a.shape[1]
            assert orders <= grid_orders
            intensity = np.zeros(plus.shape[1])
            for coefficients, angular in ((a + b, plus[:orders]), (a - b, minus[:orders])):
                for component in (coefficients.real, coefficients.imag):
                    amplitude = component @ angular
                    np.square(amplitude, out=amplitude)
                    intensity += weight[part] @ amplitude
            sums += projection @ intensity
        result: Array = sums / sums[0]
        return result

    def _grid(self, orders: int) -> tuple[Array, Array, Array, int]:
        """Angular functions and projection on Legendre polynomials for at least ``orders`` multipoles."""
        step = int(np.ceil(np.log(orders) / np.log(_GRID_GROWTH)))
        if step not in self._grids:
            most = int(np.ceil(_GRID_GROWTH**step)) + 1
            # Exact for the product of the intensity, of degree 2 * most, and the last Legendre polynomial.
            mu, weight = np.polynomial.legendre.leggauss(most + self._count // 2 + 1)
            plus, minus = _angular(mu, most)
            self._grids[step] = plus, minus, legendre_polynomials(mu, self._count) * weight, most
        return self._grids[step]
