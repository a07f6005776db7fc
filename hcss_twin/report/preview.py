"""Contact sheets and animations of a cube."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError, choose_from
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.variables import TERM_PREFIX, VARIABLES

if TYPE_CHECKING:
    import xarray as xr


PIXELS_SHOWN = 800
"""Longest side of a drawn frame; larger frames are thinned, which keeps extremes of the shown pixels exact."""

FRAME_DURATION_MS = 250

DRAWN = ("radiance", "brightness_temperature", "cloud_thickness", "cloud_mask")
"""What is drawn if nothing is named: the first that a cube holds."""

_SUFFIXES = {"brightness_temperature": "kelvin"}
_FORBIDDEN = re.compile(r"[^A-Za-z0-9.]+")

MISSING = "#9dc3e6"
"""Where a variable has no value, in contact sheets: no shade of grey."""

LABEL_PIXELS = 12
"""Size of the letters above each frame of an animation."""


def draw_preview(
    cube: str | Path,
    folder: str | Path,
    *,
    kelvin: bool = False,
    frames: int = 8,
    animation: bool = True,
    variable: str | None = None,
) -> list[Path]:
    """Draw a variable of a cube: each band or cloud layer of it, if it has any.

    Parameters
    ----------
    cube : path
        A finished cube.
    folder : path
        Where the pictures go; made if missing.
    kelvin : bool
        Show brightness temperature instead of radiance; the cube must hold it.
    frames : int
        Frames per contact sheet, spread evenly over the cube.
    animation : bool
        Also write a GIF of all frames (at most 200) per band.
    variable : str, optional
        What to draw; by default radiance, or the first of ``DRAWN`` that the cube holds.

    Returns
    -------
    list of Path
        The pictures.

    Raises
    ------
    CubeError
        If the cube cannot be read or lacks the variable, or two are asked for.
    """
    if kelvin and variable not in (None, "brightness_temperature"):
        raise CubeError(f"'{variable}' in kelvin: allowed: one of both, a variable or kelvin")
    folder = Path(folder)
    written: list[Path] = []
    with open_cube(cube) as dataset:
        name = _variable(dataset, "brightness_temperature" if kelvin else variable)
        folder.mkdir(parents=True, exist_ok=True)
        for part, data in _parts(dataset[name]):
            words = [Path(cube).stem, part, "" if name == "radiance" else _SUFFIXES.get(name, name)]
            stem = "_".join([words[0], *(_FORBIDDEN.sub("-", each) for each in words[1:] if each)])
            if any(path.stem == stem for path in written):  # names that differ only in what a file may not hold
                stem += f"_{len(written)}"
            sheet = folder / f"{stem}.png"
            _contact_sheet(dataset, data, part or name, frames, sheet)
            written.append(sheet)
            if animation and data.sizes["time"] > 1:
                film = folder / f"{stem}.gif"
                _animation(data, film)
                written.append(film)
    return written


def _variable(dataset: xr.Dataset, asked: str | None) -> str:
    """Return the variable to draw."""
    known = [str(name) for name, data in dataset.data_vars.items() if {"time", "y", "x"} <= set(data.dims)]
    if asked in known:
        return str(asked)
    if asked is not None:
        exists = asked.startswith(TERM_PREFIX) or asked in {spec.name for spec in VARIABLES}
        run = f"; run the scenario with --set 'output.variables=[\"{asked}\"]'" if exists else ""
        raise CubeError(f"the cube holds no '{asked}'; {choose_from(asked, known)}{run}")
    for name in DRAWN:
        if name in known:
            return name
    raise CubeError(f"the cube holds none of {', '.join(DRAWN)}; name a variable; {choose_from('', known)}")


def _parts(data: xr.DataArray) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield each band or layer by its name, as (time, y, x); the whole without a name where there are none."""
    others = [dim for dim in data.dims if dim not in ("time", "y", "x")]
    if not others:
        yield "", data
        return
    for index, name in enumerate(data[others[0]].to_numpy()):
        yield str(name), data.isel({others[0]: index})


