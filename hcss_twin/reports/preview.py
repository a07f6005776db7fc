"""Picture files: contact sheets and animations of cubes."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError, choose_from
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.variables import TERM_PREFIX, VARIABLES
from hcss_twin.engine.cube_temperature import brightness_temperature
from hcss_twin.reports.colour_scale import MISSING, ColourScale, band_limits_um, colours_of
from hcss_twin.reports.figures import Figures

if TYPE_CHECKING:
    import xarray as xr

PIXELS_SHOWN = 800
"""Longest side of a drawn frame; larger frames are thinned, which keeps the values of the shown pixels exact."""

FRAME_DURATION_MS = 250

DRAWN = ("radiance", "brightness_temperature", "cloud_thickness", "cloud_mask")
"""Default variable: the first of these in the cube."""

LABEL_PIXELS = 12
"""Font size of the title of each frame in an animation."""

_FRAMES_ANIMATED = 200
_FORBIDDEN = re.compile(r"[^A-Za-z0-9.]+")


@checked
@Reading.argument(CubeError)
def draw_preview(
    cube: str | Path,
    folder: str | Path,
    *,
    kelvin: bool = False,
    frames: int = 4,
    animation: bool = True,
    variable: str | None = None,
    replace: bool = False,
) -> list[Path]:
    """Draw a variable of a cube, each band or cloud layer separately; of thermal radiation, cold is white.

    Parameters
    ----------
    cube : path
        A finished cube.
    folder : path
        Folder of the pictures; created if missing.
    kelvin : bool
        Show brightness temperature instead of radiance, computed from it if the cube does not hold it.
    frames : int
        Frames per contact sheet, spread evenly over the cube.
    animation : bool
        Also write a GIF of all frames (at most 200) per band.
    variable : str, optional
        Default: radiance, or the first of ``DRAWN`` in the cube.
    replace : bool
        Replace existing files.

    Returns
    -------
    list of Path
        The pictures.

    Raises
    ------
    CubeError
        If the cube cannot be read or lacks the variable, ``kelvin`` and another variable are given, or a
        picture exists.
    """
    if kelvin and variable not in (None, "brightness_temperature"):
        raise CubeError(f"'{variable}' with kelvin; allowed: a variable or kelvin, not both")
    folder = Path(folder)
    written: list[Path] = []

    def drawn(path: Path) -> Path:
        if path.exists() and not replace:
            raise CubeError(f"{path} exists; give another folder with -o, or --force")
        written.append(path)
        return path

    with open_cube(cube) as opened:
        dataset = FrameSelection.as_seen(opened)
        if kelvin and "brightness_temperature" not in dataset and "radiance" in dataset:
            dataset = dataset.assign(brightness_temperature=brightness_temperature(dataset))
        name = _variable(dataset, "brightness_temperature" if kelvin else variable)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CubeError(f"cannot write to {folder}: {error.strerror}") from error
        suffix = {"radiance": "", "brightness_temperature": "kelvin"}.get(name, name)
        limits = band_limits_um(dataset, dataset[name])
        for number, (part, data) in enumerate(_parts(dataset[name])):
            stem = "_".join([Path(cube).stem, *(_FORBIDDEN.sub("-", word) for word in (part, suffix) if word)])
            if any(path.stem == stem for path in written):  # differs only in characters not allowed in names
                stem += f"_{len(written)}"
            low, high = limits[number] if limits else (0.0, 0.0)
            title = f"{part} ({low:.4g}-{high:.4g} um)" if limits else part or name
            grey = "gray_r" if colours_of(name, low) == "gray_r" else "gray"
            _contact_sheet(dataset, data, title, frames, grey, drawn(folder / f"{stem}.png"))
            if animation and data.sizes["time"] > 1:
                _animation(data, grey, drawn(folder / f"{stem}.gif"))
    return written


def _variable(dataset: xr.Dataset, requested: str | None) -> str:
    """Return the variable to draw."""
    known = [str(name) for name, data in dataset.data_vars.items() if {"time", "y", "x"} <= set(data.dims)]
    if requested in known:
        return str(requested)
    if requested is not None:
        exists = requested.startswith(TERM_PREFIX) or requested in {spec.name for spec in VARIABLES}
        run = f"; run the scenario with --set 'output.variables=[\"{requested}\"]'" if exists else ""
        raise CubeError(f"the cube holds no '{requested}'; {choose_from(requested, known)}{run}")
    for name in DRAWN:
        if name in known:
            return name
    raise CubeError(f"the cube holds none of {', '.join(DRAWN)}; name a variable; {choose_from('', known)}")


def _parts(data: xr.DataArray) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield each band or layer (time, y, x) with its name; without them, all data with an empty name."""
    others = [dim for dim in data.dims if dim not in ("time", "y", "x")]
    if not others:
        yield "", data
        return
    for index, name in enumerate(data[others[0]].to_numpy()):
        yield str(name), data.isel({others[0]: index})


