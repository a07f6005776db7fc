import copy
import dataclasses
import pickle

import numpy as np
import pytest
from hcss_author import (
    PlainGas,
    PlainOptics,
    PlainSea,
    sample_cloud_inputs,
    sample_microphysics,
    sample_profile,
    sample_radiance_inputs,
)

from hcss_twin.core.errors import ProviderError
from hcss_twin.physics.multiple_scattering.layer import checked_layers
from hcss_twin.physics.paths import to_space
from hcss_twin.providers import (
    AtmosphereDeclaration,
    CloudGenerator,
    ColumnStates,
    Optics,
    SeaModel,
    SingleScattering,
    Sun,
    TransmittanceProvider,
)
from hcss_twin.providers.registry import Entry, Kind, Origin, ProviderSpec
from hcss_twin.providers.registry.guard import guard

NU = np.array([800.0, 1000.0, 2500.0])
MU = np.array([1.0, 0.5])
PATHS = [to_space(0.0, 0.0), to_space(0.0, 60.0)]
WHOLE = slice(0, 48), slice(0, 64)


class Answers:
    """A provider of every kind whose methods all return (or raise) the same."""

    def __init__(self, answer, **attributes):
        self.answer = answer
        self.declares = AtmosphereDeclaration()
        self.__dict__.update(attributes)

    def _reply(self, *arguments):
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer

    thickness_m = emissivity = brdf = single_scattering = transmittance = columns = _reply


def guarded(kind, provider, inputs=None):
    spec = ProviderSpec(name="toy", target="a:B", parameters=None, api_version=3, summary="a toy")
    return guard(Entry(Kind(kind), spec, Origin("a", "hcss-a", "1.2")), provider, inputs)


def clouds(answer):
    return guarded("clouds", Answers(answer), sample_cloud_inputs()).thickness_m(0.0, *WHOLE)


def emissivity(answer):
    return guarded("sea", Answers(answer)).emissivity(NU, MU)


def with_one(value, shape=(2, 3), dtype=float):
    array = np.full(shape, 0.5, dtype=dtype)
    array.flat[1] = value
    return array


def test_good_values_pass_unaltered():
    np.testing.assert_array_equal(guarded("sea", PlainSea()).emissivity(NU, MU), PlainSea().emissivity(NU, MU))
    gas = PlainGas(sample_profile())
    np.testing.assert_array_equal(guarded("atmosphere", gas).transmittance(NU, PATHS), gas.transmittance(NU, PATHS))
    bulk = guarded("optics", PlainOptics()).single_scattering(sample_microphysics(), NU)
    np.testing.assert_array_equal(bulk.albedo, 0.6)
    field = clouds(np.full((48, 64), 800.0))
    assert field.dtype == np.float32
    assert emissivity(np.ones((2, 3), dtype=np.float32)).dtype == np.float64
    assert emissivity([[0, 1, 1], [1, 0, 1]]).dtype == np.float64


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (np.full((3, 2), 0.5), r"expected shape \(2, 3\), got shape \(3, 2\)"),
        (0.5, r"expected shape \(2, 3\), got shape \(\)"),
        (None, "real numbers"),
        ("text", "real numbers"),
        (np.full((2, 3), 0.5 + 0j), "complex128"),
        (np.ones((2, 3), dtype=bool), "bool"),
        ([[1.0], [1.0, 2.0]], "an array of shape"),
        (np.ma.masked_greater(np.full((2, 3), 0.5), 0.4), "masked"),
        (with_one(np.nan), "1 of 6 not finite"),
        (with_one(np.inf), "not finite"),
        (with_one(1.0 + 1e-6), r"\[-1e-09, 1\]"),
        (with_one(-1e-6), "-1e-06 to 0.5"),
        (RuntimeError("boom"), r"emissivity\(\) raised RuntimeError: boom"),
        (SystemExit(2), r"emissivity\(\) raised SystemExit: 2"),
    ],
)
def test_bad_emissivity_is_refused_with_provider_distribution_and_method(answer, message):
    with pytest.raises(ProviderError, match=message) as error:
        emissivity(answer)
    assert "sea model 'toy' of hcss-a 1.2: emissivity()" in str(error.value)


def test_rounding_beyond_the_ends_is_let_through():
    assert emissivity(with_one(1.0 + 1e-12)).max() > 1.0
    assert emissivity(with_one(-1e-12)).min() < 0.0


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, 800.1])
def test_bad_thickness_is_refused(value):
    with pytest.raises(ProviderError, match=r"thickness_m\(\)"):
        clouds(with_one(value, (48, 64), np.float32))


def test_window_is_checked_against_its_own_shape():
    guard_of_zero = guarded("clouds", Answers(np.zeros((5, 7))), sample_cloud_inputs())
    assert guard_of_zero.thickness_m(0.0, slice(10, 15), slice(57, None)).shape == (5, 7)
    with pytest.raises(ProviderError, match=r"expected shape \(48, 64\)"):
        guard_of_zero.thickness_m(0.0, *WHOLE)


