"""Layers are sorted into chains of doublings, and none is lost."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcss_twin.physics.multiple_scattering.chains import chains
from hcss_twin.physics.multiple_scattering.doubling import solve_chains
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun


def of(thickness):
    return chains(thickness, np.ones(thickness.shape, dtype=bool))


def test_halves_of_a_layer_are_one_chain_for_each_wavenumber() -> None:
    found = of(np.outer(0.7 * 0.5 ** np.arange(5), [1.0, 3.0, 1.7]))
    np.testing.assert_array_equal(found.first, [0, 5, 10, 15])
    np.testing.assert_array_equal(found.doublings, [0, 1, 1, 1, 1] * 3)
    for start in found.first[:-1]:
        members = np.s_[start : start + 5]
        assert np.all(np.diff(found.thickness[members]) > 0.0)
        assert np.unique(found.column[members]).size == 1


def test_families_may_differ_from_one_wavenumber_to_the_next() -> None:
    found = of(np.array([[1.0, 1.0], [4.0, 3.0], [3.0, 6.0]]))
    sizes = sorted(zip(np.diff(found.first), found.column[found.first[:-1]], strict=True))
    assert sizes == [(1, 0), (1, 1), (2, 0), (2, 1)]


@pytest.mark.parametrize(("factor", "members"), [(1 + 1e-13, 1), (1 - 1e-13, 1), (1 + 1e-11, 2), (1 - 1e-11, 2)])
def test_a_family_allows_rounding_and_no_more(factor, members) -> None:
    # 8 is a power of 2: just below it the exponent is another.
    for thickest in (8.0, 5.3):
        assert of(np.array([[1.0 / 8.0 * thickest], [thickest * factor]])).first.size - 1 == members


@settings(deadline=None, max_examples=50)
@given(
    st.lists(st.one_of(st.just(0.0), st.floats(1e-300, 1e6), st.sampled_from([0.3, 0.6, 2.4])), max_size=12),
    st.integers(1, 3),
)
def test_every_layer_is_in_one_chain(values, columns) -> None:
    thickness = np.resize(np.array(values), (len(values) // columns, columns))
    found = of(thickness)
    np.testing.assert_array_equal(np.sort(found.cell), np.arange(thickness.size))
    np.testing.assert_array_equal(thickness.ravel()[found.cell], found.thickness)
    np.testing.assert_array_equal(found.wavenumber[found.column], found.cell % columns)
    for start, stop in zip(found.first[:-1], found.first[1:], strict=True):
        steps = np.cumsum(found.doublings[start:stop])
        np.testing.assert_allclose(found.thickness[start:stop], found.thickness[start] * 2.0**steps, rtol=1e-11)


def test_only_layers_that_are_wanted_are_in_chains() -> None:
    wanted = np.array([[True, False], [False, False], [True, False]])
    found = chains(np.array([[1.0, 1.0], [2.0, 2.0], [4.0, 4.0]]), wanted)
    np.testing.assert_array_equal(found.cell, [0, 4])
    np.testing.assert_array_equal(found.doublings, [0, 2])
    np.testing.assert_array_equal(found.wavenumber, [0])


def test_one_compiled_program_solves_every_kind_of_input() -> None:
    moments = np.array([[1.0, 1.0], [0.8, 0.7]])
    tau = np.asfortranarray([[1.0, 2.0], [3.0, 4.0]])
    for thickness in (tau, tau[::-1], np.broadcast_to(1.0, (3, 2)), tau.astype(np.float32)):
        for albedo in (np.broadcast_to(0.9, 2), np.array([0.9, 0.0, 0.8])[::2]):
            solve_layers(thickness, albedo, moments, [1.0], 2)
            solve_layers(thickness[:, :1], albedo[:1], moments[:, :1], [], 2)
            solve_sun(thickness, albedo, moments[:, ::-1], [1.0], 0.5, [0.0], 2, 4)
            solve_sun(thickness[:, :1], albedo[:1], moments[:, :1], [1.0], 0.5, [0.0], 2, 1)
    assert len(solve_chains.signatures) == 1
