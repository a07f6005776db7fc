"""A cube against what its own provenance makes today."""

import hashlib
import json
import shutil

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP, NARROW
from click.testing import CliRunner
from example_cube import example_frame, example_header

from hcss_twin.cli.main import cli
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CubeError
from hcss_twin.core.stored_files import LARGEST_BYTES
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.engine import verification
from hcss_twin.engine.cube_comparison import TOLERANCE
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario

SMALL = CHEAP | {"image.rows": 16, "image.columns": 16, "frames.count": 2, "bands": NARROW, "output.certificate": 4}
MASKS = SMALL | {"bands": ["mwir", "lwir"], "output.variables": ["cloud_mask", "cloud_thickness"]}


def simulated(path, overrides, base=None):
    raw = json.loads(Scenario.load("stratus").to_json())
    run(make_plan(Scenario.from_dict(raw, overrides, base=base)), path)
    return path


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    overrides = SMALL | {"frames.count": 3, "output.variables": ["radiance", "brightness_temperature", "truth"]}
    return simulated(tmp_path_factory.mktemp("fresh") / "cube.nc", overrides)


@pytest.fixture(scope="module")
def fresh_masks(tmp_path_factory):
    return simulated(tmp_path_factory.mktemp("masks") / "cube.nc", MASKS | {"frames.count": 5})


@pytest.fixture
def cube(fresh, tmp_path):
    return shutil.copy(fresh, tmp_path / "cube.nc")


@pytest.fixture
def masks(fresh_masks, tmp_path):
    return shutil.copy(fresh_masks, tmp_path / "masks.nc")


def edit_json(path, attribute, change):
    with netCDF4.Dataset(path, "a") as file:
        table = json.loads(file.getncattr(attribute))
        change(table)
        file.setncattr(attribute, json.dumps(table))


def by_name(found):
    return {check.name: check for check in found.variables}


def command(*arguments):
    return CliRunner().invoke(cli, ["verify", *map(str, arguments)])


def test_a_fresh_cube_is_identical_and_nothing_is_written_or_taken_from_earlier_runs(cube, tmp_path, monkeypatch):
    cache = tmp_path / "cache"
    monkeypatch.setenv("HCSS_CACHE_DIR", str(cache))
    monkeypatch.setattr("hcss_twin.engine.compile.tables_of", None)
    before = cube.read_bytes()
    done = command(cube)
    assert done.exit_code == 0
    assert done.output == f"{cube}: bit-identical (all 3 frames)\n"
    assert cube.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["cube.nc"]


def test_computed_cloud_optics_are_neither_kept_nor_taken(tmp_path, monkeypatch):
    """Particles that no shipped table has; a poisoned table of an earlier run would be told as a difference."""
    folder = tmp_path / "cache" / "optics"
    monkeypatch.setenv("HCSS_CACHE_DIR", str(folder.parent))
    cube = simulated(tmp_path / "cube.nc", SMALL | {"clouds.effective_radius": 9.0, "bands": ["mwir-3.7"]})
    [kept] = folder.iterdir()
    with netCDF4.Dataset(kept, "a") as table:
        table["properties"][:] = table["properties"][:] + 0.1
    before = kept.read_bytes()
    assert verify_cube(cube).verdict is Verdict.IDENTICAL
    assert kept.read_bytes() == before
    assert list(folder.iterdir()) == [kept]


def test_a_changed_pixel_is_found_with_its_place_and_both_values(cube):
    with netCDF4.Dataset(cube, "a") as file:
        was = file["radiance"][1, 1, 3, 5]
        file["radiance"][1, 1, 3, 5] = was * np.float32(1.01)
        file["radiance"][2, 0, 7, 7] *= np.float32(1.5)
    found = verify_cube(cube)
    assert found.verdict is Verdict.DIFFERENT
    check = by_name(found)["radiance"]
    assert (check.values, check.unequal, check.beyond) == (3 * 2 * 16 * 16, 2, 2)
    assert check.first.position == {"frame": 1, "band": "lwir", "row": 3, "column": 5}
    assert check.first.recomputed == pytest.approx(float(was), rel=0)
    assert check.first.cube == pytest.approx(1.01 * float(was), rel=1e-6)
    assert check.largest == pytest.approx(1 / 3, rel=1e-6)
    assert check.largest_at.position == {"frame": 2, "band": "mwir", "row": 7, "column": 7}
    assert all(each.unequal == 0 for name, each in by_name(found).items() if name != "radiance")
    done = command(cube)
    assert done.exit_code == 1
    assert "radiance: 2 of 1536 differ" in done.output
    assert "first at frame 1, band lwir, row 3, column 5: " in done.output
    assert "cause       none recorded" in done.output


