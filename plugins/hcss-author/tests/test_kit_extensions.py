"""Rays, effects, sections, light and commands: the packages of ``new-plugin`` are accepted, wrong ones refused."""

import dataclasses
import os
import subprocess
import sys
import tomllib

import click
import hcss_author
import pytest
from click.testing import CliRunner
from hcss_author import CommandContract, EffectContract, LightContract, RaysContract, SectionContract
from hcss_author.extension_entries import Extension, find_extension
from hcss_author.new_plugin.templates import effect, light, rays
from hcss_author.new_plugin.write import write_package

from hcss_twin import Scenario, make_plan
from hcss_twin.cli.main import cli
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.laws.law import LawBroken


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """Return the folder of the packages, and an environment in which all are installed."""
    folder, paths = tmp_path_factory.mktemp("packages"), []
    for kind in Extension:
        write_package(kind, f"own-{kind}", folder / kind)
        project = tomllib.loads((folder / kind / "pyproject.toml").read_text())["project"]
        info = folder / kind / "src" / f"hcss_own_{kind}-0.1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 0.1.0\n")
        groups = project["entry-points"].items()
        lines = [f"[{group}]\n{name} = {value}\n" for group, entries in groups for name, value in entries.items()]
        (info / "entry_points.txt").write_text("".join(lines))
        paths.append(str(folder / kind / "src"))
    with pytest.MonkeyPatch.context() as patch:
        for path in paths:
            patch.syspath_prepend(path)
        path = os.pathsep.join([*paths, os.environ.get("PYTHONPATH", "")])
        yield folder, {**os.environ, "PYTHONPATH": path, "PYTEST_ADDOPTS": "", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}


def test_the_tests_of_all_packages_pass(packages):
    folder, environment = packages
    tests = [str(folder / kind / "tests") for kind in Extension]
    options = ["-q", "-p", "no:cacheprovider", "--import-mode=importlib", f"--rootdir={folder}"]
    command = [sys.executable, "-m", "pytest", *options, *tests]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert "passed" in done.stdout
    assert "skipped" not in done.stdout


