"""One plugin of each kind, written from the guide: the kit accepts it, and a scene runs with it."""

import json

import numpy as np
import pytest
import stranger
from cheap import CHEAP
from hcss_author import (
    CloudGeneratorContract,
    ElementContract,
    OpticsContract,
    RadianceModelContract,
    SeaModelContract,
    SensorContract,
    SurfaceContract,
    TransmittanceContract,
    VariableContract,
    assert_registered,
    sample_atmosphere_inputs,
)
from installed_providers import install
from stranger.atmosphere import Malkmus
from stranger.atmosphere import Parameters as MalkmusParameters
from stranger.clouds import CloudStreets
from stranger.clouds import Parameters as StreetParameters
from stranger.elements import Parameters as ShipParameters
from stranger.elements import Ship
from stranger.optics import Parameters as SoftParameters
from stranger.optics import SoftParticles
from stranger.radiance import Absorbing
from stranger.radiance import Parameters as AbsorbingParameters
from stranger.sea import Parameters as SlushParameters
from stranger.sea import Slush
from stranger.sensor import Lagging
from stranger.sensor import Parameters as LaggingParameters
from stranger.surfaces import Floe
from stranger.surfaces import Parameters as FloeParameters
from stranger.variables import Parameters as SlantParameters
from stranger.variables import Slant

import hcss_twin
from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import CubeError, ProviderError
from hcss_twin.engine.simulate import overlaps
from hcss_twin.physics.paths import to_space
from hcss_twin.providers.registry import Kind, Origin, ProviderSpec, Registry, hookimpl

CHOICES = {
    Kind.CLOUDS: ("clouds.generator", "streets"),
    Kind.SEA: ("sea.model", "slush"),
    Kind.OPTICS: ("optics.provider", "soft"),
    Kind.ATMOSPHERE: ("atmosphere.provider", "malkmus"),
    Kind.RADIANCE: ("radiance.model", "absorbing"),
    Kind.ELEMENTS: ("elements", "ship"),
    Kind.SURFACES: ("surfaces.provider", "floe"),
    Kind.VARIABLES: ("output.derived", "slant"),
    Kind.SENSORS: ("sensor.model", "lagging"),
}

OF_THE_CLEAN_CUBE = {kind: choice for kind, choice in CHOICES.items() if kind not in (Kind.SENSORS, Kind.VARIABLES)}


class TestCloudStreets(CloudGeneratorContract):
    def make_provider(self, inputs):
        return CloudStreets(inputs, StreetParameters())


class TestSlush(SeaModelContract):
    def make_provider(self, inputs):
        return Slush(inputs, SlushParameters())


class TestSoftParticles(OpticsContract):
    def make_provider(self, inputs):
        return SoftParticles(inputs, SoftParameters())


class TestMalkmus(TransmittanceContract):
    def make_provider(self, inputs):
        return Malkmus(inputs, MalkmusParameters())


class TestAbsorbing(RadianceModelContract):
    def make_provider(self, inputs):
        return Absorbing(inputs, AbsorbingParameters())


class TestShip(ElementContract):
    def make_provider(self, inputs):
        return Ship(inputs, ShipParameters())


class TestFloe(SurfaceContract):
    def make_provider(self, inputs):
        return Floe(inputs, FloeParameters())


class TestSlant(VariableContract):
    def make_provider(self, inputs):
        return Slant(inputs, SlantParameters())


class TestLagging(SensorContract):
    def make_provider(self, inputs):
        return Lagging(inputs, LaggingParameters())


def test_saturated_legs_do_not_multiply():
    gas = Malkmus(sample_atmosphere_inputs(), MalkmusParameters(depth=5.0))
    down, up = to_space(0.0, 40.0), to_space(0.0, 20.0)
    one, other, both = gas.transmittance(np.array([1000.0]), [down, up, down + up])
    assert np.all(both > 1.2 * one * other)


@pytest.fixture
def installed(monkeypatch):
    """All of them beside the built-in providers."""
    install(monkeypatch, stranger, "stranger")


@pytest.mark.parametrize("kind", CHOICES)
def test_it_is_soundly_registered(installed, kind):
    assert_registered(kind, CHOICES[kind][1], distribution="hcss-stranger")


@pytest.mark.long
def test_frames_of_a_stranger_are_not_written_beside_the_computing_because_it_may_read_netcdf(installed):
    def beside(**overrides):
        return overlaps(make_plan(Scenario.load("stratus", {**CHEAP, **overrides})))

    assert beside()
    assert not beside(**{"clouds.generator": "streets"})
    # Seas are asked in frames only where they draw waves.
    assert beside(**{"sea.model": "slush"})


