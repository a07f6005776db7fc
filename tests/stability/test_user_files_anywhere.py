"""Files of users with NaN, infinities, holes and words in them: refused with the name of the file, or sound."""

import dataclasses
import math
import shutil
import tempfile
from itertools import cycle, product
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP
from examples import examples
from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hypothesis import assume, given
from hypothesis import strategies as st
from input_files import small_table
from pydantic import BaseModel, ValidationError
from refusals import result_or_refusal

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.band_model.absorption import read_coefficients
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.optics.ice_crystals import load_crystals
from hcss_twin.models.parameters import (
    AsPrintedParameters,
    BandModelParameters,
    BulkParameters,
    CoxMunkParameters,
    MieParameters,
    PhysicalParameters,
    RoughSeaParameters,
)
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.scenario.response_file import read_response

BAD_NUMBERS = (math.nan, math.inf, -math.inf)
BAD_WORDS = st.sampled_from(["nan", "NaN", "inf", "-inf", "1e999", "", "x", "--", "1;2"])
SHIPPED = Catalog().root
TINY = CHEAP | {"image.rows": 20, "image.columns": 20, "frames.count": 1, "bands": ["lwir-10.8"]}
SOME = examples(20)

CSV = {
    "response": ("wavelength_um,response", ["3.5,0", "3.6,0.5", "3.7,1", "3.8,0"]),
    "index": ("wavelength_um,n,k", ["0.5,1.33,1e-9", "3,1.4,0.2", "20,1.3,0.1"]),
    "profile": (
        "pressure_hPa,temperature_C,relative_humidity_percent",
        ["1013,17,80", "850,8,48", "700,-1,30", "500,-16,22", "300,-42,25", "200,-55,10", "100,-60,3"],
    ),
}


def read(kind, folder, name):
    """Whatever reads that kind of file."""
    catalog = Catalog(base=folder)
    match kind:
        case "response":
            return read_response(name, catalog)
        case "index":
            return load_refractive_index(catalog, str(folder / name))
    from hcss_twin.models.atmosphere.profile_file import load_profile

    return load_profile(name, catalog)


@pytest.mark.parametrize("kind", CSV)
def test_a_number_that_is_none_in_a_table_is_named_with_file_and_line(kind, tmp_path):
    head, rows = CSV[kind]
    (tmp_path / "sound.csv").write_text("\n".join([head, *rows]))
    read(kind, tmp_path, "sound.csv")

    @SOME
    @given(st.integers(0, len(rows) - 1), st.integers(0, head.count(",")), BAD_WORDS)
    def poison(row, column, word):
        assume(kind != "profile" or word.strip().lower() not in ("", "nan"))  # a level that is left out, and told
        cells = [line.split(",") for line in rows]
        cells[row][column] = word
        path = tmp_path / "bad.csv"
        path.write_text("\n".join([head, *map(",".join, cells)]))
        with pytest.raises(CatalogError, match=rf"bad\.csv, line {row + 2}"):
            read(kind, tmp_path, "bad.csv")

    poison()


