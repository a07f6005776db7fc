"""The conformance kit accepts providers in closed form and refuses each kind of mistake."""

import dataclasses
import threading
from pathlib import Path

import numpy as np
import pytest

from hcss_twin.physics.paths import to_space
from hcss_twin.providers import Declares, SingleScattering, Sun
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
        wind = inputs.motion.cloud_velocity_m_s
        self.speed_x = (inputs.motion.platform_speed_m_s - wind[0]) / inputs.grid.pixel_size_m
        self.speed_y = -wind[1] / inputs.grid.pixel_size_m
        moves = self.speed_x or self.speed_y
        self.declares = Declares(depends_on=frozenset({"time"} if moves else ()), tileable=True)

    def thickness_m(self, time_s, rows, columns):
        layer = self.inputs.layer
        x = np.arange(columns.start, columns.stop) + round(self.speed_x * time_s)
        y = np.arange(rows.start, rows.stop)[:, None] + round(self.speed_y * time_s)
        value = np.abs(np.sin((y + 1) * 12.9898 + x * 78.233 + self.inputs.seed) * 43758.5453) % 1.0
        span = layer.thickness_max_m - layer.thickness_min_m
        return np.where(value < layer.coverage, layer.thickness_min_m + span * value, 0.0).astype(np.float32)


class GreyModel:
    """Black sea and black cloud, and a constant glint."""

    declares = Declares(depends_on=frozenset({"thickness"}))
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


def test_kit_refuses_a_gas_that_clears_higher_up():
    gas = broken_gas(
        lambda honest, nu, paths: np.where(
            [[any(5e3 < leg.upper_m < 6e4 for leg in path.legs)] for path in paths], 1.0, honest(nu, paths)
        )
    )
    with pytest.raises(AssertionError):
        TransmittanceContract().test_every_layer_of_air_only_takes_away(gas, GAS_INPUTS, NU)


def scattering_gas(scatter):
    gas = PlainGas(sample_profile())
    gas.solar_path_radiance = lambda nu, paths, sun_zenith_deg, relative_azimuth_deg: scatter(
        1.0 - gas.transmittance(nu, paths), nu, paths
    )
    return gas


def test_kit_accepts_a_gas_that_scatters_sunlight_in_proportion_to_its_depth():
    TransmittanceContract().test_scattered_sunlight_is_not_less_from_a_longer_leg(
        scattering_gas(lambda lost, nu, paths: 0.1 * lost), NU
    )


@pytest.mark.parametrize(
    "mistake",
    [
        lambda lost, nu, paths: 1.0 - lost,
        lambda lost, nu, paths: -lost,
        lambda lost, nu, paths: np.nan * lost,
        lambda lost, nu, paths: lost.T,
        lambda lost, nu, paths: lost / len(paths),
        lambda lost, nu, paths: lost / nu.size,
    ],
    ids=[
        "less from longer legs",
        "negative",
        "not finite",
        "shape",
        "batch of paths",
        "batch of wavenumbers",
    ],
)
def test_kit_refuses_scattered_sunlight_that_breaks_a_law(mistake):
    with pytest.raises(AssertionError):
        TransmittanceContract().test_scattered_sunlight_is_not_less_from_a_longer_leg(
            scattering_gas(mistake), NU
        )


@pytest.mark.parametrize("count", [lambda nu, paths: len(paths), lambda nu, paths: nu.size])
def test_kit_refuses_path_radiance_that_depends_on_its_batch(count):
    gas = PlainGas(sample_profile())
    gas.path_radiance = lambda nu, paths: np.full((len(paths), nu.size), 1e-6 / count(nu, paths))
    with pytest.raises(AssertionError):
        TransmittanceContract().test_path_radiance_does_not_depend_on_batching(gas, NU)


