"""A cube is recomputed where the files that it was made from do not exist: small ones travel in it."""

import base64
import json
import shutil
import zlib

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CubeError
from hcss_twin.engine.provenance import Recorded, recorded_files
from hcss_twin.engine.verification import Verdict, verify_cube

SCENE = CHEAP | {"image.rows": 12, "image.columns": 12, "frames.count": 1, "output.certificate": 0}

RESPONSE = "wavelength_um,response\n3.7,0\n3.8,1\n3.9,0.9\n4.0,0\n"


def scenario(folder):
    """A scenario above a spectral response, in folders that are nobody's business."""
    (folder / "inputs").mkdir(parents=True)
    (folder / "inputs" / "response.csv").write_text(RESPONSE)
    raw = json.loads(hcss_twin.Scenario.load("stratus", SCENE).to_json())
    raw["bands"] = [{"name": "mine", "response": "inputs/response.csv"}]
    (folder / "scene.json").write_text(json.dumps(raw))
    return folder / "scene.json"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("home") / "user" / "secret-programme"
    cube = tmp_path_factory.mktemp("made") / "cube.nc"
    hcss_twin.simulate(hcss_twin.Scenario.load(scenario(folder)), cube).close()
    shutil.rmtree(folder)
    return cube


@pytest.fixture
def cube(made, tmp_path, monkeypatch):
    """The cube on another machine: its inputs are gone, and the working folder is another one."""
    monkeypatch.chdir(tmp_path)
    return shutil.copy(made, tmp_path / "cube.nc")


def stored(path):
    with netCDF4.Dataset(path) as file:
        return json.loads(file.getncattr("hcss_input_files"))


def store(path, table):
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("hcss_input_files", table if isinstance(table, str) else json.dumps(table))


def test_a_moved_cube_is_verified_without_the_files_it_was_made_from(cube):
    found = verify_cube(cube)
    assert (found.verdict, found.problems, found.files) == (Verdict.IDENTICAL, (), ())


def test_its_brightness_temperature_and_a_sensor_need_no_files_either(cube):
    kelvin = hcss_twin.brightness_temperature(cube)
    assert np.all((kelvin > 250.0) & (kelvin < 330.0))
    measured = cube.with_name("measured.nc")
    hcss_twin.sense(cube, sensor="generic-mwir", output=measured).close()
    assert stored(measured) == stored(cube)
    assert hcss_twin.brightness_temperature(measured).dims == kelvin.dims


def test_the_stored_files_have_no_names_and_no_folders(cube):
    with netCDF4.Dataset(cube) as file:
        text = file.getncattr("hcss_input_files")
        recorded = json.loads(file.getncattr("hcss_files_sha256"))
    [digest] = [digest for name, digest in recorded.items() if name.endswith("response.csv")]
    assert list(json.loads(text)) == [digest]
    assert not any(part in text for part in ("secret-programme", "response", "inputs"))


def test_no_attribute_tells_where_the_inputs_were(cube):
    with netCDF4.Dataset(cube) as file:
        recorded = json.loads(file.getncattr("hcss_files_sha256"))
        text = "\n".join(str(file.getncattr(name)) for name in file.ncattrs())
    assert "./inputs/response.csv" in recorded
    assert "secret-programme" not in text
    assert not any(name.startswith("/") for name in recorded)


def test_a_file_above_the_folder_is_named_as_the_scenario_names_it(made, tmp_path, monkeypatch):
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "response.csv").write_text(RESPONSE)
    raw = json.loads(scenario(tmp_path / "scenes" / "own").read_text())
    for path in ("../../shared/response.csv", str(tmp_path / "shared" / "response.csv")):
        raw["bands"][0]["response"] = path
        (tmp_path / "scenes" / "own" / "scene.json").write_text(json.dumps(raw))
        out = tmp_path / "scenes" / "cube.nc"
        out.unlink(missing_ok=True)
        hcss_twin.simulate(hcss_twin.Scenario.load(tmp_path / "scenes" / "own" / "scene.json"), out).close()
        with netCDF4.Dataset(out) as file:
            recorded = json.loads(file.getncattr("hcss_files_sha256"))
        # an absolute path is in the scenario anyway
        assert [name for name in recorded if name.endswith("response.csv")] == [
            path if path.startswith("/") else f"./{path}"
        ]
        monkeypatch.chdir(tmp_path)
        assert verify_cube(out).verdict is Verdict.IDENTICAL  # with the stored copy
        assert verify_cube(out, base=tmp_path / "scenes" / "own", data=[tmp_path]).verdict is Verdict.IDENTICAL
    (tmp_path / "shared" / "response.csv").write_text(RESPONSE.replace("0.9", "0.5"))
    assert verify_cube(out, data=[tmp_path]).verdict is Verdict.DIFFERENT


def test_a_file_that_a_package_ships_is_named_by_the_package_wherever_it_is_installed(tmp_path, monkeypatch):
    attributes = {"hcss_scenario": "{}", "hcss_versions": "{}", "hcss_providers": "{}"}
    recorded = []
    for place in ("one", "another"):
        folder = tmp_path / place / "site-packages" / "shipping_plugin" / "library"
        folder.mkdir(parents=True)
        (folder.parent / "__init__.py").write_text("raise ImportError('not imported')")
        (folder / "sky.nc").write_text("sky")
        with monkeypatch.context() as patch:
            patch.syspath_prepend(tmp_path / place / "site-packages")
            catalog = Catalog(base=tmp_path / "scene")
            catalog.shipped(folder / "sky.nc")
            recorded.append(recorded_files(catalog, {}))
            files = json.dumps(recorded[0])
            now = Recorded.of({**attributes, "hcss_files_sha256": files}, str(tmp_path / "cube.nc"))
            assert now.files == catalog.used  # those of this installation
            assert now.file_changes(catalog.used, catalog.shelf) == ()
    assert recorded[0] == recorded[1]
    assert list(recorded[0]) == ["package:shipping_plugin/library/sky.nc"]
    gone = Recorded.of({**attributes, "hcss_files_sha256": files}, str(tmp_path / "cube.nc"))
    assert [(change.name, change.state) for change in gone.file_changes(None, Catalog().shelf)] == [
        ("package:shipping_plugin/library/sky.nc", "missing")
    ]


