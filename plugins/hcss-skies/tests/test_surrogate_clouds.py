"""Laws of surrogate clouds: amplitudes, spectrum, evolution, motion, coverage, and what does not fit."""

from __future__ import annotations

import dataclasses
import re
from itertools import cycle, pairwise

import numpy as np
import pytest
from conftest import octave_power, power_law
from hcss_skies.surrogate.evolution import EvolvingNoise
from hcss_skies.surrogate.generator import SurrogateClouds
from hcss_skies.surrogate.parameters import SurrogateParameters
from hcss_skies.surrogate.template import periodic_component
from pydantic import ValidationError
from scipy.special import hyp2f1

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.clouds.fractal.rows import cubic_weights
from hcss_twin.models.clouds.imagery.generator import ImageryClouds
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.providers import CloudGenerator, CloudInputs, CloudLayer, Grid, Microphysics, Motion

NUMBERS = (
    "tolerance",
    "evolution_exponent",
    "iterations",
    "crop_rows",
    "period_columns",
    "row_origin",
    "window_pixels",
)
THINNEST, THICKEST = 100.0, 2000.0
LAYER = CloudLayer(
    "test",
    1000.0,
    1000.0 + THICKEST,
    "base",
    THINNEST,
    0.4,
    None,
    Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0)),
)


def make(
    folder,
    image=None,
    *,
    size=None,
    platform=0.0,
    wind=(0.0, 0.0),
    evolution=1000.0,
    interval=1.0,
    seed=0,
    pixel_size_m=100.0,
    catalog=None,
    layer=None,
    method="coverage",
    **parameters,
):
    if image is None:
        image = power_law((96, 128))
    np.save(folder / "image.npy", image)
    changes = {name: parameters.pop(name) for name in ("coverage", "coverage_mode") if name in parameters}
    inputs = CloudInputs(
        layer=dataclasses.replace(layer or LAYER, **changes),
        grid=Grid(*(size or image.shape), pixel_size_m),
        motion=Motion(platform, wind, evolution, interval),
        seed=seed,
        catalog=catalog or Catalog(base=folder),
    )
    return SurrogateClouds(inputs, SurrogateParameters(image="image.npy", method=method, **parameters))


def frame(clouds, time_s=0.0):
    return clouds.thickness_m(time_s, slice(None), slice(None))


def rms_log_error(field, template):
    """Rms over octaves of the log of the ratio of two spectra."""
    return float(np.sqrt(np.mean(np.log(octave_power(field) / octave_power(template)) ** 2)))


# --- amplitudes and coverage ------------------------------------------------------------


@pytest.mark.parametrize("evolution", [1000.0, np.inf])
def test_every_frame_has_exactly_the_amplitudes_of_the_image(tmp_path, evolution):
    clouds = make(tmp_path, evolution=evolution, wind=(3.0, 1.0))
    assert isinstance(clouds, CloudGenerator)
    expected = np.sort(clouds.template.thickness_m, axis=None)
    for time_s in (0.0, 17.3, 1e5):
        np.testing.assert_array_equal(np.sort(frame(clouds, time_s), axis=None), expected)


def test_template_is_the_scene_that_the_imagery_generator_would_show(tmp_path):
    image = power_law((96, 128))
    clouds = make(tmp_path, image, size=(70, 80), row_origin=3)
    inputs = CloudInputs(LAYER, Grid(70, 80, 100.0), Motion(0.0, (0.0, 0.0), np.inf, 1.0), 0, Catalog(base=tmp_path))
    cut = ImageryClouds(inputs, ImageryParameters(image="image.npy", method="coverage", row_origin=3))
    np.testing.assert_array_equal(clouds.template.thickness_m, frame(cut))


@pytest.mark.parametrize("coverage", [0.0, 0.1, 0.37, 1.0])
def test_coverage_of_the_scenario_is_exact_in_each_frame(tmp_path, coverage):
    clouds = make(tmp_path, size=(70, 90), crop_rows=80, crop_columns=100, coverage=coverage)
    assert clouds.image_coverage is None
    for time_s in (0.0, 40.0):
        assert np.count_nonzero(frame(clouds, time_s)) == round(coverage * 70 * 90)


