"""Shared code of the figures: simulations with both radiance models, and drawing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_paper.cubes import ACCURACY
from hcss_paper.inputs import AssumedInput, assumed, fitted, in_words
from hcss_paper.scene import COLUMNS, PHYSICAL, Model
from hcss_twin import Scenario, simulate
from hcss_twin.providers import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHORT_WAVE = "swir-2.7-3.0"
BANDS = {SHORT_WAVE: "2.7-3.0 um", "mwir": "3.0-5.0 um", "lwir": "8.0-14.0 um"}
"""The paper's bands by their names in the catalog."""

MODEL_SECTIONS: Mapping[Model, Mapping[str, Any]] = {
    "as-printed": {
        "optics": {"provider": "mie", "parameters": {"phase_function": "henyey-greenstein"}},
        "sea.model": "cox-munk",
    },
    "physical": PHYSICAL,
}
"""What a scenario has for each of the two radiance models."""

PHYSICAL_NOTE = (
    "Physical: the same scene with the corrected physics, with the full glint and with sunlight on the clouds, to 1 % "
    "of the radiance."
)


def radiance_inputs(*bands: str) -> tuple[AssumedInput, ...]:
    """Return the inputs of radiance images of other scenes than ``baseline`` in these bands, for a reproduction."""
    scales = [_glint_name(band, _MIXTURE) for band in bands]
    return (
        *assumed([f"sea temperature{_MIXTURE}", *dict.fromkeys(scales)]),
        *in_words(
            "wind 10 m/s, and no sunlight on the cloud in as-printed: inputs of scenario baseline, fixed in the fits"
        ),
    )


def scenario_of(name: str, model: Model, overrides: Mapping[str, Any]) -> Scenario:
    """Return a shipped scenario with one of the two radiance models and further overrides.

    The fitted factor on the glint is that of its first band. ``baseline`` has the inputs of the tables' scene, and
    other scenarios, whose clouds are opaque, have those of the mixture.
    """
    kind = "" if name == "baseline" else _MIXTURE
    common: dict[str, Any] = {
        **COLUMNS,
        "frames.count": 1,
        "accuracy": ACCURACY[model],
        "output.certificate": 0,
        "sea.temperature": fitted(f"sea temperature{kind}"),
        "atmosphere.coefficients": "lowtran7",
        **MODEL_SECTIONS[model],
    }
    if model == "as-printed":
        glint = fitted(_glint_name(next(iter(overrides.get("bands", ["mwir"]))), kind))
        common["radiance"] = {"model": model, "parameters": {"glint_scale": glint, "cloud_sun_scale": 0.0}}
    return Scenario.load(name, {**common, **overrides})


def simulated(name: str, model: Model, overrides: Mapping[str, Any]) -> xr.Dataset:
    """Return the cube of :func:`scenario_of`."""
    return simulate(scenario_of(name, model, overrides))


def radiance_by_band(name: str, model: Model, overrides: Mapping[str, Any]) -> dict[str, Array]:
    """Return radiance (frames, rows, columns) in the three bands, each with its fitted glint factor."""
    # 8-14 um has almost no glint: it uses the factor of 3-5 um.
    groups: tuple[tuple[str, ...], ...] = ((SHORT_WAVE,), ("mwir", "lwir"))
    if model == "physical":
        groups = (tuple(BANDS),)
    found: dict[str, Array] = {}
    for bands in groups:
        cube = simulated(name, model, {**overrides, "bands": list(bands)})
        for band in bands:
            found[band] = cube.radiance.sel(band=band).to_numpy().astype(np.float64)
    return found


_MIXTURE = " of the mixture"


def _glint_name(band: str, kind: str) -> str:
    return "short-wave glint scale" if band == SHORT_WAVE else f"glint scale{kind}"


RADIANCE = "W m-2 sr-1"
RADIANCE_SHOWN = "W m$^{-2}$ sr$^{-1}$"

PANEL_PIXELS = 200
"""Largest number of pixels along a side of a panel; larger images are reduced to block means."""

SHADES = 64
"""Number of grey levels: enough for a small picture, with a third fewer bytes than 256 levels."""


def blank(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches, independent of any window system."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def reduced(values: NDArray[Any], most: int = PANEL_PIXELS) -> NDArray[np.float64]:
    """Return means over blocks, so that no side has more than ``most`` pixels; incomplete blocks are cropped.

    Parameters
    ----------
    values : ndarray (rows, columns)
    most : int
        At least 1.
    """
    image = np.asarray(values, dtype=np.float64)
    step = -(-max(image.shape) // most)
    rows, columns = (side // step for side in image.shape)
    cut = image[: rows * step, : columns * step]
    means: NDArray[np.float64] = cut.reshape(rows, step, columns, step).mean(axis=(1, 3))
    return means


def shades(name: str = "gray") -> Any:
    """Return a matplotlib colour map with :data:`SHADES` levels."""
    from matplotlib import colormaps

    return colormaps[name].resampled(SHADES)


def image_panel(
    axis: Axes,
    values: NDArray[Any],
    title: str = "",
    limits: tuple[float, float] | None = None,
    most: int = PANEL_PIXELS,
) -> Any:
    """Draw a grey image without ticks, north up, and return it for a colour bar."""
    low, high = limits if limits is not None else (float(np.min(values)), float(np.max(values)))
    drawn = axis.imshow(
        reduced(values, most), origin="lower", cmap=shades(), vmin=low, vmax=high, interpolation="nearest"
    )
    axis.set_xticks([])
    axis.set_yticks([])
    if title:
        axis.set_title(title, fontsize=9)
    return drawn