def _thin(data: xr.DataArray) -> xr.DataArray:
    step = max(1, -(-max(data.sizes["x"], data.sizes["y"]) // PIXELS_SHOWN))
    return data.isel(x=slice(None, None, step), y=slice(None, None, step))


def _contact_sheet(dataset: xr.Dataset, data: xr.DataArray, band: str, frames: int, grey: str, path: Path) -> None:
    count = min(frames, data.sizes["time"])
    chosen = np.unique(np.linspace(0, data.sizes["time"] - 1, count).round().astype(int))
    shown = _thin(data.isel(time=chosen)).load()
    columns = min(4, chosen.size)
    rows = -(-chosen.size // columns)
    # A single frame gets a large panel; many frames share the page width.
    panel = 5.5 if chosen.size == 1 else 3.0
    height = panel * min(max(data.sizes["y"] / data.sizes["x"], 0.3), 3.0)
    figure = Figures.new(panel * columns + 1.6, (height + 0.3) * rows + 0.9)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    scale = ColourScale.of(shown.to_numpy(), grey)
    limits = {"vmin": scale.low, "vmax": scale.high}
    on_ground = dataset["x"].attrs.get("units") == "m"
    unit = 1e3 if on_ground else 1.0
    x, y = shown["x"].to_numpy() / unit, shown["y"].to_numpy() / unit
    half = float(dataset["x"][1] - dataset["x"][0]) / (2.0 * unit) if dataset.sizes["x"] > 1 else 0.5
    up = half if on_ground else -half
    extent = (x[0] - half, x[-1] + half, y[0] - up, y[-1] + up)
    start = dataset["time"].to_numpy()[0]
    for axis, position in zip(axes, range(chosen.size), strict=False):
        frame = shown.isel(time=position)
        image = axis.imshow(
            frame.to_numpy(), origin="lower", extent=extent, cmap=grey, interpolation="nearest", **limits
        )
        axis.set_facecolor(MISSING)
        axis.set_title(f"frame {chosen[position]}, {time_label(frame['time'].to_numpy(), start)}", fontsize=9)
        axis.tick_params(labelsize=7)
        axis.locator_params(nbins=5)
    for axis in axes[chosen.size :]:
        axis.set_visible(False)
    figure.supxlabel("x (km, east)" if on_ground else "column", fontsize=9)
    figure.supylabel("y (km, north)" if on_ground else "row", fontsize=9)
    ends = scale.below, scale.above
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get(ends, "neither")
    bar = figure.colorbar(image, ax=axes[: chosen.size].tolist(), shrink=0.85, extend=extend)
    units = str(shown.attrs.get("units", ""))
    units = {"W m-2 sr-1": "W m$^{-2}$ sr$^{-1}$", "1": ""}.get(units, units)
    missing = "; blue: no value" if scale.missing else ""
    bar.set_label(Figures.axis_label(str(shown.name).replace("_", " "), units) + missing)
    title = f"{dataset.attrs.get('title', '')} — {band} — t from {np.datetime_as_string(start, unit='ms')}Z"
    figure.suptitle(textwrap.fill(title, int(13 * figure.get_figwidth())), fontsize=10)
    with Writing(path, CubeError) as draft:
        figure.savefig(draft, dpi=110, format="png")


def time_label(time: np.datetime64 | NDArray[Any], start: np.datetime64) -> str:
    """Format the time since the first frame, to the microsecond."""
    seconds = (time - start) / np.timedelta64(1, "ns") * 1e-9
    text = f"{float(seconds):.6f}".rstrip("0").rstrip(".")
    return f"t = {text} s"


def _animation(data: xr.DataArray, colours: str, path: Path) -> None:
    from PIL import Image, ImageDraw, ImageFont

    step = max(1, -(-data.sizes["time"] // _FRAMES_ANIMATED))
    chosen = _thin(data.isel(time=slice(None, None, step)))
    scale = ColourScale.of(chosen.isel(time=slice(None, None, max(1, chosen.sizes["time"] // 8))).to_numpy(), colours)
    # The step in time may vary, so each frame shows its own time.
    start = data["time"].to_numpy()[0]
    labels = [time_label(time, start) for time in chosen["time"].to_numpy()]
    font = ImageFont.load_default(LABEL_PIXELS)
    width = max(chosen.sizes["x"], *(math.ceil(font.getlength(label)) + 4 for label in labels))
    strip = LABEL_PIXELS + 6
    images = []
    for index, label in enumerate(labels):
        frame = chosen.isel(time=index).to_numpy()[::-1]
        grey = np.clip((frame - scale.low) / (scale.high - scale.low), 0, 1)
        grey = 1.0 - grey if colours == "gray_r" else grey
        picture = Image.new("L", (width, chosen.sizes["y"] + strip), 0)
        picture.paste(Image.fromarray((np.nan_to_num(grey) * 255).round().astype(np.uint8)), (0, strip))
        ImageDraw.Draw(picture).text((2, 2), label, fill=255, font=font)
        images.append(picture)
    with Writing(path, CubeError) as draft:
        rest = {"append_images": images[1:], "duration": FRAME_DURATION_MS, "loop": 0}
        images[0].save(draft, format="GIF", save_all=True, **rest)
