"""The conformance kit accepts providers in closed form and refuses each kind of mistake."""

import dataclasses

import numpy as np
import pytest

from hcss_twin.physics.paths import to_space
from hcss_twin.providers import Declares, SingleScattering
from hcss_twin.testing import (
    CloudGeneratorContract,
    OpticsContract,
    PlainGas,
    PlainOptics,
    PlainSea,
    RadianceModelContract,
    SeaModelContract,
    TransmittanceContract,
    sample_atmosphere_inputs,
    sample_cloud_inputs,
    sample_microphysics,
    sample_optics_inputs,
    sample_profile,
    sample_radiance_inputs,
    sample_sea_inputs,
    sample_wavenumbers,
)


class Checkerboard:
    """Each pixel of a frozen, infinite plane is cloudy or not by a (cheap) random number of its own."""

    def __init__(self, inputs):
        self.inputs = inputs
        self.speed = inputs.motion.platform_speed_m_s / inputs.grid.pixel_size_m
        self.declares = Declares(depends_on=frozenset({"time"} if self.speed else ()), tileable=True)

    def thickness_m(self, time_s, rows, columns):
        layer = self.inputs.layer
        x = np.arange(columns.start, columns.stop) + round(self.speed * time_s)
        y = np.arange(rows.start, rows.stop)[:, None]
        value = np.abs(np.sin((y + 1) * 12.9898 + x * 78.233 + self.inputs.seed) * 43758.5453) % 1.0
        span = layer.thickness_max_m - layer.thickness_min_m
        return np.where(value < layer.coverage, layer.thickness_min_m + span * value, 0.0).astype(np.float32)


class GreyModel:
    """Black sea and black cloud, and a constant glint."""

    declares = Declares()
    terms = {"surface": "emitted by the surface", "glint": "reflected sun"}  # noqa: RUF012
    solar_terms = frozenset({"glint"})

    def clear(self, wavenumber_cm1, sun):
        ones = np.ones(wavenumber_cm1.size)
        return {"surface": ones, "glint": ones * (sun is not None)}

    def cloudy(self, wavenumber_cm1, thickness_m, sun):
        ones = np.ones((thickness_m.shape[0], wavenumber_cm1.size))
        depth = np.sum(thickness_m, axis=1, keepdims=True) / 100.0
        return {"surface": ones * np.exp(-depth), "glint": ones * (sun is not None)}


class TestPlainGas(TransmittanceContract):
    def make_provider(self, inputs):
        return PlainGas(inputs.profile)


class TestPlainSea(SeaModelContract):
    def make_provider(self, inputs):
        return PlainSea()


class TestPlainOptics(OpticsContract):
    def make_provider(self, inputs):
        return PlainOptics()


class TestCheckerboard(CloudGeneratorContract):
    def make_provider(self, inputs):
        return Checkerboard(inputs)


class TestGreyModel(RadianceModelContract):
    def make_provider(self, inputs):
        return GreyModel()


GAS_INPUTS = sample_atmosphere_inputs()
GAS = PlainGas(sample_profile())
NU = sample_wavenumbers(GAS.declares)


def broken_gas(transmittance):
    gas = PlainGas(sample_profile())
    honest = gas.transmittance
    gas.transmittance = lambda nu, paths: transmittance(honest, nu, paths)
    return gas


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("path_without_legs_transmits_everything", lambda honest, nu, paths: 0.99 * honest(nu, paths)),
        (
            "another_leg_never_transmits_more",
            lambda honest, nu, paths: np.array([[0.5 + 0.1 * len(p.legs)] * nu.size for p in paths]),
        ),
        ("longer_path_never_transmits_more", lambda honest, nu, paths: 1.0 - honest(nu, paths)),
        (
            "order_of_legs_does_not_matter",
            lambda honest, nu, paths: np.array([[0.5 + p.legs[0].zenith_deg / 200] * nu.size for p in paths]),
        ),
    ],
)
def test_kit_refuses_a_gas_that_breaks_a_law(law, mistake):
    kit = TransmittanceContract()
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(broken_gas(mistake), NU)