@pytest.mark.parametrize(
    ("overrides", "field"),
    [
        ({"bands": [{"name": "x", "response": "bad.csv"}]}, "bands"),
        ({"atmosphere.profile": "bad.csv"}, "atmosphere.profile"),
        ({"sea.parameters.water_index": "bad.csv"}, "sea"),
        ({"optics.parameters.water_index": "bad.csv"}, "optics"),
        ({"clouds.generator": "imagery", "clouds.parameters": {"image": "bad.npy"}}, "clouds"),
        ({"clouds.type": "bad.toml"}, "clouds"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@pytest.mark.parametrize("bad", ["nan", "inf"])
def test_a_scenario_says_which_of_its_fields_names_the_bad_file(overrides, field, bad, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.csv").write_text(f"wavelength_um,n,k,response\n3,1,1,{bad}\n5,1,{bad},1\n")
    np.save(tmp_path / "bad.npy", np.full((30, 30), float(bad)))
    shipped = (SHIPPED / "cloud_types" / "paper-stratus.toml").read_text()
    (tmp_path / "bad.toml").write_text(shipped.replace("top = 1000.0", f"top = {bad}"))
    with pytest.raises(ScenarioError) as caught:
        make_plan(Scenario.load("stratus", TINY | overrides))
    assert any(problem.field.startswith(field) for problem in caught.value.problems), str(caught.value)
    assert "bad." in str(caught.value)


@SOME
@given(
    st.sampled_from(["transmittance", "path_radiance", "wavenumber_cm1", "level_temperature_K", "level_pressure_Pa"]),
    st.integers(0, 29),
    st.sampled_from([*BAD_NUMBERS, -1.0]),
)
def test_an_atmosphere_table_with_an_impossible_number_is_refused(name, place, bad):
    with tempfile.TemporaryDirectory() as folder:
        path = small_table(Path(folder) / "table.nc")
        AtmosphereTable.read(path)
        with netCDF4.Dataset(path, "a") as file:
            array = file[name][:].filled()
            array.flat[place % array.size] = bad
            file[name][:] = array
        with pytest.raises(CatalogError, match=r"table\.nc: .*" + name):
            AtmosphereTable.read(path)


def numeric_variables(path):
    with netCDF4.Dataset(path) as file:
        return sorted(name for name, each in file.variables.items() if np.dtype(each.dtype).kind == "f")


BAND_MODEL = SHIPPED / "atmospheres" / "lowtran7-band-model.nc"
CRYSTALS = SHIPPED / "optics" / "ice-yang-2013.nc"


def poisoned(source, folder, name, bad):
    """A copy of a file in which one number that was finite is not."""
    path = Path(shutil.copy(source, folder / "poisoned.nc"))
    path.chmod(0o644)
    with netCDF4.Dataset(path, "a") as file:
        file.set_auto_mask(False)
        array = np.asarray(file[name][:])
        finite = np.flatnonzero(np.isfinite(array.ravel()) & (array.ravel() != 0.0))
        array.flat[finite[finite.size // 2]] = bad
        file[name][:] = array
    return path


def same(one, other):
    """Whether two records of arrays hold the same bits."""
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if dataclasses.is_dataclass(one):
        return all(same(getattr(one, each.name), getattr(other, each.name)) for each in dataclasses.fields(one))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return one == other


@pytest.fixture(scope="module")
def coefficients():
    return read_coefficients(BAND_MODEL)


UNREAD = {"pressure_mb", "temperature_K", "albedo", "asymmetry", "extinction", "published_diameter"}
"""Variables that are kept for people: a bad number in them changes nothing."""


def by_turns(names):
    """Pairs of a name and a number that is none: what refuses one of these refuses the others."""
    return list(zip(names, cycle(BAD_NUMBERS), strict=False))


@pytest.mark.parametrize(("name", "bad"), by_turns(numeric_variables(BAND_MODEL)))
def test_coefficients_of_the_band_model_that_are_no_numbers_are_refused(name, bad, tmp_path, coefficients):
    path = poisoned(BAND_MODEL, tmp_path, name, bad)
    if name in UNREAD:
        assert same(read_coefficients(path), coefficients)
        return
    with pytest.raises(CatalogError, match=rf"poisoned\.nc: {name}"):
        read_coefficients(path)


@pytest.mark.parametrize(("name", "bad"), by_turns(numeric_variables(CRYSTALS)))
def test_a_table_of_crystals_with_a_number_that_is_none_is_refused(name, bad, tmp_path):
    catalog, path = Catalog(), str(poisoned(CRYSTALS, tmp_path, name, bad))
    if name in UNREAD:
        read, known = (load_crystals(catalog, path, "moderate"), load_crystals(catalog, str(CRYSTALS), "moderate"))
        assert same(read, known)
        return
    with pytest.raises(CatalogError, match=r"poisoned\.nc: "):
        load_crystals(catalog, path, "moderate")  # the middle of three, of which the file's middle number is


@examples(6)
@given(st.integers(0, 2**32), st.floats(0.0, 1.0), st.sampled_from(BAD_NUMBERS), st.booleans())
def test_images_with_holes_are_refused_or_the_holes_are_clear_as_asked(seed, share, bad, allow):
    """Thickness is finite and not negative everywhere."""
    random = np.random.default_rng(seed)
    values = random.random((40, 40)).cumsum(axis=0) + 1.0
    hole = random.random(values.shape) < share**3
    values[hole] = bad
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "image.npy", values)
        raw = {
            "time": "2024-04-20T12:30:00+10:00",
            "place": {"latitude": 35.0, "longitude": 150.0},
            "image": {"rows": 30, "columns": 30, "pixel_size": 100.0},
            "frames": {"count": 1},
            "motion": {"wind_speed": 0.0},
            "clouds": {
                "generator": "imagery",
                "parameters": {"image": "image.npy", "missing": "clear" if allow else "error"},
            },
            "output": {"variables": ["cloud_mask", "cloud_thickness"]},
        }
        cube, error = result_or_refusal(lambda: simulate(Scenario.from_dict(raw, base=Path(folder))))
        if cube is None:
            assert "image" in str(error)
            assert hole.any()
            return
        # In row 0 of an image north is first; the scene is the middle of it.
        inside = hole[5:35, 5:35]
        assert allow or not inside.any()
        thickness = cube.cloud_thickness.values[0]
        assert np.all(np.isfinite(thickness))
        assert np.all(thickness >= 0.0)
        assert np.all(thickness[inside[::-1]] == 0.0)


@SOME
@given(st.integers(0, 2**32), st.sampled_from(BAD_NUMBERS), st.floats(0.0, 0.5))
def test_an_import_marks_what_is_missing_and_its_entry_reads_back(seed, bad, share):
    random = np.random.default_rng(seed)
    values = 20.0 + random.random((50, 60))
    values[10:30, 15:40] += 150.0
    hole = random.random(values.shape) < share
    values[hole] = bad
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "image.npy", values)
        options = ImportOptions(pixel_size_m=100.0)
        entry, error = result_or_refusal(lambda: import_image(Path(folder) / "image.npy", options))
        if entry is None:
            assert "image.npy" in str(error)
            return
        np.testing.assert_array_equal(entry.missing, hole)
        assert not np.any(entry.mask & hole)
        path = Path(folder) / "entry.nc"
        entry.write(path)
        again = CloudEntry.read(path)
        np.testing.assert_array_equal(again.grey, entry.grey)
        with netCDF4.Dataset(path, "a") as file:
            file.pixel_size_m = bad
        with pytest.raises(CatalogError, match=r"entry\.nc: pixel_size_m"):
            CloudEntry.read(path)


MODELS = (
    BandModelParameters,
    FractalParameters,
    ImageryParameters,
    CoxMunkParameters,
    RoughSeaParameters,
    MieParameters,
    BulkParameters,
    AsPrintedParameters,
    PhysicalParameters,
)


def numeric_fields(model: type[BaseModel]):
    return [
        name
        for name, field in model.model_fields.items()
        if any(kind in str(field.annotation) for kind in ("float", "int"))
    ]


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_no_parameter_of_a_provider_may_be_no_number(model):
    needed = {"image": "x"} if model is ImageryParameters else {}
    for name, bad in product(numeric_fields(model), BAD_NUMBERS):
        for value in (bad, [bad, 1.0], (1.0, bad)):
            with pytest.raises(ValidationError):
                model(**needed, **{name: value})


@pytest.mark.parametrize("bad", ["nan", "inf", "-inf"])
def test_no_number_of_a_cloud_type_may_be_none(bad, tmp_path):
    lines = (SHIPPED / "cloud_types" / "paper-stratus.toml").read_text().splitlines()
    numeric = [index for index, line in enumerate(lines) if "=" in line and line.split("= ")[1][0].isdigit()]
    assert len(numeric) >= 8
    for index in numeric:
        key = lines[index].split(" =")[0]
        changed = [*lines[:index], f"{key} = {bad}", *lines[index + 1 :]]
        (tmp_path / "bad.toml").write_text("\n".join(changed))
        with pytest.raises(ScenarioError, match=r"bad\.toml|clouds"):
            make_plan(Scenario.load("stratus", TINY | {"clouds.type": str(tmp_path / "bad.toml")}))
