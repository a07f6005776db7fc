"""Cubes in 16-bit integers: the error is stated, bounded and certified, and every reader gets the same numbers."""

import re

import h5py
import netCDF4
import numpy as np
import pytest
import rasterio
from astropy.io import fits
from cheap import CHEAP
from hcss_export import export_cube

from hcss_twin import Scenario, make_plan, open_cube
from hcss_twin.core.errors import CertificateWarning, CubeError, ScenarioError
from hcss_twin.cube.packing import FILL, LARGEST, packing_of, round_to_steps
from hcss_twin.engine.sense import section_of, sense_file
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.plan import packing as packing_of_plans
from hcss_twin.plan.description import describe
from hcss_twin.reports.plan_text import plan_text

PACKED = {"radiance", "brightness_temperature", "cloud_fraction", "cloud_thickness"}
SMALL = CHEAP | {
    "image.rows": 40,
    "image.columns": 50,
    "bands": ["lwir"],
    "frames.count": 2,
    "output.certificate": 4,
    "output.variables": ["truth", "radiance", "brightness_temperature", "terms"],
}


SOURCE = {
    "provider": "point-sources",
    "parameters": {"tracks": [{"x": 0, "y": 5, "altitude": 9e3, "intensity": {"lwir": 5e2}}]},
}