def _thin(data: xr.DataArray) -> xr.DataArray:
    step = max(1, -(-max(data.sizes["x"], data.sizes["y"]) // PIXELS_SHOWN))
    return data.isel(x=slice(None, None, step), y=slice(None, None, step))


def _limits(sample: NDArray[Any]) -> tuple[float, float]:
    known = sample[np.isfinite(sample)]
    if not known.size:  # altitudes of cloud tops under clear sky
        return 0.0, 1.0
    low, high = (float(value) for value in np.percentile(known, (0.5, 99.5)))
    return (low, high) if high > low else (low, low + max(abs(low), 1.0) * 1e-3)


def _contact_sheet(dataset: xr.Dataset, data: xr.DataArray, band: str, frames: int, path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    count = min(frames, data.sizes["time"])
    chosen = np.unique(np.linspace(0, data.sizes["time"] - 1, count).round().astype(int))
    shown = _thin(data.isel(time=chosen)).load()
    columns = min(4, chosen.size)
    rows = -(-chosen.size // columns)
    # One frame gets a large panel; many share the width of a page.
    panel = 5.5 if chosen.size == 1 else 3.0
    height = panel * min(max(data.sizes["y"] / data.sizes["x"], 0.3), 3.0)
    figure = Figure(figsize=(panel * columns + 1.6, (height + 0.3) * rows + 0.9), layout="constrained")
    FigureCanvasAgg(figure)
    axes = np.atleast_1d(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)).ravel()
    low, high = _limits(shown.to_numpy())
    x, y = shown["x"].to_numpy() / 1e3, shown["y"].to_numpy() / 1e3
    half = float(dataset["x"][1] - dataset["x"][0]) / 2e3 if dataset.sizes["x"] > 1 else 0.5
    extent = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    start = dataset["time"].to_numpy()[0]
    for axis, position in zip(axes, range(chosen.size), strict=False):
        frame = shown.isel(time=position)
        image = axis.imshow(
            frame.to_numpy(), origin="lower", extent=extent, vmin=low, vmax=high, cmap="gray", interpolation="nearest"
        )
        axis.set_facecolor(MISSING)
        axis.set_title(f"frame {chosen[position]}, {time_label(frame['time'].to_numpy(), start)}", fontsize=9)
        axis.tick_params(labelsize=7)
        axis.locator_params(nbins=5)
    for axis in axes[chosen.size :]:
        axis.set_visible(False)
    figure.supxlabel("x (km, east)", fontsize=9)
    figure.supylabel("y (km, north)", fontsize=9)
    below, above = float(shown.min()) < low, float(shown.max()) > high
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")
    bar = figure.colorbar(image, ax=axes[: chosen.size].tolist(), shrink=0.85, extend=extend)
    missing = not bool(np.all(np.isfinite(shown.to_numpy())))
    bar.set_label(_label(shown) + ("; blue: no value" if missing else ""))
    since = f"t from {np.datetime_as_string(start, unit='ms')}Z"
    title = f"{dataset.attrs.get('title', '')} — {band} — {since}"
    figure.suptitle(textwrap.fill(title, int(13 * figure.get_figwidth())), fontsize=10)
    figure.savefig(path, dpi=110)


def time_label(time: np.datetime64 | NDArray[Any], start: np.datetime64) -> str:
    """Write the time since the first frame, to the microsecond."""
    seconds = (time - start) / np.timedelta64(1, "ns") * 1e-9
    text = f"{float(seconds):.6f}".rstrip("0").rstrip(".")
    return f"t = {text} s"


def _label(data: xr.DataArray) -> str:
    units = str(data.attrs.get("units", ""))
    pretty = {"W m-2 sr-1": "W m$^{-2}$ sr$^{-1}$", "1": ""}.get(units, units)
    name = str(data.name).replace("_", " ")
    return f"{name} ({pretty})" if pretty else name


def _animation(data: xr.DataArray, path: Path) -> None:
    from PIL import Image, ImageDraw, ImageFont

    step = max(1, -(-data.sizes["time"] // 200))
    chosen = _thin(data.isel(time=slice(None, None, step)))
    low, high = _limits(chosen.isel(time=slice(None, None, max(1, chosen.sizes["time"] // 8))).to_numpy())
    times = chosen["time"].to_numpy()
    # Frames have unequal steps of time where some are left out or the cube has them: each says its own time.
    labels = [time_label(time, data["time"].to_numpy()[0]) for time in times]
    font = ImageFont.load_default(LABEL_PIXELS)
    width = max(chosen.sizes["x"], *(math.ceil(font.getlength(label)) + 4 for label in labels))
    strip = LABEL_PIXELS + 6
    images = []
    for index, label in enumerate(labels):
        frame = chosen.isel(time=index).to_numpy()[::-1]
        grey = np.clip((frame - low) / (high - low), 0, 1)
        picture = Image.new("L", (width, chosen.sizes["y"] + strip), 0)
        picture.paste(Image.fromarray((np.nan_to_num(grey) * 255).round().astype(np.uint8)), (0, strip))
        ImageDraw.Draw(picture).text((2, 2), label, fill=255, font=font)
        images.append(picture)
    images[0].save(path, save_all=True, append_images=images[1:], duration=FRAME_DURATION_MS, loop=0)
