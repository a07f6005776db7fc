"""``hcss evaluate --radiance``: spots are where the image has them, and differences are those of the scenes."""

import json
from datetime import UTC, datetime

import netCDF4
import numpy as np
import pytest
from evaluation_images import hcss
from hcss_evaluate.radiance import blind
from hcss_evaluate.radiance.measured import read_spots

from hcss_twin import CatalogError, ImageError, ScenarioError

LIMITS = {"ir_108": (9.8, 11.8), "ir_120": (11.0, 13.0)}


@pytest.fixture
def measured(tmp_path):
    """Two scenes at two times: clear sea of 295 K with noise, in the second scene a square of opaque cloud at 220 K."""
    rng = np.random.default_rng(1)
    kelvin = 295.0 + 0.1 * rng.standard_normal((2, 2, 128, 128))
    kelvin[:, :, :32] -= 4.0 * rng.random((2, 2, 32, 128))  # broken cloud
    kelvin[1, :, 96:, 96:] = 220.0 + 0.1 * rng.standard_normal((2, 32, 32))
    path = tmp_path / "measured.nc"
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip(("scene", "time", "y", "x"), kelvin.shape, strict=True):
            file.createDimension(name, size)
        for name, colder in (("ir_108", 0.0), ("ir_120", 1.5)):
            variable = file.createVariable(name, "f4", ("scene", "time", "y", "x"))
            variable[:], variable.units = kelvin - colder, "K"
        for name, values in (("latitude", [10.0, -20.0]), ("view_zenith", [30.0, 50.0])):
            file.createVariable(name, "f4", ("scene",))[:] = values
        file.createVariable("longitude", "f4", ("x",))[:] = np.linspace(-30.0, -29.0, 128)
        times = file.createVariable("time", "f8", ("time",))
        times[:], times.units = [0.0, 15.0], "minutes since 2020-09-06 00:00:00"
    return path


def test_spots_have_the_temperatures_places_and_times_of_the_file(measured):
    spots = read_spots(measured, list(LIMITS), "ir_108")
    assert [spot.kind for spot in spots] == ["clear sea"] * 3 + ["opaque cloud", "clear sea", "opaque cloud"]
    sea, cloud = spots[0], spots[-1]
    assert sea.kelvin["ir_108"] == pytest.approx(295.0, abs=0.1)
    assert sea.kelvin["ir_108"] - sea.kelvin["ir_120"] == pytest.approx(1.5, abs=1e-3)
    assert cloud.kelvin["ir_108"] == pytest.approx(220.0, abs=0.2)
    assert (cloud.latitude, cloud.view_zenith) == (-20.0, 50.0)
    assert -29.3 < cloud.longitude < -29.0
    assert cloud.time == datetime(2020, 9, 6, 0, 15, tzinfo=UTC)


def test_differences_are_simulated_less_measured_and_places_without_climatology_are_left_out(monkeypatch, measured):
    def simulated(spot, limits_um, reference, responses):
        assert reference == "ir_108"
        if spot.latitude < 0.0 and spot.kind == "clear sea":
            raise ScenarioError("no ships")
        return {"ir_108": spot.kelvin["ir_108"] + 1.0, "ir_120": spot.kelvin["ir_120"] + spot.time.minute}

    monkeypatch.setattr(blind, "simulated_kelvin", simulated)
    done = blind.blind_test(measured, LIMITS)
    found = {
        (difference.kind, difference.channel): (difference.spots, difference.mean_K, difference.sd_K)
        for difference in done.differences
    }
    assert found["clear sea", "ir_108"] == pytest.approx((2, 1.0, 0.0))
    assert found["clear sea", "ir_120"] == pytest.approx((2, 7.5, 15.0 / np.sqrt(2.0)))
    assert len(done.notes) == 2
    assert done.as_dict()["notes"] == list(done.notes)


def test_the_command_simulates_prints_and_writes_a_page(measured, tmp_path):
    """Clear sea of the tropics is between 285 and 300 K at 10.8 um; an opaque cloud has its own temperature."""
    page = tmp_path / "page.html"
    done = hcss("evaluate", "--radiance", measured, "--channel", "ir_108", "--spots", "1", "-o", page)
    assert done.exit_code == 0, done.output
    row = next(line for line in done.output.splitlines() if "opaque cloud" in line and "ir_108" in line)
    assert abs(float(row.split()[-2])) < 1.0
    row = next(line for line in done.output.splitlines() if "clear sea" in line and "ir_108" in line)
    assert -10.0 < float(row.split()[-2]) < 5.0
    assert "Simulated / measured brightness temperature" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("form", ["um", "cm-1", "several columns", "no labels"])
def test_a_channel_has_the_response_of_its_file_in_any_unit(form, measured, tmp_path):
    """A rectangle as a file gives what the limits give; a response that ends elsewhere gives something else."""
    low, high = LIMITS["ir_108"]
    file = tmp_path / "srf.txt"
    file.write_text(
        {
            "um": f"wavelength_um,response\n{low},1\n{high},1\n",
            "cm-1": f"wavenumber (cm-1)   SRF\n{1e4 / high:.9f}  1.0\n{1e4 / low:.9f}  1.0\n",
            "no labels": f"{1e4 / high:.9f}  1.0\n{1e4 / low:.9f}  1.0\n",
            "several columns": f"Wavelength (nm),B1,B2\n{1e3 * low},0.2,1\n{1e3 * high},1,1\n",
        }[form]
    )
    named = f"{file}{ {'several columns': ':B2', 'no labels': '@cm-1'}.get(form, '') }"
    answers = []
    for channel in (f"ir_108={low}-{high}", f"ir_108={named}"):
        done = hcss("evaluate", "--radiance", measured, "--channel", channel, "--spots", "1", "--json", tmp_path / "a")
        assert done.exit_code == 0, done.output
        answers.append(json.loads((tmp_path / "a").read_text())["differences"])
        (tmp_path / "a").unlink()
    assert [each["mean_K"] for each in answers[1]] == pytest.approx([each["mean_K"] for each in answers[0]], abs=0.01)
    assert f"{low:g}-{high:g} (half power), srf.txt" in done.output
    assert ("by its label" in done.output) == (form in ("cm-1", "several columns"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--radiance", "{file}"), "SIM: allowed without --radiance only"),
        (("--radiance", "--method", "otsu"), "--method: allowed without --radiance only"),
        (("--radiance", "--paired"), "--paired: allowed with --realism only"),
        (("{file}", "--spots", "3"), "--spots: allowed with --radiance only"),
        (("--radiance", "--channel", "ir_108=11-9"), "'ir_108=11-9' given, allowed: a variable"),
        (("--radiance", "--channel", "ir_108=none.txt"), "allowed: a variable, or with limits in um"),
        ((), "Missing argument 'SIM'"),
    ],
)
def test_options_of_another_test_are_refused(measured, options, message):
    done = hcss("evaluate", measured, *(option.format(file=measured) for option in options))
    assert done.exit_code == 2
    assert message in done.output


def test_files_without_channels_or_places_are_named(measured, tmp_path):
    with pytest.raises(ImageError, match=r"no channel contains 10.8 um"):
        blind.blind_test(measured, {"ir_120": (11.0, 13.0)})
    with pytest.raises(CatalogError, match="no variable 'ir_087'"):
        blind.blind_test(measured, {**LIMITS, "ir_087": (8.3, 9.1)})
    with pytest.raises(ImageError, match=r"channel 'ir_109': not known, .* or ir_109=LOW-HIGH in um"):
        blind.channel_limits("ir_109")
