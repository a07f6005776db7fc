"""hcss atmosphere plot: one or two providers or tables become a picture and a comparison."""

import dataclasses
import json

import numpy as np
import pytest
from command import hcss
from PIL import Image

from hcss_twin.core.catalog import catalog_root
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.table_file import AtmosphereTable

SHIPPED = AtmosphereTable.read(catalog_root() / "atmospheres" / "us-standard-1976-lowtran7.nc")


def part_of_the_shipped_table(path, heights, angles):
    at = np.ix_(np.searchsorted(SHIPPED.target_altitude_m, heights), np.searchsorted(SHIPPED.zenith_deg, angles))
    values = {"transmittance": SHIPPED.transmittance[at], "path_radiance": SHIPPED.path_radiance[at]}
    nodes = {"target_altitude_m": np.array(heights), "zenith_deg": np.array(angles)}
    dataclasses.replace(SHIPPED, **nodes, **values).write(path, {})
    return path


def is_a_drawing(path):
    with Image.open(path) as image:
        shades = np.asarray(image.convert("L"))
    return shades.shape[0] > 800 and np.unique(shades).size > 50


def test_plot_draws_one_provider(tmp_path):
    result = hcss("atmosphere", "plot", "table", "-o", tmp_path / "one.png")
    assert result.output.strip() == str(tmp_path / "one.png")
    assert is_a_drawing(tmp_path / "one.png")


def test_plot_compares_two_and_says_how_they_differ(tmp_path):
    mine = part_of_the_shipped_table(tmp_path / "mine.nc", [0.0, 500.0, 1500.0], [0.0, 40.0, 60.0, 75.0])
    arguments = ["table", mine, "-o", tmp_path / "two.png", "--zenith", 0, "--zenith", 60]
    said = hcss("atmosphere", "plot", *arguments).output
    assert "mine - table: transmittance rms" in said
    assert "8-14 um: mean transmittance differs by up to" in said
    assert is_a_drawing(tmp_path / "two.png")


def test_plot_of_a_table_with_one_height_and_angle(tmp_path):
    part_of_the_shipped_table(tmp_path / "one.nc", [0.0], [40.0])
    result = hcss("atmosphere", "plot", tmp_path / "one.nc", "-o", tmp_path / "one.png")
    assert result.exit_code == 0
    assert is_a_drawing(tmp_path / "one.png")


def test_plot_names_what_there_is(tmp_path):
    with pytest.raises(CatalogError, match=r"'tabel' is neither .*allowed: .*closest is 'table'"):
        hcss("atmosphere", "plot", "tabel", "-o", tmp_path / "x.png")
    assert "one to plot, or two" in hcss("atmosphere", "plot", "a", "b", "c", "-o", tmp_path / "x.png").output
    with pytest.raises(CatalogError, match="no common wavenumbers"):
        hcss("atmosphere", "plot", "table", "-o", tmp_path / "x.png", "--range-um", 100, 200)


def test_plot_answers_in_json_with_the_numbers_of_the_bands(tmp_path):
    picture = tmp_path / "air.png"
    arguments = ["us-standard-1976-lowtran7", "-o", picture, "--range-um", 8, 14.2, "--json"]
    found = json.loads(hcss("atmosphere", "plot", *arguments).output)
    assert found["picture"] == str(picture)
    assert picture.is_file()
    assert found["comparison"] == []
    [source] = found["sources"].values()
    [band] = source["bands"]
    assert band["limits_um"] == [8.0, 14.0]
    assert len(band["transmittance"]) == len(band["path_radiance"]) == len(source["zenith_deg"]) == 8
    assert all(
        later < earlier for earlier, later in zip(band["transmittance"], band["transmittance"][1:], strict=False)
    )
    assert 0 < band["path_radiance"][0] < band["path_radiance"][-1]