def fold(nu, mu, nodes, reflected=0.02):
    """The same share of every node's light in every view."""
    return np.full((mu.size, nodes.size, nu.size), reflected / nodes.size)


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
        (
            "result_does_not_depend_on_batching",
            {"emissivity": lambda nu, mu: np.ones((mu.size, 1)) * (nu / nu.max())},
        ),
        (
            "result_does_not_depend_on_batching",
            {"brdf": lambda nu, out, into, az: np.ones((out.size, 1)) * (nu / nu.max())},
        ),
        (
            "result_does_not_depend_on_batching",
            {"brdf": lambda nu, out, into, az: out[:, None] / out.max() * np.ones(nu.size)},
        ),
        ("what_is_not_emitted_is_reflected", {"emissivity": lambda nu, mu: np.full((mu.size, nu.size), 0.8)}),
        (
            "what_the_sky_sends_and_what_the_sea_emits_is_all",
            {"reflection_weights": lambda nu, mu, nodes, basis="lagrange": fold(nu, mu, nodes, 0.021)},
        ),
        (
            "what_the_sky_sends_and_what_the_sea_emits_is_all",
            {
                "reflection_weights": lambda nu, mu, nodes, basis="linear": fold(
                    nu, mu, nodes, basis == "linear"
                )
            },
        ),
        (
            "what_the_sky_sends_and_what_the_sea_emits_is_all",
            {
                "reflection_weights": lambda nu, mu, nodes, basis="lagrange": fold(nu, mu, nodes).swapaxes(
                    1, 2
                )
            },
        ),
    ],
)
def test_kit_refuses_a_sea_that_breaks_a_law(law, methods):
    with pytest.raises(AssertionError):
        getattr(SeaModelContract(), f"test_{law}")(broken_sea(**methods), NU)


class TiltedSea(PlainSea):
    """Emits and reflects more toward the wind than away from it."""

    anisotropic = True
    share = 0.2
    mean = 1.0

    def _turn(self, wind):
        return self.mean if wind is None else (1.0 + self.share * np.cos(wind))[:, None]

    def emissivity(self, nu, mu, wind_azimuth=None):
        return 1.0 - (1.0 - super().emissivity(nu, mu)) * self._turn(wind_azimuth)

    def brdf(self, nu, mu_out, mu_in, relative_azimuth, wind_azimuth=None):
        # the mean over both directions, so that exchanging them changes nothing
        both = (None, None) if wind_azimuth is None else (wind_azimuth, wind_azimuth + relative_azimuth)
        turn = 0.5 * (self._turn(both[0]) + self._turn(both[1]))
        return super().brdf(nu, mu_out, mu_in, relative_azimuth) * turn

    def reflection_weights(self, nu, mu, mu_nodes, basis="lagrange", wind_azimuth=None):
        left = 1.0 - self.emissivity(nu, mu, wind_azimuth)
        return np.repeat(left[:, None, :] / mu_nodes.size, mu_nodes.size, axis=1)


class TestTiltedSea(SeaModelContract):
    def make_provider(self, inputs):
        return TiltedSea()


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        ("without_a_bearing_results_are_means_over_all", {"mean": 1.3}),
        (
            "without_a_bearing_results_are_means_over_all",
            {
                "brdf": lambda nu, out, into, az, wind=None: np.full(
                    (out.size, nu.size), 1 if wind is None else 2
                )
            },
        ),
        (
            "without_a_bearing_results_are_means_over_all",
            {"reflection_weights": lambda nu, mu, nodes, basis="", wind_azimuth=None: fold(nu, mu, nodes)},
        ),
        (
            "anisotropic_brdf_is_reciprocal_at_every_bearing",
            {"brdf": lambda nu, out, into, az, wind: (2.0 + np.cos(wind))[:, None] * np.ones(nu.size)},
        ),
    ],
)
def test_kit_refuses_an_anisotropic_sea_that_breaks_a_law(law, changes):
    sea = TiltedSea()
    vars(sea).update(changes)
    with pytest.raises(AssertionError):
        getattr(SeaModelContract(), f"test_{law}")(sea, NU)


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
        (
            "scattering_cosine_has_a_variance",
            {"moments": lambda bulk: np.vstack((bulk.moments, 0.4 + 0 * NU))},
        ),
        ("ranges", {"moments": lambda bulk: np.array([[1.0], [3.0]]) * bulk.moments}),
    ],
)
def test_kit_refuses_optics_that_break_a_law(law, change):
    class Broken(PlainOptics):
        def single_scattering(self, cloud, wavenumber_cm1):
            bulk = super().single_scattering(cloud, wavenumber_cm1)
            return dataclasses.replace(bulk, **{name: make(bulk) for name, make in change.items()})

    with pytest.raises(AssertionError):
        getattr(OpticsContract(), f"test_{law}")(Broken(), sample_microphysics(), NU)