def test_the_last_bit_of_radiance_is_equal_but_not_identical(cube):
    with netCDF4.Dataset(cube, "a") as file:
        file["radiance"][0, 0, 0, 0] = np.nextafter(file["radiance"][0, 0, 0, 0], np.float32(np.inf))
    found = verify_cube(cube, frames=1)
    assert found.verdict is Verdict.EQUAL
    assert 0 < found.largest < TOLERANCE
    done = command(cube)
    assert done.exit_code == 0
    assert "equal within 1e-06; the largest relative difference is" in done.output


def test_a_mask_must_be_exact_and_what_is_missing_must_stay_missing(cube):
    with netCDF4.Dataset(cube, "a") as file:
        file.set_auto_mask(False)
        file["cloud_mask"][1, 2, 3] = 1 - file["cloud_mask"][1, 2, 3]
        top = file["cloud_top_altitude"][0]
        row, column = np.argwhere(np.isfinite(top))[0]
        file["cloud_top_altitude"][0, row, column] = np.nan
    checks = by_name(verify_cube(cube))
    assert checks["cloud_mask"].beyond == 1
    assert checks["cloud_mask"].first.position == {"frame": 1, "row": 2, "column": 3}
    assert checks["cloud_top_altitude"].beyond == 1
    assert checks["cloud_top_altitude"].largest == np.inf
    answer = json.loads(command(cube, "--json").output, parse_constant=pytest.fail)  # no NaN in JSON
    assert answer["verdict"] == "different"
    [told] = [each for each in answer["variables"] if each["name"] == "cloud_top_altitude"]
    assert told["first"]["cube"] is None


def test_a_changed_coordinate_is_found(masks):
    with netCDF4.Dataset(masks, "a") as file:
        file["solar_zenith_angle"][1] = 12.0
    found = verify_cube(masks)
    assert found.verdict is Verdict.DIFFERENT
    assert by_name(found)["solar_zenith_angle"].first.position == {"frame": 1}


@pytest.mark.parametrize(("frames", "seen"), [(1, False), (2, True), (3, True), (9, True)])
def test_a_subset_of_frames_is_spread_from_the_first_to_the_last(masks, frames, seen):
    with netCDF4.Dataset(masks, "a") as file:
        file["cloud_mask"][4, 0, 0] = 1 - file["cloud_mask"][4, 0, 0]
    found = verify_cube(masks, frames=frames)
    assert found.frames_checked == min(frames, 5)
    assert by_name(found)["cloud_mask"].beyond == int(seen)


def test_a_subset_of_frames_is_identical_to_those_of_the_whole(fresh):
    done = command(fresh, "--frames", 2, "--json")
    assert done.exit_code == 0
    answer = json.loads(done.stdout)
    assert (answer["verdict"], answer["frames"], answer["frames_checked"]) == ("identical", 3, 2)


def test_a_cube_of_masks_alone_compiles_nothing(masks, monkeypatch):
    monkeypatch.setattr("hcss_twin.engine.verification.compile_tables", None)
    assert verify_cube(masks).verdict is Verdict.IDENTICAL


def test_another_version_is_told_but_compared_all_the_same(masks):
    edit_json(masks, "hcss_versions", lambda table: table.update({"hcss-twin": "0.0.9", "numpy": "1.0"}))
    edit_json(masks, "hcss_providers", lambda table: table["clouds"].update({"version": "0.0.9"}))
    found = verify_cube(masks)
    assert found.verdict is Verdict.IDENTICAL
    assert [(each.what, each.recorded, each.now) for each in found.versions if each.what == "numpy"] == [
        ("numpy", "1.0", np.__version__)
    ]
    assert [each.what for each in found.providers] == ["clouds"]
    shown = command(masks)
    assert shown.exit_code == 0
    assert "version     hcss-twin: recorded 0.0.9; now " in shown.output
    assert "provider    clouds: recorded fractal of hcss-twin 0.0.9; now fractal of hcss-twin " in shown.output


def test_versions_of_numpy_and_numba_are_recorded(masks):
    with open_cube(masks) as dataset:
        assert {"numpy", "numba"} <= set(json.loads(dataset.attrs["hcss_versions"]))


def test_a_provider_that_is_not_installed_is_named(masks):
    def other(scenario):
        scenario["clouds"]["layers"][0]["generator"] = "far-clouds/swirls"

    edit_json(masks, "hcss_scenario", other)
    gone = {"name": "swirls", "distribution": "far-clouds", "version": "2.1"}
    edit_json(masks, "hcss_providers", lambda table: table.update({"clouds": gone}))
    found = verify_cube(masks)
    assert found.verdict is Verdict.NOT_RECOMPUTED
    [problem] = found.problems
    assert "no cloud generator is called 'far-clouds/swirls'" in problem
    [change] = found.providers
    assert (change.recorded, change.now) == ("swirls of far-clouds 2.1", "far-clouds is not installed")
    assert command(masks).exit_code == 1


