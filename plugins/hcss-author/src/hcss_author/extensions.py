"""Contract tests of extensions: sections, their rays and effects, light between columns, commands."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import Any, ClassVar
from unittest import SkipTest

import click
import numpy as np
import pytest
from click.testing import CliRunner

from hcss_author.extension_entries import Extension, ExtensionEntry, find_extension
from hcss_author.samples import frozen
from hcss_twin import Scenario, make_plan
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.laws import laws_of
from hcss_twin.laws.samples import sample_radiance_inputs
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Array, Catalog, ColumnSetting, Kind, PointEffect, ScenarioError, Sun, to_space
from hcss_twin.providers.light import LightInputs

SCENE = """
place = {latitude = 35.0, longitude = 150.0}
time = 2024-04-20T12:30:00+10:00
image = {rows = 24, columns = 32, pixel_size = 200.0}
frames = {count = 1}
bands = ["lwir-10.8"]
accuracy = 1e-2
clouds = {type = "stratus", coverage = 0.4, coverage_mode = "field"}
radiance.model = "as-printed"
sea = {model = "cox-munk", waves = "off"}
optics.provider = "mie"
slant = {shadows = "off", parallax = "off"}
"""
"""Scene of the laws."""

HEIGHT_M = 1500.0
"""Height at which lines of sight are compared with their views."""

_AIR, _SEA = laws_of(Kind.ATMOSPHERE), laws_of(Kind.SEA)

WAVENUMBERS_CM1 = frozen([900.0, 1000.0, 2500.0])

OF_AIR = (
    *("path_without_legs_transmits_everything", "leg_without_length_transmits_everything"),
    *("dividing_a_leg_changes_nothing", "slant_path_at_60_degrees_is_the_vertical_path_twice"),
    "grazing_paths_transmit_less",
)
OF_SEA = ("brdf_is_reciprocal", "no_more_is_reflected_than_is_not_emitted")
"""Laws of the air and the sea of an effect."""

Question = tuple[str, Callable[[], tuple[Any, ...]], Callable[[], tuple[Any, ...]]]
"""Name of a method, and two sets of arguments."""


class ExtensionContract:
    """Base of the test classes of extensions.

    Attributes
    ----------
    name : str
        Of the installed extension.
    """

    kind: ClassVar[Extension]
    name: str = ""

    @pytest.fixture
    def entry(self) -> ExtensionEntry:
        """The installed extension."""
        entry = find_extension(self.name)
        assert entry is not None, f"no extension is called '{self.name}': is the package installed?"
        return entry


class SectionContract(ExtensionContract):
    """Inherit in a class named ``Test...`` and set ``name``, the key of the section.

    Attributes
    ----------
    settings : mapping
        Keys of the section in the scenarios of the laws; by default none.
    """

    kind = Extension.SECTION
    settings: ClassVar[Mapping[str, Any]] = {}

    @pytest.fixture
    def scenario(self, entry: ExtensionEntry) -> Scenario:
        """A scenario with the section."""
        return Scenario.from_toml(SCENE, {entry.name: dict(self.settings)})

    def test_keys_are_described_and_immutable(self, entry: ExtensionEntry) -> None:
        """Each key has a description, and values cannot be changed after they are checked."""
        model = entry.what.load(entry.what.spec.model)
        assert model.model_config.get("frozen"), "settings must be immutable"
        bare = [key for key, field in model.model_fields.items() if not field.description]
        assert not bare, f"keys without description: {bare}"

    def test_a_misspelt_key_is_refused(self, entry: ExtensionEntry) -> None:
        """A key that the section lacks is a problem of the scenario."""
        with pytest.raises(ScenarioError, match="no_such_key"):
            Scenario.from_toml(SCENE, {entry.name: {**self.settings, "no_such_key": 1}})

    def test_settings_are_recorded_in_scenarios(self, entry: ExtensionEntry, scenario: Scenario) -> None:
        """The scenario that a cube records has the section, and reads the same again."""
        recorded = json.loads(scenario.to_json())
        assert entry.name in recorded
        assert Scenario.from_dict(recorded).sections == scenario.sections


class RaysContract(SectionContract):
    """Inherit in a class named ``Test...`` and set ``name``, the key of the section that brings the rays.

    Attributes
    ----------
    parallax_tolerance : float
        Allowed difference, in parts of the height, between where a line of sight is higher up and where its view says.
    """

    kind = Extension.RAYS
    parallax_tolerance: float = 0.02

    @pytest.fixture
    def rays(self, entry: ExtensionEntry, scenario: Scenario) -> Rays:
        """The rays of the scenario."""
        rays: Rays = entry.what.make(entry.what.spec.rays, scenario, Catalog())
        return rays

    def test_every_pixel_has_points_and_a_position(self, rays: Rays) -> None:
        """Finite or NaN, in the shape of the window; positions from -1 to 1."""
        window, shape = _whole(rays), (rays.image.rows, rays.image.columns)
        points = tuple(size * rays.samples_per_pixel for size in shape)
        for height_m in (0.0, HEIGHT_M):
            for metres in rays.points_m(window, 0.0, height_m):
                assert metres.shape == points
                assert metres.dtype == np.float64
                assert not np.any(np.isinf(metres))
        if rays.directions is not None:
            for places in rays.positions(window, 0.0):
                assert places.shape == shape
                assert np.all(np.isnan(places) | (np.abs(places) <= 1.0 + 1e-9))

    def test_windows_equal_the_whole(self, rays: Rays) -> None:
        """A pixel looks at the same places in any window."""
        rows, columns = rays.image.rows, rays.image.columns
        windows = ((slice(0, rows // 2), slice(columns // 3, columns)), (slice(rows - 1, rows), slice(0, 1)))
        per = rays.samples_per_pixel
        for time_s in (0.0, 3.0):
            whole = rays.points_m(_whole(rays), time_s, 0.0)
            for window in windows:
                inside = tuple(slice(per * part.start, per * part.stop) for part in window)
                for found, expected in zip(rays.points_m(window, time_s, 0.0), whole, strict=True):
                    np.testing.assert_allclose(found, expected[inside], rtol=1e-9, atol=1e-6)
                if rays.directions is not None:
                    for found, expected in zip(
                        rays.positions(window, time_s), rays.positions(_whole(rays), time_s), strict=True
                    ):
                        np.testing.assert_allclose(found, expected[window], rtol=1e-9, atol=1e-12)

    def test_lines_of_sight_lean_toward_the_sensor(self, rays: Rays) -> None:
        """Higher up, a line of sight is nearer to the sensor by height times the tangent of its view's zenith angle."""
        if rays.directions is None:
            pytest.skip("the plan finds out the views")
        rows, columns = (np.unique(np.linspace(0, n - 1, 4).astype(int)) for n in (rays.image.rows, rays.image.columns))
        row, column = (each.ravel() for each in np.meshgrid(rows, columns, indexing="ij"))
        views = rays.views_of_pixels(row.tolist(), column.tolist(), 0.0)
        per = rays.samples_per_pixel
        low, high = (rays.points_m(_whole(rays), 0.0, height_m) for height_m in (0.0, HEIGHT_M))
        compared = 0
        for y, x, view in zip(row, column, views, strict=True):
            pixel = slice(per * y, per * (y + 1)), slice(per * x, per * (x + 1))
            moved = [float(np.mean(above[pixel] - below[pixel])) for below, above in zip(low, high, strict=True)]
            if not np.all(np.isfinite(moved)) or view.zenith_deg > 70.0:
                continue
            compared += 1
            assert 0.0 <= view.zenith_deg < 90.0
            lean = HEIGHT_M * np.tan(np.radians(view.zenith_deg))
            expected = lean * np.sin(np.radians(view.azimuth_deg)), lean * np.cos(np.radians(view.azimuth_deg))
            allowed = self.parallax_tolerance * HEIGHT_M * max(1.0, 1.0 / np.cos(np.radians(view.zenith_deg)) ** 2)
            np.testing.assert_allclose(moved, expected, atol=allowed, rtol=0.0, err_msg=f"row {y}, column {x}")
        assert compared, "no pixel sees the ground and a height"

    def test_rays_are_the_same_in_every_call(self, rays: Rays) -> None:
        """No call changes what another returns, and no random number is drawn."""
        window = _whole(rays)
        part = slice(0, 1), slice(0, 2)
        questions: list[Question] = [("points_m", lambda: (window, 0.0, 0.0), lambda: (part, 3.0, HEIGHT_M))]
        if rays.directions is not None:
            questions.append(("positions", lambda: (window, 0.0), lambda: (part, 3.0)))
        _AIR["no_later_call_changes_a_result"](rays, questions)
        for member, given, _ in questions:
            first, again = (getattr(rays, member)(*given()) for _ in range(2))
            for one, other in zip(first, again, strict=True):
                np.testing.assert_array_equal(one, other)

    def test_a_scene_can_be_planned(self, scenario: Scenario) -> None:
        """The plan takes the rays for its image."""
        plan = make_plan(scenario)
        assert not plan.is_grid