@pytest.mark.parametrize("key", [lambda cloud: cloud.number_density_m3, lambda cloud: None])
def test_kit_refuses_optics_that_take_other_particles_for_the_same(key):
    class Remembers(PlainOptics):
        def __init__(self):
            super().__init__()
            self.known = {}

        def single_scattering(self, cloud, wavenumber_cm1):
            bulk = super().single_scattering(cloud, wavenumber_cm1)
            mine = dataclasses.replace(bulk, albedo=0.0 * bulk.albedo + min(1.0, 0.5 * cloud.b))
            return self.known.setdefault(key(cloud), mine)

    class Kit(OpticsContract):
        def make_provider(self, inputs):
            return Remembers()

    with pytest.raises(AssertionError):
        Kit().test_result_does_not_depend_on_earlier_calls(
            Remembers(), sample_optics_inputs(), sample_microphysics(), NU
        )


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


@pytest.mark.parametrize("wrong", ["speed_x", "speed_y"])
def test_kit_refuses_clouds_that_drift_the_other_way(wrong):
    class Backward(Checkerboard):
        def __init__(self, inputs):
            super().__init__(inputs)
            setattr(self, wrong, -getattr(self, wrong))

    class Kit(CloudGeneratorContract):
        def make_provider(self, inputs):
            return Backward(inputs)

    with pytest.raises(AssertionError):
        Kit().test_frozen_field_only_translates(sample_cloud_inputs())


