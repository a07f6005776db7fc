"""Laws of clouds against closed forms and an independent package."""

import numpy as np
import pytest
from hcss_evaluate.realism.clouds import (
    Clouds,
    edge_exponent,
    ensemble_dimension,
    individual_dimension,
    organisation,
    size_exponent,
)
from hcss_evaluate.realism.coherence import coherence
from hcss_evaluate.realism.intermittency import codimension, gradient_size
from hcss_evaluate.realism.laws import PUBLISHED, Law, cloud_laws
from random_fields import power_law


def excursions(seed, slope, count=6, size=512, cover=0.3):
    rng = np.random.default_rng(seed)
    fields = [power_law(rng, slope, size) for _ in range(count)]
    levels = [np.quantile(field, 1.0 - cover) for field in fields]
    return [field > level for field, level in zip(fields, levels, strict=True)]


def discs(size, centres, radius):
    y, x = np.ogrid[:size, :size]
    mask = np.zeros((size, size), dtype=bool)
    for row, column in centres:
        mask |= np.hypot(y - row, x - column) <= radius
    return mask


def test_a_square_a_ring_and_a_cloud_at_the_frame_have_their_areas_and_outlines():
    mask = np.zeros((20, 20), dtype=bool)
    mask[2:5, 2:5] = True
    mask[8:13, 8:13] = True
    mask[10, 10] = False
    mask[18:, 15:18] = True
    found = Clouds.of(mask)
    assert found.area.tolist() == [9, 24, 6]
    assert found.perimeter.tolist() == [12, 24, 7]
    assert found.truncated.tolist() == [False, False, True]
    np.testing.assert_allclose(found.centre[:2], [[3, 3], [10, 10]])
    assert found.shape == (20, 20)


@pytest.mark.parametrize("exponent", [0.5, 0.87, 1.26])
def test_sizes_drawn_from_a_power_law_have_its_exponent(exponent):
    tail = 1.0 - np.random.default_rng(0).random(50_000)
    areas = np.floor(10.0 * tail ** (-1.0 / exponent))
    inside = np.zeros(len(areas), dtype=bool)
    assert size_exponent(areas, inside, 10.0) == pytest.approx(exponent, abs=0.03)
    assert size_exponent(2.0 * areas, inside, 20.0, 2.0) == pytest.approx(exponent, abs=0.03)
    assert size_exponent(areas[:50], inside[:50], 10.0) is None


def test_clouds_that_the_frame_cuts_do_not_change_the_exponent():
    # Squares of known sizes at random places; the frame cuts large ones more often, and what is left is smaller.
    rng = np.random.default_rng(1)
    frame = 200.0
    side = np.sqrt(10.0) * (1.0 - rng.random(400_000)) ** (-1.0 / 1.6)
    side = side[side < 2.0 * frame]
    corner = rng.uniform(-2.0 * frame, frame, (len(side), 2))
    low, high = np.maximum(corner, 0.0), np.minimum(corner + side[:, None], frame)
    met = np.all(high > low, axis=1)
    area = np.floor(np.prod(high[met] - low[met], axis=1))
    cut = np.any((corner < 0.0) | (corner + side[:, None] > frame), axis=1)[met]
    kept = size_exponent(area, cut, 10.0)
    assert kept == pytest.approx(0.8, abs=0.06)
    # As if the largest clouds were not known to be cut.
    whole = size_exponent(area[~cut], np.zeros(np.count_nonzero(~cut), dtype=bool), 10.0)
    assert abs(whole - 0.8) > abs(kept - 0.8)


def test_squares_have_dimension_one_and_level_sets_of_a_fractal_surface_theirs():
    masks = []
    for side in np.repeat([4, 6, 9, 13, 19, 28], 3):
        masks.append(np.zeros((64, 64), dtype=bool))
        masks[-1][10 : 10 + side, 12 : 12 + side] = True
        masks[-1][12, 14] = False  # a hole, which is filled
    assert individual_dimension(masks) == pytest.approx(1.0, abs=1e-9)
    half = np.zeros((128, 128), dtype=bool)
    half[:50] = True
    assert ensemble_dimension([half]) == pytest.approx(1.0, abs=0.02)
    # Level sets of a surface with Hurst exponent H have dimension 2 - H; spectra go as k^-(2 + 2 H).
    for hurst in (1.0 / 3.0, 0.5):
        masks = excursions(3, -2.0 - 2.0 * hurst)
        assert ensemble_dimension(masks) == pytest.approx(2.0 - hurst, abs=0.06)


@pytest.mark.filterwarnings("ignore:Power law exponent")
def test_areas_outlines_and_exponents_agree_with_an_independent_package():
    objscale = pytest.importorskip("objscale", reason="in the test extra of hcss-evaluate")
    masks = excursions(4, -2.0 - 2.0 / 3.0)
    arrays = [mask.astype(float) for mask in masks]
    ones = np.ones((514, 514))
    for mask in masks[:2]:
        # Clear sky around, because the package closes frames in another way.
        padded = np.pad(mask, 1)
        theirs, ours = objscale.get_structure_props(padded.astype(int), ones, ones), Clouds.of(padded)
        np.testing.assert_array_equal(np.sort(theirs[0]), np.sort(ours.perimeter))
        np.testing.assert_array_equal(np.sort(theirs[1]), np.sort(ours.area))
    laws = cloud_laws(masks, arrays)
    area = objscale.finite_array_powerlaw_exponent(arrays, "area")
    perimeter = objscale.finite_array_powerlaw_exponent(arrays, "summed perimeter")
    assert laws["exponent of areas"] == pytest.approx(area, abs=0.12)
    assert laws["exponent of perimeters"] == pytest.approx(perimeter, abs=0.12)
    assert laws["dimension of a cloud"] == pytest.approx(objscale.individual_fractal_dimension(arrays), abs=0.04)
    correlation = objscale.ensemble_correlation_dimension(arrays, point_reduction_factor=50)
    assert laws["dimension of the field"] == pytest.approx(correlation, abs=0.08)


