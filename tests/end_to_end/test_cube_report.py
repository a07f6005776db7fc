"""Every number and every pixel on the page of a cube is the cube's; pages hold everything and stay small."""

import json
import math
import re

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from click.testing import CliRunner
from example_cube import example_frame, example_header
from pages import ends, read_page, ticks, view_of

import hcss_twin
from hcss_twin import HcssError, Scenario, open_cube, sense, simulate
from hcss_twin.cli.main import cli
from hcss_twin.cube.header import BandInfo
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.reports import cube_frames
from hcss_twin.reports.colour_scale import LEVELS
from hcss_twin.reports.cube_frames import Reader

MASK = tuple(expand(["cloud_mask"], {}))
"""Of a cube without curves, for what is not about them."""

SMALL = {
    **CHEAP,
    "image.rows": 30,
    "image.columns": 44,
    "frames.count": 3,
    "frames.interval": 60.0,
    "bands": NARROW,
    "output.certificate": 4,
}


def made(folder, name="cube.nc", scenario="stratus", **changes):
    simulate(Scenario.load(scenario, SMALL | changes), folder / name).close()
    return folder / name


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    return made(tmp_path_factory.mktemp("cube"), **{"output.variables": ["all"]})


@pytest.fixture(scope="module")
def page(cube):
    return hcss_twin.report(cube)


def written(path, frames=3, **changes):
    """Write a cube of random numbers."""
    times = tuple(0.5 * frame for frame in range(frames))
    header = example_header(
        frame_times_s=times,
        solar_zenith_deg=tuple(24.0 for _ in times),
        solar_azimuth_deg=tuple(180.0 for _ in times),
        **changes,
    )
    with CubeWriter(path, header) as writer:
        for frame in range(frames):
            writer.write_frame(frame, example_frame(header, frame))
    return path


def test_a_page_is_one_file_beside_its_cube_that_needs_nothing_else(cube, page):
    assert page == cube.with_suffix(".html")
    found = read_page(page)
    with open_cube(cube) as data:
        assert data.attrs["title"] in found.text
    for title in ("Frames", "Scene", "Certificate", "Plan and approximations", "Provenance"):
        assert title in found.text
    assert page.stat().st_size < 2_000_000


def test_every_pixel_shown_is_the_cubes_within_half_a_shade(cube, page):
    """On linear scales; on stretched ones every pixel is on the right side of every tick of its colour bar."""
    view = view_of(page)
    shades = LEVELS - 1
    with open_cube(cube) as data:
        assert set(view) - {"frames"} == set(data.data_vars)
        for name in data.data_vars:
            for part in view[name]["parts"]:
                planes = data[name].isel(which(view[name], part)).to_numpy().astype(float)
                shown = np.stack(part["pictures"]).astype(float)
                missing = np.isnan(planes)
                np.testing.assert_array_equal(shown[missing], LEVELS)
                if "more contrast" in part["bar"]:
                    for value, share in ticks(part["bar"]):
                        assert np.all(shown[planes <= value] <= shades * share + 0.51), name
                        assert np.all(shown[planes >= value] >= shades * share - 0.51), name
                    order = np.argsort(planes, axis=None)
                    assert np.all(np.diff(shown.ravel()[order]) >= 0.0), name
                    continue
                flags = "flag_values" in data[name].attrs
                low, high = (0.0, 1.0) if flags else ends(part["bar"])
                share = np.clip((planes - low) / (high - low), 0.0, 1.0)
                # the ends are printed with five digits
                slack = 0.501 + shades * 1e-4 * max(abs(low), abs(high)) / (high - low)
                assert np.abs(shown - shades * share)[~missing].max() <= slack, name


def which(quantity, part):
    return {} if part["name"] == "" else {quantity["dim"]: part["number"]}


def test_numbers_of_each_frame_and_of_all_are_the_cubes(cube, page):
    view = view_of(page)
    rows = {(row[0], row[1]): row[2:] for row in read_page(page).table("quantity", "band or layer")}
    with open_cube(cube) as data:
        for name in data.data_vars:
            for part in view[name]["parts"]:
                planes = data[name].isel(which(view[name], part)).to_numpy().astype(float)
                for plane, numbers in zip(planes, part["numbers"], strict=True):
                    assert numbers["mean"] == f"{np.nanmean(plane):.5g}"
                    assert numbers["lowest"] == f"{np.nanmin(plane):.5g}"
                    assert numbers["highest"] == f"{np.nanmax(plane):.5g}"
                mean = np.mean([np.nanmean(plane) for plane in planes])
                told = ["3", *(f"{each:.5g}" for each in (mean, np.nanmin(planes), np.nanmax(planes)))]
                assert rows[view[name]["label"], part["name"]][:4] == told