def test_brdf_may_exceed_one_but_not_fall_below_zero():
    sea = guarded("sea", Answers(with_one(12.0)))
    assert sea.brdf(NU, MU, MU, MU).max() == 12.0
    with pytest.raises(ProviderError, match=r"brdf\(\)"):
        guarded("sea", Answers(with_one(-1e-12))).brdf(NU, MU, MU, MU)


ONES = np.ones(3)
GOOD = SingleScattering(ONES, ONES, np.stack((ONES, 0.5 * ONES)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"extinction_m1": -ONES}, "extinction_m1"),
        ({"extinction_m1": np.ones(2)}, "extinction_m1"),
        ({"albedo": 1.1 * ONES}, "albedo"),
        ({"moments": ONES}, "moments"),
        ({"moments": np.stack((ONES,))}, "K of at least 2"),
        ({"moments": np.stack((0.9 * ONES, ONES))}, r"moments\[0\]"),
        ({"moments": np.stack((ONES, ONES))}, "above -1 and below 1"),
        ({"moments": np.stack((ONES, 1.1 * ONES))}, "moments"),
        ({"moments": None}, "moments"),
    ],
)
def test_bad_bulk_properties_are_refused(changes, message):
    guarded("optics", Answers(GOOD)).single_scattering(sample_microphysics(), NU)
    bad = dataclasses.replace(GOOD, **changes)
    with pytest.raises(ProviderError, match=message):
        guarded("optics", Answers(bad)).single_scattering(sample_microphysics(), NU)


def test_rounding_of_bulk_properties_never_reaches_the_solvers():
    # the solvers want moments[0] = 1 to the bit; a plugin that divides two sums misses it by a bit or two
    rounded = SingleScattering(ONES, ONES * (1.0 + 1e-15), np.stack((ONES * (1.0 - 2.0**-53), 0.5 * ONES)))
    bulk = guarded("optics", Answers(rounded)).single_scattering(sample_microphysics(), NU)
    checked_layers(np.ones((1, 3)), bulk.albedo, bulk.moments)


def test_bulk_properties_must_be_of_their_class():
    with pytest.raises(ProviderError, match="expected SingleScattering, got tuple"):
        guarded("optics", Answers((ONES, ONES, ONES))).single_scattering(sample_microphysics(), NU)


def test_path_radiance_is_there_only_if_the_provider_has_it():
    assert not hasattr(guarded("atmosphere", Answers(0)), "path_radiance")
    own = guarded("atmosphere", Answers(0, path_radiance=lambda nu, paths: with_one(-1.0)))
    assert hasattr(own, "path_radiance")
    with pytest.raises(ProviderError, match=r"path_radiance\(\)"):
        own.path_radiance(NU, PATHS)


@pytest.mark.parametrize("keywords", [False, True])
def test_scattered_sunlight_is_checked_where_the_provider_has_it(keywords):
    def ask(value):
        sky = Answers(0, solar_path_radiance=lambda nu, paths, sun_zenith_deg, relative_azimuth_deg: value)
        own = guarded("atmosphere", sky).solar_path_radiance
        if keywords:
            return own(NU, PATHS, sun_zenith_deg=30.0, relative_azimuth_deg=90.0)
        return own(NU, PATHS, 30.0, 90.0)

    assert not hasattr(guarded("atmosphere", Answers(0)), "solar_path_radiance")
    np.testing.assert_array_equal(ask(with_one(0.5)), with_one(0.5))
    for wrong in (with_one(-1.0), with_one(np.nan), with_one(0.5).T, "sunlight"):
        with pytest.raises(ProviderError, match=r"solar_path_radiance\(\)"):
            ask(wrong)


def test_nobody_is_asked_outside_the_declared_range():
    provider = Answers(with_one(0.5), declares=AtmosphereDeclaration(valid={"wavenumber_cm1": (900.0, 3000.0)}))
    with pytest.raises(ProviderError, match="asked for 800 to 2500 cm-1; valid are 900 to 3000 cm-1"):
        guarded("atmosphere", provider).transmittance(NU, PATHS)
    assert guarded("sea", provider).emissivity(NU + 100.0, MU).shape == (2, 3)