def test_a_file_that_changed_since_is_named_with_both_hashes(tmp_path, monkeypatch):
    folder = tmp_path / "mine"
    folder.mkdir()
    image = folder / "clouds.npy"
    values = np.random.default_rng(1).random((24, 24))
    np.save(image, values)
    imagery = {"clouds.generator": "imagery", "clouds.parameters": {"image": "clouds.npy"}}
    overrides = MASKS | imagery | {"frames.count": 1}
    cube = simulated(tmp_path / "cube.nc", overrides, folder)
    # Relative paths lead where they led, wherever the command is given.
    monkeypatch.chdir(tmp_path)
    found = verify_cube(cube)
    assert found.verdict is Verdict.IDENTICAL
    assert found.base == str(folder)

    moved = tmp_path / "moved"
    shutil.copytree(folder, moved)
    found = verify_cube(cube, base=moved)
    assert (found.verdict, found.files) == (Verdict.IDENTICAL, ())

    shutil.rmtree(moved)  # of two folders that have the file, neither is chosen
    np.save(image, values[::-1])
    found = verify_cube(cube)
    assert found.verdict is Verdict.DIFFERENT
    [change] = found.files
    assert (change.name, change.now_at, change.state) == ("./clouds.npy", str(image.resolve()), "changed")
    assert None not in (change.recorded_sha256, change.now_sha256)
    shown = command(cube).output
    assert change.recorded_sha256 in shown
    assert change.now_sha256 in shown

    image.unlink()  # the copy in the cube is left
    found = verify_cube(cube)
    assert (found.verdict, found.files) == (Verdict.IDENTICAL, ())


def test_a_file_too_large_to_travel_is_named_where_it_is_missing(tmp_path, monkeypatch):
    folder = tmp_path / "mine"
    folder.mkdir()
    image = folder / "clouds.npy"
    np.save(image, np.random.default_rng(1).random((200, 200)))
    assert image.stat().st_size > LARGEST_BYTES
    imagery = {"clouds.generator": "imagery", "clouds.parameters": {"image": "clouds.npy"}}
    cube = simulated(tmp_path / "cube.nc", MASKS | imagery | {"frames.count": 1}, folder)
    assert json.loads(attribute(cube, "hcss_input_files")) == {}
    (tmp_path / "far").mkdir()
    moved = shutil.move(folder, tmp_path / "far" / "moved")
    found = verify_cube(cube)
    assert found.verdict is Verdict.NOT_RECOMPUTED
    assert "clouds.npy" in found.problems[0]
    assert [(each.name, each.state) for each in found.files] == [("./clouds.npy", "missing")]
    assert "--base" in command(cube).output
    assert command(cube, "--base", moved).exit_code == 0


def attribute(path, name):
    with netCDF4.Dataset(path) as file:
        return file.getncattr(name)


def test_a_hostile_cube_reads_only_what_the_user_named_and_quotes_nothing(masks, tmp_path_factory):
    secret = tmp_path_factory.mktemp("private") / "secret.csv"
    secret.write_text("wavelength_um,response\npassword,hunter2\n")
    digest = hashlib.sha256(secret.read_bytes()).hexdigest()
    name = {"name": "mine", "response": str(secret)}
    edit_json(masks, "hcss_scenario", lambda scenario: scenario.update(bands=[name]))
    edit_json(masks, "hcss_files_sha256", lambda table: table.update({str(secret): "0" * 64}))
    found = verify_cube(masks)
    assert found.verdict is Verdict.NOT_RECOMPUTED
    assert "it is not under the cube's folder; name it with --data" in found.problems[0]
    assert [(each.name, each.now_sha256) for each in found.files] == [(str(secret), None)]
    for data in ((), ("--data", str(secret)), ("--data", str(secret.parent))):
        answer = command(masks, *data)
        assert answer.exit_code == 1
        assert not [word for word in ("password", "hunter2") if word in answer.output]
        assert (digest in answer.output) == bool(data)