def test_kit_refuses_a_gas_that_depends_on_its_batch_or_leaves_its_range():
    kit = TransmittanceContract()
    paths = [to_space(0.0, 0.0), to_space(0.0, 60.0)]
    relative = broken_gas(lambda honest, nu, paths: honest(nu, paths) / honest(nu, paths).max())
    with pytest.raises(AssertionError):
        kit.test_result_does_not_depend_on_batching(relative, NU, paths)
    with pytest.raises(AssertionError):
        kit.test_shape_type_and_range(
            broken_gas(lambda honest, nu, paths: 2.0 * honest(nu, paths)), NU, paths
        )
    with pytest.raises(AssertionError):
        kit.test_shape_type_and_range(broken_gas(lambda honest, nu, paths: honest(nu, paths).T), NU, paths)


def test_kit_refuses_path_radiance_brighter_than_the_air():
    gas = PlainGas(sample_profile())
    gas.path_radiance = lambda nu, paths: np.ones((len(paths), nu.size))
    with pytest.raises(AssertionError):
        TransmittanceContract().test_path_radiance_is_not_brighter_than_the_warmest_air(gas, GAS_INPUTS, NU)


def broken_sea(**methods):
    sea = PlainSea()
    vars(sea).update(methods)
    return sea


@pytest.mark.parametrize(
    ("law", "methods"),
    [
        ("emissivity_shape_type_and_range", {"emissivity": lambda nu, mu: np.full((mu.size, nu.size), 1.01)}),
        ("emissivity_shape_type_and_range", {"emissivity": lambda nu, mu: np.full((nu.size, mu.size), 0.9)}),
        ("brdf_shape_type_and_range", {"brdf": lambda nu, out, into, az: np.full((out.size, nu.size), -0.1)}),
        ("brdf_is_reciprocal", {"brdf": lambda nu, out, into, az: out[:, None] * np.ones(nu.size)}),
        (
            "no_more_is_reflected_than_is_not_emitted",
            {"brdf": lambda nu, out, into, az: np.full((out.size, nu.size), 0.0069)},
        ),
        (
            "undeclared_directions_have_no_influence",
            {"emissivity": lambda nu, mu: mu[:, None] * np.ones(nu.size)},
        ),
        (
            "undeclared_directions_have_no_influence",
            {"brdf": lambda nu, out, into, az: az[:, None] * np.ones(nu.size)},
        ),
        (
            "result_does_not_depend_on_batching",
            {"emissivity": lambda nu, mu: mu[:, None] / mu.max() * np.ones(nu.size)},
        ),
    ],
)
def test_kit_refuses_a_sea_that_breaks_a_law(law, methods):
    with pytest.raises(AssertionError):
        getattr(SeaModelContract(), f"test_{law}")(broken_sea(**methods), NU)


@pytest.mark.parametrize(
    ("law", "change"),
    [
        ("ranges", {"albedo": lambda bulk: bulk.albedo + 0.5}),
        ("ranges", {"moments": lambda bulk: 1.01 * bulk.moments}),
        ("ranges", {"extinction_m1": lambda bulk: 0.0 * bulk.extinction_m1}),
        ("shapes", {"moments": lambda bulk: bulk.moments[:1]}),
        ("shapes", {"albedo": lambda bulk: bulk.albedo[:, None]}),
        (
            "extinction_is_proportional_to_the_number_of_particles",
            {"extinction_m1": lambda bulk: bulk.extinction_m1**2},
        ),
        ("result_does_not_depend_on_batching", {"albedo": lambda bulk: np.linspace(0, 1, bulk.albedo.size)}),
    ],
)
def test_kit_refuses_optics_that_break_a_law(law, change):
    class Broken(PlainOptics):
        def single_scattering(self, cloud, wavenumber_cm1):
            bulk = super().single_scattering(cloud, wavenumber_cm1)
            return dataclasses.replace(bulk, **{name: make(bulk) for name, make in change.items()})

    with pytest.raises(AssertionError):
        getattr(OpticsContract(), f"test_{law}")(Broken(), sample_microphysics(), NU)