def test_terms_are_checked_by_name_shape_and_sun():
    names = {"terms": {"sea": "emitted", "glint": "reflected"}, "solar_terms": frozenset({"glint"})}
    night = sample_radiance_inputs().setting
    settings, ones = (night, night.under(Sun(40.0, 180.0, 1.0))), np.ones((2, 3))

    def columns(answer, lit=(True, True)):
        states = ColumnStates(settings, np.array(lit, dtype=np.intp), np.ones((2, 1)))
        return guarded("radiance", Answers(answer, **names)).columns(states, NU)

    assert set(columns({"sea": ones, "glint": ones})) == {"sea", "glint"}
    assert columns({"sea": ones, "glint": 0 * ones}, (False, False))["glint"].max() == 0.0
    for answer, message in (
        ({"sea": ones}, "a mapping with the terms sea, glint, got sea"),
        ({"sea": ones, "glint": ones, "extra": ones}, "with the terms"),
        ({"sea": ones, "glint": np.ones((2, 2))}, "term 'glint'"),
        ({"sea": ones, "glint": np.ones((1, 3))}, "term 'glint'"),
        ({"sea": ones * np.nan, "glint": ones}, "term 'sea'"),
        ([ones, ones], "a mapping"),
    ):
        with pytest.raises(ProviderError, match=message):
            columns(answer)
    first = {"sea": ones, "glint": np.array([[1e-30], [0.0]]) * ones}
    assert columns(first, (True, False))["glint"].max() == 1e-30
    for lit in ((False, True), (False, False)):
        with pytest.raises(ProviderError, match=r"solar term 'glint'.*exactly 0 without a sun"):
            columns(first, lit)


def test_wrapped_providers_are_still_providers_and_forward_the_rest():
    assert isinstance(guarded("sea", PlainSea()), SeaModel)
    assert isinstance(guarded("optics", PlainOptics()), Optics)
    assert isinstance(guarded("atmosphere", PlainGas(sample_profile())), TransmittanceProvider)
    assert isinstance(guarded("clouds", Answers(0), sample_cloud_inputs()), CloudGenerator)
    plain = Answers(0, significant_wave_height_m=2.0)
    own = guarded("sea", plain)
    assert own.significant_wave_height_m == 2.0
    assert own.declares == plain.declares
    with pytest.raises(AttributeError):
        own.no_such_attribute  # noqa: B018


def test_wrapped_providers_can_be_sent_to_other_processes():
    sea = guarded("sea", PlainSea())
    for twin in (copy.deepcopy(sea), pickle.loads(pickle.dumps(sea))):
        np.testing.assert_array_equal(twin.emissivity(NU, MU), sea.emissivity(NU, MU))


def test_reflection_weights_are_offered_only_by_models_that_have_them():
    assert not hasattr(guarded("sea", PlainSea()), "reflection_weights")
    nodes, good = np.array([0.3, 0.7]), np.full((2, 2, 3), 0.25)
    sea = guarded("sea", Answers(good, reflection_weights=lambda *arguments, **keywords: good))
    np.testing.assert_array_equal(sea.reflection_weights(NU, MU, nodes, basis="linear"), good)
    wrong = guarded("sea", Answers(good, reflection_weights=lambda *arguments: good[:1]))
    with pytest.raises(ProviderError, match=r"reflection_weights\(\) broke its contract"):
        wrong.reflection_weights(NU, MU, nodes)


def test_the_bearing_to_the_wind_reaches_only_models_that_are_asked_with_one():
    class Bearing(Answers):
        def emissivity(self, wavenumber_cm1, mu, wind_azimuth=None):
            return np.full((2, 3), 0.9 if wind_azimuth is None else 0.8)

    sea = guarded("sea", Bearing(None))
    assert sea.emissivity(NU, MU).max() == 0.9
    assert sea.emissivity(NU, MU, np.zeros(2)).max() == 0.8


def test_waves_are_offered_only_by_seas_that_have_them_and_are_checked():
    plain = guarded("sea", PlainSea())
    assert not any(hasattr(plain, name) for name in ("wave_slope_rms", "wave_field", "tilted"))
    good, bad = np.zeros((2, 3, 4)), np.full((2, 3, 4), np.nan)
    window = 0.0, slice(2, 5), slice(1, 5)
    for slopes in (good, good[0], bad):
        shapes = type("Shapes", (), {"slopes": lambda *_, answer=slopes: answer})()
        sea = guarded(
            "sea",
            Answers(
                np.full((2, 3), 1.5),
                wave_slope_rms=lambda size: (0.1, -0.1 if size < 0 else 0.1),
                wave_field=lambda *_, answer=shapes: answer,
                tilted=lambda *_: Answers(np.full((2, 3), 1.5)),
            ),
        )
        waves = sea.wave_field(None, None, 1)
        if slopes is good:
            assert waves.slopes(*window).dtype == np.float32
            continue
        with pytest.raises(ProviderError, match=r"toy.*slopes\(\) broke its contract"):
            waves.slopes(*window)
    assert sea.wave_slope_rms(1.0) == (0.1, 0.1)
    with pytest.raises(ProviderError, match="wave_slope_rms"):
        sea.wave_slope_rms(-1.0)
    with pytest.raises(ProviderError, match=r"emissivity\(\) broke its contract"):
        sea.tilted(0.1, 0.0, 1.0).emissivity(NU, MU)
