"""The page of a propagation."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hcss_twin.report.page.page import (
    Markup,
    Page,
    Section,
    beside,
    facts,
    folded,
    note,
    paragraph,
    preformatted,
    table,
)
from hcss_twin.report.page.pictures import drawing
from hcss_twin.report.propagation_report import figures, tables
from hcss_twin.report.propagation_report.tables import RADIATION, Contents, read_contents
from hcss_twin.sweeps.propagation.summary import QUANTILES

DRAWN_BANDS = 8
"""Bands with drawings; tables have all."""

DRAWN_INPUTS = 10

_TOLD_APART = {
    "title",
    "scenario",
    "seed",
    "shares",
    "notes",
    "uncertain",
    "hcss_versions",
    "table_sets",
    "scenes",
    "posterior",
    "posterior_sha256",
    "posterior_inputs",
    "hcss_propagation_version",
}


def propagation_page(path: Path) -> Page:
    """Return the page of a propagation.

    Raises
    ------
    PropagationError
        If it is none, or is damaged.
    """
    found = read_contents(path)
    sections = [
        Section("Spread", list(_spread(found))),
        Section("Which input matters", list(_shares(found))),
        Section("Image metrics", list(_metrics(found))),
        Section("Inputs", list(_inputs(found))),
        Section("Scenes and tables", list(_scenes(found))),
        Section("Provenance", list(_provenance(found, path))),
    ]
    title = str(found.dataset.attrs.get("title") or f"Propagation {path.name}")
    return Page(title, f"Propagation {path.name}: {found.dataset.sizes['draw']} draws", sections)


def _spread(found: Contents) -> Iterator[Markup]:
    for text in found.attribute("notes", []):
        yield note(str(text))
    yield paragraph(
        "Over draws, of the mean over the pixels of a class: how uncertain that mean is. The last column is the "
        "standard deviation over the pixels of all draws together: how uncertain a pixel is, its place in the image "
        "included. Scenes without pixels of a class are left out; there are two of each draw."
    )
    for name in RADIATION:
        shown = [tables.spread(found, name, band) for band in range(len(found.bands))]
        if name == "radiance":
            yield folded("Radiance", *shown)
        else:
            yield from shown
    marks = ", ".join(f"{100 * QUANTILES[place]:g}" for place in tables.SHOWN)
    drawn = {
        name: [
            drawing(
                figures.draws_of_band(found, name, band, tables.SHOWN),
                f"draws of {name.replace('_', ' ')}, {label}",
                f"{label}: class means of the scenes of all draws, both seeds; lines at {marks} %."
                f"{_some_classes(found)}",
            )
            for band, label in enumerate(found.bands[:DRAWN_BANDS])
        ]
        for name in RADIATION
    }
    yield beside(*drawn["brightness_temperature"])
    yield folded("The same of radiance", beside(*drawn["radiance"]))
    yield from _first_bands(found)
    yield folded(
        "All quantiles",
        *(tables.quantiles(found, name, band) for name in RADIATION for band in range(len(found.bands))),
    )


def _shares(found: Contents) -> Iterator[Markup]:
    yield paragraph(
        "The variance over draws, shared out: a first-order share is what would vanish, on average, if only this "
        "source became known; a total share is what would stay if only it remained unknown. Estimates can be "
        "negative, or above 1, by chance. They are over draws all of whose scenes have pixels of the class."
    )
    if not np.isfinite(_shares_by_regression(found)).any():
        yield note("No share by regression: there are too few draws, or nothing varies.")
    yield beside(
        *(
            drawing(
                figures.shares_of_band(found, "radiance", band),
                f"shares of the variance of radiance, {label}",
                f"{label}: bars are first-order shares, diamonds total ones, lines standard errors."
                f"{_some_classes(found)}",
            )
            for band, label in enumerate(found.bands[:DRAWN_BANDS])
        )
    )
    yield from _first_bands(found)
    for name, title in (
        ("radiance", "Shares of the variance of mean radiance"),
        ("brightness_temperature", "Shares of the variance of mean brightness temperature"),
    ):
        shown = (
            tables.shares(found, name, found.classes, (band,), f"{label}: {title.lower()}, ± standard error.")
            for band, label in enumerate(found.bands)
        )
        yield folded(title, *shown)


def _shares_by_regression(found: Contents) -> np.ndarray:
    rows = np.asarray(found.dataset["first_order_estimator"].values) == "regression"
    values = np.asarray(found.dataset["radiance_first_order"].values[rows], dtype=np.float64)
    return values if rows.any() else np.zeros(1)


def _metrics(found: Contents) -> Iterator[Markup]:
    data = found.dataset
    yield paragraph(
        "Coverage, and EV, Den, DP and FD of the clouds' thickness (entropy, density, diagonal peak, fractal "
        "dimension), means over frames. Images below 32 x 32 pixels, or without clouds, have none but coverage."
    )
    yield tables.metrics(found)
    for name in RADIATION:
        yield tables.contrasts(found, name)
    columns = [
        (
            name.replace("_", " "),
            np.asarray(data["metric"].values[:2, :, place], dtype=np.float64).ravel(),
            [float(data["metric_quantile"].values[each, place]) for each in tables.SHOWN],
        )
        for place, name in enumerate(found.metrics)
    ]
    yield drawing(figures.distributions(columns, "value"), "draws of image metrics", "Scenes of all draws, both seeds.")
    names = [name.replace("_", " ") for name in found.metrics]
    yield folded(
        "Shares of the variance of the metrics", tables.shares(found, "metric", names, (), "± standard error.")
    )
    yield folded("How many pixels are of each class", tables.fractions(found))


def _inputs(found: Contents) -> Iterator[Markup]:
    values = np.asarray(found.dataset["input_value"].values, dtype=np.float64)
    yield tables.inputs(found)
    columns = []
    for place, name in enumerate(found.inputs[:DRAWN_INPUTS]):
        own = values[:, place]
        # Seconds since 1970 have too many digits for an axis.
        instant = tables.is_instant(name)
        columns.append((f"{name}, after the first" if instant else name, own - own.min() if instant else own, ()))
    some = f" The first {DRAWN_INPUTS} of {len(found.inputs)}." if len(found.inputs) > DRAWN_INPUTS else ""
    yield drawing(
        figures.distributions(columns, "value, SI", "draws"), "draws of the inputs", f"Draws of the inputs.{some}"
    )
    if len(found.inputs) > 1:
        together = str(found.dataset.attrs.get("independence", ""))
        yield paragraph(
            f"{together[:1].upper()}{together[1:]}. By chance correlations of independent inputs scatter by about "
            f"{1.0 / np.sqrt(max(1, values.shape[0] - 1)):.2g}."
        )
        yield tables.correlations(found)
    count = min(tables.LISTED_DRAWS, values.shape[0])
    which = "Every draw" if count == values.shape[0] else f"The first {count} of {values.shape[0]} draws"
    yield folded(f"{which}: with its values any can be run by itself", tables.draws(found))


def _scenes(found: Contents) -> Iterator[Markup]:
    data = found.dataset
    names = [str(each) for each in data["mixture"].values]
    pairs = [("draws", str(data.sizes["draw"])), ("scenes", str(data.attrs.get("scenes", found.scenes)))]
    pairs.append(("computed for each draw", ", ".join(names)))
    if "table_sets" in data.attrs:
        pairs.append(("sets of radiance tables", str(data.attrs["table_sets"])))
    pairs.append(("shares of the variance", str(data.attrs.get("shares", ""))))
    yield facts(pairs)
    yield paragraph(
        "Scenes whose sea, atmosphere, cloud altitudes and particles are the same share a set of radiance tables; "
        "cloud shape, coverage and seed change none."
    )


def _provenance(found: Contents, path: Path) -> Iterator[Markup]:
    attributes = found.dataset.attrs
    pairs = [("file", f"{path.name}, {path.stat().st_size / 1e6:.2f} MB")]
    if "seed" in attributes:
        pairs.append(("seed", str(attributes["seed"])))
    versions = found.attribute("hcss_versions", {})
    if versions:
        pairs.append(("versions", ", ".join(f"{name} {version}" for name, version in versions.items())))
    yield facts(pairs)
    files = [
        (str(attributes[name]), str(attributes[f"{name}_sha256"]))
        for name in ("posterior",)
        if name in attributes and f"{name}_sha256" in attributes
    ]
    files += [
        (str(each.get("name")), str(each.get("sha256")))
        for each in found.attribute("posterior_inputs", [])
        if isinstance(each, dict)
    ]
    if files:
        yield table(["file", "SHA-256"], files, "The posterior, and the images it is of.", text_columns=2)
    others = [(str(name), str(value)) for name, value in attributes.items() if name not in _TOLD_APART]
    if others:
        yield folded("All other global attributes", facts(others))
    if "scenario" in attributes:
        yield folded(
            "The scenario that inputs are replaced in, with every default filled in",
            preformatted(str(attributes["scenario"])),
        )


def _some_classes(found: Contents) -> str:
    count = len(found.classes)
    return f" The first {figures.DRAWN_CLASSES} of {count} classes." if count > figures.DRAWN_CLASSES else ""


def _first_bands(found: Contents) -> Iterator[Markup]:
    count = len(found.bands)
    if count > DRAWN_BANDS:
        yield paragraph(f"Drawn are the first {DRAWN_BANDS} of {count} bands.")