def planned(packing="int16", **changes):
    overrides = {key.replace("__", "."): value for key, value in changes.items()}
    return make_plan(Scenario.load("stratus", SMALL | {"output.packing": packing} | overrides))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The same cube in single precision, packed, and packed in Zarr."""
    folder = tmp_path_factory.mktemp("packing")
    run(planned(None), folder / "full.nc")
    for name in ("packed.nc", "packed.zarr"):
        run(planned(), folder / name)
    return folder


def test_every_number_is_within_the_error_that_its_variable_states(folder):
    with open_cube(folder / "full.nc") as full, open_cube(folder / "packed.nc") as packed:
        stored = {name for name, values in packed.data_vars.items() if "packing_maximum_error" in values.attrs}
        assert stored == PACKED | {name for name in full.data_vars if name.startswith("radiance_")}
        for name, exact in full.data_vars.items():
            error = np.abs(packed[name].to_numpy().astype(float) - exact.to_numpy())
            most = float(packed[name].attrs.get("packing_maximum_error", 0.0))
            assert np.nanmax(error) <= most
            assert name not in ("radiance", "cloud_thickness") or np.nanmax(error) > 0.9 * most
        # A clear pixel has no cloud, also in steps.
        np.testing.assert_array_equal(packed.cloud_thickness == 0, full.cloud_thickness == 0)
        about = packed.radiance.attrs
        relative = np.abs(packed.radiance - full.radiance) / full.radiance
        assert relative.max() <= about["packing_maximum_relative_error"][()]
        kelvin = np.abs(packed.brightness_temperature - full.brightness_temperature).max()
        assert kelvin <= packed.brightness_temperature.attrs["packing_maximum_error_kelvin"][()]
        assert packed.attrs["hcss_certificate"].startswith("computed as specified")


def test_every_reader_unpacks_the_same_numbers(folder):
    with open_cube(folder / "packed.nc") as cube, open_cube(folder / "packed.zarr") as store:
        assert cube.radiance.dtype == np.float32
        with netCDF4.Dataset(folder / "packed.nc") as netcdf, h5py.File(folder / "packed.nc") as file:
            for name in PACKED:
                raw, about = file[name][...], file[name].attrs
                assert raw.dtype == np.int16
                assert raw.min() >= -LARGEST > FILL == about["_FillValue"]
                by_hand = raw.astype(float) * about["scale_factor"] + about["add_offset"]
                for values in (cube[name], store[name], netcdf[name][...]):
                    np.testing.assert_array_equal(np.asarray(values), by_hand)


def test_half_the_bytes():
    names = ["radiance"]
    assert 2 * planned(output__variables=names).uncompressed_bytes == (
        planned(None, output__variables=names).uncompressed_bytes
    )


@pytest.mark.parametrize("name", ["packed.nc", "packed.zarr"])
def test_a_packed_cube_verifies_to_the_bit(folder, name):
    assert verify_cube(folder / name).verdict is Verdict.IDENTICAL


def test_exports_and_sensors_read_the_unpacked_numbers(folder, tmp_path):
    with open_cube(folder / "packed.nc") as cube:
        expected = cube.radiance.to_numpy()
    exported = export_cube(folder / "packed.nc", "fits", tmp_path, variable="radiance")
    np.testing.assert_array_equal(np.squeeze(fits.getdata(exported.files[0])), np.squeeze(expected))
    exported = export_cube(folder / "packed.nc", "geotiff", tmp_path, variable="radiance", frames=[1])
    with rasterio.open(exported.files[0]) as image:
        np.testing.assert_array_equal(image.read(1), expected[1, 0, ::-1])
    sensor = section_of({"parameters": {"noise": "none", "psf": "none"}})
    sense_file(folder / "packed.nc", sensor, tmp_path / "s.nc")
    with open_cube(tmp_path / "s.nc") as measured:
        np.testing.assert_allclose(measured.radiance, expected, rtol=1e-5)


def test_numbers_are_not_rounded_twice():
    with pytest.raises(
        ScenarioError, match=r"output.quantization: .* with output.packing = 'int16'; allowed: 0, or no output.packing"
    ):
        planned(output__quantization=1e-4)


UNLIKE = {"bands": ["mwir", "lwir"]}


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        (UNLIKE, r"steps of 16 bits are .* up to 0.0\d+ of the radiance .* in band 'mwir', beyond 0.0003, 30 % "),
        ({"elements": [SOURCE]}, r"the radiance of \[\[elements\]\] has no known limit; "),
    ],
)
def test_radiance_that_fits_no_steps_stays_in_single_precision_and_the_plan_says_why(changes, why):
    plan = planned(**changes)
    specs = {spec.name: spec for spec in plan.variables}
    assert specs["radiance"].stored_dtype == "float32"
    assert specs["radiance"].significant_bits is None
    assert specs["cloud_thickness"].stored_dtype == "int16"
    (note,) = (note for note in plan.notes if note.startswith("output.packing: radiance stays"))
    assert re.search(why, note)
    assert note.endswith("; output.compression = 1 would round it to the bits that matter")


@pytest.mark.parametrize("changes", [UNLIKE, {"elements": [SOURCE | {"parameters": {"tracks": [
    {"x": 0, "y": 5, "altitude": 9e3, "temperature": 900.0, "area": 5e4}]}}], "bands": ["mwir"]}])  # fmt: skip
def test_radiance_without_steps_is_rounded_to_the_share_of_the_accuracy_in_each_band(changes, tmp_path):
    with open_cube(run(planned(None, **changes), tmp_path / "full.nc")) as full:
        exact = full.radiance.to_numpy().astype(float)
    plan = planned(**changes, output__compression=1)
    with open_cube(run(plan, tmp_path / "packed.nc")) as packed:
        assert packed.attrs["hcss_certificate"].startswith("computed as specified")
        error = np.max(np.abs(packed.radiance - exact) / exact, axis=(0, 2, 3)).to_numpy()
    assert np.all(error < 3e-4)
    assert np.all(error > 0.3 * 3e-4)
    assert "elements" not in changes or exact.max() > 10.0 * np.median(exact)  # far beyond all steps for clouds
    assert verify_cube(tmp_path / "packed.nc").verdict is Verdict.IDENTICAL


def test_steps_beyond_the_accuracy_would_fail_the_certificate(monkeypatch, tmp_path):
    monkeypatch.setattr(packing_of_plans, "LARGEST_SHARE", 1e4)
    plan = planned(bands=["swir-2.7-3.0", "lwir"], output__variables=["radiance"])
    with pytest.warns(CertificateWarning, match="NOT as specified"):
        run(plan, tmp_path / "coarse.nc")


def test_brightness_temperature_packs_bands_of_unlike_radiance():
    plan = planned(bands=["mwir", "lwir"], output__variables=["brightness_temperature"])
    packing = describe(plan)["packing"]["brightness_temperature"]
    assert max(packing["relative"]) < 3e-4
    assert f"lwir {packing['relative'][1]:.2g} of the radiance, {packing['kelvin'][1]:.2g} K" in " ".join(
        plan_text(plan).split()
    )


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (0.0, 65.3), (183.2, 331.0), (-0.02, 0.03), (1e-9, 2e-9)])
def test_the_finest_steps_that_cover_a_range_are_exact_in_single_precision(low, high):
    packing = packing_of(low, high)
    smallest, largest = packing.limits
    assert smallest <= low < smallest + packing.scale_factor
    assert high <= largest
    assert packing.scale_factor < 2.01 * (high - low) / (2 * LARGEST)
    numbers = np.arange(-LARGEST, LARGEST + 1)
    exact = numbers * packing.scale_factor + packing.add_offset
    np.testing.assert_array_equal(exact.astype(np.float32), exact)


@pytest.mark.parametrize("value", [-0.1, 2.5, np.nan, np.inf])
def test_a_value_beyond_the_steps_is_an_error(value):
    with pytest.raises(CubeError, match=r"frame 3, radiance: .*do not fit into 16 bits; allowed: 0 to 1.99994, "):
        round_to_steps(np.array([0.5, value], np.float32), packing_of(0.0, 1.5), "frame 3, radiance")


def test_cubes_in_unlike_steps_make_no_common_dataset(folder, tmp_path):
    hcss_sweep = pytest.importorskip("hcss_sweep.dataset")
    other = planned(bands=["mwir"], output__variables=SMALL["output.variables"])
    paths = {0: folder / "packed.nc", 1: run(other, tmp_path / "1.nc")}
    with pytest.raises(hcss_sweep.SweepError, match=r"radiance.*, their sizes or their packing"):
        hcss_sweep.differences(paths)
