"""Any window of any scattered sky, any mask, and TIFF files with damaged bytes."""

from __future__ import annotations

import numpy as np
import tifffile
from hcss_evaluate.database.segmentation import Cleaning, segment
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.clouds.imagery.sky import SingleClouds, Sky

FEW = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def _shapes(seed):
    random = np.random.default_rng(seed)
    parts, sides = [], []
    for _ in range(random.integers(1, 6)):
        height, width = random.integers(1, 14, 2)
        shape = random.uniform(1, 9, (height, width)) * (random.random((height, width)) < 0.7)
        shape.flat[0] = 1.0
        parts.append(shape.astype(np.float32).ravel())
        sides.append((height, width))
    sizes = np.array([part.size for part in parts])
    heights, widths = np.array(sides, dtype=np.int64).T.copy()
    areas = np.array([np.count_nonzero(part) for part in parts])
    return SingleClouds(np.concatenate(parts), np.cumsum(sizes) - sizes, heights, widths, areas, 0)


@FEW
@given(
    shapes=st.integers(0, 10**6),
    seed=st.integers(0, 2**63 - 1),
    coverage=st.floats(0.0, 0.999),
    turned=st.booleans(),
    corner=st.tuples(st.integers(-(2**59), 2**59), st.integers(-(2**59), 2**59)),
    part=st.tuples(st.integers(0, 30), st.integers(0, 30), st.integers(1, 20), st.integers(1, 20)),
)
def test_any_window_of_any_sky_is_that_part_of_a_larger_one(shapes, seed, coverage, turned, corner, part):
    sky = Sky(_shapes(shapes), seed, turned)
    density = sky.density(coverage)
    (row, column), (top, left, rows, columns) = corner, part
    whole = sky.thickness_m(slice(row, row + 50), slice(column, column + 50), density)
    window = sky.thickness_m(slice(row + top, row + top + rows), slice(column + left, column + left + columns), density)
    np.testing.assert_array_equal(window, whole[top : top + rows, left : left + columns])
    arrivals = sky.arrivals(slice(row, row + 50), slice(column, column + 50), 12)
    # 12 layers leave 2**-12 of the sky clear: denser than any coverage asked for here.
    np.testing.assert_array_equal(arrivals < density, whole > 0)


@FEW
@given(
    seed=st.integers(0, 10**6),
    share=st.floats(0.0, 1.0),
    lost=st.floats(0.0, 0.3),
    closing=st.sampled_from([1, 3, 7]),
    opening=st.sampled_from([1, 3, 5]),
    largest_hole=st.integers(0, 300),
    min_area=st.integers(1, 60),
)
def test_any_mask_becomes_numbered_clouds_of_the_least_size(
    seed, share, lost, closing, opening, largest_hole, min_area
):
    random = np.random.default_rng(seed)
    mask, missing = random.random((30, 25)) < share, random.random((30, 25)) < lost
    found = segment(mask, missing, Cleaning(closing, opening, largest_hole, min_area))
    areas = np.bincount(found.labels.ravel(), minlength=found.clouds + 1)[1:]
    assert areas.size == found.clouds
    assert np.all(areas >= min_area)
    assert not np.any(found.labels[missing])


@FEW
@given(places=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=12))
def test_a_damaged_tiff_is_read_or_named(tmp_path, places):
    path = tmp_path / "a.tif"
    values = np.random.default_rng(0).integers(0, 255, (20, 30), dtype=np.uint8)
    scale = [(33550, "d", 3, (30.0, 30.0, 0.0), True), (34735, "H", 8, (1, 1, 0, 1, 1024, 0, 1, 1), True)]
    tifffile.imwrite(path, values, photometric="minisblack", extratags=scale, metadata=None)
    damaged = bytearray(path.read_bytes())
    for position, value in places:
        # The tags, where damage matters, are at the beginning.
        damaged[position % min(len(damaged), 400)] = value
    path.write_bytes(damaged)
    try:
        image = read_image(path)
    except CatalogError:
        return
    assert image.values.ndim == 2
    assert image.pixel_size_m is None or 0 < image.pixel_size_m < np.inf