def clouds_kit(mistake):
    class Broken(Checkerboard):
        def thickness_m(self, time_s, rows, columns):
            return mistake(self, super().thickness_m(time_s, rows, columns), time_s)

    class Kit(CloudGeneratorContract):
        def make_provider(self, inputs):
            return Broken(inputs)

    return Kit(), Broken(sample_cloud_inputs()), sample_cloud_inputs()


def counting(provider, field, time_s):
    provider.calls = getattr(provider, "calls", 0) + 1
    return np.where(field > 0.0, field - provider.calls, 0.0).astype(np.float32)


def reusing(provider, field, time_s):
    provider.buffer = getattr(provider, "buffer", np.empty_like(field))
    provider.buffer[:] = field + time_s
    return provider.buffer


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("shape_and_type", lambda self, field, time_s: field.astype(np.float64)),
        ("shape_and_type", lambda self, field, time_s: field.T),
        ("thickness_stays_within_the_layer", lambda self, field, time_s: 3.0 * field),
        ("thickness_stays_within_the_layer", lambda self, field, time_s: 0.5 * field),
        ("windows_equal_the_whole", lambda self, field, time_s: field - field.mean()),
        ("returned_field_belongs_to_the_caller", reusing),
    ],
)
def test_kit_refuses_clouds_that_break_a_law(law, mistake):
    kit, provider, inputs = clouds_kit(mistake)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(provider, inputs)


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("field_does_not_depend_on_earlier_calls", counting),
        (
            "undeclared_time_has_no_influence",
            lambda self, field, time_s: field * np.float32(1 - time_s / 1e4),
        ),
        ("frozen_field_only_translates", lambda self, field, time_s: field[::-1] if time_s else field),
    ],
)
def test_kit_refuses_clouds_that_remember_or_change(law, mistake):
    kit, _, inputs = clouds_kit(mistake)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(inputs)


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("no_coverage_is_clear_sky_and_full_coverage_has_no_gap", lambda self, field, time_s: field + 1),
        ("cloudy_fraction_is_the_coverage", lambda self, field, time_s: field * (field > 300.0)),
    ],
)
def test_kit_refuses_clouds_of_wrong_coverage(law, mistake):
    kit, _, _ = clouds_kit(mistake)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")()


def test_kit_refuses_solar_terms_without_a_sun():
    model = GreyModel()
    model.clear = lambda nu, sun: {"surface": np.ones(nu.size), "glint": 1e-12 * np.ones(nu.size)}
    with pytest.raises(AssertionError):
        RadianceModelContract().test_no_sun_no_solar_term(model, NU)


def test_kit_refuses_an_unsound_declaration():
    sea = broken_sea(declares=Declares(depends_on=frozenset({"weather"})))
    with pytest.raises(ValueError, match="weather"):
        SeaModelContract().test_declaration_is_sound(sea)


def test_sample_wavenumbers_respect_native_grid_and_range():
    grid = np.arange(400.0, 4000.0, 7.0)
    picked = sample_wavenumbers(Declares(native_grid_cm1=grid, valid={"wavenumber_cm1": (400.0, 3000.0)}), 10)
    assert np.all(np.isin(picked, grid))
    assert picked.min() >= 500.0
    assert picked.max() <= 3000.0
    assert not picked.flags.writeable


def test_sample_inputs_can_be_made():
    assert sample_sea_inputs().temperature_K == 290.0
    assert sample_optics_inputs().catalog.root.is_dir()
    assert np.all(np.diff(sample_profile(288.0).temperature_K) == 0.0)
    bulk = sample_radiance_inputs().optics.single_scattering(sample_microphysics("ice"), NU)
    assert isinstance(bulk, SingleScattering)
