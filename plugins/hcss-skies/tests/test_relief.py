"""Clouds of examples spread over heights: laws of the shares, windows, extremes, light between columns."""

from itertools import product

import numpy as np
import pytest
from conftest import FROZEN
from hcss_author import sample_cloud_inputs
from hcss_skies.relief import DENSEST, SOFT, below, depth_of, shares_of, sharpened
from hcss_skies.tops import between_cells
from test_tops import Emitting

from hcss_twin import Scenario, simulate
from hcss_twin.providers import Motion


@pytest.mark.parametrize("hanging", [False, True])
def test_shares_of_a_column_are_the_integral_of_its_extinction(hanging):
    """Extinction by hand: h^(2/3), falling to 0 over the top; or 1 above a soft base. Midpoints of 200 000 parts."""
    h = (np.arange(200_000) + 0.5) / 200_000
    extinction = np.minimum(h / SOFT, 1.0) if hanging else h ** (2.0 / 3.0) * np.minimum((1.0 - h) / SOFT, 1.0)
    expected = np.add.reduceat(extinction, np.arange(0, h.size, 20_000)) / extinction.sum()
    np.testing.assert_allclose(np.diff(below(np.linspace(0.0, 1.0, 11), hanging)), expected, atol=1e-7)


@pytest.mark.parametrize("anchor", ["base", "top"])
@pytest.mark.parametrize("pixel_m", [100.0, 700.0, 3000.0, 9000.0])
def test_columns_keep_their_whole_at_any_height_and_pixel_size(make, pixel_m, anchor):
    """Shares sum to 1; those between coarse edges are the sums of fine ones; edges need not be even."""
    provider = make(pixel_m, 64, layer={"anchor": anchor})
    layer, window = sample_cloud_inputs().layer, (slice(-3, 61), slice(0, 64))
    thickness = provider.thickness_around_m(0.0, *window)
    fine_m = np.linspace(layer.base_m, layer.top_m, 61)
    fine, coarse = (
        provider.height_shares(0.0, *window, thickness, edges_m) for edges_m in (fine_m, fine_m[[0, 7, 30, 60]])
    )
    assert np.all(fine >= 0.0)
    np.testing.assert_allclose(fine.sum(axis=0), thickness > 0.0, atol=2e-6)
    np.testing.assert_allclose(np.add.reduceat(fine, [0, 7, 30], axis=0), coarse, atol=2e-6)
    # The flat end is cloudy; the extinction of no part exceeds that of the column by more than the profile and DENSEST.
    flat = fine[-1 if anchor == "top" else 0]
    assert np.all(flat[thickness > 0.0] > 0.0)
    height = fine_m[1] - fine_m[0]
    most = 1.4 * DENSEST * height / np.maximum(thickness, 1e-9)
    assert np.all(fine <= np.minimum(most, 1.0) * (1.0 + 1e-5))


@pytest.mark.parametrize("pixel_m", [120.0, 700.0, 9000.0])
def test_windows_have_the_same_bits(make, pixel_m):
    provider = make(pixel_m, 300, motion=Motion(37.0, (6.0, -3.0), 1800.0, 1.0))
    edges, whole = np.linspace(500.0, 1500.0, 9), (slice(-5, 300), slice(-5, 300))
    thickness = provider.thickness_around_m(77.0, *whole)
    frame = provider.height_shares(77.0, *whole, thickness, edges)
    for rows, columns in ((slice(140, 160), slice(150, 151)), (slice(-2, 3), slice(250, 299))):
        cut = slice(rows.start + 5, rows.stop + 5), slice(columns.start + 5, columns.stop + 5)
        part = provider.height_shares(77.0, rows, columns, thickness[cut], edges)
        np.testing.assert_array_equal(part, frame[:, *cut])


def test_seeds_have_bodies_of_their_own_and_the_same_seed_the_same(make):
    edges, window = np.linspace(500.0, 1500.0, 9), (slice(0, 40), slice(0, 40))
    same = [make(300.0, 40, seed=seed, motion=FROZEN) for seed in (1, 1, 2)]
    fields = [provider.height_shares(0.0, *window, np.full((40, 40), 200.0, np.float32), edges) for provider in same]
    np.testing.assert_array_equal(fields[0], fields[1])
    assert not np.array_equal(fields[0], fields[2])