@pytest.mark.parametrize("method", ["otsu", "local"])
def test_coverage_of_the_image_is_kept_and_said(tmp_path, method):
    image = np.maximum(power_law((96, 128)), 0.0)
    clouds = make(tmp_path, image, method=method, coverage=0.9)
    assert clouds.image_coverage == np.mean(clouds.template.thickness_m > 0)
    assert 0.1 < clouds.image_coverage < 0.6
    assert np.mean(frame(clouds) > 0) == clouds.image_coverage
    assert "coverage, 0.9, is not used" in " ".join(clouds.declares.notes)


def test_coverage_is_exact_where_grey_levels_are_few(tmp_path):
    image = np.round(power_law((96, 128)))  # 7 levels: no threshold gives 40 %
    clouds = make(tmp_path, image, coverage=0.4)
    assert clouds.template.coverage != pytest.approx(0.4, abs=0.01)
    assert np.count_nonzero(frame(clouds)) == round(0.4 * 96 * 128)


def test_field_mode_is_exact_over_the_torus_and_varies_from_frame_to_frame(tmp_path):
    clouds = make(tmp_path, size=(48, 64), crop_rows=96, crop_columns=128, coverage_mode="field")
    tiles = [clouds.thickness_m(9.0, slice(None), slice(None))]
    for platform, wind in ((6400.0, 0.0), (0.0, -4800.0), (6400.0, -4800.0)):
        moved = make(
            tmp_path,
            size=(48, 64),
            crop_rows=96,
            crop_columns=128,
            coverage_mode="field",
            platform=platform,
            wind=(0.0, wind),
        )
        # The four quarters of the torus, as four sensors see them at the same time of evolution.
        tiles.append(frame(moved, 9.0))
    together = np.concatenate(tiles, axis=None)
    assert np.count_nonzero(together) == round(0.4 * 96 * 128)
    np.testing.assert_array_equal(np.sort(together), np.sort(clouds.template.thickness_m, axis=None))
    assert np.ptp([np.mean(tile > 0) for tile in tiles]) > 0.02
    assert clouds.declares.tileable


# --- spectrum ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("evolution", "coverage", "limit"),
    [(1000.0, 0.4, 0.25), (np.inf, 0.4, 0.08), (1000.0, 0.8, 0.08), (np.inf, 0.8, 0.005)],
)
def test_spectrum_is_that_of_the_image(tmp_path, evolution, coverage, limit):
    image = power_law((128, 128), 2.7, seed=3)
    clouds = make(tmp_path, image, evolution=evolution, coverage=coverage)
    template = periodic_component(clouds.template.thickness_m.astype(np.float64))
    for time_s in (0.0, 500.0, 1234.5):
        assert rms_log_error(frame(clouds, time_s), template) < limit
    # The measure tells spectra apart: a steeper one, and the same amplitudes in any order.
    assert rms_log_error(power_law((128, 128), 3.5), template) > 0.3
    shuffled = np.random.default_rng(0).permutation(template.ravel()).reshape(template.shape)
    assert rms_log_error(shuffled, template) > 1.0


def test_direction_of_streaks_is_kept(tmp_path):
    streaks = power_law((128, 128), 3.0, seed=4, stretch=4.0)
    field = frame(make(tmp_path, streaks)).astype(np.float64)
    along = np.mean(np.diff(field, axis=1) ** 2)
    across = np.mean(np.diff(field, axis=0) ** 2)
    template = make(tmp_path, streaks).template.thickness_m.astype(np.float64)
    expected = np.mean(np.diff(template, axis=0) ** 2) / np.mean(np.diff(template, axis=1) ** 2)
    assert expected > 2.0
    assert across / along == pytest.approx(expected, rel=0.1)


