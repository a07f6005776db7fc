"""The page of a propagation: every number is that of its file."""

import re

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP, NARROW
from hcss_uncertainty import propagate
from hcss_uncertainty.dataset import open_propagation
from hcss_uncertainty.tables import with_error
from pages import read_page
from posterior_example import example_posterior

import hcss_twin
from hcss_twin.core.errors import HcssError

SMALL = CHEAP | {"image.rows": 36, "image.columns": 36, "frames.count": 1, "bands": NARROW}
QUANTILES = {"5 %": 1, "50 %": 4, "95 %": 7}


def propagated(folder, draws=8):
    path = folder / "stratus.propagation.nc"
    propagate(
        "stratus",
        path,
        draws=draws,
        posterior=example_posterior(folder / "posterior.nc"),
        uncertain={"sea.temperature": "normal:291:0.5"},
        overrides=SMALL,
    )
    return path


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return propagated(tmp_path_factory.mktemp("propagation"))


@pytest.fixture(scope="module")
def page(path):
    return read_page(hcss_twin.report(path))


@pytest.fixture(scope="module")
def data(path):
    with open_propagation(path) as opened:
        return opened.load()


def expect(cell, value, error=None):
    """A cell says a number, to half of its last digit, and its error, likewise."""
    words = cell.split(" ± ")
    if not np.isfinite(value):
        assert words == ["-"]
        return
    if error is not None and np.isfinite(error) and error > 0.0:
        assert len(words) == 2, cell
    for word, number in zip(words, (value, error), strict=False):
        digits = re.fullmatch(r"-?\d+(?:\.(\d*))?(?:e([+-]\d+))?", word)
        last = 10.0 ** (int(digits[2] or 0) - len(digits[1] or ""))
        # what is written with five digits may have lost zeros at its end
        allowed = 0.5001 * last if len(words) == 2 else max(5.001e-5 * abs(number), 1e-12)
        assert abs(float(word) - number) <= allowed, (cell, value, error)


def tables(page, first):
    return [[table[0], *table[1:]] for table in page.tables if table[0][0] == first]


def moments(header, row, at, name):
    """Check mean, standard deviation and quantiles of a row; ``at`` is the file at one output."""
    cells = dict(zip(header, row, strict=True))
    assert int(cells["scenes"]) == int(at[f"{name}_scenes"])
    spread = float(at[f"{name}_standard_deviation"])
    varies = spread > 1e-7 * abs(float(at[f"{name}_mean"]))
    for label, statistic in (("mean", "mean"), ("standard deviation", "standard_deviation")):
        value, error = (float(at[f"{name}_{statistic}{end}"]) for end in ("", "_error"))
        expect(cells[label], value if varies or statistic == "mean" else 0.0, error if varies else None)
    for label, quantile in QUANTILES.items():
        value, error = (float(at[f"{name}_quantile{end}"][quantile]) for end in ("", "_error"))
        expect(cells[label], value, error if varies else None)


def test_spread_by_band_and_class_is_that_of_the_file(page, data):
    found = [table for table in tables(page, "class") if table[0][1] == "scenes"]
    order = [(name, band) for name in ("brightness_temperature", "radiance") for band in data["band"].values]
    assert len(found) == len(order) == 4
    for (name, band), (header, *rows) in zip(order, found, strict=True):
        assert [row[0] for row in rows] == data["class"].values.tolist()
        for row in rows:
            at = data.sel({"band": band, "class": row[0]})
            moments(header, row, at, name)
            expect(row[header.index("of a pixel")], float(at[f"{name}_pixel_standard_deviation"]))


def test_all_quantiles_are_those_of_the_file(page, data):
    found = [table for table in tables(page, "class") if table[0][1] == "of"]
    order = [(name, band) for name in ("brightness_temperature", "radiance") for band in data["band"].values]
    for (name, band), (header, *rows) in zip(order, found, strict=True):
        assert header[2:] == [f"{100 * value:g} %" for value in data["quantile"].values]
        for row in rows:
            at = data.sel({"band": band, "class": row[0]})
            kind = f"{name}_quantile" if row[1] == "mean of a class" else f"{name}_pixel_quantile"
            for number, cell in enumerate(row[2:]):
                error = float(at[f"{kind}_error"][number]) if row[1] != "pixel" else None
                expect(cell, float(at[kind][number]), error)


def test_shares_of_the_variance_are_those_of_the_file_and_none_is_missing(page, data):
    found = tables(page, "source")
    outputs = [(name, band) for name in ("radiance", "brightness_temperature") for band in (0, 1)]
    for (name, band), (header, *rows) in zip([*outputs, ("metric", None)], found, strict=True):
        one = data if band is None else data.isel(band=band)
        columns = [value.replace("_", " ") for value in data["metric_name" if band is None else "class"].values]
        assert header == ["source", "share", "estimated by", *columns]
        told = set()
        for source, share, by, *cells in rows:
            order = share.replace("-", "_")
            told.add((source, order))
            at = one.sel(source=source)
            assert by == str(at[f"{order}_estimator"].item()) != "none"
            values, errors = (at[f"{name}_{order}{end}"].values for end in ("", "_error"))
            for cell, value, error in zip(cells, values, errors, strict=True):
                assert cell == (f"{value:.2f} ± {error:.2f}" if np.isfinite(value) else "-")
        estimated = {
            (str(source), order)
            for order in ("first_order", "total")
            for source in data["source"].values
            if str(data[f"{order}_estimator"].sel(source=source).item()) != "none"
        }
        assert told == estimated