def test_images_of_another_size_are_different_without_a_plan(masks, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("planned")

    edit_json(masks, "hcss_scenario", lambda scenario: scenario["image"].update(rows=10**5, columns=10**5))
    monkeypatch.setattr(verification, "make_plan", refuse)
    found = verify_cube(masks)
    assert found.verdict is Verdict.DIFFERENT
    assert [(each.what, each.recorded) for each in found.layout] == [("rows", "16"), ("columns", "16")]


def test_a_file_that_changed_without_effect_is_told_of_an_identical_cube(tmp_path):
    profile = tmp_path / "mine.csv"
    shutil.copy(Catalog().root / "atmospheres" / "us-standard-1976.csv", profile)
    cube = simulated(tmp_path / "cube.nc", MASKS | {"atmosphere.profile": "mine.csv"}, tmp_path)
    with profile.open("a") as file:
        file.write("# a remark\n")
    found = verify_cube(cube)
    assert found.verdict is Verdict.IDENTICAL
    assert [(each.name, each.state) for each in found.files] == [("./mine.csv", "changed")]


def test_a_changed_catalog_file_is_named(masks):
    edit_json(masks, "hcss_files_sha256", lambda table: table.update({"bands.toml": "0" * 64, "gone.csv": "1" * 64}))
    found = verify_cube(masks)
    assert found.verdict is Verdict.IDENTICAL
    assert [(each.name, each.state, each.recorded_sha256) for each in found.files] == [
        ("bands.toml", "changed", "0" * 64),
        ("gone.csv", "missing", "1" * 64),
    ]
    assert len(found.files[0].now_sha256) == 64


def test_a_changed_key_of_the_scenario_is_a_different_cube(masks):
    edit_json(masks, "hcss_scenario", lambda scenario: scenario.update({"seed": 99}))
    found = verify_cube(masks)
    assert found.verdict is Verdict.DIFFERENT
    assert [(each.what, each.now) for each in found.attributes] == [("hcss_seed", "99")]


@pytest.mark.parametrize(
    ("part", "what", "compared"), [({"time": [0, 2, 4]}, "frames", 3 * 16 * 16), ({"x": slice(0, 8)}, "columns", None)]
)
def test_a_part_of_a_cube_is_told_and_compared_where_both_have_it(masks, tmp_path, part, what, compared):
    with open_cube(masks) as dataset:
        dataset.drop_vars("band").isel(part).to_netcdf(tmp_path / "part.nc", engine="netcdf4")
    found = verify_cube(tmp_path / "part.nc")
    assert found.verdict is Verdict.DIFFERENT
    assert [each.what for each in found.layout] == [what]
    checks = by_name(found)
    if compared is None:
        assert "cloud_mask" not in checks
    else:
        assert (checks["cloud_mask"].values, checks["cloud_mask"].unequal) == (compared, 0)


def test_one_band_of_two_is_compared_by_its_name(cube, tmp_path):
    with open_cube(cube) as dataset:
        one = dataset.isel(band=[1]).drop_vars("band")
        one.to_netcdf(tmp_path / "part.nc", engine="netcdf4")
    found = verify_cube(tmp_path / "part.nc", frames=1)
    assert [(each.what, each.recorded, each.now) for each in found.layout] == [("bands", "lwir", "mwir, lwir")]
    assert by_name(found)["radiance"].values == 16 * 16
    assert by_name(found)["radiance"].unequal == 0
    assert by_name(found)["wavelength"].unequal == 0


def test_a_missing_variable_is_told(masks):
    with netCDF4.Dataset(masks, "a") as file:
        file.renameVariable("cloud_mask", "mask")
    found = verify_cube(masks)
    [change] = found.layout
    assert change.what == "variables"
    assert found.verdict is Verdict.DIFFERENT


def test_interrupted_and_foreign_files_are_refused(tmp_path, masks):
    with netCDF4.Dataset(tmp_path / "foreign.nc", "w") as file:
        file.createDimension("x", 3)
    with netCDF4.Dataset(masks, "a") as file:
        file.delncattr("hcss_cube_format")  # as long as frames are missing
    (tmp_path / "text.nc").write_text("no cube")
    for path in (tmp_path / "foreign.nc", masks, tmp_path / "text.nc"):
        with pytest.raises(CubeError, match=rf"cannot read .*{path.name}"):
            verify_cube(path)


def test_a_cube_without_provenance_is_refused(tmp_path):
    header = example_header()
    with CubeWriter(tmp_path / "c.nc", header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    with pytest.raises(CubeError, match=r"carries no hcss_|is malformed|is not valid JSON"):
        verify_cube(tmp_path / "c.nc")


@pytest.mark.parametrize("text", ["{", "[]", '{"a": 1}'])
def test_malformed_provenance_is_refused_by_name(masks, text):
    with netCDF4.Dataset(masks, "a") as file:
        file.setncattr("hcss_files_sha256", text)
    with pytest.raises(CubeError, match="hcss_files_sha256"):
        verify_cube(masks)


def test_truncated_values_are_refused_not_compared(fresh_masks, tmp_path):
    short = tmp_path / "short.nc"
    short.write_bytes(fresh_masks.read_bytes()[:-2000])
    with pytest.raises(CubeError, match=r"cannot read .*short\.nc"):
        verify_cube(short)