def test_scene_larger_than_the_image_has_its_amplitudes_and_structures(tmp_path):
    image = power_law((80, 80), 2.7, seed=5)
    clouds = make(tmp_path, image, size=(150, 200))
    assert clouds.period == (150, 200)
    field = frame(clouds).astype(np.float64)
    template = clouds.template.thickness_m.astype(np.float64)
    assert np.mean(field > 0) == pytest.approx(0.4, abs=1e-4)
    np.testing.assert_allclose(
        np.quantile(field, [0.7, 0.8, 0.9, 0.99]), np.quantile(template, [0.7, 0.8, 0.9, 0.99]), rtol=0.01
    )
    for axis in (0, 1):
        assert np.mean(np.diff(field, axis=axis) ** 2) == pytest.approx(
            np.mean(np.diff(template, axis=axis) ** 2), rel=0.15
        )
    assert any("80 x 80 pixels is interpolated to 150 x 200" in why for _, why in clouds.skipped)


# --- evolution --------------------------------------------------------------------------


def node_overlap(start, lag):
    """Correlation of the blend of time nodes at two coordinates, from the weights alone."""
    weight = {}
    for name, coordinate in (("one", start), ("other", start + lag)):
        cell = int(np.floor(coordinate))
        values = cubic_weights(np.array([coordinate - cell]))[0]
        weight[name] = {cell + tap - 1: values[tap] for tap in range(4)}
    return sum(value * weight["other"].get(node, 0.0) for node, value in weight["one"].items())


def phase_correlation(correlation):
    """<exp i(a - b)> for the phases of complex normals with this correlation (closed form)."""
    return np.pi / 4 * correlation * hyp2f1(0.5, 0.5, 2.0, correlation**2)


def test_autocorrelation_in_time_is_the_designed_one(tmp_path):
    """Normal amplitudes: only phases change, and the mean of exp i(difference) has a closed form."""
    clouds = make(
        tmp_path,
        np.random.default_rng(6).normal(size=(96, 96)),  # white: as many modes as possible
        coverage=1.0,
        evolution=100.0,
        evolution_exponent=0.0,
    )
    starts = np.arange(8) / 8
    fields = {time_s: frame(clouds, 100.0 * time_s).ravel() for time_s in np.arange(0, 5.5, 0.125)}
    found = []
    for lag in (0.125, 0.25, 0.5, 1.0, 1.5, 4.0):
        found.append(np.mean([np.corrcoef(fields[t], fields[t + lag])[0, 1] for t in starts]))
        expected = np.mean([phase_correlation(node_overlap(t, lag)) for t in np.arange(64) / 64])
        assert found[-1] == pytest.approx(expected, abs=0.04)
    assert found[0] > 0.9
    assert np.all(np.diff(found[:5]) < 0)
    assert abs(found[-1]) < 0.04


def test_frozen_clouds_never_change(tmp_path):
    clouds = make(tmp_path, evolution=np.inf)
    np.testing.assert_array_equal(frame(clouds), frame(clouds, 1e7))
    assert not clouds.declares.evolves
    assert clouds.declares.depends_on == frozenset()


def test_small_structures_change_faster_than_large_ones(tmp_path):
    image = power_law((128, 128), 2.5, seed=7)
    for exponent, ratio in ((1.0, 0.5), (0.0, None)):
        clouds = make(tmp_path, image, coverage=1.0, evolution=100.0, evolution_exponent=exponent)
        one, other = (np.fft.fft2(frame(clouds, time_s)) for time_s in (0.0, 20.0))
        wavenumber = np.hypot(*np.meshgrid(*[np.fft.fftfreq(128) * 128] * 2, indexing="ij"))
        kept = []
        for low, high in ((1, 5), (32, 64)):
            ring = (wavenumber >= low) & (wavenumber < high)
            cross = np.sum(one[ring] * np.conj(other[ring])).real
            kept.append(cross / np.sqrt(np.sum(np.abs(one[ring]) ** 2) * np.sum(np.abs(other[ring]) ** 2)))
        if ratio is None:
            assert kept[1] == pytest.approx(kept[0], abs=0.2)
        else:
            assert kept[1] < ratio * kept[0]


