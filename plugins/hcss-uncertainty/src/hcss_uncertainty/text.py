"""A propagation in the terminal: its tables as text, or as JSON values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hcss_twin.core.json_numbers import json_value
from hcss_uncertainty.joint_sample import POSTERIOR
from hcss_uncertainty.summary import IN_CLASSES, outputs_of
from hcss_uncertainty.tables import (
    RADIATION,
    STATISTICS,
    PropagationContents,
    budget,
    contrasts,
    metrics,
    payload,
    shares,
    spread,
)

if TYPE_CHECKING:
    import xarray as xr

    from hcss_uncertainty.propagation import Propagation


def propagation_text(propagation: Propagation) -> str:
    """Describe the spread of radiance and the inputs that cause it."""
    return "\n".join(_lines(propagation))


def _lines(propagation: Propagation) -> Iterator[str]:
    data, counts, path = propagation.dataset, propagation.tables, propagation.path
    if path is not None:
        yield f"{path}  {path.stat().st_size / 1e6:.1f} MB"
    draws, mixtures = data.sizes["draw"], data.sizes["mixture"]
    more = "" if mixtures == 2 else f" and {mixtures - 2} times with inputs exchanged"
    yield f"  {draws} draws, each with two seeds{more}: {counts.scenes} scenes"
    yield (
        f"  radiance tables: {counts.sets} set{'s' if counts.sets > 1 else ''} for {draws} draws, {counts.compiled} "
        f"compiled, {counts.sets - counts.compiled} from the cache"
    )
    yield f"  drawn independently of each other: {', '.join(_independent(data))}"
    yield from (f"  note: {note}" for note in propagation.notes)
    contents = PropagationContents(data)
    bands = range(len(contents.labels("band")))
    yield ""
    yield "Mean over the pixels of a class. The last column is the standard deviation of single pixels."
    for band in bands:
        for name in RADIATION:
            yield from spread(contents, name, band).lines()
        if contents.has_sensor:
            yield from payload(contents, band).lines()
        yield from budget(contents, band).lines()
    yield ""
    yield from metrics(contents).lines()
    for name in RADIATION:
        yield from contrasts(contents, name).lines()
    yield ""
    for band in bands:
        caption = f"{contents.labels('band')[band]}: shares of the variance of mean radiance over draws"
        yield from shares(contents, "radiance", contents.labels("class"), (band,), caption).lines()


def _independent(data: xr.Dataset) -> Iterator[str]:
    kinds = {str(name): str(kind) for name, kind in zip(data["input"].values, data["input_kind"].values, strict=True)}
    together = [name for name, kind in kinds.items() if kind == POSTERIOR]
    if together:
        yield f"the posterior ({', '.join(together)}, together)"
    yield from (name for name, kind in kinds.items() if kind != POSTERIOR)
    yield "seeds"


def propagation_values(propagation: Propagation) -> Mapping[str, Any]:
    """Return the summary for ``--json``, nested by output, band, class and source; NaN becomes null."""
    data, path = propagation.dataset, propagation.path
    estimators = [data[name].values for name in ("source", "first_order_estimator", "total_estimator")]
    return {
        "propagation": None if path is None else str(path),
        "bytes": None if path is None else path.stat().st_size,
        "draws": int(data.sizes["draw"]),
        "mixtures": [str(name) for name in data["mixture"].values],
        "tables": vars(propagation.tables),
        "inputs": [str(name) for name in data["input"].values],
        "estimators": {
            str(name): {"first_order": str(first), "total": str(total)}
            for name, first, total in zip(*estimators, strict=True)
        },
        "outputs": {
            name: {
                **{key: _tree(data[f"{name}_{key}"]) for key in STATISTICS},
                **{f"{key}_error": _tree(data[f"{name}_{key}_error"]) for key in STATISTICS},
                **{key: _tree(data[f"{name}_{key}"]) for key in ("scenes", "draws")},
            }
            for name in outputs_of(data)
        },
        "pixels": {
            name: {key: _tree(data[f"{name}_pixel_{key}"]) for key in STATISTICS[:3]}
            for name in IN_CLASSES
            if name in data
        },
        "notes": list(propagation.notes),
        "cubes": [str(path) for path in propagation.cubes],
    }


def _tree(array: xr.DataArray) -> Any:
    """Nest values by the labels of their dimensions."""
    if array.ndim == 0:
        return json_value(array.item())
    dimension = str(array.dims[0])
    return {
        (f"{label:g}" if isinstance(label, float) else str(label)): _tree(array.isel({dimension: index}))
        for index, label in enumerate(array[dimension].values)
    }
