"""Tables of a propagation: spread, quantiles, shares of the variance, errors of models, inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.reading import Reading
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.tables import Table
from hcss_uncertainty.dataset import open_propagation
from hcss_uncertainty.errors import PropagationError
from hcss_uncertainty.estimators import SAME
from hcss_uncertainty.joint_budget import MODEL_ERRORS, UNKNOWN, ErrorSize, Stated, joint_budget
from hcss_uncertainty.pixel_maps import MAP
from hcss_uncertainty.summary import OUTPUTS, PAYLOAD, QUANTILES

if TYPE_CHECKING:
    import xarray as xr


RADIATION = ("brightness_temperature", "radiance")
STATISTICS = ("mean", "standard_deviation", "quantile", "first_order", "total")

SHOWN = tuple(QUANTILES.index(quantile) for quantile in (0.05, 0.5, 0.95))
"""Indices of the quantiles shown in the main tables and figures."""

LISTED_DRAWS = 200
"""Maximum number of rows in the table of draws; the file has all."""

MAX_DECIMALS = 8
"""Maximum number of digits; longer numbers are written with an exponent."""

_ORDERS = {"first_order": "first-order", "total": "total"}
_MOMENTS = ["scenes", "mean", "standard deviation", *(f"{100 * QUANTILES[index]:g} %" for index in SHOWN)]
_NEEDED = (
    "input_value",
    "input_kind",
    "scene_seed",
    "first_order_estimator",
    "total_estimator",
    *OUTPUTS,
    *(f"{name}_{statistic}" for name in OUTPUTS for statistic in ("scenes", "draws")),
    *(f"{name}_{statistic}{end}" for name in OUTPUTS for statistic in STATISTICS for end in ("", "_error")),
    *(f"{name}_pixel_{statistic}" for name in RADIATION for statistic in STATISTICS[:3]),
)


@dataclass(frozen=True)
class PropagationContents:
    """A propagation in memory, with the labels of its dimensions."""

    dataset: xr.Dataset

    def labels(self, dimension: str) -> list[str]:
        """Return the labels of ``band``, ``class``, ``source``, ``input`` or ``metric_name``."""
        return [str(value) for value in self.dataset[dimension].values]

    def orders(self, source: int) -> list[str]:
        """Return which shares of a source are estimated: ``first_order``, ``total``, both or none."""
        return [name for name in _ORDERS if str(self.dataset[f"{name}_estimator"].values[source]) != "none"]

    @property
    def has_sensor(self) -> bool:
        """Whether a sensor measured the scenes."""
        return PAYLOAD[0] in self.dataset

    @property
    def mapped(self) -> list[str]:
        """Names of the quantities with maps, for example ``radiance``."""
        end = f"{MAP}mean"
        return [str(name).removesuffix(end) for name in self.dataset.data_vars if str(name).endswith(end)]

    def pair(self, name: str, at: tuple[int, ...]) -> tuple[float, float]:
        """Return a statistic and its standard error at one index."""
        return float(self.dataset[name].values[at]), float(self.dataset[f"{name}_error"].values[at])

    def label(self, name: str) -> str:
        """Return the name of an output with its units."""
        return f"{name.replace('_', ' ')} ({self.dataset[name].attrs.get('units', '')})"


@Reading.argument(PropagationError)
def read_contents(path: Path) -> PropagationContents:
    """Read a propagation.

    Raises
    ------
    PropagationError
        If it is not a propagation or is damaged.
    """
    with open_propagation(path) as opened:
        missing = [name for name in _NEEDED if name not in opened.variables]
        if missing:
            raise PropagationError(f"cannot read {path}: damaged: it has no {', '.join(missing[:3])}")
        # only the maps of the first frame are shown; those of all frames may be large
        return PropagationContents(opened.isel(time=slice(1), missing_dims="ignore").load())


def with_error(value: float, error: float) -> str:
    """Return ``280.65 ± 0.11``: the error with two digits, the value with as many decimals.

    Without an error greater than 0, the value has five digits and no error; NaN becomes ``-``.
    """
    if not (math.isfinite(value) and math.isfinite(error) and error > 0.0):
        return Table.number(value, 5)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > MAX_DECIMALS:
        # the value has the same last decimal place as the error
        size = math.floor(math.log10(abs(value))) if value else 0
        digits = max(0, min(15, size - math.floor(math.log10(error)) + 1))
        return f"{value:.{digits}e} ± {error:.1e}"
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def _share(value: float, error: float) -> str:
    if not math.isfinite(value):
        return "-"
    return f"{value:.2f} ± {error:.2f}" if math.isfinite(error) else f"{value:.2f}"


def _moments(contents: PropagationContents, name: str, at: tuple[int, ...]) -> list[str]:
    """Return scenes, mean, standard deviation and some quantiles of an output, with their errors."""
    mean, deviation = contents.pair(f"{name}_mean", at), contents.pair(f"{name}_standard_deviation", at)
    shown = [contents.pair(f"{name}_quantile", (index, *at)) for index in SHOWN]
    if deviation[0] <= SAME * abs(mean[0]):  # rounding
        mean, deviation, shown = (mean[0], 0.0), (0.0, 0.0), [(value, 0.0) for value, _ in shown]
    count = int(contents.dataset[f"{name}_scenes"].values[at])
    return [str(count), *(with_error(*value) for value in (mean, deviation, *shown))]


def spread(contents: PropagationContents, name: str, band: int) -> Table:
    """Return mean, standard deviation and quantiles over draws by class, and the pixel standard deviation."""
    pixels = contents.dataset[f"{name}_pixel_standard_deviation"].values[band]
    rows = [
        [kind, *_moments(contents, name, (band, class_number)), Table.number(float(pixels[class_number]), 5)]
        for class_number, kind in enumerate(contents.labels("class"))
    ]
    caption = f"{contents.labels('band')[band]}: {contents.label(name)}, ± standard error."
    return Table(["class", *_MOMENTS, "of a pixel"], rows, caption)


def payload(contents: PropagationContents, band: int) -> Table:
    """Return moments over draws of what the sensor measures and of its noise, by class and quantity."""
    data = contents.dataset
    shown = [name for name in PAYLOAD if name in data and name in _SENSOR]
    rows = [
        [kind, _SENSOR[name], *_moments(contents, name, (band, class_number))]
        for class_number, kind in enumerate(contents.labels("class"))
        for name in shown
    ]
    caption = f"{contents.labels('band')[band]}: as the sensor measures it, ± standard error."
    return Table(["class", "measured", *_MOMENTS], rows, caption, text_columns=2)


_SENSOR = {
    "measured_radiance": "radiance (W m-2 sr-1)",
    "digital_number": "digital number",
    "noise_radiance": "noise (W m-2 sr-1)",
    "signal_to_noise": "signal-to-noise ratio",
    "nedt": "NEDT (K)",
    "saturated_fraction": "saturated part",
}


def budget(contents: PropagationContents, band: int, stated: Stated | None = None) -> Table:
    """Return the errors of the mean of each class due to inputs, seed and models, in K and as shares of radiance.

    ``stated`` are the errors of models, by default those in the file.
    """
    if stated is None:
        stated = Provenance.value(contents.dataset.attrs, MODEL_ERRORS, {})
    name = contents.labels("band")[band]
    found = joint_budget(contents.dataset, name, stated)
    models = list(dict.fromkeys(model for row in found for model in row.models))
    rows = [
        [
            row.kind,
            _size(row.parameters, "-"),
            _size(row.seed, "-"),
            *(_size(row.models.get(model, UNKNOWN)) for model in models or ("models",)),
            ("at least " if row.is_least and math.isfinite(row.total.kelvin) else "") + _size(row.total),
        ]
        for row in found
    ]
    header = ["error of the mean of", "uncertain inputs", "seed", *(models or ["models"]), "together"]
    return Table(header, rows, f"{name}: standard deviations in K of brightness temperature, and % of radiance.")


def _size(size: ErrorSize, unknown: str = "not stated") -> str:
    if not math.isfinite(size.kelvin):
        return unknown
    kelvin, percent = f"{size.kelvin:.3g} K", f"{100.0 * size.relative:.2g} %"
    return f"not told apart from 0 (± {kelvin}, {percent})" if size.is_limit else f"{kelvin} ({percent})"


def quantiles(contents: PropagationContents, name: str, band: int) -> Table:
    """Return all quantiles over draws by class, then those over the pixels of all draws together."""
    rows = []
    for class_number, kind in enumerate(contents.labels("class")):
        places = range(len(QUANTILES))
        means = (with_error(*contents.pair(f"{name}_quantile", (index, band, class_number))) for index in places)
        rows.append([kind, "mean of a class", *means])
        pixels = contents.dataset[f"{name}_pixel_quantile"].values[:, band, class_number]
        rows.append([kind, "pixel", *(Table.number(float(pixel), 5) for pixel in pixels)])
    header = ["class", "of", *(f"{100 * quantile:g} %" for quantile in QUANTILES)]
    caption = f"{contents.labels('band')[band]}: quantiles of {contents.label(name)}."
    return Table(header, rows, caption, text_columns=2)


def metrics(contents: PropagationContents) -> Table:
    """Return moments of the image metrics."""
    rows = [
        [name.replace("_", " "), *_moments(contents, "metric", (index,))]
        for index, name in enumerate(contents.labels("metric_name"))
    ]
    return Table(["metric", *_MOMENTS], rows, "Metrics of the images, ± standard error.")


def contrasts(contents: PropagationContents, name: str) -> Table:
    """Return moments of the standard deviation over all pixels of a scene, by band."""
    rows = [
        [band, *_moments(contents, f"{name}_spread", (index, 0))] for index, band in enumerate(contents.labels("band"))
    ]
    caption = f"Standard deviation over all pixels of a scene: {contents.label(name)}, ± standard error."
    return Table(["band", *_MOMENTS], rows, caption)


def fractions(contents: PropagationContents) -> Table:
    """Return moments of the fraction of the pixels in each class."""
    classes = enumerate(contents.labels("class"))
    rows = [[kind, *_moments(contents, "class_fraction", (class_number,))] for class_number, kind in classes]
    return Table(["fraction of the pixels", *_MOMENTS], rows)


def shares(
    contents: PropagationContents, name: str, columns: Sequence[str], part: tuple[int, ...], caption: str
) -> Table:
    """Return every source's share of the variance of an output; ``part`` is its band, if any."""
    data = contents.dataset
    rows = []
    for index, source in enumerate(contents.labels("source")):
        for order in contents.orders(index):
            values, errors = (data[f"{name}_{order}{end}"].values[(index, *part)] for end in ("", "_error"))
            cells = (_share(float(value), float(error)) for value, error in zip(values, errors, strict=True))
            rows.append([source, _ORDERS[order], str(data[f"{order}_estimator"].values[index]), *cells])
    return Table(["source", "share", "estimated by", *columns], rows, caption, text_columns=3)