@pytest.mark.parametrize("coverage", [0.1, 0.5])
def test_frames_follow_each_other_without_jumps(tmp_path, coverage):
    """A surrogate that fell into another solution would change all at once."""
    image = power_law((64, 64), 3.3, seed=8)
    clouds = make(tmp_path, image, coverage=coverage, evolution=1000.0, evolution_exponent=0.0)
    fields = [frame(clouds, 5.0 * n).astype(np.float64) for n in range(120)]
    change = [np.mean((b - a) ** 2) / (2 * a.var()) for a, b in pairwise(fields)]
    assert max(change) < 0.1  # 1: independent fields


def test_law_of_the_noise_is_the_same_at_every_instant():
    """No pulsing between the time nodes: unit mean square, and the phases of a real field."""
    noise = EvolvingNoise((60, 64), 3, 0.05, 100.0, 1.0, 1.0)
    for time_s in (0.0, 13.0, 50.0, 77.7):
        coefficients = noise.coefficients(time_s)
        assert np.mean(np.abs(coefficients[:, 1:-1]) ** 2) == pytest.approx(1.0, abs=0.08)
        field = np.fft.irfft2(coefficients, s=(60, 64))
        np.testing.assert_allclose(np.fft.rfft2(field), coefficients, atol=1e-5)
    edge = [noise.coefficients(1e4 * n)[:, [0, -1]] for n in range(40)]
    assert np.mean(np.abs(edge) ** 2) == pytest.approx(1.0, abs=0.08)


def test_octaves_that_outrun_the_frames_are_named(tmp_path):
    clouds = make(tmp_path, evolution=20.0, interval=10.0)
    assert any(what.startswith("interpolation in time of octaves") for what, _ in clouds.skipped)
    assert not any(what.startswith("interpolation") for what, _ in make(tmp_path, interval=0.0).skipped)