def test_metrics_and_classes_are_those_of_the_file(page, data):
    ((header, *rows),) = tables(page, "metric")
    for row, name in zip(rows, data["metric_name"].values, strict=True):
        assert row[0] == name.replace("_", " ")
        moments(header, row, data.sel(metric_name=name), "metric")
    ((header, *rows),) = tables(page, "fraction of the pixels")
    for row in rows:
        moments(header, row, data.sel({"class": row[0]}), "class_fraction")
    for name, (header, *rows) in zip(("brightness_temperature", "radiance"), tables(page, "band"), strict=True):
        for row in rows:
            moments(header, row, data.sel({"band": row[0], "class": "all"}), f"{name}_spread")


def test_inputs_their_correlations_and_every_draw_are_those_of_the_file(page, data):
    values = data["input_value"].values
    rows = page.table("input", "drawn from")
    names = data["input"].values.tolist()
    assert [row[0] for row in rows] == names == ["H", "Lx", "Ly", "coverage", "sea.temperature"]
    assert [row[1] for row in rows] == ["posterior"] * 4 + ["normal: mean 291.0, standard deviation 0.5"]
    for row, draws in zip(rows, values.T, strict=True):
        for cell, number in zip(
            row[2:], (draws.mean(), draws.std(ddof=1), draws.min(), np.median(draws), draws.max()), strict=True
        ):
            assert float(cell) == pytest.approx(number, rel=5.1e-5)
    matrix = np.corrcoef(values, rowvar=False)
    assert page.table("correlation") == [
        [name, *(f"{value:.2f}" for value in row)] for name, row in zip(names, matrix, strict=True)
    ]
    for draw, row in enumerate(page.table("draw", "seed")):
        assert row[:3] == [str(draw), *(str(seed) for seed in data["scene_seed"].values[:, draw])]
        np.testing.assert_allclose([float(value) for value in row[3:]], values[draw], rtol=1e-8)


def test_scenes_tables_and_provenance_are_told_and_each_band_has_its_drawings(page, data):
    for text in (
        "8 draws", "sets of radiance tables8", "scenes16", "draws, other seed", "regression", data.attrs["title"],
        data.attrs["posterior_sha256"], "ab" * 32, f"seed{data.attrs['seed']}", "unbounded sky",
    ):  # fmt: skip
        assert text in page.text, text
    pictures = [attributes["alt"] for tag, attributes in page.elements if tag == "img"]
    for band in ("mwir", "lwir"):
        assert f"draws of brightness temperature, {band}" in pictures
        assert f"draws of radiance, {band}" in pictures
        assert f"shares of the variance of radiance, {band}" in pictures
    assert {"draws of image metrics", "draws of the inputs"} <= set(pictures)


def test_two_draws_are_too_few_for_shares_and_the_page_says_so(tmp_path):
    path = tmp_path / "few.nc"
    small = SMALL | {"image.rows": 8, "image.columns": 8, "bands": NARROW[1:]}
    propagate("stratus", path, draws=2, uncertain={"clouds.parameters.H": "uniform:0.3:0.6"}, overrides=small)
    found = read_page(hcss_twin.report(path))
    assert "too few draws" in found.text


def test_a_damaged_file_is_told_and_leaves_no_page(path, tmp_path):
    with netCDF4.Dataset(path) as file:
        version = file.hcss_propagation_version
    broken = tmp_path / "broken.nc"
    with netCDF4.Dataset(broken, "w") as file:
        file.hcss_propagation_version = version
    with pytest.raises(HcssError, match="damaged: it has no input_value"):
        hcss_twin.report(broken)
    with netCDF4.Dataset(broken, "w") as file:
        file.hcss_propagation_version = version + 1
    with pytest.raises(HcssError, match=f"version {version + 1}, allowed: {version}"):
        hcss_twin.report(broken)
    assert not broken.with_suffix(".html").exists()


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (280.6512, 0.1123, "280.65 ± 0.11"),
        (1234.56, 78.9, "1235 ± 79"),
        (0.01523, 0.00045, "0.01523 ± 0.00045"),
        (1.234567e-9, 2.5e-12, "1.2346e-09 ± 2.5e-12"),
        (0.5, 0.0, "0.5"),
        (0.5, np.nan, "0.5"),
        (np.nan, 0.1, "-"),
    ],
)
def test_a_number_has_as_many_decimals_as_its_error(value, error, text):
    assert with_error(value, error) == text