class EffectContract(SectionContract):
    """Inherit in a class named ``Test...`` and set ``name``, the key of the section that brings the effect.

    Attributes
    ----------
    extent_m : float
        Side of the area of the places.
    """

    kind = Extension.EFFECT
    extent_m: float = 40e3

    @pytest.fixture
    def effect(self, entry: ExtensionEntry, scenario: Scenario) -> PointEffect:
        """The effect of the scenario."""
        effect: PointEffect = entry.what.make(entry.what.spec.effect, scenario, Catalog())
        return effect

    def test_the_range_and_its_kinks_are_sound(self, effect: PointEffect) -> None:
        """Low below high, both finite; kinks between them, ascending."""
        assert np.isfinite([effect.low, effect.high]).all()
        assert effect.low < effect.high
        assert list(effect.kinks) == sorted(effect.kinks)
        assert all(effect.low < kink < effect.high for kink in effect.kinks)

    def test_values_are_within_the_range(self, effect: PointEffect) -> None:
        """One number for each place, from low to high."""
        for time_s in (0.0, 3.0, 600.0):
            found = np.asarray(effect.values(*_places(self.extent_m), time_s))
            assert found.shape == (24, 32)
            assert found.dtype.kind == "f"
            assert np.all((found >= effect.low) & (found <= effect.high))

    def test_a_place_does_not_depend_on_others(self, effect: PointEffect) -> None:
        """Some places alone have the values that they have among all, in any order and shape."""
        x_m, y_m = _places(self.extent_m)
        whole = np.asarray(effect.values(x_m, y_m, 3.0))
        np.testing.assert_allclose(effect.values(x_m[5:7, 8::-1], y_m[5:7, 8::-1], 3.0), whole[5:7, 8::-1], rtol=1e-12)
        np.testing.assert_allclose(effect.values(x_m[3], y_m[3], 3.0), whole[3], rtol=1e-12)

    def test_places_and_values_belong_to_the_caller(self, effect: PointEffect) -> None:
        """The arrays of the places are not changed, and a later call changes no earlier result."""
        x_m, y_m = _places(self.extent_m)
        one, other = (lambda: (x_m.copy(), y_m.copy(), 0.0)), (lambda: (y_m.copy(), x_m.copy(), 3.0))
        questions = [("values", one, other)]
        _AIR["arguments_are_left_as_they_were"](effect, None, questions)
        _AIR["no_later_call_changes_a_result"](effect, questions)

    def test_only_sea_and_air_of_a_setting_change(self, effect: PointEffect) -> None:
        """View, sun and cloud layers are those of the setting."""
        setting = _setting()
        for value in _values(effect):
            changed = effect.apply(setting, value)
            assert isinstance(changed, ColumnSetting)
            assert (changed.view, changed.sun, changed.layers) == (setting.view, setting.sun, setting.layers)

    def test_the_number_matters_and_does_so_gradually(self, effect: PointEffect) -> None:
        """The ends of the range differ in sea or air; between kinks a small step changes little."""
        ends = [_seen(effect.apply(_setting(), value)) for value in (effect.low, effect.high)]
        assert np.max(np.abs(ends[1] - ends[0])) > 1e-9, "the ends of the range look alike"
        span = effect.high - effect.low
        for value in np.linspace(effect.low, effect.high, 9)[1:-1].tolist():
            if all(abs(value - kink) > 1e-3 * span for kink in effect.kinks):
                one, other = (_seen(effect.apply(_setting(), at)) for at in (value, value + 1e-6 * span))
                np.testing.assert_allclose(other, one, rtol=1e-3, atol=1e-9, err_msg=f"sea and air at {value:g}")

    def test_changed_air_and_sea_obey_their_laws(self, effect: PointEffect) -> None:
        """Transmittance of no path is 1, and legs can be divided; no more is reflected than is not emitted."""
        for value in _values(effect):
            changed = effect.apply(_setting(), value)
            for laws, names, provider in ((_AIR, OF_AIR, changed.transmittance), (_SEA, OF_SEA, changed.sea)):
                for name in names:
                    with contextlib.suppress(SkipTest):
                        laws[name](provider=provider, wavenumber_cm1=WAVENUMBERS_CM1)

    def test_a_scene_can_be_planned(self, scenario: Scenario) -> None:
        """The plan finds out how many values need tables."""
        plan = make_plan(scenario)
        assert len(plan.point_effects) == 1


