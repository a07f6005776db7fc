"""Rasters of surfaces: places, interpolation, and what the guard refuses."""

from types import SimpleNamespace

import numpy as np
import pytest
import rasterio
from hcss_author import PlainSea, sample_surface_inputs
from surface_files import write_netcdf

from hcss_twin.core.errors import CatalogError, ProviderError
from hcss_twin.models.surfaces.parameters import RasterParameters
from hcss_twin.models.surfaces.raster import Raster
from hcss_twin.providers import Declaration, SurfaceClass, SurfaceInputs, SurfaceMap
from hcss_twin.providers.common import check_surface_classes
from hcss_twin.providers.registry.guard import guard
from hcss_twin.providers.registry.specs import Kind

LATITUDE, LONGITUDE = np.array([34.9, 34.95, 35.0, 35.05, 35.1]), np.array([149.85, 149.95, 150.05, 150.15])
CLASSES = np.arange(20).reshape(5, 4) % 3.0
KELVIN = 280.0 + 4.0 * (LATITUDE[:, None] - 35.0) + 7.0 * (LONGITUDE - 150.0)


def raster(path, inputs=None, **parameters):
    return Raster(inputs or sample_surface_inputs(), RasterParameters(file=str(path), **parameters))


def write_tiff(path, crs="EPSG:4326"):
    transform = rasterio.Affine(0.1, 0.0, 149.8, 0.0, -0.05, 35.125)
    about = {"driver": "GTiff", "height": 5, "width": 4, "count": 2, "dtype": "float64", "transform": transform}
    with rasterio.open(path, "w", **about, crs=crs, nodata=-1.0) as file:
        file.write(CLASSES[::-1], 1)
        file.write(KELVIN[::-1], 2)


@pytest.fixture(params=["map.nc", "map.tif", "turned.nc"])
def path(request, tmp_path):
    place = tmp_path / request.param
    if place.suffix == ".tif":
        write_tiff(place)
    elif place.name == "map.nc":
        write_netcdf(place, LATITUDE, LONGITUDE, surface_class=CLASSES, skin=KELVIN)
    else:  # from north to south, and longitudes beyond 180
        write_netcdf(place, LATITUDE[::-1], LONGITUDE - 360.0, surface_class=CLASSES[::-1], skin=KELVIN[::-1])
    return place


def test_classes_are_those_of_the_cell_and_temperature_is_bilinear(path):
    """A plane is reproduced exactly; the class is that of the nearest centre."""
    inputs = sample_surface_inputs()
    window = slice(3, 40), slice(5, 60)
    layer = "2" if path.suffix == ".tif" else "skin"
    provider = raster(path, classes={0: "sea", 1: "ice", 2: "sea"}, temperature_layer=layer)
    ground = provider.surface(0.0, *window)
    latitude, longitude = inputs.ground(0.0, *window)
    row = np.argmin(np.abs(latitude[..., None] - LATITUDE), axis=-1)
    column = np.argmin(np.abs(longitude[..., None] - LONGITUDE), axis=-1)
    np.testing.assert_array_equal(ground.number, CLASSES[row, column] == 1.0)
    np.testing.assert_allclose(ground.temperature_K, 280.0 + 4.0 * (latitude - 35.0) + 7.0 * (longitude - 150.0), 1e-12)
    assert [each.name for each in provider.classes] == ["sea", "ice"]


def test_a_projected_geotiff_has_its_cells_where_pyproj_puts_them(tmp_path):
    import pyproj

    globe = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32656", always_xy=True)
    x, y = globe.transform(150.0, 35.0)
    transform = rasterio.Affine(1000.0, 0.0, x - 20e3, 0.0, -1000.0, y + 20e3)
    about = {"driver": "GTiff", "height": 40, "width": 40, "count": 1, "dtype": "uint8", "transform": transform}
    values = np.random.default_rng(3).integers(0, 2, (40, 40)).astype(np.uint8)
    with rasterio.open(tmp_path / "utm.tif", "w", **about, crs="EPSG:32656") as file:
        file.write(values, 1)
    number = raster(tmp_path / "utm.tif", classes={0: "sea", 1: "land"}).surface(0.0, slice(0, 48), slice(0, 64)).number
    latitude, longitude = sample_surface_inputs().ground(0.0, slice(0, 48), slice(0, 64))
    east, north = globe.transform(longitude, latitude)
    expected = values[np.floor((y + 20e3 - north) / 1e3).astype(int), np.floor((east - x + 20e3) / 1e3).astype(int)]
    np.testing.assert_array_equal(number, expected)