def test_detail_moves_tops_by_a_pixel_at_most_and_hardly_in_flat_layers():
    """Needles of 3 km become lumps as high as a pixel is wide; detail of a tenth of a pixel stays what it is."""
    rng = np.random.default_rng(1)
    body = np.full(1000, 1500.0)
    tall = depth_of(body, rng.uniform(1e-3, 3000.0, 1000), 100.0, 3000.0)
    assert np.all(np.abs(tall - body) <= 100.0)
    flat = body + rng.uniform(-10.0, 10.0, 1000)
    np.testing.assert_allclose(depth_of(body, flat, 100.0, 3000.0), flat, atol=0.04)


def test_sharpened_cells_keep_means_between_which_heights_are_interpolated():
    cells = 500.0 + 200.0 * np.sin(np.arange(24) / 3.0)[:, None] * np.cos(np.arange(24) / 4.0)
    at = np.arange(3.5, 19.5, 0.125) + 0.0625
    errors = []
    for nodes in (cells, sharpened(cells)):
        means = between_cells(nodes, at, at).reshape(16, 8, 16, 8).mean(axis=(1, 3))
        errors.append(np.abs(means - cells[4:20, 4:20]).max())
    assert errors[1] < 0.05 * errors[0]


@pytest.mark.parametrize("hanging", [False, True])
@pytest.mark.parametrize("pixel_m", [1e-3, 1e6])
def test_shares_stay_whole_at_extremes(hanging, pixel_m):
    edges = np.array([500.0, 500.001, 900.0, 1499.9, 1500.0])
    for thickness_m, body_m in product((0.0, 1e-30, 1e-6, 1.0, 999.9, 1000.0), (0.0, 1e-30, 300.0, 1e30)):
        thickness = np.array([[thickness_m]], np.float32)
        depth = depth_of(np.array([[body_m]]), thickness.astype(float), pixel_m, 1000.0)
        shares = shares_of(thickness, depth, edges, 1500.0 if hanging else 500.0, hanging)
        assert np.isfinite(shares).all()
        assert shares.min() >= 0.0
        assert shares.sum() == pytest.approx(float(thickness_m > 0.0), abs=1e-5)


def test_columns_and_clouds_with_tops_of_their_own_have_no_shares(make):
    assert not hasattr(make(shape="columns"), "height_shares")
    assert not hasattr(make(inversion=Emitting(), least=1.0, tops="example"), "height_shares")


def test_images_by_columns_do_not_see_the_shape_and_light_between_columns_does():
    """At nadir opaque tops move by up to a pixel and by their soft edge: a tenth of a kelvin rms."""
    pytest.importorskip("hcss_light")
    images = {}
    for light in ("columns", "slant"):
        for shape in ("columns", "relief"):
            clouds = {"type": "stratocumulus", "generator": "example"}
            scene = Scenario.from_dict(
                {
                    "time": "2024-04-20T23:30:00+10:00",
                    "place": {"latitude": 20.0, "longitude": 150.0},
                    "view": {"zenith": 0.0},
                    "image": {"rows": 60, "columns": 60, "pixel_size": 100.0},
                    "frames": {"count": 1},
                    "accuracy": 0.02,
                    "bands": [[10.5, 11.0]],
                    "sea": {"model": "cox-munk", "temperature_texture": 0.0},
                    "clouds": clouds | {"parameters": {"example": "closed-cells-1", "shape": shape}},
                    "radiance": {"light": light},
                    "output": {"variables": ["radiance", "brightness_temperature"], "certificate": 0},
                }
            )
            images[light, shape] = simulate(scene).brightness_temperature.values[0, 0]
    np.testing.assert_array_equal(images["columns", "relief"], images["columns", "columns"])
    change = images["slant", "relief"] - images["columns", "relief"]
    assert 0.0 < np.sqrt(np.mean(change**2)) < 0.15
    assert not np.array_equal(images["slant", "relief"], images["slant", "columns"])
