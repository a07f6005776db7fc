"""The kit refuses radiance models that break a law; it accepts those of ``tests/contract`` and of this package."""

import numpy as np
import pytest
from hcss_author import RadianceModelContract, sample_radiance_inputs, sample_wavenumbers

from hcss_twin.providers import RadianceDeclaration, Sun, to_space

NU = sample_wavenumbers(RadianceDeclaration())


def of_thickness(states):
    """Return exp(-thickness) (N, V) of the columns."""
    return np.exp(-np.sum(states.thickness_m, axis=1, keepdims=True) / 100.0)


def of_settings(states, value):
    """Return what ``value`` says of the setting of each column, (N, 1)."""
    return np.array([value(states.settings[number]) for number in states.setting_of])[:, None]


def lit(states):
    """Return 1 for columns with a sun and 0 for others, (N, 1)."""
    return of_settings(states, lambda setting: float(setting.sun is not None))


def is_clear(states):
    """Return whether columns have no cloud, (N, 1)."""
    return ~np.any(states.thickness_m, axis=1, keepdims=True)


class GreyModel:
    """Sea and clouds of radiance 1 at all wavenumbers, and a constant glint: for laws of form, not of size."""

    declares = RadianceDeclaration(depends_on=frozenset({"thickness"}))
    terms = {"surface": "emitted by the surface", "glint": "reflected sun"}  # noqa: RUF012
    solar_terms = frozenset({"glint"})

    def columns(self, states, wavenumber_cm1):
        ones = np.ones((len(states), wavenumber_cm1.size))
        return {"surface": ones * of_thickness(states), "glint": ones * lit(states)}


def model_kit(make=None, **changes):
    """Return a kit of grey models with other members, the model for the sample inputs, and these."""

    class Kit(RadianceModelContract):
        def make_provider(self, inputs):
            model = GreyModel() if make is None else make(inputs)
            vars(model).update(changes)
            return model

    inputs = sample_radiance_inputs()
    return Kit(), Kit().make_provider(inputs), inputs


def answering(surface, glint=lambda states, nu: 0.0):
    """Return ``columns`` with the terms of two functions of states and wavenumbers."""

    def columns(states, wavenumber_cm1):
        ones = np.ones((len(states), wavenumber_cm1.size))
        return {"surface": ones * surface(states, wavenumber_cm1), "glint": ones * glint(states, wavenumber_cm1)}

    return columns


SUN = Sun(40.0, 200.0, 1.0)
SETTING = sample_radiance_inputs().setting.under(SUN)


def test_the_kit_accepts_the_grey_model():
    kit, model, inputs = model_kit()
    kit.test_declaration_is_sound(model)
    kit.test_no_sun_no_solar_term(model, inputs, NU)
    kit.test_undeclared_thickness_and_sun_have_no_influence(model, inputs, NU)
    for law in ("every_term_of_every_column", "result_does_not_depend_on_batching"):
        getattr(kit, f"test_{law}")(model, SETTING, NU)
    kit.test_result_does_not_depend_on_other_wavenumbers(model, SETTING, NU)
    kit.test_columns_are_those_of_their_settings(model, inputs, SETTING, NU)
    kit.test_clear_columns_do_not_depend_on_the_layers(model, inputs, SETTING, NU)
    kit.test_columns_of_two_layers(model, SETTING, NU)
    kit.test_a_layer_without_cloud_has_no_influence(model, inputs, SETTING, NU)


@pytest.mark.parametrize("clear", [True, False])
def test_kit_refuses_solar_terms_without_a_sun(clear):
    """Also if only columns without cloud have them, or only cloudy ones."""
    kit, model, inputs = model_kit(
        columns=answering(lambda states, nu: 1.0, lambda states, nu: 1e-12 * (is_clear(states) == clear))
    )
    with pytest.raises(AssertionError):
        kit.test_no_sun_no_solar_term(model, inputs, NU)


def clear_sky(value):
    """Return ``columns`` whose clear sky has another ``surface``."""
    return answering(lambda states, nu: np.where(is_clear(states), value(nu), 1.0), lambda states, nu: 0.5)


@pytest.mark.parametrize(
    ("law", "columns"),
    [
        ("every_term_of_every_column", lambda states, nu: {"surface": np.ones((len(states), nu.size))}),
        (
            "every_term_of_every_column",
            lambda states, nu: {"surface": np.ones(nu.size), "glint": np.ones((len(states), nu.size))},
        ),
        ("every_term_of_every_column", answering(lambda states, nu: np.where(is_clear(states), 1.0, np.nan))),
        ("every_term_of_every_column", clear_sky(lambda nu: np.inf)),
        ("every_term_of_every_column", clear_sky(lambda nu: -1.0)),
        ("every_term_of_every_column", answering(lambda states, nu: is_clear(states) - 1e-9)),
        (
            "result_does_not_depend_on_batching",
            answering(lambda states, nu: states.thickness_m / np.max(states.thickness_m, initial=1.0)),
        ),
        ("result_does_not_depend_on_batching", answering(lambda states, nu: states.settings[0].view.zenith_deg)),
        ("result_does_not_depend_on_batching", answering(lambda states, nu: states.settings[0].sun.zenith_deg)),
        ("result_does_not_depend_on_batching", answering(lambda states, nu: states.settings[-1].sea_temperature_K)),
        (
            "result_does_not_depend_on_batching",
            answering(lambda states, nu: states.settings[-1].profile.temperature_at(0.0)),
        ),
        ("result_does_not_depend_on_other_wavenumbers", clear_sky(lambda nu: nu / np.max(nu))),
        (
            "result_does_not_depend_on_other_wavenumbers",
            answering(lambda states, nu: np.where(is_clear(states), 1.0, nu / np.sum(nu))),
        ),
    ],
)
def test_kit_refuses_a_radiance_model_that_breaks_a_law(law, columns):
    kit, model, _ = model_kit(columns=columns)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(model, SETTING, NU)


