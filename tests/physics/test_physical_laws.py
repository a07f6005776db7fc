"""Laws of radiation that the physical model keeps with any providers."""

import dataclasses

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.laws.radiance import LawScene
from hcss_twin.laws.samples import (
    PlainGas,
    PlainOptics,
    PlainSea,
    sample_high_layer,
    sample_layer,
    sample_radiance_inputs,
)
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical import slab_operators
from hcss_twin.models.radiance.physical.model import Physical, PhysicalTwoStream
from hcss_twin.models.radiance.physical.operator_table import OperatorTable, thickness_grid
from hcss_twin.models.radiance.spectral_grid import SolarSpectrum
from hcss_twin.physics.planck import planck
from hcss_twin.providers import AtmosphereInputs, ColumnStates, OpticsInputs, SeaInputs, Sun, View
from hcss_twin.providers.column_states import spectra_of
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind

NU = np.array([800.0, 1000.0, 1200.0, 2200.0, 2600.0, 3500.0])
ENCLOSURE_K = 285.0
ONE_LAYER = np.array([[50.0], [200.0], [800.0]])
TWO_LAYERS = np.array([[100.0, 300.0], [800.0, 2000.0], [0.0, 500.0], [60.0, 0.0]])


def made(kind, name, inputs, **parameters):
    registry = Registry.defaults_only()
    entry = registry.resolve(kind, name)
    return registry.create(entry, inputs, registry.parameters_model(entry)(**parameters))


def profile_at(temperature_K):
    profile = load_profile("us-standard-1976", Catalog())
    if temperature_K is None:
        return profile
    return dataclasses.replace(profile, temperature_K=np.full_like(profile.temperature_K, temperature_K))


def gas(name, profile):
    if name == "plain":
        return PlainGas(profile)
    return made(Kind.ATMOSPHERE, name, AtmosphereInputs(profile, Catalog()))


def sea(name, wind=8.0):
    if name == "plain":
        return PlainSea()
    name, _, slopes = name.partition(" ")
    parameters = {"slopes": slopes} if slopes else {}
    return made(Kind.SEA, name, SeaInputs(wind, 270.0, ENCLOSURE_K, Catalog()), **parameters)


def optics(name):
    return PlainOptics() if name == "plain" else made(Kind.OPTICS, name, OpticsInputs(Catalog()))


def scene(profile, gas_name="plain", sea_name="plain", optics_name="plain", zenith=30.0, layers=1, sea_K=ENCLOSURE_K):
    inputs = with_setting(
        sample_radiance_inputs(profile, (sample_layer(), sample_high_layer())[:layers]),
        transmittance=gas(gas_name, profile),
        sea=sea(sea_name),
        sea_temperature_K=sea_K,
        view=View(zenith, 40.0),
    )
    return dataclasses.replace(inputs, optics=optics(optics_name), wind_from_deg=270.0)


def with_setting(inputs, **changes):
    return dataclasses.replace(inputs, setting=dataclasses.replace(inputs.setting, **changes))


def physical(inputs, **parameters):
    return LawScene(Physical(inputs, PhysicalParameters(**parameters)), inputs.setting)


def total(terms):
    return np.sum(list(terms.values()), axis=0)


def departure(scene, thickness):
    black = planck(NU, ENCLOSURE_K)
    return max(
        np.abs(total(scene.clear(NU)) / black - 1.0).max(),
        np.abs(total(scene.cloudy(NU, thickness)) / black - 1.0).max(),
    )


GASES = ("plain", "band-model")
SEAS = ("plain", "cox-munk", "rough-sea", "rough-sea gram-charlier")
OPTICS = ("plain", "mie", "bulk")
ZENITHS_DEG = (0.0, 55.0, 80.0)

# Every two choices meet: zeniths alternate over each row and column of seas and optics, and gases over their sums.
PAIRWISE = [
    (GASES[(i + j) % 2], sea_name, optics_name, ZENITHS_DEG[(i + j) % 3])
    for i, sea_name in enumerate(SEAS)
    for j, optics_name in enumerate(OPTICS)
]