class LightContract(ExtensionContract):
    """Inherit in a class named ``Test...`` and set ``name``, the value of ``radiance.light``.

    Attributes
    ----------
    overrides : mapping
        Changes of the scene of the laws.
    clear_tolerance : float
        Allowed relative difference of clear sky from a column without cloud; Monte Carlo has noise.
    reach_tolerance : float
        Allowed influence of cloud beyond the reach, of the greatest thickness, 1, and the radiance of clear sky.
    """

    kind = Extension.LIGHT
    clear_tolerance: float = 0.02
    reach_tolerance: float = 0.01
    overrides: ClassVar[Mapping[str, Any]] = {}

    @pytest.fixture
    def inputs(self) -> LightInputs:
        """Inputs of a small scene of stratus."""
        plan = make_plan(Scenario.from_toml(SCENE, dict(self.overrides)))
        return LightStage.inputs(plan, plan.spectral_grid.all_nodes())

    @pytest.fixture
    def light(self, entry: ExtensionEntry, inputs: LightInputs) -> Any:
        """The light of the scene."""
        return entry.what.load()(inputs)

    def test_errors_cost_and_reach_are_sound(self, light: Any, inputs: LightInputs) -> None:
        """An error of each band, not negative; a positive cost; whole numbers of points."""
        assert light.cost > 0.0
        for errors in (light.expected_errors(), light.errors_of_columns()):
            assert len(errors) == len(inputs.weights_cm1)
            assert np.all(np.asarray(errors) >= 0.0)
        assert all(isinstance(points, int) and points >= 0 for both in light.reach for points in both)

    def test_results_have_the_shapes_of_points_and_bands(self, light: Any, inputs: LightInputs) -> None:
        """Thickness within the layer's, share and added radiance of each band: finite, share not negative."""
        for sun in _suns(inputs):
            thickness, share, added = light.at(sun).correct(_clouds(inputs, light))
            shape = _clouds(inputs, light).shape
            assert thickness.shape == shape
            assert share.shape == added.shape == (len(inputs.weights_cm1), *shape)
            assert np.all(np.isfinite(thickness) & (thickness >= 0.0))
            assert np.all(thickness <= inputs.layer.thickness_max_m * (1.0 + 1e-6))
            assert np.all(np.isfinite(added))
            assert np.all(np.isfinite(share) & (share >= 0.0))

    def test_a_sky_without_cloud_is_left_alone(self, light: Any, inputs: LightInputs) -> None:
        """Points far from any cloud have the radiance of their columns."""
        for sun in _suns(inputs):
            seen = (inputs.weights_cm1 @ inputs.clear(sun))[:, None, None]
            thickness, share, added = light.at(sun).correct(np.zeros_like(_clouds(inputs, light)))
            inner = _inner(light)
            read = np.max(share, axis=0)[inner] > 0.0
            assert not np.any(thickness[inner][read]), "clear points are read at a thickness"
            total = (share * seen + added)[(..., *inner)]
            np.testing.assert_allclose(total, np.broadcast_to(seen, total.shape), rtol=self.clear_tolerance)

    def test_cloud_beyond_the_reach_does_not_matter(self, light: Any, inputs: LightInputs) -> None:
        """A change farther away than ``reach`` leaves a point as it is, to ``reach_tolerance``."""
        field = _clouds(inputs, light)
        (before, after), (left, right) = light.reach
        other = field.copy()
        other[:2] = np.where(other[:2] > 0.0, 0.0, inputs.layer.thickness_max_m)
        rows = slice(2 + before, field.shape[0] - after)
        columns = slice(left, field.shape[1] - right)
        seen = float(np.max(inputs.weights_cm1 @ inputs.clear(None)))
        for sun in _suns(inputs):
            results = light.at(sun).correct(field), light.at(sun).correct(other)
            for one, changed, scale in zip(*results, (inputs.layer.thickness_max_m, 1.0, seen), strict=True):
                allowed = self.reach_tolerance * scale
                np.testing.assert_allclose(changed[..., rows, columns], one[..., rows, columns], rtol=0.0, atol=allowed)

    def test_the_field_is_left_as_it_was_and_repeats(self, light: Any, inputs: LightInputs) -> None:
        """The array of the clouds is not written to, and the same clouds give the same light."""
        field = _clouds(inputs, light)
        for sun in _suns(inputs):
            at = light.at(sun)
            questions = [("correct", lambda: (field.copy(),), lambda: (np.ascontiguousarray(field[::-1]),))]
            _AIR["arguments_are_left_as_they_were"](at, None, questions)
            _AIR["no_later_call_changes_a_result"](at, questions)
            first, again = (light.at(sun).correct(field.copy()) for _ in range(2))
            for one, other in zip(first, again, strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-12)


