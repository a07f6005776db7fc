"""Chains of sensor stages, and stages that ask for the scene at other instants, against closed forms."""

import json

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from hcss_author import SensorContract, sample_sensor_inputs
from installed_providers import install
from pydantic import BaseModel, ConfigDict
from written_cubes import loaded, measured_and_clean

from hcss_twin import Scenario, make_plan, sense
from hcss_twin.core.errors import CubeError, ProviderError, ScenarioError
from hcss_twin.engine import parts
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.providers import Measured, SensorDeclaration
from hcss_twin.providers.registry import ProviderSpec, hookimpl

SPEED, DELAY, EXPOSURE = 130.0, 0.004, 0.9  # m/s, s per row, s
BASE = {
    **CHEAP,
    "time": "2024-04-20T22:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 12, "columns": 40, "pixel_size": 20.0},
    "frames": {"count": 2, "first": 3, "interval": 2.0},
    "bands": NARROW,
    "accuracy": 1e-2,
    "output": {"variables": ["radiance"], "certificate": 0},
}


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    delay: float = DELAY
    exposure: float = EXPOSURE
    count: int = 15
    kernel: tuple[float, ...] = (0.25, 0.5, 0.25)


class RollingShutter:
    """Row after row, the first of the image at the time of the frame."""

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)

    def __init__(self, inputs, parameters):
        self._inputs, self._delay = inputs, parameters.delay
        first = inputs.corner[0]
        ends = first * self._delay, (first + inputs.grid.rows) * self._delay
        self.instants = min(*ends, 0.0), max(*ends, 0.0)

    def measure(self, radiance, frame, time_s):
        grid, corner, measured = self._inputs.grid, self._inputs.corner[0], np.empty(radiance.shape)
        for row in range(grid.rows):
            late = time_s + (corner + row) * self._delay
            measured[:, row] = self._inputs.scene_at(late, slice(row, row + 1), slice(0, grid.columns))[:, 0]
        return Measured(measured)


class Integrating:
    """Mean over the exposure, which begins with the frame."""

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)

    def __init__(self, inputs, parameters):
        self._inputs, self._exposure, self._count = inputs, parameters.exposure, parameters.count
        self.instants = 0.0, parameters.exposure

    def measure(self, radiance, frame, time_s):
        grid = self._inputs.grid
        times = time_s + (np.arange(self._count) + 0.5) / self._count * self._exposure
        whole = slice(0, grid.rows), slice(0, grid.columns)
        return Measured(np.mean([self._inputs.scene_at(time, *whole) for time in times.tolist()], axis=0))


class Smearing:
    """Convolution along the rows; the mirror image beyond the edges."""

    variables = ()

    def __init__(self, inputs, parameters):
        self._kernel = np.array(parameters.kernel)
        self._reach = len(parameters.kernel) // 2
        self.declares = SensorDeclaration(reach_pixels=self._reach)

    def measure(self, radiance, frame, time_s):
        wide = np.pad(radiance, ((0, 0), (0, 0), (self._reach, self._reach)), mode="symmetric")
        shifted = (wide[..., n : n + radiance.shape[2]] for n in range(len(self._kernel)))
        return Measured(sum(share * each for share, each in zip(self._kernel[::-1], shifted, strict=True)))


class Curious(RollingShutter):
    """Asks for more than it declares."""

    def measure(self, radiance, frame, time_s):
        return Measured(self._inputs.scene_at(time_s - 1.0, slice(0, 1), slice(0, 1)))


class Secretive(Smearing):
    """Asks without declaring it."""

    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._inputs = inputs

    def measure(self, radiance, frame, time_s):
        return Measured(self._inputs.scene_at(time_s, slice(0, 1), slice(0, 1)))


class Remembering(Smearing):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self.declares = SensorDeclaration(reach_pixels=1, remembers=True)


class TestRollingShutter(SensorContract):
    def make_provider(self, inputs):
        return RollingShutter(inputs, Parameters())


class TestIntegrating(SensorContract):
    def make_provider(self, inputs):
        return Integrating(inputs, Parameters())


