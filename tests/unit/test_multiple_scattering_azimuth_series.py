"""Where azimuth series of layers end."""

import numpy as np

from hcss_twin.physics.multiple_scattering.sunlight import AzimuthSeries


def test_a_series_ends_where_two_modes_in_succession_are_small_and_the_last_one_ends_all():
    series = AzimuthSeries(np.array([[1.0, 3.0, 5.0]]))
    small = np.array([True, True, False])
    assert not series.end_where(small[series.chains.cell])
    # The second is not small again, so that it counts anew.
    small = np.array([True, False, True])
    assert not series.end_where(small[series.chains.cell])
    assert sorted(series.chains.cell) == [1, 2]
    small = np.array([False, True, True])
    assert not series.end_where(small[series.chains.cell])
    assert sorted(series.chains.cell) == [1]
    assert series.end_where(small[series.chains.cell])


def test_layers_of_which_no_mode_is_small_go_on():
    series = AzimuthSeries(np.array([[1.0, 2.0], [3.0, 4.0]]))
    for _ in range(5):
        assert not series.end_where(np.zeros(series.chains.cell.size, dtype=bool))
    assert sorted(series.chains.cell) == [0, 1, 2, 3]
