"""Volumes: what a run kept is packed and read, and the generator `volume` shows it to light with sides."""

import json
from dataclasses import replace

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from hcss_author import CloudGeneratorContract, assert_registered, sample_cloud_inputs
from hcss_skies.command import skies
from hcss_skies.library import shipped_volumes
from hcss_skies.parameters import VolumeParameters
from hcss_skies.simulation import extinction_m1
from hcss_skies.volume import read_volume, volume_of_run, write_volume
from hcss_skies.volume_clouds import VolumeClouds
from les_cases import CLOUDY, case

from hcss_twin.providers import Catalog, CatalogError, Grid, Motion, ProviderError, ScenarioError

PER_M = extinction_m1(sample_cloud_inputs().layer)
CATALOG = Catalog()


class TestVolumeClouds(CloudGeneratorContract):
    """The shipped cumulus, 3.2 km wide."""

    def make_inputs(self, coverage=0.5, seed=1):
        return replace(sample_cloud_inputs(coverage, seed), grid=Grid(64, 80, 50.0), catalog=CATALOG)

    def make_provider(self, inputs):
        return VolumeClouds(inputs, VolumeParameters())


def clouds(name="trade-cumulus", *, pixel_m=50.0, size=64, seed=1, wind=(0.0, 0.0), **layer):
    """A generator in a layer that is deep enough for the thickest clouds."""
    inputs = sample_cloud_inputs(seed=seed)
    deep = {"base_m": 500.0, "top_m": 4500.0, "thickness_min_m": 1e-3, **layer}
    inputs = replace(inputs, layer=replace(inputs.layer, **deep), grid=Grid(size, size, pixel_m), catalog=CATALOG)
    motion = Motion(0.0, wind, np.inf, 1.0)
    return VolumeClouds(replace(inputs, motion=motion), VolumeParameters(volume=name))


