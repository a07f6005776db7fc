"""States of columns: which settings are the same, which rows are theirs, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from hcss_twin.laws.samples import sample_high_layer, sample_layer, sample_radiance_inputs
from hcss_twin.providers import ColumnStates, Sun, View, clear_column, cloudy_columns
from hcss_twin.providers.column_states import spectra_of

NIGHT = sample_radiance_inputs(layers=(sample_layer(), sample_high_layer())).setting
DAY = NIGHT.under(Sun(40.0, 200.0, 1.0))
NU = np.array([800.0, 1000.0, 2500.0])
THICKNESS = np.array([[0.0, 0.0], [60.0, 0.0], [0.0, 500.0], [90.0, 700.0]])


class Sums:
    """Radiance is the sum of thicknesses in km, times the wavenumber in m-1, and 100 more by day."""

    terms = {"clouds": "", "sun": ""}  # noqa: RUF012

    def __init__(self):
        self.calls = 0

    def columns(self, states, wavenumber_cm1):
        self.calls += 1
        result = states.empty(self.terms, wavenumber_cm1)
        for rows, setting, thickness_m in states.groups():
            result["clouds"][rows] = np.outer(thickness_m.sum(axis=1), wavenumber_cm1) / 10.0
            result["sun"][rows] = 0.0 if setting.sun is None else 100.0
        return result


@pytest.mark.parametrize(
    "changes",
    [
        {"view": View(10.0, 20.0)},
        {"sun": Sun(40.0, 200.0, 1.01)},
        {"sun": None},
        {"sea_temperature_K": 291.0},
        {"sea": sample_radiance_inputs().setting.sea},
        {"profile": sample_radiance_inputs().setting.profile},
        {"transmittance": sample_radiance_inputs().setting.transmittance},
        {"layers": (sample_layer(0.7), sample_high_layer())},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_settings_are_equal_if_they_have_the_same_providers_and_values(changes):
    same = replace(DAY, view=View(DAY.view.zenith_deg, DAY.view.azimuth_deg), layers=tuple(DAY.layers))
    assert same == DAY
    assert hash(same) == hash(DAY)
    assert replace(DAY, **changes) != DAY
    assert len({DAY, same, replace(DAY, **changes)}) == 2


def test_under_another_sun_all_else_is_the_same():
    assert DAY.under(DAY.sun) is DAY
    assert DAY.under(None) == NIGHT
    assert NIGHT.under(DAY.sun) == DAY


def test_groups_have_each_column_once_with_its_own_setting():
    settings, setting_of = (DAY, NIGHT, replace(DAY, view=View(0.0, 0.0))), np.array([2, 0, 2, 0])
    states, seen = ColumnStates(settings, setting_of, THICKNESS), []
    for rows, setting, thickness_m in states.groups():
        np.testing.assert_array_equal(thickness_m, THICKNESS[rows])
        assert all(settings[setting_of[row]] is setting for row in rows)
        seen += rows.tolist()
    assert sorted(seen) == [0, 1, 2, 3]
    assert len(states) == 4


def test_products_have_each_thickness_in_each_setting_and_equal_settings_are_one():
    states = ColumnStates.product([DAY, NIGHT, DAY.under(Sun(40.0, 200.0, 1.0))], THICKNESS)
    assert states.settings == (DAY, NIGHT)
    np.testing.assert_array_equal(states.setting_of, np.repeat([0, 1, 0], 4))
    np.testing.assert_array_equal(states.thickness_m, np.tile(THICKNESS, (3, 1)))


def test_helpers_give_what_one_call_gives_in_their_shapes():
    model = Sums()
    spectra = spectra_of(model, [NIGHT, DAY], NU, THICKNESS)
    assert model.calls == 1
    assert spectra.shape == (2, 4, 2, 3)
    np.testing.assert_array_equal(spectra[:, :, 0], np.outer(THICKNESS.sum(axis=1), NU)[None].repeat(2, 0) / 10.0)
    np.testing.assert_array_equal(spectra[:, :, 1], np.full((2, 4, 3), [[[0.0]], [[100.0]]]))
    for number, setting in enumerate((NIGHT, DAY)):
        clear, cloudy = clear_column(model, setting, NU), cloudy_columns(model, setting, NU, THICKNESS)
        for place, name in enumerate(model.terms):
            np.testing.assert_array_equal(clear[name], spectra[number, 0, place])
            np.testing.assert_array_equal(cloudy[name], spectra[number, :, place])


@pytest.mark.parametrize("settings", [[], [DAY]])
def test_no_columns_ask_for_nothing(settings):
    model = Sums()
    rows = THICKNESS[:0] if settings else THICKNESS
    assert spectra_of(model, settings, NU, rows).shape == (len(settings), len(rows), 2, 3)
    assert model.calls == 0


@pytest.mark.parametrize(
    ("settings", "setting_of", "thickness_m", "message"),
    [
        ((DAY,), [0], [[-1.0, 5.0]], "thickness_m: allowed finite numbers, 0 or more"),
        ((DAY,), [0], [[np.nan, 5.0]], "thickness_m: allowed finite numbers, 0 or more"),
        ((DAY,), [0], [[np.inf, 5.0]], "thickness_m: allowed finite numbers, 0 or more"),
        ((DAY,), [0], [[5.0]], r"thickness_m: shape \(1, 1\); allowed .* \(1, 2\)"),
        ((DAY,), [0], [5.0, 5.0], r"thickness_m: shape \(2,\); allowed .* \(1, 2\)"),
        ((DAY,), [0, 0], [[5.0, 5.0]], r"thickness_m: shape \(1, 2\); allowed .* \(2, 2\)"),
        ((DAY, replace(DAY, layers=())), [0], [[5.0, 5.0]], "thickness_m"),
        ((DAY, NIGHT), [2], [[5.0, 5.0]], "setting_of: allowed 0 to 1"),
        ((DAY, NIGHT), [-1], [[5.0, 5.0]], "setting_of: allowed 0 to 1"),
    ],
)
def test_states_that_are_none_are_refused(settings, setting_of, thickness_m, message):
    with pytest.raises(ValueError, match=message):
        ColumnStates(settings, np.array(setting_of), np.array(thickness_m))