def test_frames_are_told_with_their_time_and_sun(cube, page):
    frames = view_of(page)["frames"]
    with open_cube(cube) as data:
        assert [each["number"] for each in frames] == [0, 1, 2]
        assert [each["time"] for each in frames] == ["t = 0 s", "t = 60 s", "t = 120 s"]
        for each, time, zenith in zip(frames, data.time.to_numpy(), data.solar_zenith_angle.to_numpy(), strict=True):
            assert each["instant"].startswith(np.datetime_as_string(time, unit="s"))
            assert f"{zenith:.2f}°" in each["sun"]


def test_without_a_script_the_first_frame_of_every_band_is_there(page):
    found = read_page(page)
    stills = [attributes for tag, attributes in found.elements if tag == "img" and "first frame" in attributes["alt"]]
    bands = ("lwir", "mwir")  # that with most to see first
    assert [still["alt"] for still in stills] == [f"brightness temperature {band}, first frame" for band in bands]
    assert ".viewer:not(.live) .controls" in page.read_text(encoding="utf-8")


def test_certificate_and_ledger_are_those_of_the_cube(cube, page):
    found = read_page(page)
    with open_cube(cube) as data:
        attributes = data.attrs
    achieved = json.loads(attributes["hcss_accuracy_achieved"])
    asked, estimated = (f"{attributes[f'hcss_{key}']:.3g}" for key in ("accuracy_requested", "table_error_estimated"))
    rows = found.table("band", "requested", "estimated", "achieved")
    assert rows == [[band, asked, estimated, f"{error:.3g}"] for band, error in achieved.items()]
    assert "computed as specified" in found.text
    for part in attributes["hcss_certificate"].split("; "):
        assert part in found.text
    strata = json.loads(attributes["hcss_certificate_strata"])
    kinds = found.table("kind of pixel")
    assert [row[:3] for row in kinds] == [[each["name"], str(each["pixels"]), str(each["checked"])] for each in strata]
    skipped = json.loads(attributes["hcss_skipped"])
    ledger = {row[0]: row[1:] for row in found.table("what", "at most", "typical", "why")}
    assert set(ledger) == {each["what"] for each in skipped}
    for each in skipped:
        bound, typical, why = ledger[each["what"]]
        assert typical.endswith(f"({each['sense']})") if each["estimate"] is not None else typical == ""
        assert why == each["why"]
        if each["bound"] is None:
            assert bound == "unknown"
        elif each["bound"] == 0.0:
            assert bound == "nothing"
        else:
            share = float(bound.split()[0]) * (1.0 if bound.endswith("x") else 0.01)
            assert share == pytest.approx(each["bound"], rel=0.06)


@pytest.mark.parametrize("verdict", ["NOT as specified", "FAILED"], ids=["now", "earlier version"])
def test_a_cube_not_as_specified_is_marked_at_once(tmp_path, verdict):
    header = {"hcss_certificate": f"{verdict}: 3 of 24 pixels exceed; mwir", "hcss_accuracy_requested": 1e-3}
    path = written(tmp_path / "c.nc", attributes=header, variables=MASK)
    found = read_page(hcss_twin.report(path))
    assert "NOT as specified" in found.text
    assert any(attributes.get("class") == "badge bad" for _, attributes in found.elements)


def test_the_page_of_a_cube_says_how_many_kelvin_computed_as_specified_is(page):
    assert re.search(r"computed as specified, within [\d.e-]+ K", read_page(page).text)


def test_provenance_is_whole(cube, page):
    found = read_page(page)
    with open_cube(cube) as data:
        for name, digest in json.loads(data.attrs["hcss_files_sha256"]).items():
            assert [name, digest] in found.table("file", "SHA-256")
        assert data.attrs["hcss_scenario"] in found.text
        for name, version in json.loads(data.attrs["hcss_versions"]).items():
            assert f"{name} {version}" in found.text
        assert data.attrs["id"] in found.text