class TestSmearing(SensorContract):
    def make_provider(self, inputs):
        return Smearing(inputs, Parameters())


@pytest.mark.parametrize(
    ("sensor", "message"),
    [(Curious, "-1 s after the frame, not in"), (Secretive, "calls scene_at and has no attribute instants")],
)
def test_the_kit_refuses_undeclared_instants(sensor, message):
    contract = TestRollingShutter()
    contract.make_provider = lambda inputs: sensor(inputs, Parameters())
    with pytest.raises(AssertionError, match=message):
        contract.test_the_scene_is_asked_for_as_declared(sample_sensor_inputs())


class Plugin:
    @hookimpl
    def hcss_register_sensors(self):
        names = ("RollingShutter", "Integrating", "Smearing", "Curious", "Secretive", "Remembering")
        return [ProviderSpec(each.lower(), f"{__name__}:{each}", f"{__name__}:Parameters", 3, "test") for each in names]


@pytest.fixture(scope="module", autouse=True)
def installed():
    with pytest.MonkeyPatch.context() as patch:
        install(patch, Plugin())
        yield


def sources(velocity, altitude=300.0):
    """One source in the middle of each row, which moves along it; its square is a pixel of the ground."""
    return [
        {"x": -170.0 - 6.0 * velocity, "y": 20.0 * (row - 6) + 10.0, "altitude": altitude, "velocity": [velocity, 0, 0],
         "intensity": 1e4} for row in range(12)
    ]  # fmt: skip


def planned(stages, tracks=(), **changes):
    elements = [{"parameters": {"tracks": list(tracks), "footprint": 20.0}}] if tracks else []
    raw = {key: value for key, value in BASE.items() if key not in CHEAP}
    sensor = {"stages": [{"model": model, "parameters": parameters} for model, parameters in stages]}
    return make_plan(Scenario.from_dict({**raw, "elements": elements, "sensor": sensor}, {**CHEAP, **changes}))


def measured(path, stages, tracks=(), **changes):
    """The measured cube of a run, and its clean one."""
    run(planned(stages, tracks, **changes), path)
    return measured_and_clean(path)


def centroids(radiance):
    """Column of the energy in each row (F, B, y), and the energy, above the background at the first column."""
    more = radiance - radiance[..., :1]
    columns = np.arange(radiance.shape[-1]) + 0.5
    return (more @ columns) / more.sum(axis=-1), more.sum(axis=-1)


def test_a_rolling_shutter_displaces_rows_by_velocity_times_delay(tmp_path):
    shutter, clean = measured(tmp_path / "rolling.nc", [("rollingshutter", {})], sources(SPEED))
    (column, energy), (before, whole) = (centroids(each.radiance.to_numpy().astype(float)) for each in (shutter, clean))
    expected = SPEED * DELAY * np.arange(12) / 20.0
    np.testing.assert_allclose(column - before, np.broadcast_to(expected, column.shape), rtol=0, atol=2e-4)
    np.testing.assert_allclose(energy, whole, rtol=2e-4)
    start = (-170.0 / 20.0 + 20.0) + SPEED / 20.0 * np.array([0.0, 2.0])
    np.testing.assert_allclose(before, np.broadcast_to(start[:, None, None], before.shape), rtol=0, atol=2e-4)


def test_integration_keeps_the_energy_and_its_centroid_is_that_of_mid_time(tmp_path):
    exposed, clean = measured(tmp_path / "exposed.nc", [("integrating", {})], sources(SPEED))
    (column, energy), (before, whole) = (centroids(each.radiance.to_numpy().astype(float)) for each in (exposed, clean))
    np.testing.assert_allclose(column - before, SPEED * 0.5 * EXPOSURE / 20.0, rtol=0, atol=2e-4)
    np.testing.assert_allclose(energy, whole, rtol=2e-4)
    more = exposed.radiance.to_numpy() - exposed.radiance.to_numpy()[..., :1]
    length = SPEED * EXPOSURE / 20.0 + 1.0  # of the streak, with the side of the square, pixels
    assert np.all((more > 1e-3 * more.max()).sum(axis=-1) <= np.ceil(length) + 1)