@pytest.mark.parametrize(("gas_name", "sea_name", "optics_name", "zenith"), PAIRWISE)
def test_an_isothermal_enclosure_is_black(gas_name, sea_name, optics_name, zenith):
    inputs = scene(profile_at(ENCLOSURE_K), gas_name, sea_name, optics_name, zenith)
    assert departure(physical(inputs, space_temperature=ENCLOSURE_K, streams=4), ONE_LAYER) < 1e-9


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("model", [Physical, PhysicalTwoStream])
def test_an_enclosure_with_two_layers_is_black(order, model):
    inputs = scene(profile_at(ENCLOSURE_K), "band-model", "rough-sea", "plain", 40.0, layers=2)
    parameters = PhysicalParameters(space_temperature=ENCLOSURE_K, closure_order=order, streams=4)
    assert departure(LawScene(model(inputs, parameters), inputs.setting), TWO_LAYERS) < 1e-9


@pytest.mark.parametrize("sun", [None, Sun(40.0, 200.0, 1.0)])
def test_a_cloud_that_vanishes_leaves_clear_sky(sun):
    layer = dataclasses.replace(sample_layer(), thickness_min_m=1e-3)
    tested = physical(with_setting(scene(profile_at(None), "band-model", "rough-sea", "bulk"), layers=(layer,)))
    clear = total(tested.clear(NU, sun))
    thin = total(tested.cloudy(NU, np.array([[1e-3], [1e-2]]), sun))
    # One hundredth of a metre has an optical thickness of 2e-4.
    np.testing.assert_allclose(thin[0], clear, rtol=1e-4)
    np.testing.assert_allclose(thin[0] - clear, (thin[1] - clear) / 10.0, rtol=0.05, atol=1e-7 * clear.max())


@pytest.mark.parametrize(
    ("bases_m", "zenith", "allowed"),
    [((600.0,), 50.0, 1.5e-4), ((600.0,), 62.0, 1.5e-4), ((1400.0, 3500.0), 63.0, 3e-4)],
)
def test_one_exact_change_of_direction_is_enough(bases_m, zenith, allowed):
    """With all legs behind the view's path to the lower end of their gap, it left 1.6, 2.4 and 4.8e-4."""
    layers = tuple(dataclasses.replace(sample_layer(), base_m=base, top_m=base + 800.0) for base in bases_m)
    inputs = with_setting(scene(profile_at(None), "band-model", "rough-sea", "bulk", zenith), layers=layers)
    thickness_m = np.repeat([[15.0], [100.0], [800.0]], len(layers), axis=1)
    one, two = (total(physical(inputs, closure_order=order).cloudy(NU, thickness_m)) for order in (1, 2))
    np.testing.assert_allclose(one, two, rtol=allowed)


def test_more_streams_change_little():
    inputs = scene(profile_at(None), "band-model", "rough-sea", "bulk", 20.0)
    sun = Sun(40.0, 200.0, 1.0)
    eight, sixteen = (total(physical(inputs, streams=count).cloudy(NU, ONE_LAYER, sun)) for count in (8, 16))
    np.testing.assert_allclose(eight, sixteen, rtol=5e-3)


def test_terms_that_are_left_out_are_0_and_the_others_stay():
    inputs = scene(profile_at(None), "plain", "rough-sea", "bulk")
    sun = Sun(40.0, 200.0, 1.0)
    whole = physical(inputs).cloudy(NU, ONE_LAYER, sun)
    name = "reflected_air_emission"
    some = physical(inputs, leave_out=(name,)).cloudy(NU, ONE_LAYER, sun)
    assert not np.any(some[name])
    for other in set(whole) - {name}:
        np.testing.assert_array_equal(some[other], whole[other])


def test_water_cloud_is_bright_by_day_at_3_7_um_and_cirrus_dark():
    nu = np.array([2700.0])
    night = dataclasses.replace(
        scene(profile_at(None), "band-model", "rough-sea", "bulk", sea_K=291.4),
        solar_irradiance=SolarSpectrum(Catalog()),
    )
    high = with_setting(night, layers=(sample_high_layer(),))
    sun = Sun(30.0, 200.0, 1.0)
    clear = total(physical(night).clear(nu, sun))
    water = total(physical(night).cloudy(nu, np.array([[800.0]]), sun))
    ice = total(physical(high).cloudy(nu, np.array([[2000.0]]), sun))
    assert water[0] > 1.3 * clear
    assert ice[0] < 0.8 * clear