class CommandContract(ExtensionContract):
    """Inherit in a class named ``Test...`` and set ``name``, what users write after ``hcss``."""

    kind = Extension.COMMAND

    @pytest.fixture
    def command(self, entry: ExtensionEntry) -> click.Command:
        """The imported command."""
        command: click.Command = entry.what.load()
        return command

    def test_help_says_what_the_command_and_its_options_do(self, command: click.Command) -> None:
        """``--help`` works, the command has a description, and each option has one."""
        done = CliRunner().invoke(command, ["--help"])
        assert done.exit_code == 0, done.output
        commands = command.commands.values() if isinstance(command, click.Group) else [command]
        for each in commands:
            assert each.get_short_help_str(), f"{each.name} has no description"
            bare = [o.name for o in each.params if isinstance(o, click.Option) and not o.hidden and not o.help]
            assert not bare, f"options of {each.name} without help: {bare}"

    def test_an_unknown_option_is_refused(self, command: click.Command) -> None:
        """Exit code 2, and a message that names the option."""
        done = CliRunner().invoke(command, ["--no-such-option"])
        assert done.exit_code == 2
        assert "--no-such-option" in done.output

    def test_the_module_of_the_hook_imports_nothing_heavy(self, entry: ExtensionEntry) -> None:
        """`hcss --help` imports it: not numpy, not the module of the command, and it prints nothing."""
        module = entry.what.spec.target.partition(":")[0]
        group, distribution = Extension.COMMAND.group, entry.distribution
        script = (
            "import sys; from importlib.metadata import distribution; "
            f"[e.load() for e in distribution('{distribution}').entry_points.select(group='{group}')]; "
            f"print([name for name in ('numpy', 'xarray', '{module}') if name in sys.modules])"
        )
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == "[]", "imported with the hook, or printed by it"