def angle(line):
    """Angle of a line from the vertical, upward 0, to the right 90 degrees."""
    x, y = (float(line[f"{axis}2"]) - float(line[f"{axis}1"]) for axis in "xy")
    return math.degrees(math.atan2(x, -y)) % 360.0


@pytest.mark.parametrize(("azimuth", "sign"), [(10.0, -1.0), (200.0, 1.0), (300.0, -1.0)])
def test_the_scene_is_drawn_to_its_angles(tmp_path, azimuth, sign):
    path = written(tmp_path / "c.nc", view_zenith_deg=33.0, view_azimuth_deg=azimuth, variables=MASK)
    lines = {
        attributes["class"]: attributes
        for tag, attributes in read_page(hcss_twin.report(path)).elements
        if tag == "line" and "class" in attributes
    }
    assert angle(lines["view-ray"]) == pytest.approx(33.0, abs=0.01)
    # drawn from the sun to the sea; its bearing is 180, so that only a view to the south is on its side
    assert (angle(lines["sun-ray"]) + 180.0) % 360.0 == pytest.approx(sign * 24.0 % 360.0, abs=0.01)
    assert angle(lines["view-bearing"]) == pytest.approx(azimuth, abs=0.01)
    assert angle(lines["sun-bearing"]) == pytest.approx(180.0, abs=0.01)


def test_cloud_layers_stand_at_the_altitudes_of_their_type(page):
    assert "stratus 33 to 1000 m" in read_page(page).text


# --- cubes of other kinds


def test_cubes_without_radiance_and_zarr_stores_have_pages(tmp_path):
    mask = made(tmp_path, "mask.nc", **{"output.variables": ["cloud_mask"]})
    view = view_of(hcss_twin.report(mask))
    assert set(view) == {"cloud_mask", "frames"}
    with open_cube(mask) as data:
        np.testing.assert_array_equal(
            np.stack(view["cloud_mask"]["parts"][0]["pictures"]) == LEVELS - 1, data.cloud_mask == 1
        )
    assert "no radiance that could be checked" in read_page(mask.with_suffix(".html")).text
    store = made(tmp_path, "store.zarr", **{"output.variables": ["cloud_mask"]})
    page = hcss_twin.report(store)
    assert page == tmp_path / "store.html"
    again = view_of(page)
    assert again["cloud_mask"]["parts"][0]["png"] == view["cloud_mask"]["parts"][0]["png"]


def test_a_cube_without_frames_says_so(tmp_path):
    names = {"output.variables": ["geometry"], "platform.altitude": 7e5}
    found = read_page(hcss_twin.report(made(tmp_path, **names)))
    assert "holds no variable with frames" in found.text
    assert "700 km above the ellipsoid" in found.text


def test_a_measured_cube_shows_its_sensor_and_whose_the_certificate_is(tmp_path):
    clean = made(tmp_path, **{"bands": NARROW[:1], "frames.count": 1})
    sense(clean, sensor="generic-mwir", output=tmp_path / "measured.nc").close()
    found = read_page(hcss_twin.report(tmp_path / "measured.nc"))
    for text in ("Measured cube", "generic staring mid-wave imager", "that of the clean cube", "one frame"):
        assert text in found.text


# --- what is left out


def test_of_many_frames_some_are_shown_the_ends_among_them(tmp_path):
    path = written(tmp_path / "c.nc", frames=60, variables=tuple(expand(["radiance", "cloud_mask"], {})))
    page = hcss_twin.report(path)
    view = view_of(page)
    numbers = [view["frames"][place]["number"] for place in view["radiance"]["frames"]]
    assert len(numbers) == cube_frames.FRAMES
    assert numbers[0] == 0
    assert numbers[-1] == 59
    steps = np.diff(numbers)
    assert steps.max() - steps.min() <= 1
    assert len(view["cloud_mask"]["frames"]) == cube_frames.OTHER_FRAMES
    assert "radiance (24 of 60 frames, evenly spread" in read_page(page).text
    with open_cube(path) as data:
        for place, number in zip(range(24), numbers, strict=True):
            mean = float(data.radiance[number, 1].mean(dtype="float64"))
            assert view["radiance"]["parts"][1]["numbers"][place]["mean"] == f"{mean:.5g}"


