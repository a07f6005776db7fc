"""The file of a propagation: the values of all draws, and their summary."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PropagationError
from hcss_twin.core.files import atomic_write
from hcss_twin.sweeps.propagation.draw_statistics import LEVELS, METRICS, DrawStatistics
from hcss_twin.sweeps.propagation.joint_sample import JointSample, images_of
from hcss_twin.sweeps.propagation.summary import pooled_pixels, summarise

if TYPE_CHECKING:
    import xarray as xr


VERSION_ATTRIBUTE = "hcss_propagation_version"
VERSION = 2
"""From 2 on, moments are of all scenes that have an output; before, of draws whose scenes all had it."""

_RADIANCE, _KELVIN = "W m-2 sr-1", "K"
_PER_DRAW = {
    "radiance": ("mean radiance of the pixels of a class", _RADIANCE),
    "radiance_spread": ("standard deviation over the pixels of a class of radiance", _RADIANCE),
    "brightness_temperature": ("mean brightness temperature of the pixels of a class", _KELVIN),
    "brightness_temperature_spread": (
        "standard deviation over the pixels of a class of brightness temperature",
        _KELVIN,
    ),
}
_METRICS = "mean over frames of a metric of the clouds: cloudy part of pixels, EV, Den, DP and FD of their thickness"


def drawn_dataset(
    statistics: Mapping[str, Sequence[DrawStatistics]],
    sample: JointSample,
    inputs: Array,
    bands: Sequence[str],
    classes: Sequence[str],
    kelvin_levels: NDArray[np.float32],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Put the values of all draws together.

    ``statistics`` are by mixture, then by draw; ``inputs`` (draw, input) are those of the first sample;
    ``kelvin_levels`` (draw, band, class, level) are the brightness temperatures of the levels of radiance of the draws.
    """
    import xarray as xr

    mixtures = [mixture.name for mixture in sample.mixtures]
    each = [statistics[name] for name in mixtures]

    def stacked(name: str) -> NDArray[Any]:
        return np.stack([np.stack([getattr(one, name) for one in row]) for row in each])

    full = ("mixture", "draw", "band", "class")
    data: dict[str, Any] = {
        name: (full, stacked(name), {"long_name": meaning, "units": units})
        for name, (meaning, units) in _PER_DRAW.items()
    }
    pixels = stacked("pixels")
    data["class_pixels"] = (
        ("mixture", "draw", "class"),
        pixels,
        {"long_name": "pixels of a class in all frames", "units": "1"},
    )
    data["class_fraction"] = (
        ("mixture", "draw", "class"),
        pixels / pixels[..., :1],
        {"long_name": "part of the pixels that is of a class", "units": "1"},
    )
    data["metric"] = (("mixture", "draw", "metric_name"), stacked("metrics"), {"long_name": _METRICS, "units": "1"})
    levels = np.stack([one.levels for one in statistics[mixtures[0]] if one.levels is not None])
    for name, array in (("radiance", levels), ("brightness_temperature", kelvin_levels)):
        data[f"{name}_level"] = (
            ("draw", "band", "class", "level"),
            array,
            {
                "long_name": f"{name.replace('_', ' ')} below which a share of the pixels of a class lies",
                "units": _PER_DRAW[name][1],
            },
        )
    data["input_value"] = (
        ("draw", "input"),
        inputs,
        {"long_name": "value of an input in the draws, SI; instants in seconds since 1970"},
    )
    data["scene_seed"] = (
        ("sample", "draw"),
        sample.seeds,
        {"long_name": "seed of the scene, of the draws and with other seeds"},
    )
    names = sample.inputs
    keys = {each.key for each in sample.keys}
    coords = {
        "mixture": ("mixture", mixtures, {"long_name": "which inputs come from the second sample"}),
        "band": ("band", list(bands), {"long_name": "band"}),
        "class": ("class", list(classes), {"long_name": "kind of pixel"}),
        "metric_name": ("metric_name", list(METRICS), {"long_name": "metric of the clouds of an image"}),
        "level": ("level", LEVELS, {"long_name": "share of pixels below", "units": "1"}),
        "input": ("input", list(names), {"long_name": "uncertain input"}),
        "input_kind": (
            "input",
            ["key" if name in keys else "posterior" for name in names],
            {"long_name": "where its distribution comes from"},
        ),
    }
    return xr.Dataset(data, coords, dict(attributes))


def with_summary(drawn: xr.Dataset) -> xr.Dataset:
    """Add what the draws say; what is there already is made anew."""
    import xarray as xr

    summary = summarise(drawn)
    summary.update({name: xr.Variable(*each) for name, each in pooled_pixels(drawn)})
    whole = drawn.drop_vars([name for name in summary.variables if name in drawn.variables])
    return whole.merge(summary)


def sample_attributes(sample: JointSample) -> dict[str, Any]:
    """Return what the file says about where its draws come from."""
    found: dict[str, Any] = {
        "uncertain": json.dumps({each.key: dict(each.distribution) for each in sample.keys}, default=str),
        "independence": "inputs are drawn independently of each other; the parameters of a posterior together",
    }
    if sample.posterior is not None:
        found["posterior"] = sample.posterior.file
        found["posterior_sha256"] = sample.posterior.sha256
        found["posterior_inputs"] = json.dumps(images_of(sample.posterior))
        found["posterior_layer"] = sample.layer
        if sample.posterior.octaves is not None:
            found["posterior_octaves"] = np.array(sample.posterior.octaves, dtype=np.int64)
        found["posterior_fixed"] = json.dumps(dict(sample.posterior.fixed))
        found["posterior_draws"] = np.int64(sample.posterior.samples.shape[0])
    return found


def write_propagation(dataset: xr.Dataset, path: Path) -> None:
    """Write the file; whatever happens, ``path`` holds a whole file or what it held before.

    The same values give the same bytes: there is no date in it.

    Raises PropagationError if it cannot be written.
    """
    encoding = {
        name: {"zlib": True, "shuffle": True, "_FillValue": None}
        for name, each in dataset.data_vars.items()
        if each.dtype.kind in "fi" and each.ndim
    }
    with atomic_write(path, PropagationError) as draft:
        dataset.to_netcdf(draft, engine="netcdf4", format="NETCDF4", encoding=encoding)


def open_propagation(path: str | Path) -> xr.Dataset:
    """Open the file of a propagation.

    Raises PropagationError if it cannot be read, or is none.
    """
    import xarray as xr

    try:
        dataset = xr.open_dataset(path, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise PropagationError(f"cannot read {path}: {error}") from error
    version = dataset.attrs.get(VERSION_ATTRIBUTE)
    if version != VERSION:
        dataset.close()
        what = "it is no propagation" if version is None else f"version {version}, allowed: {VERSION}"
        raise PropagationError(f"cannot read {path}: {what}")
    return dataset