def test_hcss_check_passes_an_extension_by_its_name(packages):
    done = CliRunner().invoke(cli, ["check", "own-effect"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert done.output.startswith("section with an effect own_effect  [hcss-own-effect 0.1.0]")
    assert done.output.rstrip().endswith("11 passed")


@pytest.mark.parametrize("kind", Extension)
def test_each_extension_is_found_by_its_name(packages, kind):
    entry = find_extension(f"own-{kind}")
    assert entry.kind is kind
    assert entry.distribution == f"hcss-own-{kind}"
    assert find_extension(f"own-{kind}", "command" if kind != "command" else "rays") is None
    assert hasattr(hcss_author, kind.contract)


def test_a_stage_is_refused_with_the_reason(tmp_path):
    done = CliRunner().invoke(cli, ["new-plugin", "stage", "mine", "--folder", str(tmp_path / "mine")])
    assert "stages of the engine have no public protocol" in str(done.exception)


EFFECT = effect.Settings()


class Changed:
    """An object with other members; all else is the right one's."""

    def __init__(self, right, **members):
        self._right = right
        vars(self).update(members)

    def __getattr__(self, name):
        return getattr(self._right, name)


def scattered(x_m, y_m, time_s):
    return EFFECT.values(x_m, y_m, time_s) - x_m.mean() / 1e7


def written(x_m, y_m, time_s):
    x_m *= 1.0 + 1e-9
    return EFFECT.values(x_m, y_m, time_s)


def turned(setting, value):
    return dataclasses.replace(EFFECT.apply(setting, value), view=dataclasses.replace(setting.view, zenith_deg=0.0))


def absorbing(setting, value):
    air = EFFECT.apply(setting, value)
    wrong = lambda nu, paths: 0.9 * air.transmittance.transmittance(nu, paths)  # noqa: E731
    return dataclasses.replace(air, transmittance=Changed(air.transmittance, transmittance=wrong))


WRONG_EFFECTS = {
    "the_range_and_its_kinks_are_sound": {"low": 1.0},
    "values_are_within_the_range": {"values": lambda *given: EFFECT.values(*given) + 0.1},
    "a_place_does_not_depend_on_others": {"values": scattered},
    "places_and_values_belong_to_the_caller": {"values": written},
    "only_sea_and_air_of_a_setting_change": {"apply": turned},
    "the_number_matters_and_does_so_gradually": {"apply": lambda setting, value: EFFECT.apply(setting, round(value))},
    "changed_air_and_sea_obey_their_laws": {"apply": absorbing},
}


@pytest.mark.parametrize("law", WRONG_EFFECTS)
def test_the_law_refuses_the_wrong_effect(law):
    ask = getattr(EffectContract(), f"test_{law}")
    ask(EFFECT)
    with pytest.raises((AssertionError, LawBroken)):
        ask(Changed(EFFECT, **WRONG_EFFECTS[law]))


class WindowRays(rays.FanRays):
    def points_m(self, window, time_s, height_m):
        return super().points_m(tuple(slice(0, part.stop - part.start) for part in window), time_s, height_m)


class LeaningAway(rays.FanRays):
    def points_m(self, window, time_s, height_m):
        return super().points_m(window, time_s, -height_m)


class TooWide(rays.FanRays):
    def positions(self, window, time_s):
        return tuple(1.5 * places for places in super().positions(window, time_s))


class Trembling(rays.FanRays):
    calls = 0

    def points_m(self, window, time_s, height_m):
        self.calls += 1
        return tuple(metres + self.calls for metres in super().points_m(window, time_s, height_m))


WRONG_RAYS = {
    "every_pixel_has_points_and_a_position": TooWide,
    "windows_equal_the_whole": WindowRays,
    "lines_of_sight_lean_toward_the_sensor": LeaningAway,
    "rays_are_the_same_in_every_call": Trembling,
}


@pytest.mark.parametrize("law", WRONG_RAYS)
def test_the_law_refuses_wrong_rays(law):
    ask = getattr(RaysContract(), f"test_{law}")
    ask(rays.FanRays(rays.Settings()))
    with pytest.raises((AssertionError, LawBroken)):
        ask(WRONG_RAYS[law](rays.Settings()))


@pytest.fixture(scope="module")
def inputs():
    plan = make_plan(Scenario.from_toml(hcss_author.extensions.SCENE))
    return LightStage.inputs(plan, plan.spectral_grid.all_nodes())


def lit(change):
    """A light whose corrections are changed by a function of the clouds and the right result."""

    class Wrong(light.Light):
        def at(self, sun):
            right = super().at(sun)
            return Changed(right, correct=lambda thickness: change(thickness, *right.correct(thickness)))

    return Wrong


def darkened(thickness, amount, share, added):
    thickness[:] = 0.0
    return amount, share, added


WRONG_LIGHTS = {
    "results_have_the_shapes_of_points_and_bands": lit(lambda field, amount, share, added: (amount, share[0], added)),
    "a_sky_without_cloud_is_left_alone": lit(lambda field, amount, share, added: (amount, 0.8 * share, added)),
    "cloud_beyond_the_reach_does_not_matter": lit(
        lambda field, amount, share, added: (amount * field.mean() / 300.0, share, added)
    ),
    "the_field_is_left_as_it_was_and_repeats": lit(darkened),
}


@pytest.mark.parametrize("law", WRONG_LIGHTS)
def test_the_law_refuses_the_wrong_light(inputs, law):
    ask = getattr(LightContract(), f"test_{law}")
    ask(light.Light(inputs), inputs)
    with pytest.raises((AssertionError, LawBroken)):
        ask(WRONG_LIGHTS[law](inputs), inputs)


def test_errors_of_a_light_are_those_of_each_band(inputs):
    right = light.Light(inputs)
    LightContract().test_errors_cost_and_reach_are_sound(right, inputs)
    with pytest.raises(AssertionError):
        LightContract().test_errors_cost_and_reach_are_sound(Changed(right, expected_errors=list), inputs)


@click.command()
@click.option("--level")
def bare(level):
    """Do something."""


def test_the_law_refuses_a_command_without_help():
    with pytest.raises(AssertionError, match="options of bare without help"):
        CommandContract().test_help_says_what_the_command_and_its_options_do(bare)


def test_the_law_refuses_settings_that_can_be_changed(packages):
    entry = find_extension("own-section")
    contract = SectionContract()
    contract.test_keys_are_described_and_immutable(entry)
    loose = type("Loose", (), {"model_config": {}, "model_fields": {}})
    changed = Changed(entry.what, load=lambda target: loose)
    with pytest.raises(AssertionError, match="immutable"):
        contract.test_keys_are_described_and_immutable(dataclasses.replace(entry, what=changed))