def test_a_raster_that_is_not_on_the_globe_is_an_error_that_names_it(tmp_path):
    write_tiff(tmp_path / "site.tif", 'LOCAL_CS["building site", UNIT["metre", 1]]')
    with pytest.raises(CatalogError, match=r"site\.tif: no place on the globe has a place in its projection"):
        raster(tmp_path / "site.tif", classes={0: "sea"}).surface(0.0, slice(0, 2), slice(0, 2))


def test_outside_missing_and_unknown_values_are_errors_that_name_the_raster(tmp_path):
    far = LATITUDE + 2.0
    write_netcdf(tmp_path / "far.nc", far, LONGITUDE, surface_class=CLASSES)
    with pytest.raises(ProviderError, match=r"far.nc' covers latitude 36.875 to 37.125.*3072 points of the scene"):
        raster(tmp_path / "far.nc", classes={0: "sea"}).surface(0.0, slice(0, 48), slice(0, 64))
    holes = np.where(CLASSES == 1.0, np.nan, KELVIN)
    write_netcdf(tmp_path / "holes.nc", LATITUDE, LONGITUDE, surface_class=CLASSES, skin=holes)
    names = {0: "sea", 1: "land", 2: "sea"}
    with pytest.raises(ProviderError, match="has no temperature at or beside"):
        raster(tmp_path / "holes.nc", classes=names, temperature_layer="skin").surface(0.0, slice(0, 48), slice(0, 64))
    with pytest.raises(ProviderError, match=r"has the class 1, 2, which parameters.classes does not name; allowed: 0"):
        raster(tmp_path / "holes.nc", classes={0: "sea"}).surface(0.0, slice(0, 48), slice(0, 64))


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({}, "neither classes nor temperature_layer"),
        ({"temperature_layer": "skni"}, "has no layer 'skni'.*closest.*skin"),
        ({"temperature_layer": "celsius"}, "temperatures are -?[0-9.]+ to [0-9.]+; allowed: 150 to 400 K"),
        ({"classes": {0: "sea"}, "temperatures": {"land": 290.0}}, "'land' is no class"),
    ],
)
def test_wrong_parameters_name_what_is_allowed(tmp_path, parameters, message):
    write_netcdf(tmp_path / "map.nc", LATITUDE, LONGITUDE, surface_class=CLASSES, skin=KELVIN, celsius=KELVIN - 273.15)
    with pytest.raises(CatalogError, match=message):
        raster(tmp_path / "map.nc", **parameters)


CASES = {
    "text": ("text", "expected SurfaceMap"),
    "shape": (SurfaceMap(np.zeros((2, 3), np.uint8), np.full((2, 3), 280.0)), r"expected shape \(4, 5\)"),
    "number": (SurfaceMap(np.full((4, 5), 2), np.full((4, 5), 280.0)), r"values in \[0, 1\]"),
    "kind": (SurfaceMap(np.zeros((4, 5)), np.full((4, 5), 280.0)), "whole numbers"),
    "no temperature": (SurfaceMap(np.ones((4, 5), np.uint8)), "temperature_K"),
    "celsius": (SurfaceMap(np.ones((4, 5), np.uint8), np.full((4, 5), 7.0)), r"class 'ice'.*values in \[250, 271\]"),
    "gap": (SurfaceMap(np.ones((4, 5), np.uint8), np.full((4, 5), np.nan)), "not finite"),
}


@pytest.mark.parametrize("case", CASES)
def test_the_guard_refuses_a_wrong_map(case):
    answer, message = CASES[case]
    classes = (SurfaceClass("sea"), SurfaceClass("ice", (250.0, 271.0), PlainSea()))
    provider = SimpleNamespace(declares=Declaration(), classes=classes, surface=lambda *arguments: answer)
    entry = SimpleNamespace(kind=Kind.SURFACES, name="ice", label="surface provider 'ice'", distribution="hcss-ice")
    inputs = SurfaceInputs(sample_surface_inputs().grid, sample_surface_inputs().ground, 280.0, 280.0, None)
    with pytest.raises(ProviderError, match=message):
        guard(entry, provider, inputs).surface(0.0, slice(0, 4), slice(0, 5))


@pytest.mark.parametrize(
    ("classes", "message"),
    [
        ((), "1 to 12 SurfaceClass"),
        ((SurfaceClass("Sea"),), "lower-case"),
        ((SurfaceClass("ice"), SurfaceClass("ice")), "distinct names"),
        ((SurfaceClass("sea", boundary=PlainSea()),), "sea model of the scenario"),
        ((SurfaceClass("ice", (280.0, 270.0)),), "lowest, highest"),
        ((SurfaceClass("ice", -3.0),), "a number of kelvin"),
    ],
)
def test_wrong_classes_are_refused(classes, message):
    with pytest.raises(ValueError, match=message):
        check_surface_classes(classes)
