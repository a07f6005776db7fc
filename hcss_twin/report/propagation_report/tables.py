"""What the page of a propagation needs of its file.

Numbers with their standard errors, as text.

Tables of a propagation: spread, quantiles, shares of the variance, inputs.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.errors import PropagationError
from hcss_twin.report.page.page import Markup, element, table
from hcss_twin.sweeps.propagation.dataset import open_propagation
from hcss_twin.sweeps.propagation.estimators import SAME
from hcss_twin.sweeps.propagation.summary import OUTPUTS, QUANTILES

if TYPE_CHECKING:
    import xarray as xr


RADIATION = ("brightness_temperature", "radiance")
_STATISTICS = ("mean", "standard_deviation", "quantile", "first_order", "total")
_NEEDED = (
    "input_value",
    "input_kind",
    "scene_seed",
    "first_order_estimator",
    "total_estimator",
    *OUTPUTS,
    *(f"{name}_{each}" for name in OUTPUTS for each in ("scenes", "draws")),
    *(f"{name}_{each}{end}" for name in OUTPUTS for each in _STATISTICS for end in ("", "_error")),
    *(f"{name}_pixel_{each}" for name in RADIATION for each in ("mean", "standard_deviation", "quantile")),
)


@dataclass(frozen=True)
class Contents:
    """A propagation in memory.

    Attributes
    ----------
    dataset : Dataset
        All of the file.
    bands, classes, sources, inputs, metrics : list of str
        Labels of its dimensions.
    """

    dataset: xr.Dataset
    bands: list[str]
    classes: list[str]
    sources: list[str]
    inputs: list[str]
    metrics: list[str]

    @property
    def scenes(self) -> int:
        """Scenes that were made."""
        return int(self.dataset.sizes["mixture"] * self.dataset.sizes["draw"])

    def attribute(self, name: str, default: Any) -> Any:
        """Return an attribute that is JSON; the default where it is missing or of another kind."""
        try:
            found = json.loads(str(self.dataset.attrs[name]))
        except (KeyError, ValueError):
            return default
        return found if isinstance(found, type(default)) else default

    def orders(self, source: int) -> list[str]:
        """Return which shares of a source are estimated: ``first_order``, ``total``, both or none."""
        return [
            order
            for order in ("first_order", "total")
            if str(self.dataset[f"{order}_estimator"].values[source]) != "none"
        ]


def read_contents(path: Path) -> Contents:
    """Read a propagation.

    Raises
    ------
    PropagationError
        If it is none, or is damaged.
    """
    with open_propagation(path) as opened:
        missing = [name for name in _NEEDED if name not in opened.variables]
        if missing:
            raise PropagationError(f"cannot read {path}: damaged: it has no {', '.join(missing[:3])}")
        try:
            dataset = opened.load()
        except (OSError, RuntimeError) as error:
            raise PropagationError(f"cannot read {path}: damaged: {error}") from error
    names = ("band", "class", "source", "input", "metric_name")
    return Contents(dataset, *([str(each) for each in dataset[name].values] for name in names))


MAX_DECIMALS = 8
"""Numbers that need more are written with an exponent."""


def with_error(value: float, error: float) -> str:
    """Return ``280.65 ± 0.11``: the error with two digits, the value with as many decimals.

    Without an error greater than 0 the value stands alone, with five digits; what is no number is ``-``.
    """
    if not math.isfinite(value):
        return "-"
    if not math.isfinite(error) or error <= 0.0:
        return plain(value)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > MAX_DECIMALS:
        # The last digit of the value stands where that of the error does.
        size = math.floor(math.log10(abs(value))) if value else 0
        digits = max(0, min(15, size - math.floor(math.log10(error)) + 1))
        return f"{value:.{digits}e} ± {error:.1e}"
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def plain(value: float) -> str:
    """Return a number with five digits."""
    return f"{value:.5g}" if math.isfinite(value) else "-"


def share(value: float, error: float) -> str:
    """Return a share of a variance with its error."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.2f} ± {error:.2f}" if math.isfinite(error) else f"{value:.2f}"


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
            with_error(*(float(data[f"{name}_quantile{end}"].values[each, band, place]) for end in ("", "_error")))
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
    rows = [[name.replace("_", " "), *_moments(found, "metric", (place,))] for place, name in enumerate(found.metrics)]
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
