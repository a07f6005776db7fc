"""Elements of a scene follow closed forms: flux, centroid, attenuation by air and clouds, what they hide."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from whole_frames import first_frame

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.models.elements.parameters import PointSourceParameters
from hcss_twin.models.elements.point_sources import PointSources
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import Declaration, ElementInputs, ElementPixels
from hcss_twin.scenario.bands import sensor_bands

BASE = {
    **CHEAP,
    "time": "2024-04-20T22:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 12, "columns": 16, "pixel_size": 20.0},
    "slant": {"shadows": "off", "parallax": "off"},
    "frames": {"count": 1},
    "bands": NARROW,
    "output": {"variables": ["radiance", "truth"], "certificate": 0},
}
THIN = {"type": "stratus", "anchor": "base", "coverage": 1.0, "base": 1000.0, "top": 1008.0, "thickness_min": 1.0}
THICK = {"type": "stratus", "anchor": "base", "coverage": 1.0, "base": 1000.0, "top": 1400.0, "thickness_min": 300.0}
STRENGTH = 1e4  # W/sr


def planned(*tracks, clouds=None, footprint=0.0, **changes):
    elements = [{"parameters": {"tracks": list(tracks), "footprint": footprint}}] if tracks else []
    raw = {key: value for key, value in BASE.items() if key not in CHEAP}
    raw |= {} if clouds is None else {"clouds": clouds}
    return make_plan(Scenario.from_dict({**raw, "elements": elements}, {**CHEAP, **changes}))


def inputs_of(plan):
    """The inputs of an element provider of the scene."""
    return ElementInputs(sensor_bands(plan.bands), plan.grid, plan.view, lambda kelvin: np.zeros(2), Catalog())


def gained(*tracks, **scene):
    """What a source adds to the radiance, and the plan and frame with it."""
    plan = planned(*tracks, **scene)
    result = first_frame(plan)
    plain = replace(plan, assembly=replace(plan.assembly, elements=()))
    without = tuple(each for each in plan.variables if each.needs != "elements")
    plain = replace(plain, variables=without, computed=without)
    return result["radiance"].astype(float) - first_frame(plain)["radiance"], plan, result


def reach(plan, altitude_m, cloud=None, kelvin=None):
    """Band means of the transmittance of air and cloud (V,), computed on their own."""
    grid, zenith = plan.spectral_grid, plan.view.zenith_deg
    spectrum = plan.assembly.transmittance.transmittance(grid.wavenumber_cm1, [to_space(altitude_m, zenith)])[0]
    spectrum = spectrum if cloud is None else spectrum * cloud
    colour = 1.0 if kelvin is None else planck(grid.wavenumber_cm1, kelvin)
    return (grid.weights_cm1 @ (colour * spectrum)) / (grid.weights_cm1 @ (colour * np.ones_like(spectrum)))


@pytest.mark.parametrize("side", [0.0, 20.0, 40.0])
@pytest.mark.parametrize(
    ("x", "y", "zenith"), [(0.0, 0.0, 0.0), (3.0, -7.5, 50.0), (31.7, 44.4, 0.0), (-61.25, 9.99, 50.0)]
)
def test_flux_and_centroid_of_a_source_are_those_of_its_square(side, x, y, zenith):
    source = {"x": x, "y": y, "altitude": 2000.0, "intensity": STRENGTH}
    more, plan, _ = gained(source, footprint=side, **{"view.zenith": zenith})
    flux = more.sum(axis=(1, 2)) * 20.0**2 * math.cos(math.radians(zenith))
    np.testing.assert_allclose(flux, STRENGTH * reach(plan, 2000.0), rtol=1e-5)
    rows, columns = np.arange(12) + 0.5, np.arange(16) + 0.5
    row = (more[0].sum(axis=1) @ rows) / more[0].sum()
    column = (more[0].sum(axis=0) @ columns) / more[0].sum()
    expected = y / 20.0 + 6.0, x / 20.0 + 8.0
    if side == 0.0:
        expected = math.floor(expected[0]) + 0.5, math.floor(expected[1]) + 0.5
    np.testing.assert_allclose((row, column), expected, atol=1e-4)


@pytest.mark.parametrize(
    ("kelvin", "area", "zenith"), [(200.0, 100.0, 0.0), (900.0, 150.0, 50.0), (200.0, 2000.0, 0.0)]
)
def test_a_body_above_the_air_replaces_its_area_across_the_line_of_sight(kelvin, area, zenith):
    body = {"x": 3.0, "y": -7.5, "altitude": 2e5, "temperature": kelvin, "area": area}
    more, plan, _ = gained(body, clouds=THICK, **{"view.zenith": zenith})
    plain = first_frame(replace(plan, assembly=replace(plan.assembly, elements=())))["radiance"].astype(float)
    grid = plan.spectral_grid
    emitted = grid.weights_cm1 @ planck(grid.wavenumber_cm1, kelvin)
    side, mu = math.sqrt(area / math.cos(math.radians(zenith))), math.cos(math.radians(zenith))
    if area <= 400.0 * mu:  # in the pixel that holds it
        expected = np.zeros_like(more)
        expected[:, 5, 8] = area / (400.0 * mu) * (emitted - plain[:, 5, 8])
    else:  # a square
        rows, columns = (
            np.clip(np.minimum(at + side / 2, 20.0 * (n + 1)) - np.maximum(at - side / 2, 20.0 * n), 0.0, None) / 20.0
            for at, n in ((112.5, np.arange(12)), (163.0, np.arange(16)))
        )
        expected = np.outer(rows, columns) * (emitted[:, None, None] - plain)
    np.testing.assert_allclose(more, expected, atol=1e-5 * plain.max())


@pytest.mark.parametrize(("apart", "left"), [(0.0, 0.0), (5.0, 0.5)])
def test_a_higher_body_hides_the_overlap_of_its_square_and_no_more(apart, left):
    low = {"x": 3.0, "y": 3.0, "altitude": 2e5, "temperature": 900.0, "area": 100.0}
    high = {"x": 3.0 + apart, "y": 3.0, "altitude": 3e5, "temperature": 400.0, "area": 100.0}
    one, other, both = (gained(*each)[0].sum(axis=(1, 2)) for each in ((low,), (high,), (low, high)))
    np.testing.assert_allclose(both, left * one + other, rtol=1e-5)


@pytest.mark.parametrize("kelvin", [150.0, 700.0])
def test_equal_bodies_at_one_place_and_altitude_are_as_bright_as_one(kelvin):
    body = {"x": 3.0, "y": 3.0, "temperature": kelvin, "area": 300.0}
    one, three = (gained(*count * [body])[0].sum(axis=(1, 2)) for count in (1, 3))
    np.testing.assert_allclose(three, one, rtol=1e-5)


def test_clouds_weaken_a_source_at_its_own_point_whatever_it_is_spread_over():
    clouds = {**THICK, "coverage": 0.5, "coverage_mode": "field"}
    plan = planned({"intensity": 0.0}, clouds=clouds, **{"image.samples_per_pixel": 2, "image.pixel_size": 200.0})
    tables, inputs = tables_of(plan), inputs_of(plan)
    [points] = [each.thickness_m(0.0, slice(0, 24), slice(0, 32)) for each in plan.assembly.generators]
    row, column = np.argwhere((points[8:16, 8:23] > 0) != (points[8:16, 9:24] > 0))[0] + 8

    def seen(**source):
        one = PointSources(inputs, PointSourceParameters(tracks=[source], footprint=source.pop("footprint", 0.0)))
        with_it = replace(plan, assembly=replace(plan.assembly, elements=(one,)))
        return next(stream(with_it, tables))

    plain = seen(intensity=0.0)["radiance"].astype(float)
    for at in (column, column + 1):
        place = {"x": 100.0 * (at + 0.5) - 1600.0, "y": 100.0 * (row + 0.5) - 1200.0, "intensity": 1e8}
        arriving = 0.0 if points[row, at] > 0 else 1e8 * reach(plan, 0.0)
        for side in (0.0, 600.0):
            result = seen(footprint=side, **place)
            more = result["radiance"] - plain
            np.testing.assert_allclose(more.sum(axis=(1, 2)) * 4e4, arriving, rtol=1e-4, atol=2e3)
        pixel = row // 2, at // 2
        assert np.all((result["element_transmittance"][:, *pixel] > 0.1) == (points[row, at] == 0))


@pytest.mark.parametrize("clouds", [THIN, THICK])
@pytest.mark.parametrize("altitude", [0.0, 300.0, 1003.0])
def test_clouds_above_a_source_transmit_by_bouguer(clouds, altitude):
    source = {"x": 33.0, "y": -41.0, "altitude": altitude, "intensity": 1e6}
    more, plan, result = gained(source, clouds=clouds, **{"view.zenith": 30.0})
    [(row, column)] = np.argwhere(result["element"])
    thickness = float(result["cloud_thickness"][row, column])
    above = min(max(plan.layers[0].base_m + thickness - altitude, 0.0), thickness)
    optics = plan.assembly.optics.single_scattering(plan.layers[0].microphysics, plan.spectral_grid.wavenumber_cm1)
    mu = math.cos(math.radians(30.0))
    expected = 1e6 / (400.0 * mu) * reach(plan, altitude, np.exp(-optics.extinction_m1 * above / mu))
    np.testing.assert_allclose(more[:, row, column], expected, rtol=1e-3, atol=2e-6)
    free = 1e6 / (400.0 * mu) * reach(plan, altitude)
    assert np.all(expected < (0.98 if clouds is THIN else 1e-3) * free)


@pytest.mark.parametrize("clouds", [THIN, THICK])
def test_clouds_below_a_source_do_not_weaken_it(clouds):
    more, plan, _ = gained({"altitude": 2000.0, "intensity": STRENGTH}, clouds=clouds)
    np.testing.assert_allclose(more.sum(axis=(1, 2)) * 400.0, STRENGTH * reach(plan, 2000.0), rtol=1e-4)


def test_above_the_air_nothing_is_lost():
    more, _, _ = gained({"altitude": 5e5, "intensity": STRENGTH})
    np.testing.assert_allclose(more.sum(axis=(1, 2)) * 400.0, STRENGTH, rtol=1e-5)


def test_a_source_moves_with_its_velocity_over_the_moving_image():
    source = {"x": -70.0, "velocity": [30.0, 20.0, 10.0], "altitude": 50.0, "intensity": STRENGTH}
    plan = planned(source, **{"frames.count": 3, "frames.interval": 2.0, "motion.platform_speed": 10.0})
    for index, result in enumerate(stream(plan, tables_of(plan))):
        time = 2.0 * index
        [(row, column)] = np.argwhere(result["element"])
        assert row == math.floor(6 + 20.0 * time / 20.0)
        assert column == math.floor(8 + (-70.0 + 20.0 * time) / 20.0)
        assert result["element_altitude"][row, column] == 50.0 + 10.0 * time
        assert np.isnan(result["element_altitude"]).sum() == 12 * 16 - 1


def test_a_source_on_a_path_moves_between_its_points_and_is_absent_beside_them():
    path = [[-1.0, -40.0, 0.0, 100.0], [1.0, 0.0, 40.0, 100.0], [5.0, 0.0, 40.0, 500.0]]
    inputs = inputs_of(planned({"path": path, "intensity": STRENGTH}))
    provider = PointSources(inputs, PointSourceParameters(tracks=[{"path": path, "intensity": STRENGTH}]))
    for time_s, place, velocity in (
        (0.0, (-20.0, 20.0, 100.0), (20.0, 20.0, 0.0)),
        (2.0, (0.0, 40.0, 200.0), (0.0, 0.0, 100.0)),
    ):
        (point,) = provider.pixels(time_s, slice(0, 12), slice(0, 16), None)
        assert (point.x_m, point.y_m, point.altitude_m) == pytest.approx(place)
        assert point.velocity_m_s == pytest.approx(velocity)
        assert point.intensity == pytest.approx(STRENGTH)
    assert not [each for at in (-1.1, 5.1) for each in provider.pixels(at, slice(0, 12), slice(0, 16), None)]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"altitude": 5.0}, "path alone"),
        ({"path": [[0.0, 0.0, 0.0, 0.0]]}, "at least two"),
        ({"path": [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]}, "ascend"),
        ({"path": [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, -1.0]]}, "altitudes from 0"),
    ],
)
def test_wrong_paths_are_refused(change, words):
    good = {"path": [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]], "intensity": 1.0}
    assert PointSourceParameters(tracks=[good])
    with pytest.raises(ValueError, match=words):
        PointSourceParameters(tracks=[good | change])


def test_parallax_moves_a_high_source_away_from_the_sensor():
    source = {"altitude": 60.0, "intensity": STRENGTH}
    view = {"view.zenith": 45.0, "view.azimuth": 90.0, "slant.parallax": "on"}
    _, _, high = gained(source, **view)
    # The sensor is in the east, so the line of sight through the source meets the sea 60 m west of it.
    assert np.argwhere(high["element"]).tolist() == [[6, 5]]


class Square:
    """One opaque pixel."""

    declares = Declaration()
    variables = {}  # noqa: RUF012

    def __init__(self, radiance, kelvin, altitude_m=0.0, share=1.0):
        self.values = np.array([4]), np.array([5]), np.array([share]), altitude_m, radiance
        self.kelvin = kelvin

    def pixels(self, time_s, rows, columns, scene):
        here = rows.start <= 4 < rows.stop and columns.start <= 5 < columns.stop
        return [ElementPixels(*self.values, temperature_K=self.kelvin)] if here else []


def with_square(plan, *squares):
    return first_frame(replace(plan, assembly=replace(plan.assembly, elements=squares)))["radiance"]


def test_an_opaque_body_above_the_air_hides_its_share():
    plan = planned(clouds=THICK)
    plain, body = first_frame(plan)["radiance"], np.array([3.0, 50.0])
    for share in (0.25, 1.0):
        shown = with_square(plan, Square(body, None, 2e5, share))
        np.testing.assert_allclose(shown[:, 4, 5], (1 - share) * plain[:, 4, 5] + share * body, rtol=1e-6)


def test_the_highest_body_is_seen_whatever_the_order():
    plan, low, high = planned(), Square(np.ones(2), None, 0.0), Square(np.full(2, 7.0), None, 3e5)
    one, other = with_square(plan, low, high), with_square(plan, high, low)
    np.testing.assert_array_equal(one, other)
    np.testing.assert_allclose(one[:, 4, 5], 7.0)


@pytest.mark.parametrize("clouds", [None, THIN, THICK])
def test_a_body_that_radiates_like_the_sea_cannot_be_seen(clouds):
    plan = planned(clouds=clouds)
    grid, kelvin = plan.spectral_grid, plan.assembly.sea_temperature_K
    emissivity = plan.assembly.sea.emissivity(grid.wavenumber_cm1, np.ones(1))[0]
    like_sea = grid.weights_cm1 @ (emissivity * planck(grid.wavenumber_cm1, kelvin))
    plain, shown = first_frame(plan)["radiance"], with_square(plan, Square(like_sea, kelvin))
    # The air weakens the sea's emissivity within a band a little differently from a black body's.
    np.testing.assert_allclose(shown, plain, rtol=2.5e-3)


def test_a_track_in_latitude_and_longitude_is_where_proj_has_it(tmp_path):
    import pyproj

    plane = pyproj.Proj(proj="aeqd", lat_0=35.0, lon_0=150.0, ellps="WGS84")
    (east, west), (north, south) = plane(np.array([103.0, -137.0]), np.array([93.0, -107.0]), inverse=True)
    table = "source, time, latitude, longitude, altitude, intensity\n"
    table += f"1, 0, {north!r}, {east!r}, 10, 1e4\n1, 4, {south!r}, {west!r}, 10, 1e4\n"
    (tmp_path / "globe.csv").write_text(table.replace("np.float64(", "").replace(")", ""))
    raw = {key: value for key, value in BASE.items() if key not in CHEAP}
    raw |= {"elements": [{"parameters": {"file": "globe.csv"}}], "frames": {"count": 5, "interval": 1.0}}
    plan = make_plan(Scenario.from_dict(raw, CHEAP, base=tmp_path))
    for time, result in enumerate(stream(plan, tables_of(plan))):
        x, y = 103.0 - 60.0 * time, 93.0 - 50.0 * time
        assert np.argwhere(result["element"]).tolist() == [[math.floor(y / 20) + 6, math.floor(x / 20) + 8]]