def test_the_plan_names_who_says_a_note(installed):
    made = make_plan(Scenario.load("stratus", {**CHEAP, "radiance.model": "absorbing"}))
    assert (
        "radiance model absorbing: absorbing radiance: clouds do not scatter, and the sea reflects no sky" in made.notes
    )


@pytest.mark.parametrize("key", [{"clouds.edge_taper": 0.3}, {"clouds.coverage_mode": "field"}])
def test_the_plan_tells_keys_of_a_layer_that_a_generator_does_not_say_it_honours(installed, key):
    ((name, value),) = key.items()

    def told(**chosen):
        notes = make_plan(Scenario.load("stratus", {**CHEAP, **chosen})).notes
        return [note for note in notes if "honours" in note]

    (note,) = told(**key, **{"clouds.generator": "streets"})
    assert note.startswith("cloud generator streets: ")
    assert f"honours {name.partition('.')[2]} = {value!r}" in note
    assert not told(**key)
    assert not told(**{"clouds.generator": "streets"})


class Misdirected:
    """Hooks whose targets are no providers."""

    @hookimpl
    def hcss_register_sea_models(self):
        return [
            ProviderSpec("parameters-only", "stranger.sea:Parameters", None, 3, "the wrong class"),
            ProviderSpec("nowhere", "stranger.sea:Slosh", None, 3, "a misspelt class"),
        ]

    @hookimpl
    def hcss_register_transmittance_providers(self):
        return [ProviderSpec("bound-to-text", f"{__name__}:BoundToText", None, 3, "a profile by name")]


class BoundToText(Malkmus):
    @staticmethod
    def bound_profile(parameters, catalog):
        return "us-standard-1976"


@pytest.mark.parametrize(
    ("kind", "name", "error", "message"),
    [
        ("sea", "parameters-only", AssertionError, "lacks .*'emissivity', 'brdf'"),
        ("sea", "nowhere", ProviderError, "cannot import 'stranger.sea:Slosh'"),
        ("atmosphere", "bound-to-text", ProviderError, r"bound_profile\(\) returned str"),
    ],
)
def test_kit_refuses_a_registration_that_leads_nowhere(installed, kind, name, error, message):
    Registry.discover().add(Misdirected(), Origin("misdirected", "hcss-misdirected", "1.0"))
    with pytest.raises(error, match=message):
        assert_registered(kind, name, distribution="hcss-misdirected")


SCENE = """
place = {latitude = 35.0, longitude = 150.0}
time = 2024-04-20T12:30:00+10:00
image = {rows = 24, columns = 32}
frames.count = 2
bands = ["mwir-3.7", "lwir-10.8"]
accuracy = 1e-2
output.certificate = 4
clouds = {type = "stratus", coverage = 0.5}
radiance.model = "as-printed"
sea.model = "cox-munk"
"""


def cube(choices):
    chosen = {key: [{"provider": name}] if key == "elements" else name for key, name in choices}
    return hcss_twin.simulate(hcss_twin.Scenario.from_toml(SCENE, chosen))


@pytest.fixture(scope="module")
def usual():
    return cube([])


def assert_runs_and_differs(choices, usual):
    other = cube(choices)
    assert np.all(np.isfinite(other["radiance"]))
    assert np.all(other["radiance"] > 0.0)
    assert not np.array_equal(usual["radiance"], other["radiance"])
    providers = json.loads(other.attrs["hcss_providers"]).values()
    used = {each["name"] for each in providers if each["distribution"] == "hcss-stranger"}
    assert used == {name for _, name in choices}


@pytest.mark.long
def test_a_scene_runs_with_all_of_them(installed, usual):
    assert_runs_and_differs(list(OF_THE_CLEAN_CUBE.values()), usual)


def test_a_stranger_sensor_measures_the_frames_in_order(installed, usual):
    measured = hcss_twin.sense(usual, {"model": "lagging", "parameters": {"part": 0.25}})
    first, second = usual["radiance"].to_numpy().astype(float)
    np.testing.assert_allclose(measured["radiance"][0], first, rtol=1e-6)
    np.testing.assert_allclose(measured["radiance"][1], 0.75 * second + 0.25 * first, rtol=1e-6)
    assert json.loads(measured.attrs["hcss_providers"])["sensors"]["distribution"] == "hcss-stranger"
    with pytest.raises(CubeError, match="out of order, and the sensor 'lagging' needs earlier ones"):
        hcss_twin.sense(usual.isel(time=[1, 0]), {"model": "lagging"})


@pytest.mark.long
@pytest.mark.parametrize("kind", OF_THE_CLEAN_CUBE)
def test_a_scene_runs_with_one_among_the_built_in(installed, usual, kind):
    assert_runs_and_differs([CHOICES[kind]], usual)
