"""Report page of a propagation: the spread of radiance over draws, and its main causes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import Array
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.provenance import Provenance
from hcss_uncertainty import tables
from hcss_uncertainty.pixel_maps import MAP
from hcss_uncertainty.summary import QUANTILES
from hcss_uncertainty.tables import RADIATION, PropagationContents, read_contents

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DRAWN_INPUTS = 10
DRAWN_PIXELS = 400
"""Maximum number of rows and columns of a map; larger ones are thinned."""

DRAWN_CLASSES = 5
"""Maximum number of classes in a figure; tables list all."""

_MARKS = "#b3261e"
_COLOURS = ("#9aa5b1", "#3d8fc6", "#e0a03a", "#6b9e4f", "#8a4f9e")
_BAR_IN = 0.15
_LONGEST_NAME = 20
_SHOWN = {
    *("title", "scenario", "shares", "notes", "uncertain", "hcss_versions", "table_sets", "scenes"),
    *("posterior", "posterior_sha256", "posterior_inputs", "hcss_propagation_version"),
}


def propagation_page(path: Path) -> Page:
    """Return the page of a propagation.

    Raises
    ------
    PropagationError
        If it is not a propagation or is damaged.
    """
    contents = read_contents(path)
    sections = [
        Page.Section("Spread", list(_spread(contents))),
        *([Page.Section("Sensor", list(_sensor(contents)))] if contents.has_sensor else []),
        *([Page.Section("Maps", list(_maps(contents)))] if contents.mapped else []),
        Page.Section("Inputs and models", list(_budget(contents))),
        Page.Section("Which input matters", list(_shares(contents))),
        Page.Section("Image metrics", list(_metrics(contents))),
        Page.Section("Inputs", list(_inputs(contents))),
        Page.Section("Scenes and tables", list(_scenes(contents))),
        Page.Section("Provenance", list(_provenance(contents, path))),
    ]
    title = str(contents.dataset.attrs.get("title") or f"Propagation {path.name}")
    return Page(title, f"Propagation {path.name}: {contents.dataset.sizes['draw']} draws", sections)


def _spread(contents: PropagationContents) -> Iterator[Markup.Block]:
    yield from (Markup.note(str(text)) for text in Provenance.value(contents.dataset.attrs, "notes", []))
    yield Markup.paragraph(
        "Over draws, of the mean over the pixels of a class: how uncertain that mean is. The last column is the "
        "standard deviation over the pixels of all draws together: how uncertain a pixel is, its place in the image "
        "included. Each draw has two scenes; scenes without pixels of a class do not count."
    )
    bands = range(len(contents.labels("band")))
    temperature, radiance = RADIATION
    yield from (tables.spread(contents, temperature, band) for band in bands)
    yield Markup.folded("Radiance", *(tables.spread(contents, radiance, band) for band in bands))
    yield _drawn_spread(contents, temperature)
    yield Markup.folded("The same of radiance", _drawn_spread(contents, radiance))
    yield from _first_bands(contents)
    yield Markup.folded(
        "All quantiles", *(tables.quantiles(contents, name, band) for name in RADIATION for band in bands)
    )


def _sensor(contents: PropagationContents) -> Iterator[Markup.Block]:
    yield Markup.paragraph(
        "Each scene is measured twice, by sensors that differ in their seeds: half the mean square difference is the "
        "variance of the noise, fixed pattern included. The signal-to-noise ratio is that of single pixels against "
        "the mean of their class; the NEDT is that of a black body at the brightness temperature of the class. Noise "
        "below the step of the converter, and in saturated pixels, is not seen."
    )
    yield from (tables.payload(contents, band) for band in range(len(contents.labels("band"))))
    for name in ("measured_radiance", "digital_number"):
        if name in contents.dataset:
            every = (tables.spread(contents, name, band) for band in range(len(contents.labels("band"))))
            yield Markup.folded(f"{name.replace('_', ' ').capitalize()} of single pixels", *every)


def _maps(contents: PropagationContents) -> Iterator[Markup.Block]:
    yield Markup.paragraph(
        "Over the scenes of all draws with both seeds, of each pixel of the first frame: mean, standard deviation, and "
        "the part of it that is due to the seed, which places the clouds."
    )
    for name in contents.mapped:
        values = contents.dataset[f"{name}{MAP}mean"]
        names = contents.labels("band")[: Figures.DRAWN_BANDS] if "band" in values.dims else [""]
        for band, label in enumerate(names):
            shown = f"{name.replace('_', ' ')}{', ' if label else ''}{label}"
            yield Markup.picture(_maps_of(contents, name, band), f"maps of {shown}", f"{shown[:1].upper()}{shown[1:]}.")


def _maps_of(contents: PropagationContents, name: str, band: int) -> Figure:
    """Draw mean and standard deviations of the pixels of the first frame side by side, as they are seen."""
    dataset = FrameSelection.as_seen(contents.dataset)
    figure = Figures.new(2.0 * Figures.WIDTH_IN, 3.2)
    titles = ("mean", "standard deviation", "due to the seed")
    statistics = ("mean", "standard_deviation", "seed_standard_deviation")
    unit = 1e3 if "units" in dataset["x"].attrs else 1.0
    x, y = (dataset[axis].values / unit for axis in ("x", "y"))
    top = float(dataset[f"{name}{MAP}standard_deviation"][..., 0, :, :].values.reshape(-1, y.size, x.size)[band].max())
    for axis, title, statistic in zip(figure.subplots(1, 3), titles, statistics, strict=True):
        values = dataset[f"{name}{MAP}{statistic}"]
        plane = values.isel(time=0).values.reshape(-1, y.size, x.size)[band]
        step = max(1, max(plane.shape) // DRAWN_PIXELS)
        limits = {} if statistic == "mean" else {"vmin": 0.0, "vmax": top or 1.0}
        shown = axis.imshow(
            plane[::step, ::step], origin="lower", extent=(x[0], x[-1], y[0], y[-1]), cmap="viridis", **limits
        )
        axis.set_title(title, fontsize=Figures.LETTERS)
        axis.tick_params(labelsize=Figures.LETTERS - 1)
        bar = figure.colorbar(shown, ax=axis, orientation="horizontal", shrink=0.9)
        bar.ax.tick_params(labelsize=Figures.LETTERS - 1)
        bar.ax.locator_params(nbins=4)
        bar.set_label(values.attrs["units"].removeprefix("1"), fontsize=Figures.LETTERS - 1)
    figure.supxlabel(
        "km from the centre" if unit > 1.0 else "column; row, the first at the top", fontsize=Figures.LETTERS
    )
    return figure


def _budget(contents: PropagationContents) -> Iterator[Markup.Block]:
    yield Markup.paragraph(
        "Errors of the mean of a class: the standard deviation over draws, divided into the parts of the uncertain "
        "inputs and of the seed, beside the errors of the models against the best reference known, where stated. "
        "Together is the root of the sum of squares."
    )
    yield from (tables.budget(contents, band) for band in range(len(contents.labels("band"))))


def _drawn_spread(contents: PropagationContents, name: str) -> Markup:
    marks = ", ".join(f"{100 * QUANTILES[index]:g}" for index in tables.SHOWN)
    return Markup.beside(
        *(
            Markup.drawing(
                _draws_of_band(contents, name, band),
                f"draws of {name.replace('_', ' ')}, {label}",
                f"{label}: class means of the scenes of all draws, both seeds; lines at {marks} %."
                f"{_some_classes(contents)}",
            )
            for band, label in enumerate(contents.labels("band")[: Figures.DRAWN_BANDS])
        )
    )


def _draws_of_band(contents: PropagationContents, name: str, band: int) -> Figure:
    data = contents.dataset
    columns = []
    for class_number, kind in enumerate(contents.labels("class")[:DRAWN_CLASSES]):
        values = np.asarray(data[name].values[:2, :, band, class_number], dtype=np.float64).ravel()
        columns.append((kind, values, data[f"{name}_quantile"].values[tables.SHOWN, band, class_number]))
    return _distributions(columns, f"mean {contents.label(name)}, {contents.labels('band')[band]}")


def _distributions(
    columns: Iterable[tuple[str, Array, Iterable[float]]], label: str, counted: str = "scenes"
) -> Figure:
    """Draw stacked histograms of draws.

    Parameters
    ----------
    columns : iterable of (str, ndarray (n,), iterable of float)
        Name, values of all draws (NaN do not count), and quantiles to be marked.
    label : str
        Axis label of the values, below all panels; panels have separate scales.
    counted : str
        What each value represents.
    """
    columns = list(columns)
    figure, axes = Figures.panels(len(columns), 1.15)
    for axis, (name, values, marks) in zip(axes, columns, strict=True):
        known = values[np.isfinite(values)]
        axis.set_title(name, fontsize=Figures.LETTERS, loc="left")
        axis.set_ylabel(counted, fontsize=Figures.LETTERS)
        if not known.size:
            axis.text(0.5, 0.5, "in no draw", transform=axis.transAxes, ha="center", fontsize=Figures.LETTERS)
            axis.set_xticks([])
            axis.set_yticks([])
            continue
        # if only rounding varies, the bar has a fixed width
        level, width = float(known.mean()), float(np.ptp(known))
        least = 1e-6 * max(abs(level), 1e-12)
        ends = (known.min(), known.max()) if width > least else (level - 500 * least, level + 500 * least)
        axis.hist(known, int(np.clip(np.sqrt(known.size) * 1.5, 6, 40)), range=ends, color=Figures.INK, alpha=0.6)
        for mark in marks:
            if np.isfinite(mark):
                axis.axvline(mark, color=_MARKS, lw=1.0)
        axis.locator_params(axis="y", nbins=3, integer=True)
        axis.locator_params(axis="x", nbins=6)
        axis.ticklabel_format(axis="x", useOffset=False, style="plain")
        if level and abs(level) < 1e-3:
            axis.ticklabel_format(axis="x", style="sci", scilimits=(0, 0))
    axes[-1].set_xlabel(label, fontsize=Figures.LETTERS)
    return figure


def _some_classes(contents: PropagationContents) -> str:
    count = len(contents.labels("class"))
    return f" The first {DRAWN_CLASSES} of {count} classes." if count > DRAWN_CLASSES else ""


def _first_bands(contents: PropagationContents) -> Iterator[Markup.Block]:
    count = len(contents.labels("band"))
    if count > Figures.DRAWN_BANDS:
        yield Markup.paragraph(f"Shown are the first {Figures.DRAWN_BANDS} of {count} bands.")


def _shares(contents: PropagationContents) -> Iterator[Markup.Block]:
    yield Markup.paragraph(
        "The variance over draws, divided among the sources: a first-order share is what would vanish, on average, if "
        "only this source became known; a total share is what would remain if only it stayed unknown. Estimates can "
        "be negative, or above 1, by chance. They use draws all of whose scenes have pixels of the class."
    )
    data = contents.dataset
    by_regression = np.asarray(data["first_order_estimator"].values) == "regression"
    if by_regression.any() and not np.isfinite(data["radiance_first_order"].values[by_regression]).any():
        yield Markup.note("No share by regression: there are too few draws, or nothing varies.")
    bands = contents.labels("band")
    yield Markup.beside(
        *(
            Markup.drawing(
                _shares_of_band(contents, "radiance", band),
                f"shares of the variance of radiance, {label}",
                f"{label}: bars are first-order shares, diamonds total ones, lines standard errors."
                f"{_some_classes(contents)}",
            )
            for band, label in enumerate(bands[: Figures.DRAWN_BANDS])
        )
    )
    yield from _first_bands(contents)
    for name in reversed(RADIATION):
        title = f"shares of the variance of mean {name.replace('_', ' ')}"
        classes = contents.labels("class")
        yield Markup.folded(
            title.capitalize(),
            *(
                tables.shares(contents, name, classes, (band,), f"{label}: {title}, ± standard error.")
                for band, label in enumerate(bands)
            ),
        )


def _shares_of_band(contents: PropagationContents, name: str, band: int) -> Figure:
    """Draw each source's Sobol indices by class: bars are first-order, diamonds total-effect."""
    data, names = contents.dataset, contents.labels("source")
    classes = contents.labels("class")[:DRAWN_CLASSES]
    sources = [index for index in range(len(names)) if contents.orders(index)]
    step = len(classes) + 1.2
    figure = Figures.new(Figures.WIDTH_IN, _BAR_IN * step * len(sources) + 1.1)
    axis = figure.subplots()
    Figures.plain(axis)
    for kind, colour in zip(range(len(classes)), _COLOURS, strict=False):
        for order in ("first_order", "total"):
            rows = [row for row, source in enumerate(sources) if order in contents.orders(source)]
            at = np.array([row * step + kind for row in rows], dtype=np.float64)
            source_indices = [sources[row] for row in rows]
            value, error = (data[f"{name}_{order}{end}"].values[source_indices, band, kind] for end in ("", "_error"))
            known = np.isfinite(value)
            if not known.any():
                continue
            spread = np.where(np.isfinite(error), error, 0.0)[known]
            style: dict[str, Any] = {"fmt": "none"}
            if order == "first_order":
                axis.barh(at[known], value[known], height=0.86, color=colour, label=classes[kind])
            else:
                style = {"fmt": "D", "mfc": "white", "ms": 4}
            axis.errorbar(value[known], at[known], xerr=spread, ecolor="#1c2733", mec=colour, lw=0.9, **style)
    axis.axvline(0.0, color="#5b6875", lw=0.8)
    places = [row * step + 0.5 * (len(classes) - 1) for row in range(len(sources))]
    axis.set_yticks(places, [_broken(names[source]) for source in sources])
    axis.invert_yaxis()
    low, high = axis.get_xlim()
    axis.set_xlim(min(low, -0.05), max(high, 1.05))
    axis.set_xlabel(f"share of the variance of mean {name.replace('_', ' ')}", fontsize=Figures.LETTERS)
    figure.suptitle(contents.labels("band")[band], fontsize=Figures.LETTERS, x=0.01, ha="left")
    if axis.get_legend_handles_labels()[0]:
        legend = {"ncols": len(classes), "fontsize": Figures.LETTERS - 2, "handlelength": 0.8, "columnspacing": 0.8}
        figure.legend(loc="outside upper right", frameon=False, **legend)
    return figure


