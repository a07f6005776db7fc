"""Pictures of any variable of a cube, and what is said of files that are no cubes."""

import json

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from click.testing import CliRunner
from PIL import Image, ImageColor

from hcss_twin import Scenario, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.errors import CubeError
from hcss_twin.reports.preview import MISSING, draw_preview

SMALL = {**CHEAP, "image.rows": 40, "image.columns": 60, "frames.count": 2, "bands": NARROW}
LAYERS = {"clouds.layers.0.coverage": 0.3, "clouds.layers.1.coverage": 0.5}


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    """A cube of two layers with every variable."""
    path = tmp_path_factory.mktemp("cube") / "all.nc"
    scene = {**SMALL, **LAYERS, "output.variables": ["all"], "image.samples_per_pixel": 1}
    simulate(Scenario.load("cirrus-over-cumulus", scene), path).close()
    return path


def drawn(cube, folder, variable, **options):
    return [path.name for path in draw_preview(cube, folder, variable=variable, animation=False, **options)]


@pytest.mark.parametrize(
    ("variable", "names"),
    [
        (None, ["all_lwir_kelvin.png", "all_mwir_kelvin.png"]),
        ("radiance", ["all_mwir.png", "all_lwir.png"]),
        ("radiance_sea_emission", ["all_mwir_radiance-sea-emission.png", "all_lwir_radiance-sea-emission.png"]),
        ("brightness_temperature", ["all_lwir_kelvin.png", "all_mwir_kelvin.png"]),
        ("cloud_mask", ["all_cloud-mask.png"]),
        (
            "cloud_layer_thickness",
            ["all_paper-cumulus_cloud-layer-thickness.png", "all_paper-cirrus_cloud-layer-thickness.png"],
        ),
    ],
)
def test_each_band_or_layer_of_the_variable_has_a_picture_of_its_own(cube, tmp_path, variable, names):
    assert drawn(cube, tmp_path, variable) == names
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_the_animation_shows_the_variable_that_was_named(cube, tmp_path):
    """Where clouds are, and nowhere else, the mask is white."""
    from hcss_twin import open_cube

    film = next(path for path in draw_preview(cube, tmp_path, variable="cloud_mask") if path.suffix == ".gif")
    with Image.open(film) as image:
        grey = np.asarray(image.convert("L"))
    with open_cube(cube) as dataset:
        mask = dataset.cloud_mask.isel(time=0).to_numpy()[::-1]
    np.testing.assert_array_equal(grey[-40:, :60] > 127, mask == 1)


def test_a_linear_scale_is_one_and_the_usual_one_is_not(cube, tmp_path):
    """Greys against percentiles of the radiance in the cube, by numpy."""
    from hcss_twin import open_cube

    with open_cube(cube) as dataset:
        radiance = dataset.radiance.isel(band=0).to_numpy().astype(float)
    low, high = np.percentile(radiance, (0.5, 99.5))
    expected = 255.0 * np.clip((radiance[0, ::-1] - low) / (high - low), 0.0, 1.0)

    def off(folder, **options):
        films = [path for path in draw_preview(cube, folder, variable="radiance", **options) if path.suffix == ".gif"]
        with Image.open(next(path for path in films if "mwir" in path.name)) as image:
            return np.abs(np.asarray(image.convert("L"))[-40:, :60] - expected).max()

    assert off(tmp_path / "linear", linear=True) <= 1.0
    assert off(tmp_path / "usual") > 20.0
    answer = CliRunner().invoke(
        cli, ["preview", str(cube), "-o", str(tmp_path / "command"), "--variable", "radiance", "--linear"]
    )
    assert answer.exit_code == 0, answer.output
    for name in ("all_mwir.png", "all_mwir.gif"):
        assert (tmp_path / "command" / name).read_bytes() == (tmp_path / "linear" / name).read_bytes()


def test_a_variable_without_any_value_is_drawn(tmp_path):
    path = tmp_path / "clear.nc"
    clear = {**SMALL, "clouds.coverage": 0.0, "output.variables": ["cloud_top_altitude"], "image.rows": 20}
    simulate(Scenario.load("stratus", clear), path).close()
    assert drawn(path, tmp_path, "cloud_top_altitude") == ["clear_cloud-top-altitude.png"]
    with Image.open(tmp_path / "clear_cloud-top-altitude.png") as picture:
        colours = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    assert np.mean(np.all(colours == ImageColor.getrgb(MISSING), axis=1)) > 0.1
    # Also where nothing is named and the cube has none of the usual ones.
    with pytest.raises(CubeError, match="name a variable; allowed: cloud_top_altitude"):
        drawn(path, tmp_path, None)


def test_an_unknown_variable_gets_those_of_the_cube_and_the_closest(cube, tmp_path):
    folder = tmp_path / "pictures"
    with pytest.raises(CubeError, match=r"no 'radiance_sea_emision'; allowed: .*closest is 'radiance_sea_emission'"):
        drawn(cube, folder, "radiance_sea_emision")
    with pytest.raises(CubeError, match=r"no 'latitude'; allowed"):
        drawn(cube, folder, "latitude")
    with pytest.raises(CubeError, match="not both"):
        drawn(cube, folder, "radiance", kelvin=True)
    assert not folder.exists()


def test_what_the_run_left_out_is_said_with_how_to_have_it(tmp_path):
    path = tmp_path / "mask.nc"
    simulate(Scenario.load("stratus", {**SMALL, "output.variables": ["cloud_mask"]}), path).close()
    with pytest.raises(CubeError, match=r"no 'brightness_temperature'; .*output.variables=\[\"brightness_temp"):
        draw_preview(path, tmp_path, kelvin=True)


@pytest.mark.parametrize("command", ["verify", "preview", "volume"])
@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        (
            "day.toml",
            b"time = 2024-04-20T12:30:00Z\n",
            "not a NetCDF file; if it is a scenario, `hcss run day.toml` makes",
        ),
        ("day.nc", b"time = 2024-04-20T12:30:00Z\n", "not a NetCDF file; a cube is needed, as `hcss run` writes it"),
        ("day.nc", b"", "it is empty; a cube is needed"),
        ("day.nc", b"\x89HDF\r\n\x1a\n and no more", "it is NetCDF, but damaged, truncated or unsupported"),
    ],
)
def test_a_file_that_is_no_cube_is_told_from_one_that_is_damaged(command, name, content, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(content)
    done = CliRunner().invoke(cli, [command, name])
    assert isinstance(done.exception, CubeError)
    assert f"cannot read {name}: " in str(done.exception)
    assert told in str(done.exception)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_the_command_draws_the_variable_it_is_given(cube, tmp_path):
    arguments = ["preview", str(cube), "-o", str(tmp_path), "--variable", "cloud_fraction", "--no-animation", "--json"]
    done = CliRunner().invoke(cli, arguments)
    assert json.loads(done.stdout) == [str(tmp_path / "all_cloud-fraction.png")]