def test_inputs_are_kept_out_of_a_cube_that_is_then_verified_beside_them(tmp_path, monkeypatch):
    path = scenario(tmp_path / "home")
    (tmp_path / "elsewhere").mkdir()
    out = tmp_path / "elsewhere" / "cube.nc"
    hcss_twin.simulate(hcss_twin.Scenario.load(path, {"output.store_inputs": False}), out).close()
    measured = out.with_name("measured.nc")
    monkeypatch.chdir(tmp_path / "home")
    hcss_twin.sense(out, sensor="generic-mwir", output=measured).close()
    for cube in (out, measured):
        with netCDF4.Dataset(cube) as file:
            assert "hcss_input_files" not in file.ncattrs()
            assert "./inputs/response.csv" in json.loads(file.getncattr("hcss_files_sha256"))
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert verify_cube(out).verdict is Verdict.NOT_RECOMPUTED
    assert verify_cube(out, base=tmp_path / "home").verdict is Verdict.IDENTICAL
    assert verify_cube(out, data=[tmp_path / "home"]).verdict is Verdict.IDENTICAL
    beside = shutil.copy(out, tmp_path / "home" / "cube.nc")
    assert verify_cube(beside).verdict is Verdict.IDENTICAL


def test_cubes_of_before_that_record_absolute_paths_are_verified(made, tmp_path, monkeypatch):
    folder = tmp_path / "home"
    scenario(folder)
    old = shutil.copy(made, tmp_path / "old.nc")
    with netCDF4.Dataset(old, "a") as file:
        recorded = json.loads(file.getncattr("hcss_files_sha256"))
        names = {str(folder / name) if name.startswith("./") else name: value for name, value in recorded.items()}
        file.setncattr("hcss_files_sha256", json.dumps(names))
        file.delncattr("hcss_input_files")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    found = verify_cube(old, data=[folder])
    assert (found.verdict, found.files) == (Verdict.IDENTICAL, ())


def test_a_file_that_is_there_and_may_be_read_goes_before_the_copy(cube, tmp_path):
    (tmp_path / "inputs").mkdir()
    (tmp_path / "inputs" / "response.csv").write_text(RESPONSE.replace("0.9", "0.5"))
    found = verify_cube(cube, base=tmp_path)
    assert found.verdict is Verdict.DIFFERENT
    assert [change.state for change in found.files] == ["changed"]


def altered(table):
    [(digest, content)] = table.items()
    return {digest: content[:-8] + "AAAAAAA="}


def exchanged(table):
    """Content that is whole, but not the one that was read."""
    other = base64.b64encode(zlib.compress(RESPONSE.replace("0.9", "0.5").encode())).decode()
    return dict.fromkeys(table, other)


def bomb(table):
    return dict.fromkeys(table, base64.b64encode(zlib.compress(bytes(10_000_000))).decode())


def many_bombs(table):
    """Each as large as allowed."""
    return {f"{number:064x}": base64.b64encode(zlib.compress(bytes(256 * 1024))).decode() for number in range(9)}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (altered, "stored input files are damaged"),
        (exchanged, "a stored input file was altered"),
        (bomb, "larger than 262144 bytes"),
        (many_bombs, "or all than 2097152"),
        (lambda table: "[1", "stored input files are damaged"),
        (lambda table: "[1]", "stored input files are damaged"),
        (lambda table: dict.fromkeys(table, "no base64!"), "stored input files are damaged"),
        (lambda table: dict.fromkeys(table, 7), "stored input files are damaged"),
    ],
)
def test_an_altered_copy_is_refused(cube, change, told):
    store(cube, change(stored(cube)))
    with pytest.raises(CubeError, match=told):
        verify_cube(cube)


@pytest.mark.parametrize("inner", ["/inner.csv", "/" + 300 * "a"])
def test_recorded_names_that_cannot_be_files_are_told(cube, inner):
    with netCDF4.Dataset(cube, "a") as file:
        recorded = json.loads(file.getncattr("hcss_files_sha256"))
        recorded |= {name + inner: digest for name, digest in recorded.items() if name.endswith(".csv")}
        file.setncattr("hcss_files_sha256", json.dumps(recorded))
    with pytest.raises(CubeError, match="a stored input file cannot be unpacked"):
        verify_cube(cube)


def test_recorded_names_that_lead_out_of_a_folder_are_not_unpacked(cube, tmp_path):
    with netCDF4.Dataset(cube, "a") as file:
        recorded = json.loads(file.getncattr("hcss_files_sha256"))
        names = {
            f"/../../../..{tmp_path}/out.csv" if name.endswith(".csv") else name: value
            for name, value in recorded.items()
        }
        file.setncattr("hcss_files_sha256", json.dumps(names))
    assert verify_cube(cube).verdict is Verdict.NOT_RECOMPUTED
    assert not (tmp_path / "out.csv").exists()