def _broken(name: str) -> str:
    """Break a long dotted name into two lines."""
    head, point, tail = name.rpartition(".")
    return f"{head}{point}\n{tail}" if len(name) > _LONGEST_NAME and point else name


def _metrics(contents: PropagationContents) -> Iterator[Markup.Block]:
    data = contents.dataset
    yield Markup.paragraph(
        "Coverage, and EV, Den, DP and FD of the clouds' thickness (entropy, density, diagonal peak, fractal "
        "dimension), means over frames. Images below 32 x 32 pixels, or without clouds, have only coverage."
    )
    yield tables.metrics(contents)
    yield from (tables.contrasts(contents, name) for name in RADIATION)
    names = [name.replace("_", " ") for name in contents.labels("metric_name")]
    columns = (
        (
            name,
            np.asarray(data["metric"].values[:2, :, index], dtype=np.float64).ravel(),
            data["metric_quantile"].values[tables.SHOWN, index],
        )
        for index, name in enumerate(names)
    )
    yield Markup.drawing(_distributions(columns, "value"), "draws of image metrics", "Scenes of all draws, both seeds.")
    shares = tables.shares(contents, "metric", names, (), "± standard error.")
    yield Markup.folded("Shares of the variance of the metrics", shares)
    yield Markup.folded("Fraction of the pixels in each class", tables.fractions(contents))