@pytest.mark.parametrize(("count", "wanted"), [(1, 24), (7, 24), (24, 24), (25, 24), (2000, 24), (5, 1)])
def test_spread_numbers_are_distinct_and_as_many_as_wanted(count, wanted):
    found = Reader.spread(count, wanted)
    assert len(found) == min(count, wanted)
    assert sorted(set(found)) == found
    assert found[0] == 0
    assert found[-1] == (count - 1 if len(found) > 1 else 0)


def test_of_large_frames_single_pixels_are_read_and_numbers_are_theirs(tmp_path, monkeypatch):
    monkeypatch.setattr(cube_frames, "READ_PIXELS", 100)
    path = written(tmp_path / "c.nc", rows=50, columns=70, variables=tuple(expand(["radiance", "cloud_mask"], {})))
    planes = []
    plane_of = Reader.plane

    def watched(*arguments):
        planes.append(plane_of(*arguments))
        return planes[-1]

    monkeypatch.setattr(Reader, "plane", watched)
    page = hcss_twin.report(path)
    assert max(plane.size for plane in planes) <= 120
    view = view_of(page)
    with open_cube(path) as data:
        plane = data.radiance[2, 0, ::6, ::6]
        assert view["radiance"]["parts"][0]["numbers"][2]["mean"] == f"{float(plane.mean(dtype='float64')):.5g}"
    assert "every 6th row and column" in read_page(page).text


def test_of_frames_that_would_take_too_long_to_read_fewer_are_shown(tmp_path, monkeypatch):
    path = written(tmp_path / "c.nc", frames=20, variables=tuple(expand(["radiance"], {})))
    with open_cube(path) as data:
        frame = data.radiance[0].nbytes
    monkeypatch.setattr(cube_frames, "READ_BYTES", 10 * frame)
    view = view_of(hcss_twin.report(path))
    assert len(view["radiance"]["frames"]) == 5


