"""Picture files: contact sheets and animations of cubes."""

from __future__ import annotations

import math
import re
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.cube.reader import open_cube
from hcss_twin.reports.colour_scale import MISSING, ColourScale, colour_map, is_stretched, tick_texts
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.orientation import Orientation, length_text
from hcss_twin.reports.shown_image import KELVIN, ShownImage, require_variable, with_kelvin

if TYPE_CHECKING:
    import xarray as xr

PIXELS_SHOWN = 800
"""Longest side of a drawn frame; larger frames are thinned, which keeps the values of the shown pixels exact."""

FRAME_DURATION_MS = 250

LABEL_PIXELS = 12
"""Font size of the title of each frame in an animation."""

_FRAMES_ANIMATED = 200
_SIDE_IN = 1.9
_ARROWS = {"N": "black", "sun": "#a86400", "sensor": "#0b5c97"}
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
    linear: bool = False,
    replace: bool = False,
) -> list[Path]:
    """Draw a variable of a cube, each band or cloud layer separately, the band with most to see first.

    Parameters
    ----------
    cube : path
        A finished cube.
    folder : path
        Folder of the pictures; created if missing.
    kelvin : bool
        Show brightness temperature, and raise if the cube has none; without it, radiance is drawn then.
    frames : int
        Frames per contact sheet, spread evenly over the cube.
    animation : bool
        Also write a GIF of all frames (at most 200) per band.
    variable : str, optional
        Default: brightness temperature, or the first of ``DRAWN`` in the cube.
    linear : bool
        Draw every variable on a linear scale; without it, frequent values of radiance and brightness temperature have
        more contrast.
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
        wanted = KELVIN if kelvin else variable
        images = with_kelvin(dataset, required=wanted == KELVIN)
        name = require_variable(images, wanted)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CubeError(f"cannot write to {folder}: {error.strerror}") from error
        suffix = {"radiance": "", KELVIN: "kelvin"}.get(name, name)
        for image in ShownImage.ordered(images[name]):
            stem = "_".join([Path(cube).stem, *(_FORBIDDEN.sub("-", word) for word in (image.part, suffix) if word)])
            if any(path.stem == stem for path in written):  # differs only in characters not allowed in names
                stem += f"_{len(written)}"
            _contact_sheet(dataset, image, frames, linear, drawn(folder / f"{stem}.png"))
            if animation and image.frames > 1:
                _animation(image, linear, drawn(folder / f"{stem}.gif"))
    return written


def _step(image: ShownImage) -> int:
    return max(1, -(-max(image.shape) // PIXELS_SHOWN))


def _scale(image: ShownImage, shown: NDArray[Any], linear: bool, flags: tuple[str, ...]) -> ColourScale:
    return ColourScale.of(shown, image.colours, flags, is_stretched(image.name) and not (linear or image.flags))


def _contact_sheet(dataset: xr.Dataset, image: ShownImage, frames: int, linear: bool, path: Path) -> None:
    count = min(frames, image.frames)
    chosen = np.unique(np.linspace(0, image.frames - 1, count).round().astype(int))
    step = _step(image)
    shown = image.values(chosen, step)
    columns = min(4, chosen.size)
    rows = -(-chosen.size // columns)
    # A single frame gets a large panel; many frames share the page width.
    panel = 5.5 if chosen.size == 1 else 3.0
    height = panel * min(max(image.shape[0] / image.shape[1], 0.3), 3.0)
    figure = Figures.new(panel * columns + _SIDE_IN, max((height + 0.3) * rows + 0.5, 3.6))
    grid = figure.add_gridspec(rows, columns + 1, width_ratios=[panel] * columns + [_SIDE_IN])
    scale = _scale(image, shown, linear, image.flags)
    norm, colours = _norm(scale)
    start = dataset["time"].to_numpy()[0]
    where = Orientation.of(dataset)
    for number, frame in enumerate(chosen):
        axis = figure.add_subplot(grid[number // columns, number % columns])
        drawn = axis.imshow(shown[number], origin="lower", cmap=colours, norm=norm, interpolation="nearest")
        axis.set_facecolor(MISSING)
        axis.set_xticks([])
        axis.set_yticks([])
        axis.set_title(f"frame {frame}, {time_label(dataset['time'].to_numpy()[frame], start)}", fontsize=9)
        if where is not None and number == 0:
            _scale_bar(axis, where, image.shape[1], step)
    side = grid[:, columns].subgridspec(2, 1, height_ratios=[1.7, 1.0])
    _colour_bar(figure, figure.add_subplot(side[0]), drawn, scale, image)
    if where is not None:
        _compass(figure.add_subplot(side[1]), where)
    band = f"{image.part} ({image.limits_um[0]:.4g}-{image.limits_um[1]:.4g} µm)" if image.limits_um else image.part
    what = ", ".join(word for word in (image.label, band, f"from {np.datetime_as_string(start, unit='s')}Z") if word)
    title = textwrap.fill(str(dataset.attrs.get("title", "")), int(13 * figure.get_figwidth()))
    figure.suptitle(f"{title}\n{what}", fontsize=10)
    with Writing(path, CubeError) as draft:
        figure.savefig(draft, dpi=110, format="png")


def axes_of_frame(dataset: xr.Dataset, image: ShownImage, frame: int, linear: bool, axis: Any) -> Any:
    """Draw one frame with its colour bar and scale bar into axes of matplotlib; returns them."""
    step = _step(image)
    values = image.values([frame], step)
    scale = _scale(image, values, linear, image.flags)
    norm, colours = _norm(scale)
    drawn = axis.imshow(values[0], origin="lower", cmap=colours, norm=norm, interpolation="nearest")
    axis.set(facecolor=MISSING, xticks=[], yticks=[])
    words = (str(dataset.attrs.get("title", "")), image.part, time_label(image.times[frame], image.times[0]))
    axis.set_title(", ".join(word for word in words if word), fontsize=10)
    where = Orientation.of(dataset)
    if where is not None:
        _scale_bar(axis, where, image.shape[1], step)
    _scaled_bar(axis.figure.colorbar(drawn, ax=axis, **_bar_options(scale)), scale, image)
    return axis


def _norm(scale: ColourScale) -> tuple[Any, Any]:
    """Return the scale as a norm and a colour map of matplotlib."""
    from matplotlib.colors import BoundaryNorm, FuncNorm

    colours = colour_map(scale.colours)
    if scale.flags:
        count = len(scale.flags)
        return BoundaryNorm(np.arange(count + 1) - 0.5, count), colours.resampled(count)
    return FuncNorm((scale.share_of, scale.value_at), vmin=scale.low, vmax=scale.high), colours


def _colour_bar(figure: Any, place: Any, drawn: Any, scale: ColourScale, image: ShownImage) -> None:
    place.set_axis_off()
    axis = place.inset_axes((0.0, 0.02, 0.13, 0.96))
    _scaled_bar(figure.colorbar(drawn, cax=axis, **_bar_options(scale)), scale, image)


def _bar_options(scale: ColourScale) -> dict[str, Any]:
    if scale.flags:
        return {"ticks": range(len(scale.flags))}
    ends = scale.below, scale.above
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get(ends, "neither")
    return {"ticks": scale.ticks(), "extend": extend}


def _scaled_bar(bar: Any, scale: ColourScale, image: ShownImage) -> None:
    """Label a colour bar: values where they are on the scale, or meanings of flags."""
    missing = "; blue: no value" if scale.missing else ""
    bar.ax.minorticks_off()
    bar.ax.set_yticklabels(scale.flags or tick_texts(scale.ticks()), fontsize=8)
    stretched = "\nfrequent values have more contrast" if scale.knots else ""
    units = "" if scale.flags else image.units
    bar.set_label(Figures.axis_label(image.label, units) + missing + stretched, fontsize=9)


def _scale_bar(axis: Any, where: Orientation, columns: int, step: int) -> None:
    """Draw a white bar with a dark edge, legible on any picture, in a corner of the first frame."""
    from matplotlib.patheffects import withStroke

    length_m = where.bar_m(columns)
    share = length_m / (where.column_m * columns)
    edge = [withStroke(linewidth=4.5, foreground="black")]
    line = {"color": "white", "linewidth": 2.5, "solid_capstyle": "butt", "transform": axis.transAxes}
    axis.plot([0.04, 0.04 + share], [0.05, 0.05], path_effects=edge, **line)
    edge = [withStroke(linewidth=2.0, foreground="black")]
    text = length_text(length_m) + ("" if where.is_map else " in the middle")
    axis.text(0.04, 0.075, text, color="white", fontsize=8, transform=axis.transAxes, path_effects=edge)


def _compass(axis: Any, where: Orientation) -> None:
    """Draw the directions of north, sun and sensor in the image."""
    axis.set_axis_off()
    axis.set(xlim=(-1.4, 3.0), ylim=(-2.6, 1.6), aspect="equal", anchor="SW")
    for name, (right, up) in where.arrows():
        arrow = {"arrowstyle": "-|>", "color": _ARROWS[name], "shrinkA": 0, "shrinkB": 0, "linewidth": 1.5}
        axis.annotate("", (right, up), (0.0, 0.0), arrowprops=arrow)
        if name == "N":
            axis.text(1.35 * right, 1.35 * up, name, fontsize=8, ha="center", va="center")
    for line, (name, words) in enumerate(where.words().items()):
        axis.text(-1.3, -1.5 - 0.5 * line, words, color=_ARROWS[name], fontsize=7.5, va="top")


def time_label(time: np.datetime64 | NDArray[Any], start: np.datetime64) -> str:
    """Format the time since the first frame, to the microsecond."""
    seconds = (time - start) / np.timedelta64(1, "ns") * 1e-9
    text = f"{float(seconds):.6f}".rstrip("0").rstrip(".")
    return f"t = {text} s"


def _animation(image: ShownImage, linear: bool, path: Path) -> None:
    from PIL import Image, ImageDraw, ImageFont

    numbers = np.arange(0, image.frames, max(1, -(-image.frames // _FRAMES_ANIMATED)))
    step = _step(image)
    sample = image.values(numbers[:: max(1, numbers.size // 8)], step)
    scale = _scale(image, sample, linear, ())
    # The step in time may vary, so each frame shows its own time.
    labels = [time_label(image.times[number], image.times[0]) for number in numbers]
    font = ImageFont.load_default(LABEL_PIXELS)
    rows, columns = sample.shape[1:]
    width = max(columns, *(math.ceil(font.getlength(label)) + 4 for label in labels))
    strip = LABEL_PIXELS + 6
    images = []
    for number, label in zip(numbers, labels, strict=True):  # frame by frame, because a film may be long
        grey = scale.share_of(image.values([int(number)], step)[0, ::-1].astype(np.float64))
        grey = 1.0 - grey if image.colours == "gray_r" else grey
        picture = Image.new("L", (width, rows + strip), 0)
        picture.paste(Image.fromarray((np.nan_to_num(grey) * 255).round().astype(np.uint8)), (0, strip))
        ImageDraw.Draw(picture).text((2, 2), label, fill=255, font=font)
        images.append(picture)
    with Writing(path, CubeError) as draft:
        rest = {"append_images": images[1:], "duration": FRAME_DURATION_MS, "loop": 0}
        images[0].save(draft, format="GIF", save_all=True, **rest)