def whole(of, size=64, time_s=0.0):
    return of.thickness_m(time_s, slice(0, size), slice(0, size))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A few minutes of a small cloud."""
    from hcss_skies.les.run import simulate_case

    path = tmp_path_factory.mktemp("run") / "run.nc"
    small = case(CLOUDY, output={"hours": 0.1, "picture_s": 120.0, "volume_s": 120.0}, grid={"columns": [8, 12]})
    simulate_case(small, path, lambda times, _: iter(times))
    return path


def test_is_found_when_installed():
    assert_registered("clouds", "volume", distribution="hcss-skies")


@pytest.mark.parametrize(("start_h", "number"), [(None, 3), (2.0 / 60.0, 1)])
def test_a_volume_has_the_optical_thickness_of_its_picture(run, start_h, number):
    volume = volume_of_run(run, start_h, licence="none")
    with netCDF4.Dataset(run) as file:
        expected = file["optical_thickness"][number].filled(np.nan)
        assert volume.time_s == file["volume_time"][number]
    np.testing.assert_allclose(volume.optical_thickness, expected, rtol=1e-3)
    assert expected.max() > 1.0
    # no clear levels at its ends
    assert volume.extinction_m1[0].max() > 0.0
    assert volume.extinction_m1[-1].max() > 0.0


def test_a_written_volume_is_read_with_the_same_bits(run, tmp_path):
    volume = volume_of_run(run, kind="blob", licence="none")
    write_volume(tmp_path / "v.nc", volume)
    found = read_volume(tmp_path / "v.nc")
    for name in ("extinction_m1", "edges_m"):
        np.testing.assert_array_equal(getattr(found, name), getattr(volume, name))
    for name in ("cell_m", "kind", "source", "licence", "recipe", "time_s", "droplets_cm3", "frame_m_s"):
        assert getattr(found, name) == getattr(volume, name)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.setncattr("hcss_skies_volume_format", 9), "no volume of clouds; `hcss skies pack --volume`"),
        (lambda file: file.setncattr("cell_m", -1.0), "cell_m -1; allowed: 1 to 5000"),
        (lambda file: file.setncattr("frame_m_s", [500.0, 0.0]), "frame_m_s along x 500; allowed: -100 to 100"),
        (lambda file: file.delncattr("recipe"), r"v\.nc"),
        (lambda file: file["extinction"].__setitem__((0, 0, 0), np.nan), "extinction that is missing, or outside 0 to"),
        (lambda file: file["extinction"].__setitem__((0, 0, 0), -1.0), "extinction that is missing, or outside 0 to 1"),
        (lambda file: file["extinction"].__setitem__(slice(None), 0.0), "no cloud"),
        (lambda file: file["z_bounds"].__setitem__((1, 0), 1e4), "levels above each other"),
        (lambda file: file.renameVariable("extinction", "other"), r"v\.nc"),
    ],
)
def test_wrong_contents_are_named(run, tmp_path, change, message):
    write_volume(tmp_path / "v.nc", volume_of_run(run, licence="none"))
    with netCDF4.Dataset(tmp_path / "v.nc", "a") as file:
        change(file)
    with pytest.raises(CatalogError, match=message):
        read_volume(tmp_path / "v.nc")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--start", "0.5"], "volume at 0.5 h; allowed: 0, 0.0333333, 0.0666667, 0.1 h"),
        (["--start", "0", "--start", "1"], "2 given; allowed with --volume: one"),
        (["--snapshots", "30"], "allowed with --volume: without"),
    ],
)
def test_volumes_that_a_run_has_not_are_refused(run, tmp_path, arguments, message):
    done = CliRunner().invoke(skies, ["pack", str(run), "--volume", "-o", str(tmp_path / "v.nc"), *arguments])
    assert done.exit_code != 0
    assert message in done.output + str(done.exception)
    assert not list(tmp_path.iterdir())


def test_a_run_without_volumes_is_refused(run, tmp_path):
    with netCDF4.Dataset(tmp_path / "run.nc", "w") as file:
        file.hcss_skies_simulation = 1
    with pytest.raises(CatalogError, match="no volumes; allowed: a run with --volumes"):
        volume_of_run(tmp_path / "run.nc", licence="none")


def test_the_command_packs_the_volume_that_a_scene_names(run, tmp_path):
    (tmp_path / "skies").mkdir()
    done = CliRunner().invoke(skies, ["pack", str(run), "--volume", "-o", str(tmp_path / "skies" / "mine.nc")])
    assert done.exit_code == 0, done.output
    assert "12 x 8 columns of" in done.output
    inputs = replace(sample_cloud_inputs(catalog=Catalog(base=tmp_path)), grid=Grid(8, 8, 50.0))
    cell_m = read_volume(tmp_path / "skies" / "mine.nc").cell_m
    inputs = replace(inputs, grid=Grid(8, 8, cell_m))
    assert whole(VolumeClouds(inputs, VolumeParameters(volume="mine")), 8).max() > 0.0
    with pytest.raises(CatalogError, match=r"no volume 'other'.*mine"):
        VolumeClouds(inputs, VolumeParameters(volume="other"))


@pytest.mark.parametrize("name", sorted(shipped_volumes()))
def test_shipped_volumes_are_small_and_name_recipe_and_seed(name):
    path = shipped_volumes()[name]
    volume = read_volume(path)
    assert path.stat().st_size <= 1_000_000
    recipe = json.loads(volume.recipe)
    assert recipe["seed"] == 1
    assert recipe["grid"]["side_m"] == volume.cell_m
    assert len(volume.source) > 50
    assert name in CliRunner().invoke(skies, ["list"]).output


@pytest.mark.parametrize("name", sorted(shipped_volumes()))
def test_light_sees_the_extinction_of_every_level(name):
    """Interpolation over the periodic box keeps the mean of each level."""
    of = clouds(name)
    volume, thickness = of.volume, whole(of)
    bottom, top = volume.edges_m[[0, -1]]
    edges = 500.0 + (volume.edges_m - bottom) * (4000.0 / (top - bottom))
    shares = of.height_shares(0.0, slice(0, 64), slice(0, 64), thickness, edges)
    np.testing.assert_allclose(shares.sum(axis=0), thickness > 0.0, atol=2e-6)
    depth = np.diff(volume.edges_m)
    expected = volume.extinction_m1.mean(axis=(1, 2), dtype=np.float64) * depth / PER_M
    np.testing.assert_allclose((shares * thickness).mean(axis=(1, 2)), expected, rtol=2e-3, atol=2e-3)
    coarse = of.height_shares(0.0, slice(0, 64), slice(0, 64), thickness, edges[[0, 5, -1]])
    np.testing.assert_allclose(coarse, np.add.reduceat(shares, [0, 5], axis=0), atol=2e-6)


def test_the_box_is_repeated_and_windows_have_the_same_bits():
    of = clouds(pixel_m=20.0, size=200, wind=(7.3, -2.1))
    frame = whole(of, 200, 321.0)
    np.testing.assert_array_equal(frame[105:130, 3:90], of.thickness_m(321.0, slice(105, 130), slice(3, 90)))
    edges, part = np.linspace(500.0, 4500.0, 12), (slice(-5, 30), slice(40, 60))
    shares = of.height_shares(321.0, *part, of.thickness_around_m(321.0, *part), edges)
    inside = of.height_shares(321.0, slice(0, 30), slice(40, 60), frame[:30, 40:60], edges)
    np.testing.assert_array_equal(shares[:, 5:], inside)
    still = clouds(pixel_m=20.0, size=200)
    repeated = still.thickness_around_m(0.0, slice(160, 200), slice(-160, -100))
    np.testing.assert_allclose(repeated, whole(still, 200)[:40, :60], atol=1e-3)


def test_clouds_move_with_the_wind_and_are_turned_along_it():
    """Those of BOMEX moved toward -x."""
    along, north = clouds(wind=(-5.0, 0.0), pixel_m=20.0), clouds(wind=(0.0, -5.0), pixel_m=20.0)
    np.testing.assert_allclose(whole(along, time_s=40.0)[:, :-10], whole(along)[:, 10:], atol=1e-3)
    np.testing.assert_allclose(whole(north), whole(along)[::-1].T, atol=1e-3)
    np.testing.assert_array_equal(whole(along), whole(clouds(pixel_m=20.0)))


def test_seeds_show_other_places_of_the_box():
    assert not np.array_equal(whole(clouds(seed=1)), whole(clouds(seed=2)))
    assert whole(clouds(seed=1)).mean() == pytest.approx(float(whole(clouds(seed=2)).mean()), rel=1e-3)


@pytest.mark.parametrize("pixel_m", [12.0, 71.0])
def test_pixels_beyond_what_the_volume_has_are_refused(pixel_m):
    with pytest.raises(ProviderError, match=r"volume: pixels of \d+ m; allowed: 12.5 to 70 m"):
        clouds(pixel_m=pixel_m)


def test_tapered_edges_are_refused():
    with pytest.raises(ScenarioError, match="edges of their own; allowed: 0"):
        clouds(edge_taper=0.2)


def test_what_is_not_computed_is_stated():
    inputs = replace(sample_cloud_inputs(), grid=Grid(8, 8, 50.0), motion=Motion(0.0, (0.0, 0.0), 1800.0, 1.0))
    skipped = VolumeClouds(inputs, VolumeParameters()).skipped
    assert ("change of cloud shapes", "a volume is one instant") in skipped