@pytest.mark.parametrize("order", [("rollingshutter", "integrating"), ("integrating", "rollingshutter")])
def test_instants_of_a_chain_add(tmp_path, order):
    stages = [(model, {"exposure": 0.2, "count": 3}) for model in order]
    both, clean = measured(tmp_path / "both.nc", stages, sources(SPEED), **{"frames.count": 1})
    column, _ = centroids(both.radiance.to_numpy().astype(float))
    before, _ = centroids(clean.radiance.to_numpy().astype(float))
    expected = SPEED * (DELAY * np.arange(12) + 0.1) / 20.0
    np.testing.assert_allclose(column - before, np.broadcast_to(expected, column.shape), rtol=0, atol=2e-4)


CLOUDS = {
    "clouds": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"},
    "motion.platform_speed": 200.0,
    "motion.wind_speed": 0.0,
    "motion.evolution_time": "frozen",
}


def test_a_moving_cloud_is_displaced_as_the_scene_moves(tmp_path):
    """The platform moves by a whole pixel in each row's delay, so row r is row r of the cloud field r pixels on."""
    shutter, clean = measured(tmp_path / "cloud.nc", [("rollingshutter", {"delay": 0.1})], **CLOUDS)
    one, other = shutter.radiance.to_numpy(), clean.radiance.to_numpy()
    for row in range(12):
        np.testing.assert_allclose(one[:, :, row, : 40 - row], other[:, :, row, row:], rtol=1e-6)
    assert not np.allclose(one[:, :, 5], other[:, :, 5])


def test_two_linear_stages_are_the_composed_single_stage(tmp_path):
    first, second = (0.1, 0.2, 0.4, 0.2, 0.1), (0.7, 0.2, 0.1)
    composed = np.convolve(first, second).tolist()
    chain, _ = measured(tmp_path / "chain.nc", [("smearing", {"kernel": k}) for k in (first, second)], **CLOUDS)
    single, clean = measured(tmp_path / "single.nc", [("smearing", {"kernel": composed})], **CLOUDS)
    np.testing.assert_allclose(chain.radiance, single.radiance, rtol=3e-7)
    assert not np.allclose(chain.radiance, clean.radiance)
    plan = planned([("smearing", {"kernel": k}) for k in (first, second)], **CLOUDS)
    assert plan.sensor.reach == 3
    rows, columns = plan.sensor.given
    assert (rows.start, columns.start) == (-3, -3)
    assert rows.stop >= 15
    assert columns.stop >= 43  # more where transforms of that size are faster


def test_one_stage_is_the_single_sensor(tmp_path):
    noisy = {"noise": "nedt", "nedt": 0.1, "psf": "gaussian", "psf_sigma": 1.2}
    chain, _ = measured(tmp_path / "one.nc", [("radiometer", noisy)], **CLOUDS)
    plan = planned([], **{"sensor": {"parameters": noisy}, **CLOUDS})
    run(plan, tmp_path / "alone.nc")
    np.testing.assert_array_equal(chain.radiance, loaded(tmp_path / "alone.sensor.nc").radiance)
    assert "stages" not in json.loads(plan.scenario.to_json())["sensor"]


NOISE = {"noise": "nedt", "nedt": 0.1}
CHAIN = [("smearing", {}), ("rollingshutter", {}), ("radiometer", NOISE), ("radiometer", {**NOISE, "bits": 12,
         "radiance_per_number": 0.01})]  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("stages") / "whole.nc"
    run(planned(CHAIN, sources(SPEED), **CLOUDS, **{"sensor.variables": ["all"]}), path)
    return path.with_name("whole.sensor.nc")


