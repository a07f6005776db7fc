"""The public names beyond the frozen ones, used as another package would: laws that must hold for what they return.

This module imports what the page of public names lists, and nothing else of hcss_twin.
"""

import ast
import dataclasses
import json
import math
import re
import warnings
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated
from unittest import SkipTest

import click
import numpy as np
import pytest
from cheap import CHEAP
from click.testing import CliRunner
from hcss_author import sample_cloud_inputs, sample_element_inputs
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from test_plugins_use_the_public_api import FROZEN, PAGE, private_imports

from hcss_twin import Scenario, brightness_temperature, make_plan, open_cube, simulate
from hcss_twin.cli import options
from hcss_twin.core.arguments import checked
from hcss_twin.core.cache import kept_result
from hcss_twin.core.environment import announce_compilation
from hcss_twin.core.errors import CertificateWarning, OptionError
from hcss_twin.core.files import Writing
from hcss_twin.core.json_numbers import json_value
from hcss_twin.core.kernels import kernel
from hcss_twin.core.reading import Reading
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.core.units import QuantityParser
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.cluster import Cluster
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.parts import Workers
from hcss_twin.engine.scene_around import SceneAround
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stages.element_paths import ElementPaths
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.laws import laws_of, questions_of
from hcss_twin.laws.samples import PlainGas, PlainOptics, PlainScene, PlainSea, StillScene, sample_radiance_inputs
from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.parameters import ImageReading
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.models.sensor.noise import Noise
from hcss_twin.models.sensor.parameters import OfBands
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.sun import sun_position
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.sensor_stages import Stage
from hcss_twin.providers import (
    Array,
    AtmosphereInputs,
    CatalogError,
    ElementPoint,
    Grid,
    HcssError,
    Kind,
    Leg,
    ProviderError,
    ScenarioError,
    SensorBand,
    SensorInputs,
    Sun,
    View,
    planck,
    to_space,
)
from hcss_twin.providers import Path as LightPath
from hcss_twin.providers.light import LightInputs
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.reports.cloud_volume import cloud_volume_figure
from hcss_twin.reports.cube_frames import Reader
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.power_spectrum import Rings
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.tables import Table
from hcss_twin.scenario.bands import spectral_band

SOURCE = Path(__file__).read_text(encoding="utf-8")


def test_this_module_uses_every_public_name_and_no_other():
    assert not list(private_imports(SOURCE))
    used = {node.id for node in ast.walk(ast.parse(SOURCE)) if isinstance(node, ast.Name)}
    used |= {node.attr for node in ast.walk(ast.parse(SOURCE)) if isinstance(node, ast.Attribute)}
    others = PAGE.public().keys() - FROZEN.keys()
    assert not {name for module in others for name in PAGE.public()[module]} - used


# --- commands, arguments, files, compiled loops


def test_a_command_of_another_package_reads_a_scenario_and_writes_a_new_file(tmp_path):
    @click.command()
    @click.argument("scenario")
    @options.Shared.changes
    @options.Shared.json_file
    @options.Shared.force
    @click.option("--scale", type=options.Number(min=0.0), default=1.0)
    def ours(scenario, assignments, json_file, force, scale):
        options.Output.require_writable([json_file], force, form="JSON")
        coverage = options.Shared.load(scenario, assignments).clouds.layers[0].coverage
        options.Shared.write_json({"coverage": scale * coverage}, json_file)

    def run(*arguments):
        return CliRunner().invoke(ours, ["stratus", "--set", "clouds.coverage=0.25", *arguments])

    path = tmp_path / "result.json"
    assert run("--json", str(path), "--scale", "2").exit_code == 0
    assert json.loads(path.read_text()) == {"coverage": 0.5}
    assert "--force" in run("--json", str(path)).output
    assert run("--json", str(path), "--force").exit_code == 0
    assert "finite" in run("--json", str(path), "--force", "--scale", "nan").output


def test_options_of_images_give_indices_and_metres_and_refuse_the_rest():
    @click.command()
    @options.Shared.at
    @options.Shared.length("--side", help="Of a square.")
    def ours(at, side):
        click.echo(f"{at} {side}")

    def run(*arguments):
        return CliRunner().invoke(ours, arguments).output.strip()

    assert run("--at", "scene=3", "--at", "time=0", "--side", "1.5 km") == "{'scene': 3, 'time': 0} 1500.0"
    assert run("--side", "20") == "{} 20.0"
    assert run() == "{} None"
    for wrong in (("--at", "scene=x"), ("--at", "a=1", "--at", "a=2"), ("--side", "-1 m"), ("--side", "3 K")):
        assert "allowed:" in run(*wrong)


