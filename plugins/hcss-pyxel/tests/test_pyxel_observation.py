"""Pyxel's observations: many exposures, which it computes in several threads."""

import re
import threading

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from hcss_pyxel import load_cube
from hcss_pyxel.cli import cli
from hcss_pyxel.run import run_pipeline

from hcss_twin.providers import HcssError


@pytest.fixture
def pipeline(cube, tmp_path):
    made = CliRunner().invoke(cli, ["example", str(cube), "--band", "mwir", "-o", str(tmp_path / "e")])
    assert made.exit_code == 0, made.output
    return tmp_path / "e" / "pipeline.yaml"


def observed(pipeline, seconds):
    """Make the pipeline one that is observed with several integration times."""
    text = pipeline.read_text()
    readout = text[text.index("  readout:") : text.index("cmos_detector:")]
    parameters = (
        "observation:\n  mode: product\n  parameters:\n"
        "    - key: pipeline.photon_collection.load_cube.arguments.integration_time\n"
        f"      values: {seconds}\n"
    )
    pipeline.write_text(text.replace("exposure:\n" + readout, parameters + readout))


def test_many_threads_see_the_cube_as_one_does(cube, detector):
    """Opening NetCDF files in two threads at once ends a process."""
    made = [detector(time=step % 8 + 1.0) for step in range(48)]

    def look(some):
        for detector_made in some:
            load_cube(detector_made, cube, "mwir", f_number=2.0)

    threads = [threading.Thread(target=look, args=(made[first::6],)) for first in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for step in range(8):
        alone = detector(time=step + 1.0)
        load_cube(alone, cube, "mwir", f_number=2.0)
        for other in made[step::8]:
            np.testing.assert_array_equal(other.photon.array_2d, alone.photon.array_2d)


def test_an_observation_of_integration_times_has_photons_in_proportion(pipeline):
    seconds = [0.001, 0.002, 0.004]
    observed(pipeline, seconds)
    output = pipeline.with_name("result.nc")
    means = run_pipeline(pipeline, output)
    with xr.open_dataset(output) as result:
        photons = result["photon"].mean(("time", "y", "x")).to_numpy().ravel()
        # what was printed is what was written
        assert float(result["photon"].mean()) == pytest.approx(means["photon (Ph)"], rel=1e-12)
    np.testing.assert_allclose(photons / photons[0], [1.0, 2.0, 4.0], rtol=2e-3)


def test_a_result_says_what_it_was_made_of(pipeline, cube):
    output = pipeline.with_name("result.nc")
    run_pipeline(pipeline, output)
    with xr.open_dataset(output) as result, xr.open_dataset(cube) as made:
        assert result.attrs["cube"] == str(cube)
        assert result.attrs["cube_id"] == made.attrs["id"]
        assert result.attrs["pyxel_pipeline"] == pipeline.read_text()
        assert "pyxel-sim 3" in result.attrs["source"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("f_number: 2.0", "fnumber: 2.0", "there is no argument 'fnumber'; allowed: .*closest is 'f_number'"),
        ('band: "mwir"', 'band: "mwir2"', "band: the cube has no 'mwir2'; .*closest is 'mwir'"),
    ],
)
def test_what_the_loader_refuses_is_one_line(pipeline, old, new, message):
    text = pipeline.read_text()
    assert old in text
    pipeline.write_text(text.replace(old, new))
    output = pipeline.with_name("result.nc")
    with pytest.raises(HcssError, match=message):
        run_pipeline(pipeline, output)
    assert not output.exists()


def test_an_example_is_for_the_instrument_asked_for(cube, tmp_path):
    from hcss_pyxel.airy import airy_kernel

    given = ["--pitch", "20", "--f-number", "4", "--full-well", "1e5", "--bits", "12"]
    made = CliRunner().invoke(cli, ["example", str(cube), "--band", "lwir", "-o", str(tmp_path / "e"), *given])
    assert made.exit_code == 0, made.output
    text = (tmp_path / "e" / "pipeline.yaml").read_text()
    for line in ("pixel_vert_size: 20.0", "f_number: 4.0", "full_well_capacity: 100000", "adc_bit_resolution: 12"):
        assert line in text
    np.testing.assert_array_equal(np.load(tmp_path / "e" / "psf.npy"), airy_kernel(11.0, 4.0, 20.0))
    refused = CliRunner().invoke(cli, ["example", str(cube), "-o", str(tmp_path / "f"), "--quantum-efficiency", "70"])
    assert isinstance(refused.exception, HcssError)
    assert "quantum_efficiency: 70; allowed: above 0, at most 1" in str(refused.exception)
    assert not (tmp_path / "f").exists()


def test_a_well_that_a_frame_cannot_fill_is_told_so(cube, tmp_path):
    made = CliRunner().invoke(
        cli, ["example", str(cube), "--band", "mwir", "-o", str(tmp_path / "e"), "--full-well", "1e12"]
    )
    told = re.search(r"fills (\d+)% of the well, the interval of the frames allows no more", made.output)
    assert told is not None
    assert int(told.group(1)) < 66
    assert "integration_time: 1.0  # s; the brightest pixel" in (tmp_path / "e" / "pipeline.yaml").read_text()
