"""Propagation file: the values of all draws, and their summary."""

from __future__ import annotations

import json
from collections.abc import Container, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, NetcdfFile
from hcss_uncertainty.draw_statistics import LEVELS, METRICS, SPREAD, DrawStatistics
from hcss_uncertainty.errors import PropagationError
from hcss_uncertainty.joint_sample import JointSample
from hcss_uncertainty.summary import pooled_pixels, summarise

if TYPE_CHECKING:
    import xarray as xr


VERSION_ATTRIBUTE = "hcss_propagation_version"
VERSION = 2
"""Since version 2, moments use all scenes with an output; before, they used draws whose scenes all had it."""

_RADIANCE, _OF_CLASS = "W m-2 sr-1", "of the pixels of a class"
_PER_DRAW = {
    "radiance": (f"mean radiance {_OF_CLASS}", _RADIANCE),
    "brightness_temperature": (f"mean brightness temperature {_OF_CLASS}", "K"),
    "measured_radiance": (f"mean radiance {_OF_CLASS} as measured by the sensor", _RADIANCE),
    "digital_number": (f"mean digital number {_OF_CLASS}", "1"),
    "saturated_fraction": (f"saturated part {_OF_CLASS}", "1"),
    "noise_radiance": (f"noise of the sensor, fixed pattern included, as radiance {_OF_CLASS}", _RADIANCE),
    "signal_to_noise": (f"mean measured radiance {_OF_CLASS} divided by the noise", "1"),
    "nedt": ("noise as a temperature difference of a black body at the brightness temperature of a class", "K"),
}
"""Variables of a scene by band and class, with their meaning and units; all but the first two need a sensor."""

_METRICS = "mean over frames of a metric of the clouds: cloudy part of pixels, EV, Den, DP and FD of their thickness"


def drawn_dataset(
    statistics: Mapping[str, Sequence[DrawStatistics]],
    sample: JointSample,
    inputs: Array,
    bands: Sequence[str],
    classes: Sequence[str],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Combine the values of all draws.

    ``statistics`` are ordered by mixture, then by draw; ``inputs`` (draw, input) are those of the first sample.
    """
    import xarray as xr

    mixtures = [mixture.name for mixture in sample.mixtures]
    by_mixture = [statistics[name] for name in mixtures]

    def stacked(name: str) -> NDArray[Any]:
        return np.stack([np.stack([getattr(one, name) for one in row]) for row in by_mixture])

    data: dict[str, Any] = {}

    def add(name: str, dims: tuple[str, ...], values: NDArray[Any], long_name: str, units: str | None = None) -> None:
        data[name] = (dims, values, {"long_name": long_name} | ({} if units is None else {"units": units}))

    for name, meaning, units in _of_scenes(by_mixture[0][0].values):
        by_class = np.stack([np.stack([one.values[name] for one in row]) for row in by_mixture])
        add(name, ("mixture", "draw", "band", "class"), by_class, meaning, units)
    of_class, pixels = ("mixture", "draw", "class"), stacked("pixels")
    add("class_pixels", of_class, pixels, "pixels of a class in all frames", "1")
    add("class_fraction", of_class, pixels / pixels[..., :1], "part of the pixels that is of a class", "1")
    add("metric", ("mixture", "draw", "metric_name"), stacked("metrics"), _METRICS, "1")
    for name in by_mixture[0][0].levels:
        meaning = f"{name.replace('_', ' ')} below which a share of the pixels of a class lies"
        levels = np.stack([one.levels[name] for one in by_mixture[0]])
        add(f"{name}_level", ("draw", "band", "class", "level"), levels, meaning, _PER_DRAW[name][1])
    meaning = "value of an input in the draws, SI; instants in seconds since 1970"
    add("input_value", ("draw", "input"), inputs, meaning)
    add("scene_seed", ("sample", "draw"), sample.seeds, "seed of the scene, of the draws and with other seeds")
    keys = {key.key for key in sample.keys}
    kinds = ["key" if name in keys else "posterior" for name in sample.inputs]
    coords = {
        "mixture": ("mixture", mixtures, {"long_name": "which inputs come from the second sample"}),
        "band": ("band", list(bands), {"long_name": "band"}),
        "class": ("class", list(classes), {"long_name": "kind of pixel"}),
        "metric_name": ("metric_name", list(METRICS), {"long_name": "metric of the clouds of an image"}),
        "level": ("level", LEVELS, {"long_name": "share of pixels below", "units": "1"}),
        "input": ("input", list(sample.inputs), {"long_name": "uncertain input"}),
        "input_kind": ("input", kinds, {"long_name": "where its distribution comes from"}),
    }
    return xr.Dataset(data, coords, dict(attributes))


def _of_scenes(names: Container[str]) -> Iterator[tuple[str, str, str]]:
    """Yield name, meaning and units of the variables by band and class among ``names``."""
    for name, (meaning, units) in _PER_DRAW.items():
        spread = f"standard deviation over the pixels of a class of {name.replace('_', ' ')}"
        for variable, text in ((name, meaning), (f"{name}{SPREAD}", spread)):
            if variable in names:
                yield variable, text, units


def with_summary(drawn: xr.Dataset) -> xr.Dataset:
    """Add the summary of the draws, replacing an earlier one."""
    import xarray as xr

    summary = summarise(drawn)
    summary.update({name: xr.Variable(*variable) for name, variable in pooled_pixels(drawn)})
    whole = drawn.drop_vars([name for name in summary.variables if name in drawn.variables])
    return whole.merge(summary)


def sample_attributes(sample: JointSample) -> dict[str, Any]:
    """Return file attributes on the source of the draws."""
    attributes: dict[str, Any] = {
        "uncertain": json.dumps({key.key: dict(key.distribution) for key in sample.keys}, default=str),
        "independence": "inputs are drawn independently of each other; the parameters of a posterior together",
    }
    posterior = sample.posterior
    if posterior is not None:
        inputs = posterior.about.get("inputs")  # names and hashes of images
        attributes["posterior"] = posterior.file
        attributes["posterior_sha256"] = posterior.sha256
        attributes["posterior_inputs"] = json.dumps(None if inputs is None else json.loads(inputs))
        attributes["posterior_layer"] = sample.layer
        if posterior.octaves is not None:
            attributes["posterior_octaves"] = np.array(posterior.octaves, dtype=np.int64)
        attributes["posterior_fixed"] = json.dumps(dict(posterior.fixed))
        attributes["posterior_draws"] = np.int64(posterior.samples.shape[0])
    return attributes


def write_propagation(dataset: xr.Dataset, path: Path) -> None:
    """Write the file atomically: on failure, ``path`` is unchanged. The same values give the same bytes, as the file
    contains no date.

    Raises PropagationError if it cannot be written.
    """
    encoding = {
        name: {"zlib": True, "shuffle": True, "_FillValue": None}
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fi" and variable.ndim
    }
    with Writing(path, PropagationError, "NetCDF") as draft:
        NetcdfFile.write_with_xarray(dataset, draft, encoding=encoding)


@checked
def open_propagation(path: str | Path) -> xr.Dataset:
    """Open the file of a propagation.

    Raises PropagationError if it cannot be read or is not a propagation.
    """
    with Reading(path, PropagationError):
        dataset = NetcdfFile.open_with_xarray(path)
    version = dataset.attrs.get(VERSION_ATTRIBUTE)
    if version != VERSION:
        dataset.close()
        what = "it is not a propagation" if version is None else f"version {version}, allowed: {VERSION}"
        raise PropagationError(f"cannot read {path}: {what}")
    return dataset
