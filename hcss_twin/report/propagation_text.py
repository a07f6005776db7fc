"""A propagation as text for a terminal, and as plain values for scripts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hcss_twin.core.json_numbers import json_value
from hcss_twin.sweeps.propagation.estimators import SAME
from hcss_twin.sweeps.propagation.joint_sample import POSTERIOR
from hcss_twin.sweeps.propagation.propagate import Propagation
from hcss_twin.sweeps.propagation.summary import OUTPUTS, QUANTILES

if TYPE_CHECKING:
    import xarray as xr


_LOW, _HIGH = QUANTILES.index(0.05), QUANTILES.index(0.95)
_STATISTICS = ("mean", "standard_deviation", "quantile", "first_order", "total")


def propagation_text(found: Propagation) -> str:
    """Describe how radiance scatters, and which input matters."""
    return "\n".join(_lines(found))


def propagation_values(found: Propagation) -> Mapping[str, Any]:
    """Return the same for ``--json``: nested by output, band, class and source; null where there is no number."""
    data = found.dataset
    return {
        "propagation": None if found.path is None else str(found.path),
        "bytes": None if found.path is None else found.path.stat().st_size,
        "draws": int(data.sizes["draw"]),
        "mixtures": [str(name) for name in data["mixture"].values],
        "tables": vars(found.tables),
        "inputs": [str(name) for name in data["input"].values],
        "estimators": {
            str(name): {"first_order": str(first), "total": str(total)}
            for name, first, total in zip(
                data["source"].values, data["first_order_estimator"].values, data["total_estimator"].values, strict=True
            )
        },
        "outputs": {
            name: {
                **{key: _tree(data[f"{name}_{key}"]) for key in _STATISTICS},
                **{f"{key}_error": _tree(data[f"{name}_{key}_error"]) for key in _STATISTICS},
                **{key: _tree(data[f"{name}_{key}"]) for key in ("scenes", "draws")},
            }
            for name in OUTPUTS
        },
        "pixels": {
            name: {key: _tree(data[f"{name}_pixel_{key}"]) for key in _STATISTICS[:3]}
            for name in ("radiance", "brightness_temperature")
        },
        "notes": list(found.notes),
        "cubes": [str(path) for path in found.cubes],
    }


def _tree(array: xr.DataArray) -> Any:
    """Nest values by the labels of their dimensions."""
    if array.ndim == 0:
        return json_value(array.item())
    dimension = str(array.dims[0])
    labels = array[dimension].values
    return {
        (f"{label:g}" if isinstance(label, float) else str(label)): _tree(array.isel({dimension: place}))
        for place, label in enumerate(labels)
    }


def _lines(found: Propagation) -> Iterator[str]:
    data = found.dataset
    if found.path is not None:
        yield f"{found.path}  {found.path.stat().st_size / 1e6:.1f} MB"
    count, mixtures = data.sizes["draw"], data.sizes["mixture"]
    more = "" if mixtures == 2 else f" and {mixtures - 2} times with inputs exchanged"
    tables = found.tables
    yield f"  {count} draws, each with two seeds{more}: {tables.scenes} scenes"
    yield (
        f"  radiance tables: {tables.sets} set{'s' if tables.sets > 1 else ''} for {count} draws, compiled "
        f"{tables.compiled} x, kept from earlier runs {tables.sets - tables.compiled} x"
    )
    yield f"  drawn independently of each other: {', '.join(_independent(data))}"
    for note in found.notes:
        yield f"  note: {note}"
    classes = [str(name) for name in data["class"].values]
    for band in map(str, data["band"].values):
        yield ""
        yield from _band(data, band, classes)
    yield ""
    yield from _metrics(data)
    yield ""
    yield from _shares(data)


def _independent(data: xr.Dataset) -> Iterator[str]:
    kinds = [str(kind) for kind in data["input_kind"].values]
    names = [str(name) for name in data["input"].values]
    together = [name for name, kind in zip(names, kinds, strict=True) if kind == POSTERIOR]
    if together:
        yield f"the posterior ({', '.join(together)}, together)"
    yield from (name for name, kind in zip(names, kinds, strict=True) if kind != POSTERIOR)
    yield "seeds"


def _band(data: xr.Dataset, band: str, classes: list[str]) -> Iterator[str]:
    width = max(map(len, classes)) + 2
    heads = ("mean", "sd", "+-", "5 %", "95 %")
    yield f"{band}: mean over the pixels of a class; radiance in W m-2 sr-1, then brightness temperature in K"
    yield f"  {'class':<{width}}{'scenes':>7}  " + "   ".join(
        "".join(f"{head:>{size}}" for head, size in zip(heads, (10, 9, 9, 10, 10), strict=True)) for _ in range(2)
    )
    for kind in classes:
        own = data.sel({"band": band, "class": kind})
        cells = []
        for name, digits in (("radiance", 4), ("brightness_temperature", 2)):
            quantile = own[f"{name}_quantile"].values
            mean = float(own[f"{name}_mean"])
            spread, error = (float(own[f"{name}_standard_deviation{suffix}"]) for suffix in ("", "_error"))
            if spread <= SAME * abs(mean):
                spread, error = 0.0, 0.0  # of rounding
            values = ((mean, 10), (spread, 9), (error, 9), (float(quantile[_LOW]), 10), (float(quantile[_HIGH]), 10))
            cells.append("".join(f"{_number(value, digits):>{size}}" for value, size in values))
        yield f"  {kind:<{width}}{int(own['radiance_scenes']):>7}  " + "   ".join(cells)


def _metrics(data: xr.Dataset) -> Iterator[str]:
    yield "image metrics of the clouds (EV, Den, DP, FD of their thickness), and standard deviation over all pixels"
    whole = data.sel({"class": "all"})
    rows = [(str(name), data.sel(metric_name=name), "metric") for name in data["metric_name"].values]
    rows += [
        (f"spread of {kind.replace('_', ' ')}, {band}", whole.sel(band=band), f"{kind}_spread")
        for kind in ("radiance", "brightness_temperature")
        for band in map(str, data["band"].values)
    ]
    width = max(len(label) for label, _, _ in rows) + 2
    yield f"  {'':<{width}}{'scenes':>7}{'mean':>11}{'sd':>11}{'5 %':>11}{'95 %':>11}"
    for label, own, name in rows:
        quantile = own[f"{name}_quantile"].values
        values = (
            float(own[f"{name}_mean"]),
            float(own[f"{name}_standard_deviation"]),
            float(quantile[_LOW]),
            float(quantile[_HIGH]),
        )
        cells = "".join(f"{_number(value, 4):>11}" for value in values)
        yield f"  {label:<{width}}{int(own[f'{name}_scenes']):>7}{cells}"


def _shares(data: xr.Dataset) -> Iterator[str]:
    classes = [str(name) for name in data["class"].values]
    sources = [str(name) for name in data["source"].values]
    width = max(map(len, sources)) + 2
    yield (
        f"shares of the variance of mean radiance over draws, +- standard error; first-order, by "
        f"{data.attrs['shares']}, but where it says total"
    )
    for band in map(str, data["band"].values):
        yield f"  {band:<{width + 7}}" + "".join(f"{kind:>16}" for kind in classes)
        for source in sources:
            for order, name in (("first_order", source), ("total", f"{source}, total")):
                own = data.sel(band=band, source=source)
                if str(own[f"{order}_estimator"].item()) == "none":
                    continue
                values, errors = (own[f"radiance_{order}{suffix}"].values for suffix in ("", "_error"))
                cells = "".join(
                    f"{_share(float(value), float(error)):>16}" for value, error in zip(values, errors, strict=True)
                )
                yield f"    {name:<{width + 5}}{cells}"


def _share(value: float, error: float) -> str:
    return f"{value:.2f} +- {error:.2f}" if math.isfinite(value) else "-"


def _number(value: float, digits: int) -> str:
    if not math.isfinite(value):
        return "-"
    if value == 0.0 or abs(value) >= 10.0**-digits * 10:
        return f"{value:.{digits}f}"
    return f"{value:.2g}"
