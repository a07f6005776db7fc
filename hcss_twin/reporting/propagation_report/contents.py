"""What the page of a propagation needs of its file."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hcss_twin.errors import PropagationError
from hcss_twin.propagation.dataset import open_propagation
from hcss_twin.propagation.summary import OUTPUTS

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