def _whole(rays: Rays) -> tuple[slice, slice]:
    return slice(0, rays.image.rows), slice(0, rays.image.columns)


def _places(extent_m: float) -> tuple[Array, Array]:
    """Return places (24, 32) east and north of the centre."""
    x_m, y_m = np.meshgrid(np.linspace(-0.5, 0.5, 32) * extent_m, np.linspace(-0.5, 0.5, 24) * extent_m)
    return x_m, y_m


def _setting() -> ColumnSetting:
    return sample_radiance_inputs().setting


def _values(effect: PointEffect) -> list[float]:
    return [effect.low, 0.5 * (effect.low + effect.high), effect.high]


def _seen(setting: ColumnSetting) -> Array:
    """Return what radiance takes of sea and air: transmittances, emissivities, temperatures."""
    mu = np.array([0.9, 0.6])
    through = setting.transmittance.transmittance(WAVENUMBERS_CM1, [to_space(0.0, 0.0)])
    emitted = setting.sea.emissivity(WAVENUMBERS_CM1, mu)
    kelvin = [setting.sea_temperature_K, *setting.profile.temperature_K.tolist()]
    return np.concatenate((through.ravel(), emitted.ravel(), kelvin))


def _suns(inputs: LightInputs) -> list[Sun | None]:
    known = zip(inputs.sun_zenith_deg.tolist(), inputs.sun_azimuth_deg.tolist(), strict=True)
    return [None, *(Sun(zenith, azimuth, 1.0) for zenith, azimuth in list(known)[:1])]


def _clouds(inputs: LightInputs, light: Any) -> Any:
    """Return clouds (y, x) of a window that is larger than the reach: blocks of several thicknesses."""
    (before, after), (left, right) = light.reach
    rows, columns = before + after + 16, left + right + 16
    random = np.random.default_rng(4)
    blocks = random.random((-(-rows // 4), -(-columns // 4))) * (random.random((-(-rows // 4), -(-columns // 4))) < 0.5)
    thickness = np.kron(blocks, np.ones((4, 4)))[:rows, :columns]
    low, high = inputs.layer.thickness_min_m, inputs.layer.thickness_max_m
    return np.where(thickness > 0.0, low + (high - low) * thickness, 0.0).astype(np.float32)


def _inner(light: Any) -> tuple[slice, slice]:
    (before, after), (left, right) = light.reach
    return slice(before, -after or None), slice(left, -right or None)