def test_a_wrong_argument_and_a_damaged_file_are_errors_of_this_package(tmp_path):
    @checked
    def halved(width_m: float) -> float:
        return 0.5 * width_m

    assert halved(3.0) == 1.5
    with pytest.raises(OptionError, match=r"width_m: 'wide'.*allowed: a finite number"):
        halved("wide")
    path = tmp_path / "numbers.txt"
    with pytest.raises(CatalogError, match="cannot write"), Writing(path, CatalogError) as draft:
        (draft / "of no folder").write_text("1 2")
    assert not list(tmp_path.iterdir())
    with Writing(path, CatalogError) as draft:
        draft.write_text("1 2 x")
    with pytest.raises(CatalogError, match=re.escape(str(path))), Reading(path, CatalogError):
        np.loadtxt(path)
    Writing(path, CatalogError, "other", [tmp_path / "other.txt"]).check()
    with pytest.raises(CatalogError, match="input of this command"):
        Writing(path, CatalogError, read=[path]).check()


def test_a_command_answers_nothing_but_json_which_has_no_infinity():
    @click.command()
    @click.argument("path", type=options.Existing(file_okay=False))
    @click.option("-o", "--output", type=options.Output(dir_okay=False))
    @options.Shared.json
    def ours(path, output, as_json):
        click.echo(f"reading {path}")
        if as_json:
            options.Shared.write_json(json_value({"output": str(output), "sizes": (1.0, math.inf)}))

    result = CliRunner().invoke(ours, [".", "--json", "-o", "a.nc"])
    assert json.loads(result.stdout) == {"output": "a.nc", "sizes": [1.0, None]}
    assert CliRunner().invoke(ours, ["/dev/null"]).exit_code == 2
    assert "name of a file" in CliRunner().invoke(ours, [".", "-o", "new/"]).output


def test_a_signal_stops_a_command_between_two_steps():
    stop = options.Stop()
    assert list(stop.progress(range(3), 3)) == [0, 1, 2]
    with pytest.raises(KeyboardInterrupt):
        stop(2, None)
    with pytest.raises(KeyboardInterrupt):  # again: a library may have swallowed the first
        next(stop.progress(range(3), 3))


def test_arrays_come_back_unless_another_program_has_changed_them(tmp_path):
    path, kept = tmp_path / "kept.npz", {"numbers": np.arange(5.0), "names": np.array(["a", "b"])}
    Writing(path, CatalogError).arrays(kept)
    found = Reading(path, CatalogError).arrays()
    assert {name: values.tolist() for name, values in found.items()} == {n: v.tolist() for n, v in kept.items()}
    np.savez(path, **kept, digest=np.array("other"))
    with pytest.raises(CatalogError, match="checksum"):
        Reading(path, CatalogError).arrays()


def test_results_of_a_key_are_computed_once():
    cache, made = ResultCache(), []
    assert [cache.get_or_compute("key", lambda: made.append(1) or len(made)) for _ in range(3)] == [1, 1, 1]
    assert set(cache.versions()) >= {"hcss-twin", "numpy"}