@pytest.mark.parametrize(
    "read",
    [
        lambda setting: setting.view.azimuth_deg,
        lambda setting: setting.sea_temperature_K,
        lambda setting: float(setting.sea.emissivity(NU, np.ones(1))[0, 0]),
        lambda setting: float(setting.profile.temperature_at(3000.0)),
        lambda setting: float(setting.transmittance.transmittance(NU, [to_space(0.0, 0.0)])[0, 0]),
        lambda setting: setting.layers[0].top_m,
    ],
    ids=["view", "sea temperature", "sea", "profile", "transmittance", "layers"],
)
def test_kit_refuses_a_model_that_reads_its_inputs_in_place_of_states(read):
    """Each column alone, and each among others, has the same wrong value."""

    class OfInputs(GreyModel):
        def __init__(self, inputs):
            self.read = read(inputs.setting)

        def columns(self, states, wavenumber_cm1):
            return answering(lambda states, nu: self.read)(states, wavenumber_cm1)

    kit, model, inputs = model_kit(OfInputs)
    kit.test_result_does_not_depend_on_batching(model, SETTING, NU)
    with pytest.raises(AssertionError):
        kit.test_columns_are_those_of_their_settings(model, inputs, SETTING, NU)


@pytest.mark.parametrize(
    "answer",
    [
        lambda states: np.max(states.thickness_m, axis=1, keepdims=True),
        lambda states: of_settings(states, lambda setting: setting.sun.zenith_deg),
        lambda states: of_settings(states, lambda setting: setting.sun.azimuth_deg),
    ],
    ids=["thickness", "sun_zenith", "relative_azimuth"],
)
def test_kit_refuses_an_undeclared_dependence_of_a_radiance_model(answer):
    undeclared = RadianceDeclaration(depends_on=frozenset())
    kit, model, inputs = model_kit(columns=answering(lambda states, nu: answer(states)), declares=undeclared)
    with pytest.raises(AssertionError):
        kit.test_undeclared_thickness_and_sun_have_no_influence(model, inputs, NU)


def test_kit_accepts_clear_sky_that_differs_where_thickness_is_not_declared():
    columns = answering(lambda states, nu: 1.0 + is_clear(states))
    kit, model, inputs = model_kit(columns=columns, declares=RadianceDeclaration(depends_on=frozenset()))
    kit.test_undeclared_thickness_and_sun_have_no_influence(model, inputs, NU)


def test_kit_refuses_clear_columns_that_know_the_layers():
    kit, model, inputs = model_kit(
        columns=answering(lambda states, nu: np.where(is_clear(states), 1.0 + states.thickness_m.shape[1], 1.0))
    )
    with pytest.raises(AssertionError):
        kit.test_clear_columns_do_not_depend_on_the_layers(model, inputs, SETTING, NU)


def test_kit_refuses_columns_of_two_layers_that_break_a_law():
    kit, model, _ = model_kit(
        columns=answering(lambda states, nu: 1.0 + states.thickness_m[:, :1] / np.max(states.thickness_m, initial=1.0))
    )
    with pytest.raises(AssertionError):
        kit.test_columns_of_two_layers(model, SETTING, NU)
    kit, model, inputs = model_kit(columns=answering(lambda states, nu: float(states.thickness_m.shape[1])))
    with pytest.raises(AssertionError):
        kit.test_a_layer_without_cloud_has_no_influence(model, inputs, SETTING, NU)


def test_kit_refuses_solar_terms_that_are_no_terms():
    _, model, _ = model_kit(solar_terms=frozenset({"glow"}))
    with pytest.raises(AssertionError):
        RadianceModelContract().test_declaration_is_sound(model)


@pytest.mark.parametrize(
    "share",
    [
        lambda z: np.where(1000.0 + z > 2000.0, 1.001, 1.0),
        lambda z: np.where(1000.0 + z >= 3000.0, 1.00001, 1.0),
        lambda z: np.where(z > 777.7, 0.99, 1.0),
    ],
    ids=["mask above a level", "mask from a level on", "another branch for thick clouds"],
)
@pytest.mark.parametrize("compensated", [False, True])
def test_kit_refuses_radiance_that_jumps_as_the_cloud_grows(share, compensated):
    """Also where another term jumps the other way, so that the sum does not."""

    def jumping(states, nu):
        z = states.thickness_m[:, :1]
        return share(z) * np.exp(-z / 2000.0)

    kit, _, inputs = model_kit(
        columns=answering(jumping, lambda states, nu: 2.0 - jumping(states, nu) if compensated else 1.0)
    )
    with pytest.raises(AssertionError, match=r"term '(surface|glint)' jumps by .* m thick, its top at"):
        kit.test_radiance_is_continuous_in_thickness(inputs, NU, "base")


def test_kit_accepts_kinks_and_steep_radiance():
    """A cloud whose top takes the temperature of levels, and one that is opaque within a metre."""
    kinked = lambda z: 1.0 + np.interp(1000.0 + z, [0.0, 2000.0, 3000.0, 4000.0], [4.0, 1.0, 2.0, 0.0])  # noqa: E731
    kit, _, inputs = model_kit(
        columns=answering(
            lambda states, nu: kinked(states.thickness_m[:, :1]),
            lambda states, nu: np.exp(-np.abs(states.thickness_m[:, :1] - 400.0)),
        )
    )
    for anchor in ("base", "top"):
        kit.test_radiance_is_continuous_in_thickness(inputs, NU, anchor)