def test_where_space_is_short_pictures_are_means_over_squares(tmp_path, monkeypatch):
    path = written(tmp_path / "c.nc", rows=50, columns=71, variables=tuple(expand(["radiance", "cloud_mask"], {})))
    monkeypatch.setattr(cube_frames, "PICTURE_BYTES", 6000)
    monkeypatch.setattr(cube_frames, "is_stretched", lambda name: False)
    page = hcss_twin.report(path)
    view = view_of(page)
    total = sum(len(png) * 3 / 4 for q in ("radiance", "cloud_mask") for p in view[q]["parts"] for png in p["png"])
    assert total < 6100
    shown = view["radiance"]["parts"][0]["pictures"][1]
    side = math.ceil(50 / shown.shape[0])
    assert side > 1
    assert f"means over {side} x {side} pixels" in read_page(page).text
    low, high = ends(view["radiance"]["parts"][0]["bar"])
    with open_cube(path) as data:
        plane = data.radiance[1, 0].to_numpy().astype(float)
    last = (shown.shape[0] - 1) * side, (shown.shape[1] - 1) * side
    for row, column in ((0, 0), (side, 2 * side), last):
        mean = plane[row : row + side, column : column + side].mean()
        expected = np.clip((mean - low) / (high - low), 0, 1) * (LEVELS - 1)
        place = shown[row // side, column // side]
        assert place == pytest.approx(expected, abs=0.51)


@pytest.mark.long
def test_the_page_of_a_large_cube_of_noise_is_no_larger_than_ten_megabytes(tmp_path):
    bands = tuple(BandInfo(f"b{number}", 3.0 + number, 4.0 + number, 3.5 + number) for number in range(3))
    path = written(tmp_path / "c.nc", frames=24, rows=240, columns=320, bands=bands)
    page = hcss_twin.report(path)
    assert 3e6 < page.stat().st_size < 10.5e6


# --- the command


def test_the_command_writes_and_replaces_only_when_told(tmp_path):
    cube = written(tmp_path / "c.nc", variables=MASK)
    target = tmp_path / "page.html"
    first = CliRunner().invoke(cli, ["report", str(cube), "-o", str(target), "--json"])
    assert json.loads(first.output) == {"report": str(target), "bytes": target.stat().st_size}
    before = target.read_bytes()
    again = CliRunner().invoke(cli, ["report", str(cube), "-o", str(target)])
    assert isinstance(again.exception, HcssError)
    assert "--force" in str(again.exception)
    assert CliRunner().invoke(cli, ["report", str(cube), "-o", str(target), "--force"]).exit_code == 0
    assert target.read_bytes() == before
    over = CliRunner().invoke(cli, ["report", str(cube), "-o", str(cube), "--force"])
    assert "it is an input of this command" in str(over.exception)
    with open_cube(cube) as data:
        assert "cloud_mask" in data


def test_what_there_is_no_report_of_is_told_with_what_is_allowed(tmp_path):
    for name, text in (("a.toml", "x = 1"), ("b.nc", ""), ("c.nc", "no NetCDF")):
        (tmp_path / name).write_text(text)
    (tmp_path / "folder").mkdir()
    told = {
        "a.toml": "`hcss run .*a.toml` computes its cube",
        "b.nc": "it is empty",
        "c.nc": "not a NetCDF file",
        "folder": "without index.json",
        "d.nc": "no such file",
    }
    for name, message in told.items():
        with pytest.raises(HcssError, match=message) as caught:
            hcss_twin.report(tmp_path / name)
        assert re.search("allowed: a cube .*sweep.*posterior", str(caught.value))
    assert not list(tmp_path.glob("*.html"))


def test_other_netcdf_and_unfinished_cubes_are_refused(tmp_path):
    import netCDF4

    with netCDF4.Dataset(tmp_path / "other.nc", "w") as file:
        file.title = "x"
    with pytest.raises(HcssError, match="NetCDF without"):
        hcss_twin.report(tmp_path / "other.nc")


def evidence_of(cube, *options):
    """The page of a cube's evidence, and the answer of the command."""
    page = cube.with_suffix(".evidence.html")
    done = CliRunner().invoke(cli, ["report", "--evidence", str(cube), "--force", "--json", *options])
    assert done.exit_code == 0, done.output
    return read_page(page), json.loads(done.output)["evidence"]


def test_the_evidence_of_a_cube_has_its_certificate_budget_and_comparisons(tmp_path):
    cube = made(tmp_path, **{"frames.count": 1})
    page, answer = evidence_of(cube)
    with open_cube(cube) as opened:
        budget = json.loads(opened.attrs["hcss_error_budget"])
        achieved = json.loads(opened.attrs["hcss_accuracy_achieved"])
        pixels = int(opened.attrs["hcss_certificate_pixels"])
    assert answer["certificate"]["largest_error"] == achieved
    assert answer["certificate"]["certificate_pixels"] == pixels
    assert f"{pixels} random pixels were recomputed" in page.text
    totals = {(row["class"], row["band"]): row["relative"] for row in answer["budget"] if row["model"] == "total"}
    assert totals == {
        (of, band): cell.get("total", cell.get("at_least"))
        for of, bands in budget.items()
        for band, cell in bands.items()
    }
    assert len(page.table("class", "band", "model")) == len(answer["budget"])
    assert len(page.table("quantity", "reference")) == len(answer["comparisons"])
    assert {"day", "water", "type paper-stratus"} <= set(answer["scene"])
    assert "No measurement supports these sunlit quantities of the scene: Sunlight reflected by clouds" in page.text


def test_the_evidence_of_a_night_has_no_sunlight_and_that_of_ice_its_crystals(tmp_path):
    cube = made(tmp_path, scenario="cirrus", **{"frames.count": 1, "time": "2024-04-20T23:30:00+10:00"})
    page, answer = evidence_of(cube)
    assert "sunlit quantities" not in page.text
    assert not [row["quantity"] for row in answer["support"] if row["quantity"].startswith("Sunlight")]
    assert "Optics of ice crystals" in page.text


def test_a_cube_without_a_certificate_says_so_in_its_evidence(tmp_path):
    cube = made(tmp_path, **{"frames.count": 1, "output.certificate": 0})
    page, answer = evidence_of(cube)
    assert "The cube has no certificate: no pixel was recomputed." in page.text
    assert answer["budget"] == []


def test_evidence_is_of_cubes_only_and_does_not_replace_the_report(tmp_path):
    cube = made(tmp_path, **{"frames.count": 1, "output.variables": ["cloud_mask"]})
    evidence_of(cube)
    assert not cube.with_suffix(".html").exists()
    with pytest.raises(HcssError, match=r"evidence\.html exists"):
        hcss_twin.report(cube, evidence=True)
    (tmp_path / "sweep").mkdir()
    (tmp_path / "sweep" / "index.json").write_text("{}")
    with pytest.raises(HcssError, match=r"no evidence of .*sweep: it is not a cube; allowed: a cube"):
        hcss_twin.report(tmp_path / "sweep", evidence=True)