def test_seeds_differ_and_a_seed_repeats(tmp_path):
    image = power_law((96, 96), 2.0, seed=9)
    one, again, other = (frame(make(tmp_path, image, seed=seed), 3.0) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.2


# --- motion -----------------------------------------------------------------------------


def test_frozen_field_translates_by_whole_pixels_and_repeats(tmp_path):
    clouds = make(tmp_path, evolution=np.inf, coverage_mode="field", platform=200.0, wind=(0.0, 100.0))
    start = frame(clouds)
    # 3 s: 6 columns east, clouds 3 rows further north.
    np.testing.assert_array_equal(frame(clouds, 3.0), np.roll(start, (3, -6), axis=(0, 1)))
    # The notes say so: after 128 columns and 96 rows the same clouds come again.
    np.testing.assert_array_equal(frame(clouds, 192.0), start)
    assert any("repeats after 128 columns (12.8 km) and 96 rows" in note for note in clouds.declares.notes)


def test_parts_of_a_pixel_are_shifted_by_phases(tmp_path):
    """A quarter of a pixel per second: each mode turns by its wavenumber, and 4 s are one pixel."""
    image = power_law((64, 64), 5.0, seed=10)
    clouds = make(tmp_path, image, coverage=1.0, evolution=np.inf, coverage_mode="field", platform=25.0)
    fields = [frame(clouds, float(time_s)).astype(np.float64) for time_s in range(5)]
    np.testing.assert_array_equal(fields[4], np.roll(fields[0], -1, axis=1))
    modes = np.array([np.fft.fft2(field)[[0, 1, 1, 63], [1, 0, 1, 1]] for field in fields])
    turned = np.angle(modes[1:] / modes[:-1])
    quarter = 2 * np.pi / 64 / 4
    np.testing.assert_allclose(turned, np.tile([quarter, 0, quarter, quarter], (4, 1)), atol=0.03 * quarter)


def test_platform_that_follows_the_wind_sees_no_motion(tmp_path):
    clouds = make(tmp_path, evolution=np.inf, platform=10.0, wind=(10.0, 0.0))
    assert clouds.declares.depends_on == frozenset()
    np.testing.assert_array_equal(frame(clouds, 1e6), frame(clouds))


def test_any_window_is_that_part_of_the_frame(tmp_path):
    for mode in ("frame", "field"):
        clouds = make(tmp_path, size=(70, 90), coverage_mode=mode, platform=33.0)
        window = clouds.thickness_m(20.0, slice(3, 17), slice(11, 40))
        np.testing.assert_array_equal(window, frame(clouds, 20.0)[3:17, 11:40])
    with pytest.raises(ValueError, match="inside 0 to 70"):
        clouds.thickness_m(0.0, slice(0, 71), slice(0, 5))
    with pytest.raises(ValueError, match="any finite time"):
        frame(clouds, np.nan)


# --- what does not fit ------------------------------------------------------------------


def test_tapered_edges_are_refused(tmp_path):
    with pytest.raises(ScenarioError, match=r"clouds\.edge_taper: 0\.3 given.*allowed: 0"):
        make(tmp_path, layer=dataclasses.replace(LAYER, edge_taper=0.3))


def test_crop_and_period_that_do_not_fit_are_refused_together(tmp_path):
    with pytest.raises(ScenarioError) as caught:
        make(tmp_path, crop_rows=97, crop_columns=200)
    assert re.search(r"crop_rows: 97 .*closest is 96", str(caught.value))
    assert "crop_columns: 200" in str(caught.value)
    with pytest.raises(ScenarioError, match=r"period_columns: 100 is less than the 128 columns of the scene"):
        make(tmp_path, period_columns=100)


def test_a_coverage_that_the_grey_levels_cannot_give_is_refused(tmp_path):
    with pytest.raises(ScenarioError, match=r"clouds\.coverage: 1e-05 given, but at that coverage no pixel"):
        make(tmp_path, size=(400, 400), coverage=1e-5)
    image = power_law((96, 128))
    image[:70, :70] = image.max()
    with pytest.raises(ScenarioError, match=r"clouds\.coverage: 0\.7 given, but all pixels .* have the same value"):
        make(tmp_path, image, size=(64, 64), row_origin=0, column_origin=0, coverage=0.7)


def test_missing_pixels_are_an_error_unless_called_clear(tmp_path):
    image = power_law((96, 128))
    image[6, 12:15] = np.nan
    with pytest.raises(ScenarioError, match='missing = "clear"'):
        make(tmp_path, image)
    assert np.count_nonzero(frame(make(tmp_path, image, missing="clear"))) == round(0.4 * 96 * 128)


def test_clear_image_gives_clear_frames(tmp_path):
    image = np.zeros((200, 200))
    image[150:160, 150:160] = 1.0
    clouds = make(tmp_path, image, size=(64, 64), row_origin=0, column_origin=0, method="otsu")
    assert clouds.image_coverage == 0.0
    assert not frame(clouds).any()
    assert clouds.declares.depends_on == frozenset()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_image_without_a_number_is_refused_by_name(tmp_path, bad):
    with pytest.raises((CatalogError, ScenarioError), match=r"image\.npy|clouds"):
        make(tmp_path, np.full((200, 200), bad))


def test_times_out_of_range_are_refused(tmp_path):
    for changes, name in (({"evolution": 0.0}, "evolution_time_s"), ({"interval": np.nan}, "frame_interval_s")):
        with pytest.raises(ScenarioError, match=f"{name}: .* given"):
            make(tmp_path, **changes)


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        *({"image": "a", name: bad} for name, bad in zip(NUMBERS, cycle((np.nan, np.inf, -np.inf)), strict=False)),
        {"image": "a", "iterations": -1},
        {"image": "a", "tolerance": 0.0},
        {"image": "a", "crop_rows": 8},
        {"image": "a", "evolution_exponent": 3.0},
        {"image": "a", "periods": 3},
    ],
)
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ValidationError):
        SurrogateParameters(**wrong)
