"""Land and sea of the catalog's coastlines agree with another data set, and with another library's polygons."""

import csv
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP
from matplotlib.path import Path as Polygon

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import catalog_root
from hcss_twin.models.surfaces.coastline import Coastline
from hcss_twin.physics.geodesy import to_geographic

POINTS = Path(__file__).parents[1] / "data" / "land-points.csv"


@pytest.fixture(scope="module")
def coastline():
    return Coastline.read(catalog_root() / "surfaces" / "coastline.npz")


def test_points_farther_than_3_km_from_another_data_sets_coast_are_as_there(coastline):
    """Natural Earth (1:10 million) against the GLOBE land mask (30 arc seconds); estuaries and lagoons may differ."""
    with POINTS.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    latitude, longitude, land = (np.array([float(row[key]) for row in rows]) for key in rows[0])
    differs = coastline.is_land(latitude, longitude) != (land == 1.0)
    assert len(rows) == 600
    assert np.mean(differs) <= 0.005


def test_points_are_inside_exactly_where_another_librarys_polygons_have_them(coastline):
    """All rings around Ireland and Great Britain, of 200 to 5000 vertices, by the even-odd rule of matplotlib."""
    random = np.random.default_rng(5)
    latitude, longitude = random.uniform(49.5, 59.0, 3000), random.uniform(-11.0, 2.0, 3000)
    inside = np.zeros(latitude.size, dtype=int)
    for first, end in zip(coastline.start[:-1], coastline.start[1:], strict=True):
        ring = np.stack((coastline.longitude[first:end], coastline.latitude[first:end]), axis=1)
        if np.all(ring.max(axis=0) > (-11.0, 49.5)) and np.all(ring.min(axis=0) < (2.0, 59.0)):
            inside += Polygon(np.concatenate((ring, ring[:1]))).contains_points(np.stack((longitude, latitude), axis=1))
    np.testing.assert_array_equal(coastline.is_land(latitude, longitude), inside % 2 == 1)
    assert 0.2 < np.mean(inside % 2) < 0.6


@pytest.mark.parametrize(
    ("latitude", "longitude", "land"),
    [
        (-90.0, 0.0, True), (-89.9, 179.0, True), (68.5, 179.99, True), (68.5, -179.99, True), (68.5, 180.01, True),
        (66.5, -171.0, True), (41.0, 51.0, False), (0.0, 0.0, False), (89.9, 10.0, False), (-17.8, 178.0, True),
        (35.0, 150.0, False), (47.0, 368.0, True),
    ],
)  # fmt: skip
def test_poles_and_the_date_line_are_as_known(coastline, latitude, longitude, land):
    assert coastline.is_land(np.array([latitude]), np.array([longitude])) == land


def test_a_point_does_not_depend_on_the_others_of_a_call(coastline):
    random = np.random.default_rng(6)
    latitude, longitude = random.uniform(30.0, 46.0, 400), random.uniform(128.0, 146.0, 400)
    together = coastline.is_land(latitude, longitude)
    single = [coastline.is_land(latitude[n : n + 1], longitude[n : n + 1])[0] for n in range(400)]
    np.testing.assert_array_equal(together, single)
    assert 0.2 < np.mean(together) < 0.8


SCENE = {
    "time": "2024-04-20T12:30:00+10:00",
    "image": {"rows": 40, "columns": 50, "pixel_size": 2000.0},
    "frames": {"count": 2, "interval": 60.0},
    "bands": ["lwir"],
    "sea": {"temperature": 288.0, "wind_speed": 5.0},
    "output": {"variables": ["surface_class"]},
}


def planned(latitude, longitude, surfaces=True, **changes):
    raw = {**SCENE, "place": {"latitude": latitude, "longitude": longitude}}
    raw |= {"surfaces": {}} if surfaces else {"output": {"variables": ["radiance"]}}
    return make_plan(Scenario.from_dict(raw, {**CHEAP, **changes}))


@pytest.mark.parametrize("speed", [0.0, 300.0])
def test_a_scene_has_the_land_below_its_pixels_also_while_the_platform_moves(coastline, speed):
    plan = planned(35.65, 139.85, **{"motion.platform_speed": speed})
    provider = plan.assembly.surfaces[0].provider
    x, y = (np.arange(50) - 24.5) * 2000.0 + 60.0 * speed, (np.arange(40) - 19.5) * 2000.0
    expected = coastline.is_land(*to_geographic(*np.meshgrid(x, y), 35.65, 139.85))
    np.testing.assert_array_equal(provider.surface(60.0, slice(0, 40), slice(0, 50)).number == 1, expected)
    start = coastline.is_land(*to_geographic(*np.meshgrid(x - 60.0 * speed, y), 35.65, 139.85))
    assert plan.surfaces[0].shares[1] == np.mean(start)


def test_a_scene_without_surfaces_says_what_share_of_it_is_land():
    share = planned(35.65, 139.85).surfaces[0].shares[1]
    plan = planned(35.65, 139.85, surfaces=False)
    assert plan.land_share == pytest.approx(share, abs=0.02)
    (note,) = (note for note in plan.notes if "Natural Earth" in note)
    assert f"{100 * plan.land_share:.1f}".rstrip("0").rstrip(".") in note
    assert "with [surfaces]" in note
    sea = planned(35.0, 160.0, surfaces=False)
    assert sea.land_share == 0.0
    assert not any("Natural Earth" in note for note in sea.notes)
