"""Mie theory for many homogeneous spheres at once: efficiencies, amplitudes and Legendre moments of phase functions.

The bulk properties of one cloud in three bands need about 1e5 spheres. In interpreted Python, a loop over spheres takes
0.1 ms per sphere; compiled loops are fast but take seconds to compile. Here the loop is over multipole orders, and each
order handles all spheres that need it: about 2 us per sphere without a compiler.

The scattered intensity of a sphere is a polynomial in the cosine of the scattering angle, with twice the degree of its
last multipole. Gauss-Legendre quadrature with enough nodes therefore gives its moments exactly, and sums over
multipoles at all nodes and all spheres are products of matrices.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

ComplexArray = NDArray[np.complex128]

_BLOCK = 4096
"""Number of spheres handled together: enough to hide interpreter overhead, few enough for the cache."""

_EXTRA_ORDERS = 16
"""Minimum number of orders above the last one needed at which the downward recurrence starts."""


def mie_efficiencies(refractive_index: ComplexArray, size_parameter: Array) -> tuple[Array, Array, Array]:
    """Return extinction and scattering efficiencies and asymmetry parameter of spheres in vacuum.

    Parameters
    ----------
    refractive_index : ndarray (M,), complex
        n + ik with k >= 0 for absorption and n > 0.
    size_parameter : ndarray (M,)
        2 pi r / wavelength, above 0.

    Returns
    -------
    q_ext, q_sca, asymmetry : ndarray (M,)
        Efficiencies per geometric cross section, and mean cosine of the scattering angle.

    Raises
    ------
    ValueError
        If the arrays differ in shape, a size parameter is not above 0, or k is negative.

    References
    ----------
    C. F. Bohren and D. R. Huffman, Absorption and Scattering of Light by Small Particles (1983), eqs 4.61, 4.62, 4.88,
    4.89 and p. 120 for the asymmetry; number of orders from W. J. Wiscombe, Appl. Opt. 19, 1505 (1980).
    """
    index = np.asarray(refractive_index, dtype=np.complex128)
    size = np.asarray(size_parameter, dtype=np.float64)
    if index.shape != size.shape or size.ndim != 1:
        raise ValueError(f"refractive_index {index.shape} and size_parameter {size.shape}: need the same shape (M,)")
    if size.size and not (np.min(size) > 0.0 and np.all(np.isfinite(size))):
        raise ValueError(f"size_parameter {np.min(size)}: allowed above 0 and finite")
    if size.size and (np.min(index.imag) < 0.0 or np.min(index.real) <= 0.0):
        raise ValueError("refractive_index: allowed n > 0 and k >= 0 in n + ik")
    # Descending size: the spheres that need an order are then a leading slice of the block.
    order = np.argsort(-size, kind="stable")
    result = np.empty((3, size.size))
    for start in range(0, size.size, _BLOCK):
        block = order[start : start + _BLOCK]
        result[:, block] = _block(index[block], size[block])
    return result[0], result[1], result[2]


def _orders(size: Array) -> NDArray[np.int64]:
    """Return the number of multipole orders, by Wiscombe's criterion for the largest spheres."""
    return np.ceil(size + 4.05 * np.cbrt(size) + 2.0).astype(np.int64)


def _log_derivative(argument: ComplexArray, orders: int) -> ComplexArray:
    """Logarithmic derivatives D_n(z) of Riccati-Bessel functions (orders + 1, M), by downward recurrence."""
    largest = float(np.max(np.abs(argument)))
    # Beyond n = |z| a wrong start decays over a number of orders that grows as the cube root of |z|;
    # the customary 15 orders leave 3e-6 in Q_ext at x = 100 and spoil x = 1e4.
    start = max(orders, int(np.ceil(largest))) + int(8.0 * np.cbrt(largest)) + _EXTRA_ORDERS
    inverse = 1.0 / argument
    current = np.zeros_like(argument)
    result = np.empty((orders + 1, argument.size), dtype=np.complex128)
    for n in range(start, 0, -1):
        ratio = n * inverse
        current = ratio - 1.0 / (current + ratio)
        if n - 1 <= orders:
            result[n - 1] = current
    return result


