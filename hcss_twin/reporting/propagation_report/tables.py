"""Tables of a propagation: spread, quantiles, shares of the variance, inputs."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from hcss_twin.propagation.estimators import SAME
from hcss_twin.propagation.summary import QUANTILES
from hcss_twin.reporting.page.blocks import table
from hcss_twin.reporting.page.markup import Markup, element
from hcss_twin.reporting.propagation_report.contents import Contents
from hcss_twin.reporting.propagation_report.numbers import plain, share, with_error

SHOWN = tuple(QUANTILES.index(each) for each in (0.05, 0.5, 0.95))
"""Places of the quantiles in the main tables and drawings."""

LISTED_DRAWS = 200
"""Draws in the table of draws; the file has all."""

_ORDERS = {"first_order": "first-order", "total": "total"}


def spread(found: Contents, name: str, band: int) -> Markup:
    """Return mean, standard deviation and quantiles over draws by class, and those of single pixels."""
    data = found.dataset
    header = ["class", "scenes", *_moments_header()]
    more = f"{name}_pixel_standard_deviation" in data
    header += ["of a pixel"] if more else []
    rows = []
    for place, kind in enumerate(found.classes):
        row = [kind, *_moments(found, name, (band, place))]
        if more:
            row.append(plain(float(data[f"{name}_pixel_standard_deviation"].values[band, place])))
        rows.append(row)
    units = str(data[name].attrs.get("units", ""))
    told = f"{found.bands[band]}: {name.replace('_', ' ')} ({units}), ± standard error."
    return _nowrap(table(header, rows, told))


def quantiles(found: Contents, name: str, band: int) -> Markup:
    """Return all quantiles over draws by class, then those over the pixels of all draws together."""
    data = found.dataset
    rows = []
    for place, kind in enumerate(found.classes):
        over_draws = [
            with_error(
                *(float(data[f"{name}_quantile{end}"].values[each, band, place]) for end in ("", "_error"))
            )
            for each in range(len(QUANTILES))
        ]
        rows.append([kind, "mean of a class", *over_draws])
        pixels = data[f"{name}_pixel_quantile"].values[:, band, place]
        rows.append([kind, "pixel", *(plain(float(each)) for each in pixels)])
    header = ["class", "of", *(_percent(each) for each in QUANTILES)]
    units = str(data[name].attrs.get("units", ""))
    told = f"{found.bands[band]}: quantiles of {name.replace('_', ' ')} ({units})."
    return _nowrap(table(header, rows, told, text_columns=2))


def metrics(found: Contents) -> Markup:
    """Return moments of the image metrics."""
    rows = [
        [name.replace("_", " "), *_moments(found, "metric", (place,))]
        for place, name in enumerate(found.metrics)
    ]
    return _nowrap(table(["metric", "scenes", *_moments_header()], rows, "± standard error."))


def contrasts(found: Contents, name: str) -> Markup:
    """Return moments of the standard deviation over all pixels of a scene, by band."""
    rows = [[band, *_moments(found, f"{name}_spread", (place, 0))] for place, band in enumerate(found.bands)]
    units = str(found.dataset[name].attrs.get("units", ""))
    told = f"Standard deviation over all pixels of a scene: {name.replace('_', ' ')} ({units}), ± standard error."
    return _nowrap(table(["band", "scenes", *_moments_header()], rows, told))


def fractions(found: Contents) -> Markup:
    """Return moments of the part of the pixels that is of each class."""
    rows = [[kind, *_moments(found, "class_fraction", (place,))] for place, kind in enumerate(found.classes)]
    return _nowrap(table(["part of the pixels", "scenes", *_moments_header()], rows))


def shares(found: Contents, name: str, columns: Sequence[str], part: tuple[int, ...], told: str) -> Markup:
    """Return the shares of every source in the variance of an output; ``part`` is its band where it has one."""
    data = found.dataset
    rows = []
    for place, source in enumerate(found.sources):
        for order in found.orders(place):
            values, errors = (data[f"{name}_{order}{end}"].values[(place, *part)] for end in ("", "_error"))
            cells = [share(float(value), float(error)) for value, error in zip(values, errors, strict=True)]
            by = str(data[f"{order}_estimator"].values[place])
            rows.append([source, _ORDERS[order], by, *cells])
    return _nowrap(table(["source", "share", "estimated by", *columns], rows, told, text_columns=3))


def inputs(found: Contents) -> Markup:
    """Return what each input was drawn from, and what was drawn."""
    distributions = found.attribute("uncertain", {})
    rows = []
    for place, name in enumerate(found.inputs):
        values = np.asarray(found.dataset["input_value"].values[:, place], dtype=np.float64)
        numbers = [values.mean(), values.std(ddof=1), values.min(), np.median(values), values.max()]
        drawn_from = distribution_text(distributions[name]) if name in distributions else "posterior"
        cells = [_value(name, float(each)) for each in numbers]
        cells[1] = f"{numbers[1]:.5g}"  # of instants, too, a number of seconds
        rows.append([name, drawn_from, *cells])
    header = ["input", "drawn from", "mean", "standard deviation", "lowest", "median", "highest"]
    return _nowrap(table(header, rows, "Of the draws, SI.", text_columns=2))


def correlations(found: Contents) -> Markup:
    """Return how inputs go together in the draws."""
    values = np.asarray(found.dataset["input_value"].values, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        matrix = np.atleast_2d(np.corrcoef(values, rowvar=False))
    rows = [
        [name, *(f"{each:.2f}" if np.isfinite(each) else "-" for each in row)]
        for name, row in zip(found.inputs, matrix, strict=True)
    ]
    return _nowrap(table(["correlation", *found.inputs], rows))


def draws(found: Contents) -> Markup:
    """Return seeds and inputs of the first draws."""
    data = found.dataset
    rows = [
        [
            str(draw),
            *(str(int(seed)) for seed in data["scene_seed"].values[:2, draw]),
            *(
                _value(name, float(data["input_value"].values[draw, place]), 9)
                for place, name in enumerate(found.inputs)
            ),
        ]
        for draw in range(min(LISTED_DRAWS, data.sizes["draw"]))
    ]
    return _nowrap(table(["draw", "seed", "other seed", *found.inputs], rows))


def distribution_text(given: Any) -> str:
    """Write a distribution as it can be given: name, and what it has."""
    if not isinstance(given, dict):
        return str(given)
    rest = (f"{str(key).replace('_', ' ')} {value}" for key, value in given.items() if key != "distribution")
    return f"{given.get('distribution', '')}: {', '.join(rest)}"


def _moments_header() -> list[str]:
    return ["mean", "standard deviation", *(_percent(QUANTILES[place]) for place in SHOWN)]


def _moments(found: Contents, name: str, part: tuple[int, ...]) -> list[str]:
    """Return scenes, mean, standard deviation and some quantiles of an output, with their errors."""
    data = found.dataset

    def pair(statistic: str, at: tuple[int, ...]) -> tuple[float, float]:
        value, error = (float(data[f"{name}_{statistic}{end}"].values[at]) for end in ("", "_error"))
        return value, error

    mean, deviation = pair("mean", part), pair("standard_deviation", part)
    if deviation[0] <= SAME * abs(mean[0]):  # of rounding
        mean, deviation = (mean[0], 0.0), (0.0, 0.0)
        shown = [(pair("quantile", (place, *part))[0], 0.0) for place in SHOWN]
    else:
        shown = [pair("quantile", (place, *part)) for place in SHOWN]
    count = int(data[f"{name}_scenes"].values[part])
    return [str(count), *(with_error(*each) for each in (mean, deviation, *shown))]


def _value(name: str, value: float, digits: int = 6) -> str:
    """Write the value of an input; instants as such."""
    if is_instant(name):
        return datetime.fromtimestamp(value, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
    return f"{value:.{digits}g}"


def is_instant(name: str) -> bool:
    """Return whether the numbers of an input are seconds since 1970."""
    return name.rpartition(".")[2] == "time"


def _percent(quantile: float) -> str:
    return f"{100 * quantile:g} %"


def _nowrap(shown: Markup) -> Markup:
    return element("div", shown, class_="nowrap")