def test_a_white_cloud_gives_back_all_sunlight():
    # Without air, and of optical thickness 8000: the flux over all views is what arrives.
    profile = profile_at(None)
    inputs = with_setting(scene(profile), transmittance=PlainGas(profile, 0.0))
    inputs = dataclasses.replace(inputs, optics=PlainOptics(1e-7, 1.0, 0.8))
    cosine, weight = np.polynomial.legendre.leggauss(4)
    mu, weight = 0.5 * (cosine + 1.0), 0.5 * weight
    flux = 0.0
    sun = Sun(60.0, 0.0, 1.0)
    for m, w in zip(mu, weight, strict=True):
        for azimuth in (30.0, 90.0, 150.0):
            view = View(float(np.degrees(np.arccos(m))), float(azimuth))
            terms = physical(with_setting(inputs, view=view)).cloudy(NU[5:], np.array([[800.0]]), sun)
            flux += 2.0 * np.pi * m * w * terms["cloud_reflected_sun"][0, 0] / 3.0
    assert flux == pytest.approx(0.01 * 0.5, rel=0.01)


def test_a_table_of_operators_gives_back_smooth_functions_and_row_sums():
    grid = thickness_grid(10.0, 3000.0, 3)
    direct = np.exp(-grid / 300.0)
    table = OperatorTable(grid, (direct[:, None], (1.0 - direct)[:, None]), 3)
    for thickness in (10.0, 11.7, 299.0, 3000.0):
        assert table.least_m <= thickness <= table.most_m
        through, rest = (float(each[0]) for each in table.at(thickness))
        assert through == pytest.approx(np.exp(-thickness / 300.0), rel=1e-6)
        assert through + rest == pytest.approx(1.0, abs=1e-14)


def test_sunlight_by_table_is_that_of_each_thickness_also_toward_grazing_views():
    """Many streams are solved at two thicknesses per octave; with one, thin clouds erred by 2e-3 at 84 deg."""
    layer = dataclasses.replace(sample_layer(), base_m=1100.0, top_m=1690.0, thickness_min_m=6.0)
    inputs = scene(profile_at(None), optics_name="bulk", zenith=84.0)
    inputs = dataclasses.replace(with_setting(inputs, layers=(layer,)), numerical_level=6)
    thickness, sun = np.geomspace(6.0, 590.0, 7)[:, None], Sun(50.0, 100.0, 1.0)
    tabled = physical(inputs).cloudy(NU[3:], thickness, sun)
    alone = physical(inputs).cloudy(NU[3:], thickness[:3], sun)
    np.testing.assert_allclose(tabled["cloud_reflected_sun"][:3], alone["cloud_reflected_sun"], rtol=3e-5)


@pytest.mark.parametrize(("gas_name", "order"), [("plain", 0), ("band-model", 1)])
def test_a_column_is_the_same_whatever_was_asked_for_before(gas_name, order):
    """Seas, legs and scattered sunlight are kept and shared by columns, suns on either side of the wind among them."""
    inputs = scene(profile_at(None), gas_name, "rough-sea upwind-crosswind", "plain", 50.0, layers=2)
    parameters = {"closure_order": order, "streams": 2, "sun_streams": 2, "azimuth_modes": 3}
    suns = [Sun(40.0, 200.0, 1.0), None, Sun(65.0, 30.0, 0.99)]
    columns = np.array([[100.0, 300.0], [0.0, 500.0]])
    used = physical(inputs, **parameters)
    for sun in suns:
        used.clear(NU, sun)
        used.cloudy(NU, columns[::-1], sun)
    for sun in suns:
        alone = physical(inputs, **parameters)
        for row, column in enumerate(columns):
            found = total(used.cloudy(NU, columns, sun))[row]
            np.testing.assert_allclose(found, total(alone.cloudy(NU, column[None], sun))[0], rtol=1e-12)
        np.testing.assert_allclose(
            total(used.clear(NU, sun)), total(physical(inputs, **parameters).clear(NU, sun)), rtol=1e-12
        )