def multipoles(index: ComplexArray, size: Array) -> Iterator[tuple[int, int, ComplexArray, ComplexArray]]:
    """Mie coefficients order by order, for spheres sorted by descending size.

    Parameters
    ----------
    index, size : ndarray (M,)
        n + ik and size parameters, the sizes descending.

    Yields
    ------
    n, m : int
        Order, and the number of leading spheres that need it.
    a, b : ndarray (m,)
        Coefficients of the electric and magnetic multipoles, Bohren and Huffman (1983), eq 4.88.
    """
    orders = _orders(size)
    derivative = _log_derivative(index * size, int(orders[0]))
    inverse_size = 1.0 / size
    psi_before, psi = np.cos(size), np.sin(size)
    chi_before, chi = -np.sin(size), np.cos(size)
    # Spheres with at least n orders: orders are descending, so search the negated array.
    alive = np.searchsorted(-orders, -np.arange(int(orders[0]) + 1), side="right")
    for n in range(1, int(orders[0]) + 1):
        m = int(alive[n])
        over = inverse_size[:m]
        psi_new = (2 * n - 1) * over * psi[:m] - psi_before[:m]
        chi_new = (2 * n - 1) * over * chi[:m] - chi_before[:m]
        psi_before, psi = psi[:m], psi_new
        chi_before, chi = chi[:m], chi_new
        xi, xi_before = psi - 1j * chi, psi_before - 1j * chi_before
        electric = derivative[n, :m] / index[:m] + n * over
        magnetic = derivative[n, :m] * index[:m] + n * over
        a = (electric * psi - psi_before) / (electric * xi - xi_before)
        b = (magnetic * psi - psi_before) / (magnetic * xi - xi_before)
        yield n, m, a, b


def _block(index: ComplexArray, size: Array) -> Array:
    """Return efficiencies and asymmetry (3, M) of spheres sorted by descending size."""
    extinction = np.zeros_like(size)
    scattering = np.zeros_like(size)
    asymmetry = np.zeros_like(size)
    a_before = np.zeros_like(index)
    b_before = np.zeros_like(index)
    for n, m, a, b in multipoles(index, size):
        extinction[:m] += (2 * n + 1) * (a.real + b.real)
        scattering[:m] += (2 * n + 1) * (a.real**2 + a.imag**2 + b.real**2 + b.imag**2)
        asymmetry[:m] += (2 * n + 1) / (n * (n + 1)) * (a.real * b.real + a.imag * b.imag)
        a_last, b_last = a_before[:m], b_before[:m]
        asymmetry[:m] += ((n - 1) * (n + 1) / n) * (
            a_last.real * a.real + a_last.imag * a.imag + b_last.real * b.real + b_last.imag * b.imag
        )
        a_before, b_before = a, b
    factor = 2.0 / size**2
    return np.stack([factor * extinction, factor * scattering, 2.0 * asymmetry / scattering])


_SPHERES_AT_ONCE = 1024
"""Number of spheres that share an angular grid; the largest sphere of a group sets the number of angles."""

_GRID_GROWTH = 1.15
"""Ratio of successive grid sizes; groups with needs between two sizes share a grid."""


def amplitudes(refractive_index: complex, size_parameter: float, mu: Array) -> tuple[ComplexArray, ComplexArray]:
    """Return the amplitudes S1 and S2 of one sphere at cosines ``mu`` (J,) of the scattering angle.

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
    """Return Mie coefficients (M, N) of spheres sorted by descending size, 0 beyond the last order of each."""
    rows = list(multipoles(index, size))
    a = np.zeros((size.size, len(rows)), dtype=np.complex128)
    b = np.zeros_like(a)
    for n, m, electric, magnetic in rows:
        a[:m, n - 1], b[:m, n - 1] = electric, magnetic
    return a, b


def _angular(mu: Array, orders: int) -> tuple[Array, Array]:
    """Return (2n + 1)/(n(n + 1)) times pi_n + tau_n and pi_n - tau_n, (orders, J) each.

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
    """Return P_l(mu) for l = 0 to count - 1, (count, J)."""
    result = np.empty((count, mu.size))
    before, current = np.zeros_like(mu), np.ones_like(mu)
    for degree in range(count):
        result[degree] = current
        before, current = current, ((2 * degree + 1) * mu * current - degree * before) / (degree + 1)
    return result


def phase_function(moments: Array, mu: Array) -> Array:
    """Return the phase function (J, V) for moments (K, V) at cosines ``mu`` (J,), normalised to a mean of 1."""
    degree = np.arange(moments.shape[0])
    result: Array = legendre_polynomials(mu, degree.size).T @ ((2 * degree + 1)[:, np.newaxis] * moments)
    return result


class MomentSums:
    """Legendre moments of scattered light, summed over spheres.

    Parameters
    ----------
    count : int
        Number K of moments.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._grids: dict[int, tuple[Array, Array, Array, int]] = {}

    def __call__(self, refractive_index: complex, size_parameter: Array, weight: Array) -> Array:
        """Return the moments (K,) of the combined phase function of spheres with ``size_parameter``, ``weight`` (M,).

        ``weight`` is the number of each; the scattered light follows from the amplitudes. The result is normalised by
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
        """Return angular functions and the Legendre projection for at least ``orders`` multipoles."""
        step = int(np.ceil(np.log(orders) / np.log(_GRID_GROWTH)))
        if step not in self._grids:
            most = int(np.ceil(_GRID_GROWTH**step)) + 1
            # Exact for the product of the intensity, of degree 2 * most, and the last Legendre polynomial.
            mu, weight = np.polynomial.legendre.leggauss(most + self._count // 2 + 1)
            plus, minus = _angular(mu, most)
            self._grids[step] = plus, minus, legendre_polynomials(mu, self._count) * weight, most
        return self._grids[step]
