"""The kit refuses radiance models that break a law; it accepts those of ``tests/contract`` and of this package."""

import numpy as np
import pytest
from hcss_author import RadianceModelContract, sample_radiance_inputs, sample_wavenumbers

from hcss_twin.providers import RadianceDeclaration, Sun

NU = sample_wavenumbers(RadianceDeclaration())


class GreyModel:
    """Sea and clouds of radiance 1 at all wavenumbers, and a constant glint: for laws of form, not of size."""

    declares = RadianceDeclaration(depends_on=frozenset({"thickness"}))
    terms = {"surface": "emitted by the surface", "glint": "reflected sun"}  # noqa: RUF012
    solar_terms = frozenset({"glint"})

    def clear(self, wavenumber_cm1, sun):
        ones = np.ones(wavenumber_cm1.size)
        return {"surface": ones, "glint": ones * (sun is not None)}

    def cloudy(self, wavenumber_cm1, thickness_m, sun):
        ones = np.ones((thickness_m.shape[0], wavenumber_cm1.size))
        depth = np.sum(thickness_m, axis=1, keepdims=True) / 100.0
        return {"surface": ones * np.exp(-depth), "glint": ones * (sun is not None)}


def test_kit_refuses_solar_terms_without_a_sun():
    model = GreyModel()
    model.clear = lambda nu, sun: {"surface": np.ones(nu.size), "glint": 1e-12 * np.ones(nu.size)}
    with pytest.raises(AssertionError):
        RadianceModelContract().test_no_sun_no_solar_term(model, NU)


def model_kit(**changes):
    class Kit(RadianceModelContract):
        def make_provider(self, inputs):
            model = GreyModel()
            vars(model).update(changes)
            return model

    return Kit(), Kit().make_provider(None), sample_radiance_inputs()


SUN = Sun(40.0, 200.0, 1.0)
ONES = np.ones((4, NU.size))


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        ("every_term_of_every_column", {"clear": lambda nu, sun: {"surface": np.ones(nu.size)}}),
        (
            "every_term_of_every_column",
            {"clear": lambda nu, sun: {"surface": np.ones((1, nu.size)), "glint": np.ones(nu.size)}},
        ),
        (
            "every_term_of_every_column",
            {"cloudy": lambda nu, z, sun: {"surface": np.full((len(z), nu.size), np.nan), "glint": ONES}},
        ),
        ("radiance_is_positive", {"clear": lambda nu, sun: {"surface": -np.ones(nu.size), "glint": np.ones(nu.size)}}),
        (
            "result_does_not_depend_on_batching",
            {"cloudy": lambda nu, z, sun: {term: z / z.max() * np.ones(nu.size) for term in GreyModel.terms}},
        ),
        (
            "result_does_not_depend_on_other_wavenumbers",
            {"clear": lambda nu, sun: {term: nu / nu.max() for term in GreyModel.terms}},
        ),
        (
            "result_does_not_depend_on_other_wavenumbers",
            {"cloudy": lambda nu, z, sun: {term: np.ones((len(z), 1)) * nu / nu.sum() for term in GreyModel.terms}},
        ),
    ],
)
def test_kit_refuses_a_radiance_model_that_breaks_a_law(law, changes):
    kit, model, _ = model_kit(**changes)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(model, NU, SUN)


@pytest.mark.parametrize(
    "answer",
    [
        lambda nu, z, sun: z / 100.0 * np.ones(nu.size),
        lambda nu, z, sun: np.full((len(z), nu.size), sun.zenith_deg),
        lambda nu, z, sun: np.full((len(z), nu.size), sun.azimuth_deg),
    ],
    ids=["thickness", "sun_zenith", "relative_azimuth"],
)
def test_kit_refuses_an_undeclared_dependence_of_a_radiance_model(answer):
    def cloudy(nu, thickness_m, sun):
        return dict.fromkeys(GreyModel.terms, answer(nu, thickness_m, sun))

    kit, model, _ = model_kit(cloudy=cloudy, declares=RadianceDeclaration())
    with pytest.raises(AssertionError):
        kit.test_undeclared_thickness_and_sun_have_no_influence(model, NU)


def test_kit_refuses_clear_columns_that_know_the_layers():
    class Tinted(GreyModel):
        def __init__(self, inputs):
            self.count = len(inputs.layers)

        def clear(self, wavenumber_cm1, sun):
            return {term: np.full(wavenumber_cm1.size, 1.0 + self.count) for term in self.terms}

    class Kit(RadianceModelContract):
        def make_provider(self, inputs):
            return Tinted(inputs)

    inputs = sample_radiance_inputs()
    with pytest.raises(AssertionError):
        Kit().test_clear_columns_do_not_depend_on_the_layers(Tinted(inputs), inputs, NU, SUN)


def test_kit_refuses_columns_of_two_layers_that_break_a_law():
    kit, model, inputs = model_kit(
        cloudy=lambda nu, z, sun: {term: z[:, :1] / z.max() * np.ones(nu.size) for term in GreyModel.terms}
    )
    with pytest.raises(AssertionError):
        kit.test_columns_of_two_layers(model, NU, SUN)
    kit, model, inputs = model_kit(
        cloudy=lambda nu, z, sun: {term: np.full((len(z), nu.size), z.shape[1]) for term in GreyModel.terms}
    )
    with pytest.raises(AssertionError):
        kit.test_a_layer_without_cloud_has_no_influence(model, inputs, NU, SUN)


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

    def cloudy(nu, thickness_m, sun):
        z = thickness_m[:, :1] * np.ones(nu.size)
        jumping = share(z) * np.exp(-z / 2000.0)
        return {"surface": jumping, "glint": (2.0 - jumping if compensated else np.ones_like(jumping))}

    kit, _, inputs = model_kit(cloudy=cloudy)
    with pytest.raises(AssertionError, match=r"term '(surface|glint)' jumps by .* m thick, its top at"):
        kit.test_radiance_is_continuous_in_thickness(inputs, NU, "base")


def test_kit_accepts_kinks_and_steep_radiance():
    """A cloud whose top takes the temperature of levels, and one that is opaque within a metre."""

    def cloudy(nu, thickness_m, sun):
        z = thickness_m[:, :1] * np.ones(nu.size)
        kinked = 1.0 + np.interp(1000.0 + z, [0.0, 2000.0, 3000.0, 4000.0], [4.0, 1.0, 2.0, 0.0])
        return {"surface": kinked, "glint": np.exp(-np.abs(z - 400.0))}

    kit, _, inputs = model_kit(cloudy=cloudy)
    for anchor in ("base", "top"):
        kit.test_radiance_is_continuous_in_thickness(inputs, NU, anchor)