def test_a_kept_result_is_computed_again_when_what_it_depends_on_changes(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    inputs, made = sample_cloud_inputs(0.5, 1), []

    def kept(altitude_m, catalog):
        def compute():
            made.append(altitude_m)
            return Sun(altitude_m, 180.0, 1.0)

        return kept_result({"for": "a test", "altitude_m": altitude_m}, catalog, compute, (Sun,))

    first = [kept(altitude_m, inputs.catalog) for altitude_m in (1.0, 2.0, 1.0)]
    assert made == [1.0, 2.0]
    assert first[0] == first[2] == kept(1.0, type(inputs.catalog)()) != first[1]
    assert made == [1.0, 2.0]


def test_work_comes_back_in_order_and_a_cluster_that_does_not_answer_is_an_error():
    with Workers.of(1) as workers:
        assert workers.executor is None
        assert list(workers.in_order(str, iter((3, 1)))) == [(3, "3"), (1, "1")]
    with pytest.raises(CatalogError, match="Dask"), Cluster.connected("nowhere", CatalogError):
        pass


def test_compiled_loops_give_what_python_gives():
    @kernel(inner=True)
    def square(x):
        return x * x

    @kernel()
    def total(values):
        result = 0.0
        for x in values:
            result += square(x)
        return result

    assert total(np.array([1.0, 2.0, 3.0])) == 14.0


# --- reports


def test_a_page_escapes_text_and_shows_tables_and_figures(tmp_path):
    figure, axes = Figures.panels(2)
    axes[0].plot([1.0, 2.0])
    table = Table(["row", "value"], [[Table.ordinal(2), Table.number(0.5)]])
    shown = [Markup.paragraph("x < y"), "a & b", table, Markup.picture(figure, "a line")]
    Page("Ours", "of a < b", [Page.Section("One part", shown)]).write(tmp_path / "ours.html")
    text = (tmp_path / "ours.html").read_text(encoding="utf-8")
    for part in ("of a &lt; b", "<p>x &lt; y</p>", "a &amp; b", "<td>2nd</td>", 'id="one-part"', 'alt="a line"'):
        assert part in text
    assert [line.split() for line in table.lines()] == [["row", "value"], ["2nd", "0.5"]]
    assert Figures.png(figure) == Figures.png(figure)
    with pytest.raises(ValueError, match="1 cells"):
        Table(["row", "value"], [["1"]])


def test_provenance_is_what_a_file_says_of_itself():
    attributes = {"hcss_versions": json.dumps({"hcss-twin": "1.0"}), "hcss_providers": "no JSON"}
    assert Provenance.versions(Provenance.value(attributes, "hcss_versions", {})) == "hcss-twin 1.0"
    assert Provenance.value(attributes, "hcss_providers", {}) == {}


def test_the_power_of_white_noise_is_its_variance_in_all_rings():
    noise = 3.0 * np.random.default_rng(5).normal(size=(128, 96))
    rings = Rings.of(noise)
    known = rings.waves > 0
    assert np.average(rings.power[known], weights=rings.waves[known]) == pytest.approx(9.0, rel=0.1)


def test_a_cloud_is_drawn_from_its_base_to_its_top(scenario):
    wanted = {"output.variables": ["radiance", "cloud_thickness", "cloud_top_altitude"], "frames.count": 1}
    cube = simulate(Scenario.from_dict(json.loads(scenario.to_json()), wanted))
    space, *others = cloud_volume_figure(cube).axes
    assert space.get_zlim()[1] > float(cube["cloud_top_altitude"].max()) / 1e3
    assert "altitude (km)" in [panel.get_ylabel() for panel in others]


# --- sections of scenarios


def test_a_section_takes_quantities_with_units_and_refuses_unknown_keys():
    class Scope(BaseModel):
        model_config = ConfigDict(extra="forbid", frozen=True)

        focal_length: Annotated[float, BeforeValidator(QuantityParser("length in an instrument"))] = 0.1
        field: Annotated[float, BeforeValidator(QuantityParser("angle"))] = Field(1.0, gt=0)
        altitude: Annotated[float, BeforeValidator(QuantityParser("length"))] = 1.0
        exposure: Annotated[float, BeforeValidator(QuantityParser("duration"))] = 1.0
        gain: QuantityParser.Number = 1.0
        lines: QuantityParser.Whole = 1

    given = {"focal_length": "50 mm", "altitude": "500 km", "exposure": "2 ms", "field": f"{math.pi / 4} rad"}
    scope = Scope.model_validate(given)
    assert (scope.focal_length, scope.altitude, scope.exposure) == pytest.approx((0.05, 5e5, 2e-3))
    assert scope.field == pytest.approx(45.0)
    for wrong in ({"gain": True}, {"lines": "3"}, {"altitude": "3 deg"}, {"width": 1}):
        with pytest.raises(ValidationError):
            Scope.model_validate(wrong)


# --- geometry


def test_the_plane_of_the_scene_is_where_the_earth_is():
    x, y = np.array([-3e5, 0.0, 2e5]), np.array([1e5, 0.0, -2e5])
    latitude, longitude, turn = Ellipsoid.to_geographic_with_turn(x, y, 40.0, 10.0)
    back = Ellipsoid.to_plane(latitude, longitude, 40.0, 10.0)
    assert np.max(np.abs(np.stack(back) - [x, y])) < 1e-3
    assert turn[1] == 0.0
    position = Ellipsoid.to_earth_centred(latitude, longitude)
    east, north, up = Ellipsoid.east_north_up(latitude, longitude)
    np.testing.assert_allclose(np.cross(east, north), up, atol=1e-12)
    higher = Ellipsoid.to_earth_centred(latitude, longitude, 1e3)
    np.testing.assert_allclose(higher - position, 1e3 * up, atol=1e-6)


def test_the_sun_stands_south_at_noon():
    noon = datetime(2024, 3, 20, 12, 7, tzinfo=UTC)  # equinox, equation of time 7 min
    zenith, azimuth, distance = sun_position([noon], 50.0, 0.0)
    assert zenith[0] == pytest.approx(50.0, abs=0.3)
    assert azimuth[0] == pytest.approx(180.0, abs=1.0)
    assert distance[0] == pytest.approx(0.996, abs=2e-3)


# --- image geometries


class Wide(Rays):
    """Two pixels, each a point below."""

    directions, view = None, View(0.0, 0.0)
    image, samples_per_pixel = Grid(1, 2, 100.0), 1

    def points_m(self, window, time_s, height_m):
        column = np.arange(window[1].start, window[1].stop)
        return 100.0 * (column[None] - 0.5), np.zeros((1, column.size))

    def positions(self, window, time_s):
        x, _ = self.points_m(window, time_s, 0.0)
        return x / 100.0, np.zeros_like(x)

    def coordinates(self):
        column = VariableSpec("column", "1", "column", "coordinate", "From 0.", ("column",), "int32")
        return ((column, np.arange(2, dtype=np.int32)),)

    def extent_deg(self, scenario):
        return 10.0, 10.1, 20.0, 20.1


def test_rays_place_their_pixels_and_name_what_excludes_them():
    rays = Wide()
    assert rays.points_m((slice(0, 1), slice(1, 2)), 0.0, 0.0)[0] == [[50.0]]
    layout = rays.layout(None)
    (column, values), *_ = layout.coordinates
    assert (layout.south, layout.east) == (10.0, 20.1)
    assert column.dims == ("column",)
    assert values.size == rays.image.columns
    table = (Excluded("elements", False, "elements", "none"), Excluded("view.zenith", True, "another view", "0"))
    with pytest.raises(ScenarioError, match=r"view\.zenith: another view cannot be computed with wide; allowed: 0"):
        Excluded.require_none("wide", table)
    Excluded.require_none("wide", table[:1])


def test_air_over_a_field_is_that_of_the_place_of_a_view(plan):
    air = {latitude: AirOverField.Air(plan.assembly.profile, plan.assembly.transmittance) for latitude in (10.0, 60.0)}
    over = AirOverField((10.0, 0.0), lambda latitude, longitude: air[latitude], lambda: iter(()))
    assert over.of(AirOverField.PlacedView(0.0, 0.0, 60.0, 0.0)) is air[60.0]
    assert over.of(View(0.0, 0.0)) is air[10.0]


# --- the plan of a scene, its tables, and frames in parts


@pytest.fixture(scope="module")
def scenario():
    given = {
        "time": "2024-04-20T02:30:00Z",
        "place": {"latitude": 20.0, "longitude": 150.0},
        "image": {"rows": 16, "columns": 20, "pixel_size": 100.0},
        "frames": {"count": 2, "interval": 5.0},
        "bands": [{"name": "lwir", "limits": [10.5, 11.0]}],
        "clouds": {"type": "stratocumulus", "coverage": 0.5, "coverage_mode": "field"},
        "sea": {"temperature_texture": 0.0},  # the look-up of clouds alone has an even sea
        "sensor": {"parameters": {"noise": "nedt", "nedt": 0.05, "nedt_temperature": 300.0}},
        "output": {"certificate": 0},
    }
    return Scenario.from_dict(given, CHEAP)


@pytest.fixture(scope="module")
def plan(scenario):
    return make_plan(scenario)


@pytest.fixture(scope="module")
def tables(plan):
    return tables_of(plan)


def test_a_plan_says_what_it_computes_and_what_it_leaves_out(plan, scenario):
    assert isinstance(plan, Plan)
    assert isinstance(plan.assembly, Assembly)
    assert plan.cloudy_layers == [0]
    assert plan.layers[0].reference_height_m == plan.layers[0].top_m
    assert plan.assembly.plane(3).samples == 3
    assert plan.views_over_image().at([(-1.0, 0.0), (1.0, 1.0)]) == [plan.view] * 2  # parallel lines of sight
    left_out = [*plan.omissions, plan.texture_of_sea("one temperature")]
    assert all(isinstance(omission, Omission) and omission.what for omission in left_out)
    assert 0.0 < left_out[-1].bound < 0.1
    bands = [spectral_band(band, plan.catalog) for band in scenario.bands]
    assert [(band.lower_um, band.upper_um) for band in bands] == [(10.5, 11.0)]


def test_parts_of_frames_are_those_of_the_cube(plan, tables, scenario, tmp_path):
    cube = simulate(scenario, tmp_path / "cube.nc")
    assert isinstance(tables, RadianceTables)
    window = (slice(3, 9), slice(5, 20))
    frame, radiance = PartMaker(plan, tables).part(1, window)
    np.testing.assert_array_equal(frame["radiance"], cube["radiance"].values[1, :, 3:9, 5:20])
    time_s = float(plan.frame_times_s[1])
    thickness = FrameClouds(plan, time_s).thickness_m(window)
    looked_up = np.empty((1, 6, 15), np.float32)
    LookUp.at(tables, time_s).fill(looked_up, thickness, plan.samples_per_pixel)
    np.testing.assert_allclose(looked_up, radiance[0], rtol=1e-5)
    kelvin = BrightnessTemperature(plan.spectral_grid, ["lwir"])(frame["radiance"])
    chosen = FrameSelection.of(cube, "radiance", frames=[1])
    np.testing.assert_array_equal(chosen.values(chosen.frames[0]), cube["radiance"].values[1])
    assert chosen.planes == (FrameSelection.Plane("lwir", 10.5, pytest.approx(10.75, abs=0.01), 11.0),)
    expected = brightness_temperature(cube)
    np.testing.assert_allclose(kelvin, np.asarray(expected)[1, :, 3:9, 5:20], atol=2e-4)


def test_a_cube_is_read_plane_by_plane_and_its_certificate_told(scenario, tmp_path):
    told, said = [], []
    changed = Scenario.from_dict(json.loads(scenario.to_json()), {"output.certificate": 20, "frames.count": 1})
    with warnings.catch_warnings(), announce_compilation(said.append):
        warnings.simplefilter("error", CertificateWarning)
        run(make_plan(changed), tmp_path / "cube.nc", report=told.append)
    (certificate,) = told
    assert isinstance(certificate, Certificate)
    assert certificate.passed
    assert {each.name for each in certificate.strata} <= set(Certificate.stratum_names(1))
    assert len(said) <= 1
    with FrameSelection.as_seen(open_cube(tmp_path / "cube.nc")) as cube:
        (radiance,) = (quantity for quantity in Reader.quantities(cube) if quantity.name == "radiance")
        reader = Reader.of(cube)
        assert radiance.parts == ("lwir",)
        np.testing.assert_array_equal(reader.plane(radiance, 0, 0), cube["radiance"].values[0, 0])
        assert reader.mean(radiance, 0, 0) == pytest.approx(float(cube["radiance"].mean()), rel=1e-6)


def test_weights_of_a_grid_integrate_over_the_band(plan):
    grid = SpectralGrid.dense([spectral_band((8.0, 12.5), plan.catalog)], None)
    assert grid.weights_cm1.sum() == pytest.approx(1e4 / 8.0 - 1e4 / 12.5)
    np.testing.assert_array_equal(grid.all_nodes().wavenumber_cm1, grid.wavenumber_cm1)


def test_the_scene_around_a_frame_contains_it_at_any_time(plan, tables):
    window, time_s = (slice(0, 16), slice(0, 20)), float(plan.frame_times_s[1])
    frame, _ = PartMaker(plan, tables).part(1, window)
    sensor = plan.sensor.measuring(())
    around = SceneAround(plan, tables, sensor)
    wide, _ = around.frame(1, frame["radiance"])
    (rows, columns), (outer_rows, outer_columns) = sensor.cube, sensor.given
    top, left = rows.start - outer_rows.start, columns.start - outer_columns.start
    np.testing.assert_array_equal(wide[:, top : top + 16, left : left + 20], frame["radiance"])
    again, _ = around.at(1, time_s, slice(0, 16), slice(0, 20))
    np.testing.assert_array_equal(again, frame["radiance"])


def test_nothing_is_between_the_sensor_and_what_is_above_the_air_and_the_clouds(plan):
    paths, top_m = ElementPaths(plan), float(plan.assembly.profile.altitude_m[-1])
    np.testing.assert_allclose(paths.air(top_m, 30.0), 1.0)
    assert np.all(paths.air(0.0, 30.0) < 1.0)
    heights = paths.heights_above([np.full((2, 2), 300.0, np.float32)], plan.layers[0].top_m + 1.0)
    np.testing.assert_array_equal(paths.through_cloud(heights, 0.0), 1.0)


def test_light_gets_the_scene_of_the_plan(plan, tables):
    inputs = LightStage.inputs(plan, tables.spectrum.nodes)
    assert isinstance(inputs, LightInputs)
    assert inputs.layer == plan.layers[0]
    assert inputs.image == (16 * plan.samples_per_pixel, 20 * plan.samples_per_pixel)
    assert [each.number for each in inputs.stack] == plan.cloudy_layers
    assert LightStage.largest_square >= max(inputs.image)  # one square, so that the image is computed at once


# --- sensors


def test_the_stages_of_a_sensor_are_built_and_examined(plan, scenario):
    inputs = SensorInputs(
        bands=tuple(SensorBand(band.name, band.wavelength_um, band.response) for band in plan.bands),
        grid=plan.grid,
        platform_speed_m_s=0.0,
        frame_interval_s=5.0,
        seed=1,
        catalog=plan.catalog,
    )
    (stage,) = Stage.build(scenario.sensor, inputs)
    measured, _ = stage.measure(np.full((1, 16, 20), 8.0, np.float32), 0, 0.0)
    assert np.mean(measured.radiance) == pytest.approx(8.0, rel=1e-2)
    assert np.std(measured.radiance) > 0.0
    assert isinstance(Stage.examine_geometry({}, (stage,)), tuple)
    assert Stage.smear_of_sensor(scenario.sensor, plan.catalog) is None
    smeared = scenario.sensor.model_copy(update={"parameters": {"integration_time": 0.01}})
    time_s, key = Stage.smear_of_sensor(smeared, plan.catalog)
    assert (time_s, key) == (0.01, "sensor.parameters.integration_time")


def test_random_numbers_of_pixels_depend_on_their_place_alone():
    key = Noise.key_of(7, "ours", "lwir")
    assert key != Noise.key_of(7, "ours", "mwir")
    whole, part = Noise.standard_normal(key, (40, 50), (-5, -5)), Noise.standard_normal(key, (3, 4), (10, 20))
    np.testing.assert_array_equal(part, whole[15:18, 25:29])
    numbers, tail = np.empty(64 * 200, np.float32), np.empty(64, np.float32)
    Noise.fill_normals(numbers, 3, 0, np.uint64(key))
    Noise.fill_normals(tail, 3, 199, np.uint64(key))
    np.testing.assert_array_equal(numbers[-64:], tail)
    assert (np.mean(numbers), np.std(numbers)) == pytest.approx((0.0, 1.0), abs=0.03)


def test_a_parameter_is_a_number_for_all_bands_or_a_table():
    check = OfBands.within(0.0, 2.0).func
    assert OfBands.number(check(1), "lwir", "gain") == 1.0
    assert OfBands.number(check({"lwir": 2.0}), "lwir", "gain") == 2.0
    with pytest.raises(ScenarioError, match=r"sensor\.parameters\.gain: gives no number for band 'mwir'"):
        OfBands.number({"lwir": 2.0}, "mwir", "gain")
    with pytest.raises(ValueError, match="out of range"):
        check(3.0)


# --- fractal clouds


@pytest.fixture(scope="module")
def octaves(plan):
    shape = plan.assembly.generators[0].parameters
    assert isinstance(shape, FractalParameters)
    return Octave.separate(shape, plan.grid, plan.assembly.motion, noise=False)


def test_octaves_share_the_variance_of_the_field(octaves):
    assert all(isinstance(octave, Octave) for octave in octaves)
    assert sum(octave.variance for octave in octaves) == pytest.approx(1.0)


def test_a_window_of_the_field_is_a_part_of_the_whole(octaves, plan):
    field = FractalField(5, octaves)
    whole = field.window(0.0, FractalField.PixelWindow(0, 30, 0.0), FractalField.PixelWindow(0, 40, 0.0))
    part = field.window(0.0, FractalField.PixelWindow(10, 5, 0.0), FractalField.PixelWindow(20, 8, 0.0))
    np.testing.assert_array_equal(part, whole[10:15, 20:28])
    layer = replace(plan.layers[0], coverage=0.5)
    thickness = FractalClouds.field_thickness(whole[None].astype(np.float32), layer)[0]
    np.testing.assert_array_equal(thickness > 0.0, whole >= 0.0)  # the median of the field
    assert np.max(thickness) <= layer.thickness_max_m


def test_an_entry_of_the_cloud_database_comes_back_from_its_file(tmp_path):
    plain = {"str": "ours", "float": 2.0, "int": 1, "bool": False}
    facts = CloudEntry.Facts(**{each.name: plain[str(each.type)] for each in dataclasses.fields(CloudEntry.Facts)})
    labels = np.zeros((4, 5), np.int32)
    labels[1:3, 2:4] = 1
    grey = np.where(labels, 100, 0).astype(np.uint8)
    CloudEntry(grey, labels, np.zeros((4, 5), bool), grey, facts).write(tmp_path / f"ours{CloudEntry.SUFFIX}")
    found = CloudEntry.read(tmp_path / "ours.nc")
    np.testing.assert_array_equal(found.labels, labels)
    assert found.facts == facts
    assert CloudEntry.read_facts(tmp_path / "ours.nc") == (facts, (4, 5))


def test_weights_between_nodes_have_unit_norm_and_correlate_as_tabulated():
    fraction = np.linspace(0.0, 1.0, 11)
    weights = FractalField.Lattice.weights(fraction)
    np.testing.assert_allclose(np.sum(weights**2, axis=1), 1.0)
    correlation = KernelCorrelation.tabulate()
    assert correlation(np.array([0.0])) == pytest.approx(1.0)
    assert correlation(np.array([4.0, 9.0])) == pytest.approx(0.0, abs=1e-12)
    # positions a cell apart share three of their four nodes
    apart = np.mean(np.sum(weights[:-1, 1:] * weights[:-1, :3], axis=1))
    assert correlation(np.array([1.0])) == pytest.approx(apart, abs=0.02)


def test_nodes_of_a_lattice_are_those_of_any_part_of_it():
    lattice, places = FractalField.Lattice(7, 2), np.arange(-3, 60)
    whole = lattice.normals(0, places, places)
    np.testing.assert_array_equal(lattice.normals(0, places[5:9], places[20:]), whole[5:9, 20:])
    assert np.mean(whole) == pytest.approx(0.0, abs=0.05)
    assert not np.any(lattice.normals(1, places, places) == whole)
    assert len({FractalField.Lattice(7, octave).offset(axis) for octave in (1, 2) for axis in (0, 1)}) == 4


def test_an_image_of_celsius_is_one_of_kelvin_in_which_cold_is_cloud(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, 270.0 + np.random.default_rng(3).normal(0.0, 9.0, (20, 30)))
    image = read_image(path, ImageReading().variable)
    assert any("brightness temperatures in kelvin?" in text for text in image.described("auto"))
    celsius = SatelliteImage(image.values - 273.15, None, True, "degC", "temperature", "a")
    kelvin = celsius.examined(path)
    np.testing.assert_allclose(kelvin.values, image.values)
    np.testing.assert_array_equal(kelvin.level("auto"), -kelvin.values[::-1])
    assert "closest is the unit degC" in SatelliteImage.of_kelvin(celsius.values).closest_reading()
    assert kelvin.size_notes(Grid(20, 30, 50.0)) == ["The image gives no pixel size; 50 m is the scenario's."]


def test_a_generator_can_be_derived_from_the_fractal_one():
    class Halved(FractalClouds):
        def thickness_m(self, time_s, rows, columns):
            return np.float32(0.5) * super().thickness_m(time_s, rows, columns)

    inputs = sample_cloud_inputs()
    shape = FractalParameters(gamma=2.0, H=0.7, L=(10.0, 10.0), k=(0, 3))
    window = 0.0, slice(0, 6), slice(2, 9)
    whole = FractalClouds(inputs, shape).thickness_m(*window)
    assert np.any(whole > 0.0)
    np.testing.assert_array_equal(2.0 * Halved(inputs, shape).thickness_m(*window), whole)


# --- air and radiance


def test_the_climatology_is_warm_at_the_equator_and_profiles_follow(plan):
    climatology, when = Climatology(plan.catalog), datetime(2024, 1, 15, tzinfo=UTC)
    warm, cold = (
        climatology.look_up("sea_surface_temperature", latitude, 200.0, when).value for latitude in (0.0, 45.0)
    )
    assert warm > cold + 10.0
    tropical, winter = (load_profile(name, plan.catalog) for name in ("tropical", "subarctic-winter"))
    assert tropical.temperature_at(np.array([0.0]))[0] > winter.temperature_at(np.array([0.0]))[0] + 30.0


def test_a_table_of_air_is_what_a_provider_that_is_chosen_by_name_reads(plan, tmp_path):
    profile, path = load_profile("tropical", plan.catalog), tmp_path / "grey.nc"
    height_m, zenith_deg, wavenumber = np.array([0.0, 2e3]), np.array([0.0, 60.0]), np.array([900.0, 1000.0])
    values = np.full((2, 2, 2), 0.5)
    AtmosphereTable(height_m, zenith_deg, wavenumber, values, values, profile, 1.0, "ours").write(path, {})
    read = AtmosphereTable.read(path)
    np.testing.assert_array_equal(read.transmittance, values)
    with Reading(path, CatalogError).netcdf() as file:
        np.testing.assert_array_equal(file.variables["zenith_deg"][:], zenith_deg)
    registry = Registry.discover()
    entry = registry.resolve("atmosphere", "hcss-twin/table")
    table = registry.create(entry, AtmosphereInputs(read.profile, plan.catalog), {"file": str(path)})
    np.testing.assert_allclose(table.transmittance(wavenumber, [to_space(0.0, 0.0)]), 0.5)
    with pytest.raises(ProviderError, match="fil"):
        registry.create(entry, AtmosphereInputs(read.profile, plan.catalog), {"fil": str(path)})


class Grey:
    """Air of one absorber; no sunlight is scattered."""

    def transmittance(self, wavenumber_cm1: Array, paths: list[LightPath]) -> Array:
        depth = [sum(self._depth(leg) for leg in path.legs) for path in paths]
        return np.exp(-np.array(depth))[:, None] * np.ones(wavenumber_cm1.size)

    def _depth(self, leg: Leg) -> float:
        low, high = leg.lower_m, leg.upper_m
        return (math.exp(-low / 8e3) - math.exp(-high / 8e3)) / math.cos(math.radians(leg.zenith_deg))


def test_isothermal_air_emits_what_it_absorbs(plan):
    profile = load_profile("tropical", plan.catalog)
    isothermal = replace(profile, temperature_K=np.full_like(profile.temperature_K, 280.0))
    wavenumber = np.array([900.0, 1000.0])
    (seen,) = path_radiance(Grey(), isothermal, wavenumber, [0.0], 0.0)
    through = math.exp(-1.0)
    np.testing.assert_allclose(seen, (1.0 - through) * planck(wavenumber, 280.0), rtol=1e-9)


# --- laws of providers


class Glossy(PlainSea):
    """Reflects more than it does not emit."""

    def brdf(self, *given: Array) -> Array:
        return 2.0 * super().brdf(*given)


def test_laws_of_a_kind_accept_a_sound_provider_and_refuse_a_wrong_one_with_its_numbers():
    laws, wavenumber = laws_of(Kind.SEA), np.array([900.0, 2500.0])
    assert laws.keys() > laws_of(Kind.SEA, in_a_run=True).keys() > {"brdf_is_reciprocal"}
    laws["no_more_is_reflected_than_is_not_emitted"](PlainSea(0.9), wavenumber)
    with pytest.raises(AssertionError, match=r"albedo at mu = 1\.0 is 0\.2"):
        laws["no_more_is_reflected_than_is_not_emitted"](Glossy(0.9), wavenumber)
    with pytest.raises(SkipTest, match="does not depend on the azimuth"):
        laws["sunlight_is_reflected_to_the_side_of_the_glint"](PlainSea(0.9), wavenumber)
    for member, one, other in questions_of(Kind.SEA, PlainSea(), None, wavenumber_cm1=wavenumber):
        for given in (one(), other()):
            assert getattr(PlainSea(), member)(*given).shape == (3, 2)


def test_samples_are_what_models_take():
    setting, wavenumber = sample_radiance_inputs().setting, np.array([900.0])
    assert isinstance(setting.sea, PlainSea)
    assert isinstance(setting.transmittance, PlainGas)
    bulk = PlainOptics(1e-10, 0.5).single_scattering(setting.layers[0].microphysics, wavenumber)
    np.testing.assert_allclose(bulk.extinction_m1, 1e-10 * setting.layers[0].microphysics.number_density_m3)
    still = StillScene()
    still.begin(np.ones((1, 4, 4)), 2.0)
    with still.brightening(0.1):
        np.testing.assert_allclose(still(4.0, slice(0, 2), slice(0, 2)), 1.2)


class Lamp:
    """An unresolved source at the centre, 1 km up."""

    def pixels(self, time_s, rows, columns, scene):
        return (ElementPoint(0.0, 0.0, 1e3, intensity=np.array([2.0])),)


def test_a_plain_scene_shows_a_small_element_in_the_pixel_that_holds_it():
    inputs = sample_element_inputs(1)
    (part,) = PlainScene(inputs).shown(Lamp(), 0.0, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))
    assert (part.rows.tolist(), part.columns.tolist()) == ([inputs.grid.rows // 2], [inputs.grid.columns // 2])
    assert part.share.tolist() == [1.0]
    assert PlainScene(inputs).shown(Lamp(), 0.0, slice(0, 2), slice(0, 2)) == []


def test_the_registry_holds_a_provider_to_the_checks_of_a_run():
    entry = Registry.discover().resolve("sea", "hcss-twin/cox-munk")
    assert isinstance(entry, Entry)
    sea = PlainSea(1.5)
    Registry.check_declared(entry.kind, sea)
    with pytest.raises(HcssError, match=r"emissivity\(\) broke its contract"):
        Registry.guarded(entry.kind, sea, None).emissivity(np.array([900.0]), np.array([1.0]))
    vars(sea)["anisotropic"] = "yes"
    with pytest.raises(ValueError, match="anisotropic"):
        Registry.check_declared(entry.kind, sea)
    commands = Registry.extensions("hcss_twin.commands")
    assert commands["check"].origin.distribution == "hcss-author"