def inputs(contents: PropagationContents) -> Table:
    """Return the distribution of each input, and the moments of its draws."""
    distributions = Provenance.value(contents.dataset.attrs, "uncertain", {})
    rows = []
    for index, name in enumerate(contents.labels("input")):
        draws = np.asarray(contents.dataset["input_value"].values[:, index], dtype=np.float64)
        numbers = (draws.mean(), draws.min(), np.median(draws), draws.max())
        mean, *rest = (_value(name, float(value)) for value in numbers)
        source = _distribution(distributions[name]) if name in distributions else "posterior"
        # the standard deviation of a time is in seconds
        rows.append([name, source, mean, f"{draws.std(ddof=1):.5g}", *rest])
    header = ["input", "drawn from", "mean", "standard deviation", "lowest", "median", "highest"]
    return Table(header, rows, "Of the draws, SI.", text_columns=2)


def correlations(contents: PropagationContents) -> Table:
    """Return the correlations of the inputs in the draws."""
    values = np.asarray(contents.dataset["input_value"].values, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        matrix = np.atleast_2d(np.corrcoef(values, rowvar=False))
    names = contents.labels("input")
    rows = [
        [name, *(f"{value:.2f}" if np.isfinite(value) else "-" for value in row)]
        for name, row in zip(names, matrix, strict=True)
    ]
    return Table(["correlation", *names], rows)


def draws(contents: PropagationContents) -> Table:
    """Return seeds and inputs of the first draws."""
    data, names = contents.dataset, contents.labels("input")
    rows = [
        [
            str(draw),
            *(str(int(seed)) for seed in data["scene_seed"].values[:2, draw]),
            *(_value(name, float(data["input_value"].values[draw, index]), 9) for index, name in enumerate(names)),
        ]
        for draw in range(min(LISTED_DRAWS, data.sizes["draw"]))
    ]
    return Table(["draw", "seed", "other seed", *names], rows)


def _distribution(given: Any) -> str:
    """Format a distribution as in the input: its name and parameters."""
    if not isinstance(given, dict):
        return str(given)
    rest = (f"{str(key).replace('_', ' ')} {value}" for key, value in given.items() if key != "distribution")
    return f"{given.get('distribution', '')}: {', '.join(rest)}"


def _value(name: str, value: float, digits: int = 6) -> str:
    """Format the value of an input; times as dates."""
    if is_instant(name):
        return datetime.fromtimestamp(value, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
    return f"{value:.{digits}g}"


def is_instant(name: str) -> bool:
    """Return whether the numbers of an input are seconds since 1970."""
    return name.rpartition(".")[2] == "time"
