"""Few weighted wavenumbers sum spectra as all of them do."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid


def band(name, lower, upper):
    return SpectralBand(name, np.array([lower, upper]), np.ones(2))


@pytest.fixture(scope="module")
def grid():
    return SpectralGrid.dense([band("mwir", 3.0, 5.0), band("lwir", 8.0, 14.0)], None)


def gas_spectra(grid, amounts, seed=0):
    """Two sources of different colour behind gas with a line-like spectrum: (S, 2, V)."""
    random = np.random.default_rng(seed)
    absorption = 10.0 ** random.uniform(-3, 2, grid.wavenumber_cm1.size)
    colour = np.exp(-grid.wavenumber_cm1 / 800.0), np.exp(-grid.wavenumber_cm1 / 2000.0)
    through = np.exp(-absorption * np.asarray(amounts)[:, None])
    return np.stack([through * colour[0], (1.0 - through) * colour[1]], axis=1)


def sums(grid, nodes, spectra):
    kept = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
    return spectra[..., kept] @ nodes.weights_cm1.T


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-5, 1e-7])
def test_every_term_it_knows_is_summed_within_the_tolerance_of_the_total(grid, tolerance):
    spectra = gas_spectra(grid, np.geomspace(1e-2, 1e2, 12))
    nodes = grid.choose_nodes(spectra, tolerance)
    exact = spectra @ grid.weights_cm1.T
    error = np.abs(sums(grid, nodes, spectra) - exact) / exact.sum(axis=1, keepdims=True)
    assert np.max(error) <= tolerance


def test_unknown_amounts_between_those_known_are_summed_too(grid):
    nodes = grid.choose_nodes(gas_spectra(grid, np.geomspace(1e-2, 1e2, 24)), 1e-5)
    between = gas_spectra(grid, np.geomspace(1.3e-2, 80.0, 31))
    exact = between.sum(axis=1) @ grid.weights_cm1.T
    found = sums(grid, nodes, between).sum(axis=1)
    np.testing.assert_allclose(found, exact, rtol=1e-4)
    assert nodes.wavenumber_cm1.size < 0.2 * grid.wavenumber_cm1.size


def test_weights_are_not_negative_and_belong_to_the_band(grid):
    nodes = grid.choose_nodes(gas_spectra(grid, [0.1, 1.0, 10.0]), 1e-4)
    assert np.all(nodes.weights_cm1 >= 0)
    for row, (low, high) in enumerate([(2000.0, 1e4 / 3.0), (1e4 / 14.0, 1250.0)]):
        inside = (nodes.wavenumber_cm1 >= low - 1e-6) & (nodes.wavenumber_cm1 <= high + 1e-6)
        assert not np.any(nodes.weights_cm1[row, ~inside])


def test_a_stricter_tolerance_takes_more_wavenumbers(grid):
    spectra = gas_spectra(grid, np.geomspace(1e-2, 1e2, 24))
    sizes = [grid.choose_nodes(spectra, t).wavenumber_cm1.size for t in (1e-1, 1e-2, 1e-4, 1e-6)]
    assert sizes == sorted(sizes)
    assert sizes[0] < sizes[-1]


def test_spectra_that_have_nothing_in_common_take_every_wavenumber():
    narrow = SpectralGrid.dense([band("narrow", 10.0, 10.02)], None)
    size = narrow.wavenumber_cm1.size
    spectra = np.eye(size)[:, None, :]
    nodes = narrow.choose_nodes(spectra, 1e-6)
    np.testing.assert_array_equal(nodes.wavenumber_cm1, narrow.all_nodes().wavenumber_cm1)
    np.testing.assert_allclose(nodes.weights_cm1, narrow.weights_cm1, rtol=1e-12)


def test_darkness_keeps_every_wavenumber(grid):
    nodes = grid.choose_nodes(np.zeros((3, 2, grid.wavenumber_cm1.size)), 1e-3)
    np.testing.assert_array_equal(nodes.wavenumber_cm1, grid.wavenumber_cm1)
    np.testing.assert_array_equal(nodes.weights_cm1, grid.weights_cm1)


@pytest.mark.parametrize("faint", [1e-3, 1e-8])
def test_a_bright_line_at_a_band_edge_is_not_lost_for_a_faint_continuum(grid, faint):
    spectra = np.full((2, 1, grid.wavenumber_cm1.size), faint)
    spectra[1, 0, grid.nodes[0][0]] = 1.0
    nodes = grid.choose_nodes(spectra, 1e-4)
    np.testing.assert_allclose(sums(grid, nodes, spectra), spectra @ grid.weights_cm1.T, rtol=1e-4)