def _inputs(contents: PropagationContents) -> Iterator[Markup.Block]:
    values = np.asarray(contents.dataset["input_value"].values, dtype=np.float64)
    names = contents.labels("input")
    yield tables.inputs(contents)
    columns: list[tuple[str, Array, Iterable[float]]] = []
    for index, name in enumerate(names[:DRAWN_INPUTS]):
        input_values = values[:, index]
        # seconds since 1970 have too many digits for an axis
        since = tables.is_instant(name)
        columns.append(
            (
                f"{name}, after the first" if since else name,
                input_values - input_values.min() if since else input_values,
                (),
            )
        )
    some = f" The first {DRAWN_INPUTS} of {len(names)}." if len(names) > DRAWN_INPUTS else ""
    figure = _distributions(columns, "value, SI", "draws")
    yield Markup.drawing(figure, "draws of the inputs", f"Draws of the inputs.{some}")
    if len(names) > 1:
        together = str(contents.dataset.attrs.get("independence", ""))
        yield Markup.paragraph(
            f"{together[:1].upper()}{together[1:]}. By chance correlations of independent inputs scatter by about "
            f"{1.0 / np.sqrt(max(1, values.shape[0] - 1)):.2g}."
        )
        yield tables.correlations(contents)
    count = min(tables.LISTED_DRAWS, values.shape[0])
    draws = "Every draw" if count == values.shape[0] else f"The first {count} of {values.shape[0]} draws"
    yield Markup.folded(f"{draws}: each can be run alone with these values", tables.draws(contents))