def test_windows_tiles_and_verification_have_the_same_bits(tmp_path, whole):
    every = {"sensor.variables": ["all"], **CLOUDS}
    window = {"image.window": {"rows": [3, 9], "columns": [5, 31]}}
    part, _ = measured(tmp_path / "part.nc", CHAIN, sources(SPEED), **every, **window)
    full = loaded(whole)
    for name in ("radiance", "digital_number", "saturated"):
        np.testing.assert_array_equal(part[name], full[name][:, :, 3:9, 5:31], name)
    assert verify_cube(whole).verdict is Verdict.IDENTICAL
    # Patches of its own, on which no analysis of the scene depends: that of the whole serves.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts, "LARGEST_FRAME_BYTES", 1)
        patch.setattr(parts, "TILE_PIXELS", 90)
        tiled, _ = measured(tmp_path / "tiles.nc", CHAIN, sources(SPEED), **every)
    np.testing.assert_array_equal(tiled.radiance, full.radiance)
    assert full.attrs["instrument"] == "smearing, then rollingshutter, then radiometer, then radiometer"


def test_a_sensor_measures_radiance_that_is_not_written(tmp_path, whole):
    every = {"sensor.variables": ["all"], "output.variables": ["cloud_mask"], "output.compression": 4, **CLOUDS}
    mask, clean = measured(tmp_path / "mask.nc", CHAIN, sources(SPEED), **every)
    full = loaded(whole)
    for name in ("radiance", "digital_number", "saturated"):
        np.testing.assert_array_equal(mask[name], full[name], name)
        assert mask[name].coords.keys() == full[name].coords.keys()
    assert "cloud_mask" in clean
    assert "radiance" not in clean
    assert verify_cube(tmp_path / "mask.sensor.nc").verdict is Verdict.IDENTICAL


def test_the_cube_names_every_stage_and_later_stages_have_noise_of_their_own(whole):
    cube = loaded(whole)
    about, providers = json.loads(cube.attrs["hcss_sensor"]), json.loads(cube.attrs["hcss_providers"])
    assert [providers[f"sensors[{n}]"]["name"] for n in range(4)] == [model for model, _ in CHAIN]
    seeds = [stage["seed"] for stage in about["stages"]]
    assert len(set(seeds)) == 4
    assert any("asks for the scene" in note for note in about["notes"])
    assert len(json.loads(cube.attrs["hcss_scenario"])["sensor"]["stages"]) == 4


def test_the_scene_at_the_time_of_a_frame_is_the_frame():
    plan = planned([("rollingshutter", {})], **CLOUDS)
    maker = PartMaker(plan, tables_of(plan))
    frame, _ = maker.part(1, plan.extent)
    other, _ = maker.part(0, plan.extent, time_s=float(plan.frame_times_s[1]))
    np.testing.assert_array_equal(frame["radiance"], other["radiance"])


@pytest.mark.parametrize("band", ["mwir", {"name": "sunlit", "limits": [3.7, 3.8]}])
def test_by_day_the_sun_of_other_instants_is_known(tmp_path, band):
    """Three hours after the only frame: the radiance of a frame at that time."""
    noon = {"time": "2024-04-20T09:30:00+10:00", "frames": {"count": 1}, "accuracy": 1e-2, "bands": [band]}
    late, clean = measured(tmp_path / "late.nc", [("rollingshutter", {"delay": 900.0})], **noon)
    after = {**noon, "time": "2024-04-20T12:15:00+10:00", "sensor": None}
    run(planned([], **after), tmp_path / "after.nc")
    frame = loaded(tmp_path / "after.nc").radiance.to_numpy()
    np.testing.assert_allclose(late.radiance.to_numpy()[:, :, 11], frame[:, :, 11], rtol=5e-3)
    assert not np.allclose(clean.radiance.to_numpy()[:, 0, 11], frame[:, 0, 11], rtol=4e-2)


