"""Files of examples: what is written is read, damaged ones are refused in one line, the shipped ones are whole."""

import subprocess
import sys

import netCDF4
import numpy as np
import pytest
from conftest import cloud_field
from hcss_skies.example import LEVELS, make_example, read_example, write_example
from hcss_skies.library import shipped

from hcss_twin.providers import CatalogError

TERMS = {"pixel_size_m": 3000.0, "clear_m": 300.0, "kind": "test", "source": "test", "licence": "none"}


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "own.nc"
    write_example(path, make_example(cloud_field(64), np.zeros((64, 64)), **TERMS))
    return path


def test_a_file_gives_the_field_back_by_its_ranks(written):
    """256 ranks over 8 standard deviations of the score."""
    example, field = read_example(written), cloud_field(64)
    found = example.opaque_m[example.opaque]
    assert np.abs(found - field).mean() < 0.01 * np.ptp(field)
    np.testing.assert_allclose(np.quantile(found, [0.1, 0.5, 0.9]), np.quantile(field, [0.1, 0.5, 0.9]), atol=25.0)
    assert example.coverage == pytest.approx(np.mean(field > 300.0), abs=0.02)
    assert example.excess_is_known
    assert not make_example(field, None, **TERMS).excess_is_known


def test_a_file_of_256_by_256_pixels_is_small(tmp_path):
    write_example(tmp_path / "own.nc", make_example(cloud_field(256), None, **TERMS))
    assert (tmp_path / "own.nc").stat().st_size < 85_000


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9])
def test_a_truncated_file_is_one_clear_error(written, part):
    content = written.read_bytes()
    written.write_bytes(content[: int(part * len(content))])
    with pytest.raises(CatalogError, match=r"own\.nc"):
        read_example(written)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.setncattr("hcss_skies_format", 9), "no example of a sky"),
        (lambda file: file.setncattr("pixel_size_m", -1.0), "pixel_size_m -1; allowed: 1 to 100000"),
        (lambda file: file.setncattr("pixel_size_m", "wide"), r"own\.nc"),
        (lambda file: file.delncattr("kind"), r"own\.nc"),
        (lambda file: file["opaque_m"].__setitem__(5, np.nan), "heights that do not ascend"),
        (lambda file: file["opaque_m"].__setitem__(LEVELS - 1, 1e6), "outside -3000 to 30000 m"),
    ],
)
def test_wrong_contents_are_named(written, change, message):
    with netCDF4.Dataset(written, "a") as file:
        change(file)
    with pytest.raises(CatalogError, match=message):
        read_example(written)


def test_the_library_has_three_examples_of_each_of_five_kinds_in_a_megabyte_and_a_quarter():
    examples = [read_example(path) for path in shipped().values()]
    assert len(examples) == 15
    assert len({example.kind for example in examples}) == 5
    assert sum(path.stat().st_size for path in shipped().values()) < 1_250_000
    assert all(example.licence == "BSD-3-Clause" and 0.1 < example.coverage < 0.99 for example in examples)


def test_registration_imports_nothing_heavy():
    code = (
        "import sys, hcss_skies as e, hcss_skies.commands as c; e.hcss_register_cloud_generators(); c.hcss_commands(); "
        "print([m for m in sys.modules if m.split('.')[0] in ('numpy', 'scipy', 'numba', 'click', 'pydantic')])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