def test_kit_refuses_clouds_that_threads_disturb():
    class Shares(Checkerboard):
        def thickness_m(self, time_s, rows, columns):
            self.now = time_s
            barrier.wait()  # all threads have written before any reads
            return super().thickness_m(self.now, rows, columns)

    barrier = threading.Barrier(3)
    provider = Shares(sample_cloud_inputs())
    alone = Checkerboard(sample_cloud_inputs())
    provider_alone = provider.thickness_m

    def thickness_m(time_s, rows, columns):
        if threading.current_thread() is threading.main_thread():
            return alone.thickness_m(time_s, rows, columns)
        return provider_alone(time_s, rows, columns)

    provider.thickness_m = thickness_m
    with pytest.raises(AssertionError):
        CloudGeneratorContract().test_field_does_not_depend_on_threads(provider, sample_cloud_inputs())


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
        (
            "radiance_is_positive",
            {"clear": lambda nu, sun: {"surface": -np.ones(nu.size), "glint": np.ones(nu.size)}},
        ),
        (
            "result_does_not_depend_on_batching",
            {"cloudy": lambda nu, z, sun: {each: z / z.max() * np.ones(nu.size) for each in GreyModel.terms}},
        ),
        (
            "result_does_not_depend_on_other_wavenumbers",
            {"clear": lambda nu, sun: {each: nu / nu.max() for each in GreyModel.terms}},
        ),
        (
            "result_does_not_depend_on_other_wavenumbers",
            {
                "cloudy": lambda nu, z, sun: {
                    each: np.ones((len(z), 1)) * nu / nu.sum() for each in GreyModel.terms
                }
            },
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

    kit, model, _ = model_kit(cloudy=cloudy, declares=Declares())
    with pytest.raises(AssertionError):
        kit.test_undeclared_thickness_and_sun_have_no_influence(model, NU)


def test_kit_refuses_clear_columns_that_know_the_layers():
    class Tinted(GreyModel):
        def __init__(self, inputs):
            self.count = len(inputs.layers)

        def clear(self, wavenumber_cm1, sun):
            return {each: np.full(wavenumber_cm1.size, 1.0 + self.count) for each in self.terms}

    class Kit(RadianceModelContract):
        def make_provider(self, inputs):
            return Tinted(inputs)

    inputs = sample_radiance_inputs()
    with pytest.raises(AssertionError):
        Kit().test_clear_columns_do_not_depend_on_the_layers(Tinted(inputs), inputs, NU, SUN)


def test_kit_refuses_columns_of_two_layers_that_break_a_law():
    kit, model, inputs = model_kit(
        cloudy=lambda nu, z, sun: {each: z[:, :1] / z.max() * np.ones(nu.size) for each in GreyModel.terms}
    )
    with pytest.raises(AssertionError):
        kit.test_columns_of_two_layers(model, NU, SUN)
    kit, model, inputs = model_kit(
        cloudy=lambda nu, z, sun: {each: np.full((len(z), nu.size), z.shape[1]) for each in GreyModel.terms}
    )
    with pytest.raises(AssertionError):
        kit.test_a_layer_without_cloud_has_no_influence(model, inputs, NU, SUN)


@pytest.mark.parametrize(
    ("kit", "provider", "said"),
    [
        (SeaModelContract(), broken_sea(declares=Declares(depends_on=frozenset({"weather"}))), "weather"),
        (SeaModelContract(), broken_sea(significant_wave_height_m="2 m"), "significant_wave_height_m"),
        (SeaModelContract(), broken_sea(anisotropic="yes"), "anisotropic"),
        (SeaModelContract(), broken_sea(declares=Declares(valid={"wavenumber": (1, 2)})), "'wavenumber_cm1'"),
        (SeaModelContract(), broken_sea(declares=Declares(notes="text")), "tuple of strings"),
        (SeaModelContract(), broken_sea(declares=Declares(resolution_cm1=-1.0)), "resolution_cm1"),
        (SeaModelContract(), broken_sea(declares=Declares(tileable="no")), "tileable"),
        (
            SeaModelContract(),
            broken_sea(declares=Declares(native_grid_cm1=np.array([2.0, 1.0]))),
            "native_grid",
        ),
        (SeaModelContract(), broken_sea(declares=Declares(legs="space")), "to_space"),
        (CloudGeneratorContract(), broken_sea(skipped=["waves", "too small"]), "pairs of text"),
        (CloudGeneratorContract(), broken_sea(image_coverage=1.5), "from 0 to 1"),
        (TransmittanceContract(), broken_sea(path_radiance=3.0), "path_radiance"),
        (OpticsContract(), broken_sea(declares=Declares(valid={"wavenumber_cm1": (2, 1)})), "low, high"),
        (RadianceModelContract(), broken_sea(declares=Declares(valid={"wavenumber_cm1": (1,)})), "low, high"),
    ],
)
def test_kit_refuses_an_unsound_declaration(kit, provider, said):
    with pytest.raises(ValueError, match=said):
        kit.test_declaration_is_sound(provider)


def test_kit_refuses_solar_terms_that_are_no_terms():
    _, model, _ = model_kit(solar_terms=frozenset({"glow"}))
    with pytest.raises(AssertionError):
        RadianceModelContract().test_declaration_is_sound(model)


def laws(kit):
    return {name for name in vars(kit) if name.startswith("test_")}


def test_every_law_of_the_kit_is_broken_by_a_provider_of_this_file():
    here = Path(__file__).read_text(encoding="utf-8")
    for kit in (
        CloudGeneratorContract,
        SeaModelContract,
        OpticsContract,
        TransmittanceContract,
        RadianceModelContract,
    ):
        for law in laws(kit):
            refused = f'"{law.removeprefix("test_")}"' in here or f".{law}(" in here
            assert refused, f"{kit.__name__}.{law} has no provider that breaks it"


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
