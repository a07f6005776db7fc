"""Films: what is packed is read, cloud stays cloud, motion is found, and frames between snapshots move with it."""

from dataclasses import replace

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from hcss_author import sample_cloud_inputs
from hcss_skies.command import skies
from hcss_skies.film import LEVELS, described, read_film, score_of, write_film
from hcss_skies.library import find_film, shipped_films
from hcss_skies.motion import densify, filled, motion_between
from hcss_skies.packing import CLOUDY, pack
from hcss_skies.parameters import SimulationParameters
from hcss_skies.simulation import SimulatedClouds
from scipy.ndimage import fourier_gaussian, fourier_shift

from hcss_twin.providers import Catalog, CatalogError, Grid

SIDE = 64


def periodic(seed, scale=3.0, side=SIDE):
    """A smooth periodic normal field (side, side)."""
    white = np.random.default_rng(seed).standard_normal((side, side))
    field = np.fft.ifft2(fourier_gaussian(np.fft.fft2(white), scale)).real
    return (field - field.mean()) / field.std()


def shifted(field, by):
    """A periodic field moved by cells (y, x), also parts of them."""
    return np.fft.ifft2(fourier_shift(np.fft.fft2(field), by)).real


def in_ranks(field):
    """Ranks of a normal field."""
    return np.clip(np.rint(128.0 + 35.0 * field), 0, 255).astype(np.uint8)


