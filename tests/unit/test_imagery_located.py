"""Images with latitudes and longitudes, and stacks of images: pixel size, orientation, and the chosen one."""

from itertools import product
from pathlib import Path

import netCDF4
import numpy as np
import pytest

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.reader import read_image

ROWS, COLUMNS, STEP_DEG = 24, 30, 0.02
RADIUS_M = 6371008.8
VALUES = np.add.outer(np.arange(ROWS) * 100.0, np.arange(COLUMNS))
"""Rows northward, columns eastward."""

WESTS = {"Pacific": 150.0, "across 180": 179.7, "across -180": -180.2, "Greenwich": 359.7, "equator's other side": -0.3}
STACKS = {
    "one": (),
    "time of one": ((1, "time"),),
    "times": ((3, "time"),),
    "scenes, times": ((2, "scene"), (3, "time")),
}
ORDERS = list(product(("north first", "south first"), ("west first", "east first")))


def write(path: Path, form, *, bounds=180.0, at=None, latitude=10.0, step=(STEP_DEG, STEP_DEG)):
    """Write one image, or a stack in which the others are its negative, with coordinates in a form."""
    kind, west, rows_from, columns_from, stack = form
    north = latitude + step[0] * np.arange(ROWS)
    east = WESTS[west] + step[1] * np.arange(COLUMNS)
    east = (east + bounds) % 360.0 - (360.0 - bounds) if bounds != 360.0 else east % 360.0
    turn = (
        slice(None, None, -1 if rows_from == "north first" else 1),
        slice(None, None, -1 if columns_from == "east first" else 1),
    )
    sizes = STACKS[stack]
    with netCDF4.Dataset(path, "w") as data:
        for size, name in (*sizes, (ROWS, "y"), (COLUMNS, "x")):
            data.createDimension(name, size)
        names = ("latitude", "longitude") if kind == "2-D" else ("y", "x")
        of_plane = np.meshgrid(north, east, indexing="ij") if kind == "2-D" else (north, east)
        for name, values, unit, axis in zip(names, of_plane, ("north", "east"), (0, 1), strict=True):
            made = data.createVariable(name, "f8", ("y", "x") if kind == "2-D" else (name,))
            made.units, made.standard_name = f"degrees_{unit}", ("latitude", "longitude")[axis]
            made[:] = values[turn] if kind == "2-D" else values[turn[axis]]
        image = data.createVariable("ir", "f4", (*(name for _, name in sizes), "y", "x"))
        if kind == "2-D":
            image.coordinates = "latitude longitude"
        image[:] = -VALUES[turn]
        image[tuple((at or {}).get(name, 0) for _, name in sizes)] = VALUES[turn]
    return path


@pytest.mark.parametrize("kind", ["1-D", "2-D"])
@pytest.mark.parametrize("west", WESTS)
def test_degrees_give_the_pixel_size_and_the_orientation_anywhere(kind, west, tmp_path):
    for order, bounds in product(ORDERS, (180.0, 360.0)):
        image = read_image(write(tmp_path / "a.nc", (kind, west, *order, "one"), bounds=bounds))
        middle = np.radians(10.0 + STEP_DEG * ROWS / 2)
        side = RADIUS_M * np.radians(STEP_DEG) * np.sqrt(np.cos(middle))
        assert image.pixel_size_m == pytest.approx(side, rel=2e-3)
        np.testing.assert_array_equal(image.north_and_east_last, VALUES)


@pytest.mark.parametrize("kind", ["1-D", "2-D"])
@pytest.mark.parametrize("stack", STACKS)
def test_the_chosen_image_of_a_stack_is_read_and_named(kind, stack, tmp_path):
    at = {name: size - 1 for size, name in STACKS[stack] if size > 1}
    image = read_image(write(tmp_path / "a.nc", (kind, "across 180", "north first", "east first", stack), at=at), at=at)
    np.testing.assert_array_equal(image.north_and_east_last, VALUES)
    assert image.source == ", ".join(["a.nc", *(f"{name} {number}" for name, number in at.items())])


@pytest.mark.parametrize("kind", ["1-D", "2-D"])
def test_pixels_that_are_far_from_square_are_told(kind, tmp_path):
    image = read_image(write(tmp_path / "a.nc", (kind, "Pacific", "north first", "west first", "one"), latitude=60.0))
    assert any("m (rows) x" in note and "squares of the same area" in note for note in image.notes)


@pytest.mark.parametrize("kind", ["1-D", "2-D"])
def test_a_stack_without_a_choice_or_with_a_wrong_one_is_refused_by_name(kind, tmp_path):
    path = write(tmp_path / "a.nc", (kind, "Pacific", "north first", "west first", "scenes, times"))
    faults = {
        "ir has 2 images along scene; allowed: one, chosen with at scene=0 to 1": {},
        "ir has 3 images along time; allowed: one, chosen with at time=0 to 2": {"scene": 1},
        "at time=3; allowed: 0 to 2": {"scene": 1, "time": 3},
        "at tim: no such dimension of ir; allowed: scene, time; closest is 'time'": {"tim": 0},
        "at x: no such dimension of ir": {"x": 0},
    }
    for message, at in faults.items():
        with pytest.raises(CatalogError, match=message):
            read_image(path, at=at)


def test_an_index_into_one_image_is_refused(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, VALUES)
    with pytest.raises(CatalogError, match="at time: allowed for NetCDF variables of several images only"):
        read_image(path, at={"time": 0})
