"""The page of a sweep: its points and their means, from the folder and from the dataset alike."""

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from hcss_sweep import SweepError, points, sweep
from hcss_sweep.points import PointOutcome, compute
from pages import read_page

import hcss_twin
from hcss_twin import brightness_temperature, open_cube

SMALL = {**CHEAP, "image.rows": 12, "image.columns": 16, "frames.count": 2, "bands": NARROW, "output.certificate": 1}
MASK = {"output.variables": ["cloud_mask"]}
OVER = {"view.zenith": [0, 30], "clouds.type": ["stratus", "cumulus"]}


def swept(folder, over=None, **more):
    over, changes = over or OVER, SMALL | more.pop("changes", {})
    overrides = {key: value for key, value in changes.items() if key not in over}
    return sweep("stratus", folder, over=over, overrides=overrides, **more)


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    return swept(folder / "out", dataset=folder / "all.nc")


@pytest.fixture(scope="module")
def pages(result):
    return {kind: read_page(hcss_twin.report(path)) for kind, path in (("f", result.folder), ("d", result.dataset))}


@pytest.mark.parametrize("kind", ["f", "d"])
def test_points_have_their_values_certificates_and_means(result, pages, kind):
    rows = pages[kind].table("point", "view.zenith", "clouds.type", "state", "certificate")
    assert len(rows) == 4
    for row, record in zip(rows, result.points, strict=True):
        assert row[:4] == [str(record.point), f"{record.values['view.zenith']:g}", record.values["clouds.type"], "done"]
        assert row[4].startswith("computed as specified, within ")
        with open_cube(result.folder / record.file) as cube:
            kelvin = brightness_temperature(cube).sel(band=["lwir", "mwir"])  # that with most to see first
            means = [data.astype(float).mean(["y", "x"]).mean("time").to_numpy() for data in (kelvin, cube.radiance)]
        np.testing.assert_allclose([float(cell) for cell in row[5:9]], np.concatenate(means), rtol=5e-5)


@pytest.mark.parametrize("kind", ["f", "d"])
def test_axes_pictures_and_provenance_are_told(pages, kind):
    found = pages[kind]
    axes = {row[0]: row[1:] for row in found.table("key", "values", "which")}
    assert axes == {"view.zenith": ["2", "0, 30"], "clouds.type": ["2", "stratus, cumulus"]}
    pictures = [attributes["alt"] for tag, attributes in found.elements if tag == "img"]
    for band in ("mwir", "lwir"):
        assert f"brightness temperature {band}, view.zenith 30, clouds.type cumulus" in pictures
    assert "Mean of radiance against view.zenith" in pictures
    assert "None." in found.text
    assert "cloud_types/stratus.toml" in found.text


def test_both_say_the_same_of_points(pages):
    header = ("point", "view.zenith", "clouds.type", "state", "certificate")
    assert pages["f"].table(*header) == pages["d"].table(*header)


def test_failed_points_stand_with_their_errors(tmp_path, monkeypatch):
    def faulty(task, shelf):
        return PointOutcome(task.point, error="out <of> luck") if task.point == 1 else compute(task, shelf)

    monkeypatch.setattr(points, "compute", faulty)
    result = swept(tmp_path / "out", {"seed": [1, 2]}, dataset=tmp_path / "out" / "all.nc", changes=MASK)
    for path in (result.folder, result.dataset):
        found = read_page(hcss_twin.report(path))
        assert found.table("point", "values", "error") == [["1", "seed 2", "out <of> luck"]]
        assert [row[2] for row in found.table("point", "seed", "state")] == ["done", "failed"]
        assert "points failed" in found.text
    moved = result.dataset.rename(tmp_path / "all.nc")
    assert "the error is in the index" in read_page(hcss_twin.report(moved)).text


def test_a_cube_that_is_gone_and_an_index_that_is_none_are_told(tmp_path):
    result = swept(tmp_path / "out-0.5", {"seed": [1, 2]}, changes=MASK)
    (result.folder / "point-0001.nc").unlink()
    page = hcss_twin.report(result.folder)
    assert page == tmp_path / "out-0.5.html"
    found = read_page(page)
    assert len(found.table("point", "seed")) == 2
    assert "point-0001.nc" in found.text
    (result.folder / "index.json").write_text("[]")
    with pytest.raises(SweepError, match="not a sweep index"):
        hcss_twin.report(result.folder, replace=True)