def write_run(path, *, cover=0.2, pictures=12, spin_up_s=3600.0, shape=(SIDE, SIDE), changes=()):
    """A file like those of `hcss skies simulate`: clouds of a smooth field that moves 1 and -0.5 cells a minute."""
    field = np.stack([shifted(periodic(1), (1.0 * n, -0.5 * n)) + 0.05 * n * periodic(2) for n in range(pictures)])
    field = field[:, : shape[0], : shape[1]]
    edge = np.quantile(field, 1.0 - cover) if cover else np.inf
    thickness = np.where(field > edge, 0.06 + 20.0 * np.maximum(field - edge, 0.0) ** 1.5, 0.0)
    with netCDF4.Dataset(path, "w") as file:
        file.setncatts(
            {"title": "blobs", "source": "a test", "hcss_skies_simulation": 1, "frame_m_s": np.array([-7.5, 1.0])}
        )
        for name, values in {
            "time": spin_up_s + 60.0 * np.arange(pictures),
            "y": 50.0 * (np.arange(shape[0]) + 0.5),
            "x": 50.0 * (np.arange(shape[1]) + 0.5),
        }.items():
            file.createDimension(name, values.size)
            file.createVariable(name, "f8", (name,))[:] = values
        for name, values in {
            "optical_thickness": thickness,
            "cloud_top": np.where(thickness > 0.1, 600.0 + 20.0 * thickness, np.nan),
            "cloud_base": np.where(thickness > 0.1, 600.0 - 2.0 * thickness, np.nan),
        }.items():
            file.createVariable(name, "f4", ("time", "y", "x"), fill_value=np.nan)[:] = values
        for change in changes:
            change(file)
    return thickness


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs by cover, their optical thickness, and their films of two pieces of six snapshots."""
    found = {}
    for cover in (0.2, 0.8):
        path = tmp_path_factory.mktemp("runs") / f"{cover}.nc"
        thickness = write_run(path, cover=cover)
        found[cover] = path, thickness.reshape(2, 6, SIDE, SIDE), pack(path, snapshots=6)
    return found


@pytest.mark.parametrize("cover", [0.2, 0.8])
def test_cloud_stays_cloud_with_its_optical_thickness(runs, cover):
    _, thickness, film = runs[cover]
    known = film.optical_thickness[film.ranks]
    np.testing.assert_array_equal(known > 0.0, thickness > CLOUDY)
    assert film.sheet == (cover > 0.5)
    assert film.coverage == pytest.approx(cover, abs=1e-3)
    first = np.flatnonzero(film.optical_thickness)[0]
    assert film.optical_thickness[first] > CLOUDY
    # a rank is up to 7 % of the exceedance; the ends of a score hold more
    inner = (film.ranks > first) & (film.ranks < LEVELS - 1)
    assert np.mean(np.abs(known - thickness)[inner]) < 0.05 * thickness[inner].mean()


@pytest.mark.parametrize("cover", [0.2, 0.8])
def test_scores_are_those_of_the_pixels_probabilities(runs, cover):
    film = runs[cover][2]
    share = np.array([np.mean(film.ranks <= rank) for rank in range(LEVELS)])
    middles = 0.5 * (film.scores[1:] + film.scores[:-1])
    held = (share[:-1] > 0.05) & (share[:-1] < 0.95)
    # ranks at the edge of cloud are moved by up to one
    np.testing.assert_allclose(score_of(share[:-1][held], film.sheet), middles[held], atol=1.1 * np.diff(middles)[0])


def test_eroded_clouds_shrink_and_grown_ones_reach_out_from_their_edges(runs):
    """A shift of the score changes cover smoothly, by the law of Gumbel, and adds no specks far from cloud."""
    film = runs[0.2][2]
    first = np.flatnonzero(film.optical_thickness)[0]
    step = film.scores[1] - film.scores[0]
    near = np.zeros((SIDE, SIDE), bool)
    for ranks in film.ranks[0]:
        cloud = ranks >= first
        for y, x in np.ndindex(5, 5):
            near |= np.roll(cloud, (y - 2, x - 2), (0, 1))
        grown = ranks >= first - round(0.35 / step)
        assert not np.any(grown & ~near)
    covers = [np.mean(film.ranks >= first + n) for n in range(-10, 11)]
    expected = 1.0 - (1.0 - covers[10]) ** np.exp(-step * np.arange(-10, 11))
    np.testing.assert_allclose(covers, expected, rtol=0.06)


def test_clear_sky_is_ranked_by_its_distance_from_cloud(tmp_path):
    """One small cloud in a box: along its row and column ranks fall to the other side of the box, without a plateau."""

    def one_cloud(file):
        thickness = np.zeros((4, SIDE, SIDE))
        thickness[:, 30:34, 30:34] = 1.0
        file["optical_thickness"][:] = thickness
        file["cloud_top"][:], file["cloud_base"][:] = 900.0 * thickness, 500.0 * thickness

    write_run(tmp_path / "one.nc", pictures=4, changes=[one_cloud])
    ranks = pack(tmp_path / "one.nc", snapshots=2).ranks[0, 0].astype(int)
    for line in (ranks[31, 33:63], ranks[33:63, 31]):
        assert np.all(np.diff(line) <= 0)
        assert np.unique(line).size > 20


@pytest.mark.parametrize("cover", [0.2, 0.8])
def test_tops_and_bases_are_within_a_255th_of_the_layer(runs, cover):
    path, thickness, film = runs[cover]
    layer = film.top_m - film.base_m
    with netCDF4.Dataset(path) as file:
        top = file["cloud_top"][:].filled(np.nan).reshape(thickness.shape)
        base = file["cloud_base"][:].filled(np.nan).reshape(thickness.shape)
    for ranks, field in ((film.top, top), (film.base, base)):
        assert np.array_equal(ranks > 0, thickness > CLOUDY)
        known = np.isfinite(field)
        clipped = np.clip(field[known], film.base_m, film.top_m)
        assert np.max(np.abs(film.base_m + layer * ranks[known] / 255.0 - clipped)) <= 1.0001 * layer / 255.0
    assert film.base_m <= np.nanquantile(base, 0.01)
    assert film.top_m >= np.nanquantile(top, 0.99)


def test_a_written_film_is_read_with_the_same_bits_and_is_small(runs, tmp_path):
    film = runs[0.2][2]
    write_film(tmp_path / "film.nc", film)
    found = read_film(tmp_path / "film.nc")
    for name in ("ranks", "top", "base", "motion", "scores"):
        np.testing.assert_array_equal(getattr(found, name), getattr(film, name))
    np.testing.assert_allclose(found.optical_thickness, film.optical_thickness, rtol=1e-6)
    for name in ("block", "cell_m", "interval_s", "base_m", "top_m", "sheet", "kind", "source", "licence", "frame_m_s"):
        assert getattr(found, name) == getattr(film, name)
    assert (found.cell_m, found.interval_s, found.frame_m_s) == (50.0, 60.0, (-7.5, 1.0))
    assert (tmp_path / "film.nc").stat().st_size < 0.6 * (film.ranks.size + film.top.size + film.base.size)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.7, 0.95])
def test_a_truncated_film_is_one_clear_error(runs, tmp_path, part):
    write_film(tmp_path / "film.nc", runs[0.2][2])
    content = (tmp_path / "film.nc").read_bytes()
    (tmp_path / "film.nc").write_bytes(content[: int(part * len(content))])
    with pytest.raises(CatalogError, match=r"film\.nc"):
        read_film(tmp_path / "film.nc")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.setncattr("hcss_skies_film_format", 9), "no film of clouds; `hcss skies pack`"),
        (lambda file: file.setncattr("cell_m", -1.0), "cell_m -1; allowed: 1 to 5000"),
        (lambda file: file.setncattr("interval_s", np.nan), "interval_s nan; allowed: 1 to 3600"),
        (lambda file: file.setncattr("block", 7), "block 7; allowed: a divisor of 64 and 64 cells"),
        (lambda file: file.setncattr("top_m", 0.0), "top_m 0; allowed: above base_m"),
        (lambda file: file.setncattr("sheet", 1), "sheet 1 with a cover of 0.20"),
        (lambda file: file.setncattr("first_and_last_score", [3.0, 1.0]), "scores that are not evenly spaced"),
        (lambda file: file.setncattr("frame_m_s", [1.0]), r"film\.nc"),
        (lambda file: file.delncattr("kind"), r"film\.nc"),
        (lambda file: file["optical_thickness"].__setitem__(200, np.nan), "optical thickness that does not ascend"),
        (lambda file: file["motion"].__setitem__((0, 0, 0, 0, 0), 127), "displacements beyond 7 cells"),
        (lambda file: file["top"].__setitem__((0, 0, 3, 0), file["top"][0, 0, 3, 0] ^ 255), "tops or bases"),
        (lambda file: file.renameVariable("rank", "other"), r"film\.nc"),
    ],
)
def test_wrong_contents_are_named(runs, tmp_path, change, message):
    write_film(tmp_path / "film.nc", runs[0.2][2])
    with netCDF4.Dataset(tmp_path / "film.nc", "a") as file:
        file.set_auto_mask(False)
        change(file)
    with pytest.raises(CatalogError, match=message):
        read_film(tmp_path / "film.nc")


def test_a_film_that_could_not_be_read_is_not_written(runs, tmp_path):
    with pytest.raises(CatalogError, match="bases above tops"):
        write_film(tmp_path / "film.nc", replace(runs[0.2][2], base=runs[0.2][2].top, top=runs[0.2][2].base))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("run", "options", "message"),
    [
        ({"cover": 0.0}, {"snapshots": 6}, "no cloud of optical thickness above 0.05"),
        ({}, {}, "12 pictures; allowed: 60 or more for two pieces of 30"),
        (
            {},
            {"starts_h": [1.05], "snapshots": 12},
            "start 1.05 h of 12 snapshots; allowed: times of pictures, 1 to 1 h",
        ),
        ({}, {"starts_h": [1.0]}, "allowed: times of pictures, none, 12 pictures"),
        ({}, {"snapshots": 1}, "1 snapshots; allowed: 2 to 1000"),
        ({"shape": (61, 61)}, {"snapshots": 6}, "61 x 61 cells; allowed: multiples of a number from 4 to 16"),
        ({"changes": [lambda f: f.delncattr("hcss_skies_simulation")]}, {}, "no run of `hcss skies simulate`"),
        ({"changes": [lambda f: f["time"].__setitem__(3, 3800.0)]}, {"snapshots": 6}, "s apart; allowed: evenly"),
        ({"changes": [lambda f: f["optical_thickness"].__setitem__((0, 3, 3), np.nan)]}, {"snapshots": 6}, "missing"),
        (
            {"changes": [lambda f: f["y"].__setitem__(1, 90.0)]},
            {"snapshots": 6},
            "cells of 50 x 65 m; allowed: squares",
        ),
    ],
)
def test_runs_that_make_no_film_are_refused(tmp_path, run, options, message):
    write_run(tmp_path / "run.nc", **run)
    with pytest.raises(CatalogError, match=message):
        pack(tmp_path / "run.nc", **options)


def test_default_pieces_are_the_first_pictures_and_later_ones(tmp_path):
    thickness = write_run(tmp_path / "run.nc", pictures=15)
    film = pack(tmp_path / "run.nc", snapshots=6)
    np.testing.assert_array_equal(film.optical_thickness[film.ranks[0]] > 0, thickness[:6] > CLOUDY)
    np.testing.assert_array_equal(film.optical_thickness[film.ranks[1]] > 0, thickness[9:] > CLOUDY)
    write_film(tmp_path / "film.nc", film)
    assert described(tmp_path / "film.nc").endswith("film of 10 min")


@pytest.mark.parametrize("by", [(0.0, 0.0), (2.25, -3.5), (-5.5, 4.75)])
def test_motion_of_a_shifted_field_is_found_within_an_eighth_of_a_cell(by):
    field = periodic(3)
    motion = motion_between(in_ranks(np.stack([field, shifted(field, by)]))[None], 16)
    assert motion.shape == (1, 1, 2, 4, 4)
    np.testing.assert_allclose(motion[0, 0] / 16.0, np.broadcast_to(np.reshape(by, (2, 1, 1)), (2, 4, 4)), atol=0.13)


def test_motion_without_structure_is_the_mean_motion():
    """Clouds in one half of the box move by three cells; the other half is clear."""
    field = np.where(np.arange(SIDE) < SIDE // 2, 0.0, periodic(5))
    still = np.clip(np.exp(-(((np.arange(SIDE) - 48.0) / 9.0) ** 2)), 0.0, 1.0) * field
    ranks = in_ranks(np.stack([still, np.roll(still, 3, 0)]))[None]
    motion = motion_between(ranks, 16)[0, 0] / 16.0
    np.testing.assert_allclose(motion[0], 3.0, atol=0.4)
    np.testing.assert_allclose(motion[1], 0.0, atol=0.4)


def test_warping_predicts_the_middle_snapshot_better_than_cross_fading(runs):
    _, _, film = runs[0.2]
    ends, middle = film.ranks[:, [0, 4]], film.ranks[:, 2].astype(float)
    motion = motion_between(ends, film.block)
    np.testing.assert_allclose(motion.mean(axis=(0, 1, 3, 4)) / 16.0, [4.0, -2.0], atol=0.4)
    warped = densify(ends, motion, film.block, 1)[:, 0].astype(float)
    faded = ends.astype(float).mean(axis=1)
    cloud = film.optical_thickness[film.ranks[:, 2]] > 0.0
    for where in (cloud, np.ones_like(cloud)):
        error, of_fading = (np.sqrt(np.mean((found - middle)[where] ** 2)) for found in (warped, faded))
        assert error < 0.6 * of_fading


def blob(centre, width=5.0):
    """A cloud (rows, columns) in a periodic box: ranks of 20 to 220."""
    y, x = np.indices((SIDE, SIDE)) - np.reshape(centre, (2, 1, 1))
    away = [(d + SIDE // 2) % SIDE - SIDE // 2 for d in (y, x)]
    return np.rint(20.0 + 200.0 * np.exp(-0.5 * (away[0] ** 2 + away[1] ** 2) / width**2)).astype(np.uint8)


def test_between_snapshots_a_cloud_moves_steadily_with_its_size():
    """Three cells a snapshot along x across the edge of the box, one along y; frames a third of an interval apart."""
    path = [(30.0 + n, 50.0 + 3.0 * n) for n in range(6)]
    ranks = np.stack([blob(centre) for centre in path])[None]
    frames = densify(ranks, motion_between(ranks, 16), 16, 3)
    assert frames.shape == (1, 15, SIDE, SIDE)
    weight = np.maximum(frames[0].astype(float) - 40.0, 0.0)
    angle = 2.0 * np.pi * np.arange(SIDE) / SIDE
    for axis, (first, speed) in ((1, (30.0, 1.0)), (2, (50.0, 3.0))):
        profile = weight.sum(axis=3 - axis)
        place = np.unwrap(np.angle(profile @ np.exp(1j * angle))) * SIDE / (2.0 * np.pi)
        expected = first + speed * (np.arange(15) + 0.5) / 3.0
        np.testing.assert_allclose((place - expected + SIDE / 2) % SIDE - SIDE / 2, 0.0, atol=0.1)
    sizes = (frames[0] > 100).sum(axis=(1, 2))
    np.testing.assert_allclose(sizes, sizes[0], rtol=0.05)


def test_filled_heights_are_those_of_cloud_and_near_it_like_it(runs):
    """A film of heights 40 west and 200 east of clear gaps; the box is periodic."""
    film = runs[0.2][2]
    filled_top = filled(film.top)
    cloud = film.top > 0
    np.testing.assert_array_equal(filled_top[cloud], film.top[cloud])
    assert filled_top.min() >= film.top[cloud].min()
    heights = np.zeros((1, 48, 48), np.uint8)
    heights[:, :, 4:8], heights[:, :, 30:36] = 40, 200
    found = filled(heights)[0].astype(int)
    assert np.all(found[:, [3, 8]] < 80)
    assert np.all(found[:, [29, 36]] > 160)
    assert np.all(np.abs(np.diff(found, axis=0)) == 0)
    np.testing.assert_array_equal(filled(np.roll(heights, 16, axis=2))[0], np.roll(found, 16, axis=1))


def test_the_command_packs_a_run_and_does_not_replace_a_file(tmp_path):
    write_run(tmp_path / "run.nc")
    arguments = ["pack", str(tmp_path / "run.nc"), "-o", str(tmp_path / "mine.nc"), "--snapshots", "4"]
    done = CliRunner().invoke(skies, [*arguments, "--start", "1", "--start", "1.1", "--kind", "heaps"])
    assert done.exit_code == 0, done.output
    assert "heaps: 50 m, cover 0." in done.output
    assert "film of 6 min; 2 x 4 snapshots of 64 x 64 cells" in done.output
    film = read_film(tmp_path / "mine.nc")
    assert (film.kind, film.licence, film.source) == ("heaps", "own computation", "a test")
    assert CliRunner().invoke(skies, arguments).exit_code != 0
    assert CliRunner().invoke(skies, [*arguments, "--force", "--licence", "free"]).exit_code == 0
    film = read_film(tmp_path / "mine.nc")
    assert (film.kind, film.licence) == ("blobs", "free")


@pytest.mark.parametrize("name", sorted(shipped_films()))
def test_a_film_is_described_with_its_own_cover_without_its_pictures(name, monkeypatch):
    film = read_film(shipped_films()[name])
    for above in (0.0, 3.0):
        assert film.share_above(above) == np.mean(film.optical_thickness[film.ranks] > above)
    monkeypatch.setattr(netCDF4.Variable, "__getitem__", small_only(netCDF4.Variable.__getitem__))
    words = described(shipped_films()[name])
    assert words.startswith(f"{film.kind}: {film.cell_m:g} m, cover ")
    assert float(words.split("cover ")[1].split(",")[0]) == pytest.approx(film.coverage, abs=0.01)


def small_only(read):
    """A reader of variables that refuses those of pictures."""

    def guarded(variable, key):
        assert variable.size <= LEVELS, f"{variable.name} is read"
        return read(variable, key)

    return guarded


@pytest.mark.parametrize("damage", ["no film", "no header", "cut"])
def test_what_is_no_film_is_not_described(damage, tmp_path):
    path = tmp_path / "film.nc"
    path.write_bytes(shipped_films()["trade-cumulus"].read_bytes()[: 500_000 if damage == "cut" else None])
    if damage != "cut":
        with netCDF4.Dataset(path, "a") as file:
            file.delncattr("hcss_skies_film_format" if damage == "no film" else "cell_m")
    with pytest.raises(CatalogError, match=str(path)):
        described(path)


def test_films_are_found_beside_a_scenario_and_by_path(runs, tmp_path):
    (tmp_path / "skies").mkdir()
    write_film(tmp_path / "skies" / "mine.nc", runs[0.2][2])
    catalog = Catalog(base=tmp_path)
    assert find_film("mine", catalog) == find_film(str(tmp_path / "skies" / "mine.nc"), catalog)
    with pytest.raises(CatalogError, match=r"no film 'mien': neither shipped, nor in .*mine"):
        find_film("mien", catalog)


def test_a_film_without_a_hole_is_a_sky_without_a_hole(tmp_path):
    path = tmp_path / "overcast.nc"
    write_run(tmp_path / "run.nc", cover=0.2, pictures=60)
    with netCDF4.Dataset(tmp_path / "run.nc", "a") as file:  # thin cloud everywhere else
        for name, value in {"optical_thickness": 0.06, "cloud_top": 600.0, "cloud_base": 590.0}.items():
            values = file[name][:]
            file[name][:] = np.where(np.ma.filled(values, np.nan) > 0.06, values, value)
    write_film(path, pack(tmp_path / "run.nc", snapshots=30))
    inputs = sample_cloud_inputs(1.0, 1)
    layer = replace(inputs.layer, coverage=1.0, coverage_mode="field")
    for pixel_m in (50.0, 200.0):
        inputs = replace(inputs, layer=layer, grid=Grid(64, 64, pixel_m), catalog=Catalog(base=tmp_path))
        made = SimulatedClouds(inputs, SimulationParameters(film=str(path)))
        assert made.thickness_m(0.0, slice(0, 64), slice(0, 64)).min() > 0.0