def test_suns_in_one_call_change_nothing_but_the_number_of_solutions(monkeypatch):
    """By reciprocity, suns are directions toward which light from the view is scattered: one solution serves all."""
    inputs = scene(profile_at(None), "plain", "rough-sea", "plain", 50.0)
    suns = [Sun(40.0, 200.0, 1.0), Sun(40.5, 203.0, 1.0), Sun(65.0, 30.0, 0.99)]
    solved, solve = [], slab_operators.solve_sun
    monkeypatch.setattr(
        slab_operators, "solve_sun", lambda *what, **how: solved.append(what[0].shape) or solve(*what, **how)
    )
    for thickness in (np.array([[120.0]]), np.geomspace(50.0, 900.0, 6)[:, None]):
        solved.clear()
        settings = [inputs.setting.under(sun) for sun in (*suns, None)]
        found = spectra_of(physical(inputs).model, settings, NU, thickness).sum(axis=2)
        assert len(solved) == 1
        for sun, values in zip((*suns, None), found, strict=True):
            alone = total(physical(inputs).cloudy(NU, thickness, sun))
            np.testing.assert_allclose(values, alone, rtol=1e-6)
        assert len(solved) == 4


@pytest.mark.parametrize("sun", [None, Sun(40.0, 200.0, 1.0)])
@pytest.mark.parametrize("model", [Physical, PhysicalTwoStream])
def test_columns_over_other_seas_and_in_other_air_in_one_call_are_those_of_each_alone(model, sun):
    """More settings than a model keeps, and columns in no order."""
    inputs = scene(profile_at(None), "plain", "rough-sea", "plain", 50.0)
    own = inputs.setting.under(sun)
    cold = profile_at(250.0)
    settings = [
        own,
        *(dataclasses.replace(own, sea_temperature_K=kelvin) for kelvin in (284.0, 285.1, 291.0)),
        dataclasses.replace(own, sea=PlainSea(0.9)),
        dataclasses.replace(own, profile=cold, transmittance=PlainGas(cold)),
        dataclasses.replace(own, layers=(sample_layer().hanging_from(3000.0),)),
        dataclasses.replace(own, view=View(10.0, 40.0), sea=PlainSea(0.9)),
    ]
    parameters = PhysicalParameters(streams=4, sun_streams=4, azimuth_modes=4)
    thickness = np.array([[0.0], [120.0], [700.0]])
    ordered = ColumnStates.product(settings, thickness)
    shuffled = np.random.default_rng(5).permutation(len(ordered))
    states = ColumnStates(ordered.settings, ordered.setting_of[shuffled], ordered.thickness_m[shuffled])
    together = model(inputs, parameters).columns(states, NU)
    for number, setting in enumerate(settings):
        alone = model(dataclasses.replace(inputs, setting=setting.under(None)), parameters)
        for row, depth in enumerate(thickness):
            (place,) = np.flatnonzero(shuffled == number * len(thickness) + row)
            exact = LawScene(alone, setting).cloudy(NU, depth[None], sun)
            for name, values in exact.items():
                np.testing.assert_allclose(together[name][place], values[0], rtol=1e-9, atol=1e-18, err_msg=name)


def test_a_few_thicknesses_without_a_grid_equal_those_interpolated_on_it():
    inputs = scene(profile_at(None), "plain", "rough-sea", "plain", 50.0)
    sun, thickness = Sun(40.0, 200.0, 1.0), np.geomspace(60.0, 800.0, 5)[:, None]
    grid = total(physical(inputs).cloudy(NU, thickness, sun))
    for row, few in enumerate(thickness):
        exact = total(physical(inputs).cloudy(NU, few[None], sun))[0]
        np.testing.assert_allclose(grid[row], exact, rtol=1e-5)


def test_seas_are_asked_for_what_they_emit_once_for_all_suns(monkeypatch):
    inputs = scene(profile_at(None), "band-model", "rough-sea", "bulk")
    asked, own = [], inputs.setting.sea
    emissivity = own.emissivity
    monkeypatch.setattr(own, "emissivity", lambda *what: asked.append(what) or emissivity(*what), raising=False)
    tested = physical(inputs, streams=2, sun_streams=2, azimuth_modes=3)
    for zenith in (None, 30.0, 40.0, 50.0, 60.0, 70.0):
        sun = None if zenith is None else Sun(zenith, 200.0, 1.0)
        tested.clear(NU, sun)
    tested.cloudy(NU, ONE_LAYER[:1], sun)
    # Clear sky needs the light toward the view alone, clouds also that toward the streams.
    assert [cosines.size for _, cosines in asked] == [1, 3]