def _scenes(contents: PropagationContents) -> Iterator[Markup.Block]:
    data = contents.dataset
    sizes, attributes = data.sizes, data.attrs
    pairs = [
        ("draws", str(sizes["draw"])),
        ("scenes", str(attributes.get("scenes", sizes["mixture"] * sizes["draw"]))),
        ("computed for each draw", ", ".join(contents.labels("mixture"))),
        ("sets of radiance tables", str(attributes.get("table_sets", ""))),
        ("shares of the variance", str(attributes.get("shares", ""))),
    ]
    yield Markup.facts((name, value) for name, value in pairs if value)
    yield Markup.paragraph(
        "Scenes whose sea, atmosphere, cloud altitudes and particles are the same share a set of radiance tables; "
        "cloud shape, coverage and seed do not matter."
    )


def _provenance(contents: PropagationContents, path: Path) -> Iterator[Markup.Block]:
    attributes = contents.dataset.attrs
    files = [
        (str(source.get("name")), str(source.get("sha256")))
        for source in Provenance.value(attributes, "posterior_inputs", [])
        if isinstance(source, dict)
    ]
    if {"posterior", "posterior_sha256"} <= set(attributes):
        files.insert(0, (str(attributes["posterior"]), str(attributes["posterior_sha256"])))
    file = f"{path.name}, {path.stat().st_size / 1e6:.2f} MB"
    yield from Provenance.blocks(attributes, file, {"seed": "seed"}, files, Provenance.names_in(_SHOWN))
    if "scenario" in attributes:
        yield Provenance.scenario(attributes["scenario"])