def test_a_finished_cube_refuses_such_a_stage_by_name(tmp_path):
    _, clean = measured(tmp_path / "clean.nc", [("smearing", {})])
    stages = [{"model": "smearing"}, {"model": "integrating"}]
    message = (
        r"sensor.stages\[1\]: 'integrating' asks for the scene at other instants, and a cube holds only its frames"
    )
    for cube in (clean, tmp_path / "clean.nc"):
        with pytest.raises(CubeError, match=message):
            sense(cube, {"stages": stages})
    assert sense(clean, {"stages": stages[:1]}).radiance.shape == clean.radiance.shape


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ("curious", "sensor model 'curious' .*scene_at: -1 s after the frame is not among the instants 0 to 0.048 s"),
        ("secretive", "sensor model 'secretive' .*scene_at: the sensor has no attribute instants"),
    ],
)
def test_undeclared_instants_are_refused_with_the_name_of_the_sensor(tmp_path, model, message):
    with pytest.raises(ProviderError, match=message):
        measured(tmp_path / "never.nc", [(model, {})])


@pytest.mark.parametrize(
    ("sensor", "field", "message"),
    [
        ({"model": "smearing", "stages": [{}]}, "sensor", "model with [[sensor.stages]]; allowed: these keys in"),
        ({"stages": [{}, {"model": "smear"}]}, "sensor.stages[1].model", "closest is 'smearing'"),
        ({"stages": [{"name": "nowhere"}]}, "sensor.stages[0].name", "nowhere"),
        ({"stages": [{"parameters": {"psff": 1}}]}, "sensor.stages[0].parameters.psff", "closest is 'psf'"),
        ({"stages": [{}, {"parameters": {"noise": "nedt", "nedt": {"mwir": 1}}}]}, "sensor.stages[1].parameters.nedt",
         "gives no number for band 'lwir'"),
        ({"stages": [{"psf": "airy"}]}, "sensor.stages[0].psf", "closest is 'sensor.stages[0].parameters.psf'"),
        ({"stages": [{}], "variables": ["photon_rate"]}, "sensor.variables", "not an output of the sensor"),
        ({"stages": [{"model": "remembering"}, {"model": "integrating"}]}, "sensor.stages[1].model",
         "'remembering' remembers earlier frames; allowed: the other order"),
    ],
)  # fmt: skip
def test_wrong_stages_name_field_and_what_is_allowed(sensor, field, message):
    with pytest.raises(ScenarioError) as error:
        planned([], **{"sensor": sensor})
    assert [each.field for each in error.value.problems] == [field]
    assert message in error.value.problems[0].message


SHADOWS = {
    **CLOUDS,
    "image.pixel_size": 50.0,
    "clouds": {"type": "stratus", "base": 2000.0, "top": 2300.0, "coverage": 0.5, "coverage_mode": "field"},
    "motion.platform_speed": 0.0,
    "time": "2024-04-20T09:30:00+10:00",
    "view": {"zenith": 40.0, "azimuth": 295.0},
    "bands": [[3.9, 3.92]],
    "sea.temperature_texture": 0.0,
    "atmosphere.water_vapour_texture": 0.0,
    "slant.parallax": "off",
    "seed": 2,
}


def test_rows_have_the_shadows_of_their_instants(tmp_path):
    """The sun goes on by half a degree from row to row: each is that of a frame at its time."""
    late = 120.0
    shutter, _ = measured(
        tmp_path / "rows.nc", [("rollingshutter", {"delay": late})], frames={"count": 1}, **SHADOWS,
        **{"slant.shadows": "on"},
    )  # fmt: skip
    frames, seen = {"count": 12, "interval": late}, shutter.radiance.to_numpy()[0]
    for shadows in ("on", "off"):
        _, clean = measured(
            tmp_path / f"{shadows}.nc", [("smearing", {})], frames=frames, **SHADOWS, **{"slant.shadows": shadows}
        )
        of_frames = clean.radiance.to_numpy()
        of_rows = np.stack([of_frames[row, :, row] for row in range(12)], axis=1)
        assert np.max(np.abs(seen / of_rows - 1.0)) < 1e-3 if shadows == "on" else np.max(seen / of_rows) < 1.0 + 1e-3
        # What would be seen without shadows, or with those of the time of the frame, is far from it.
        other = of_rows if shadows == "off" else of_frames[0]
        assert np.max(np.abs(seen / other - 1.0)) > 0.1