def test_cascades_have_their_codimension_and_gaussian_fields_none():
    rng = np.random.default_rng(5)

    def cascade(c1):
        # K(q) = C1 (q^2 - q) of log-normal weights with this variance for each halving
        variance, flux = 2.0 * c1 * np.log(2.0), np.ones((1, 1))
        for _ in range(8):
            flux = np.kron(flux, np.ones((2, 2)))
            flux = flux * np.exp(np.sqrt(variance) * rng.standard_normal(flux.shape) - variance / 2.0)
        return flux

    for c1 in (0.05, 0.1, 0.2):
        assert codimension([cascade(c1) for _ in range(40)]) == pytest.approx(c1, rel=0.12)
    smooth = codimension([gradient_size(power_law(rng, -2.0 - 2.0 / 3.0, 256)) for _ in range(6)])
    assert 0.0 < smooth < 0.03
    assert codimension([np.ones((128, 128))]) == pytest.approx(0.0, abs=1e-12)
    assert codimension([np.ones((16, 16))]) is None


def test_iorg_is_half_for_random_places_more_for_clusters_less_for_a_lattice():
    rng = np.random.default_rng(6)
    found = {
        "random": [rng.uniform(0, 256, (25, 2)) for _ in range(40)],
        "clusters": [np.repeat(rng.uniform(20, 236, (5, 2)), 6, axis=0) + rng.normal(0, 8, (30, 2)) for _ in range(10)],
        "lattice": [np.stack(np.mgrid[16:256:32, 16:256:32], axis=-1).reshape(-1, 2)],
    }
    iorg = {
        name: organisation([Clouds.of(discs(256, places, 1)) for places in frames]) for name, frames in found.items()
    }
    assert iorg["random"] == pytest.approx(0.5, abs=0.03)
    assert iorg["clusters"] > 0.7
    assert iorg["lattice"] < 0.1
    assert organisation([Clouds.of(np.eye(4, dtype=bool))]) is None


@pytest.mark.parametrize(("power", "tolerance"), [(0.0, 1e-9), (0.5, 0.03), (1.0, 0.06)])
def test_edges_have_the_exponent_of_their_profile(power, tolerance):
    y, x = np.ogrid[:128, :128]
    inside = 40.3 - np.hypot(y - 64, x - 64)
    mask = inside > 0.0
    contrast = np.where(mask, np.maximum(inside, 0.0) ** power, 0.0)
    assert edge_exponent([mask], [contrast]) == pytest.approx(power, abs=tolerance)
    assert edge_exponent([np.ones((64, 64), dtype=bool)], [np.ones((64, 64))]) is None


def test_pooled_frames_are_one_population():
    masks = excursions(7, -2.8, 4, 128)
    fields = [np.where(mask, 1.0, 0.0) for mask in masks]
    pooled, single = (
        cloud_laws(masks, fields),
        [cloud_laws([mask], [field]) for mask, field in zip(masks, fields, strict=True)],
    )
    assert pooled["clouds"] == sum(laws["clouds"] for laws in single)
    share = "share of clouds of 1 to 2 pixels"
    weighted = sum(laws[share] * laws["clouds"] for laws in single) / pooled["clouds"]
    assert pooled[share] == pytest.approx(weighted)
    assert pooled["cover"] == pytest.approx(0.3, abs=1e-3)
    # Order of frames does not matter, nor does one of another shape stop the others.
    assert cloud_laws(masks[::-1], fields[::-1]) == pytest.approx(pooled)
    assert cloud_laws([*masks, masks[0][:100]], [*fields, fields[0][:100]])["dimension of the field"] is not None


def test_clear_and_overcast_frames_have_no_laws_but_a_cover():
    for mask in (np.zeros((64, 64), dtype=bool), np.ones((64, 64), dtype=bool)):
        laws = cloud_laws([mask], [mask.astype(float)])
        assert laws.pop("cover") == mask.mean()
        assert laws.pop("clouds") == mask.max()
        assert all(value is None or value == 0.0 for value in laws.values())


def test_values_beyond_the_published_range_are_marked():
    known = PUBLISHED["exponent of perimeters"]
    law = Law.of("exponent of perimeters", 0.5 * (known.low + known.high), known.high + 0.1)
    assert law.beyond == ("simulated",)
    assert law.cells == ["exponent of perimeters", "1.260", "1.420 !", "1.2 to 1.32"]
    assert Law.of("cover", None, 0.3).cells == ["cover", "-", "0.300", ""]


def test_a_frozen_field_moved_by_the_wind_is_coherent():
    wide = power_law(np.random.default_rng(8), -2.7)
    frames = [wide[20:148, 20:148], wide[13:141, 31:159]]
    np.testing.assert_allclose(coherence([(frames, [0.0, 150.0])])[150.0], 1.0, atol=1e-9)
