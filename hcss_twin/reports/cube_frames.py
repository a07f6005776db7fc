"""Selection of the frames on a cube page: variables, frames, number of pixels, and statistics.

A page must be small enough to send, so its pictures have a budget in bytes. A large cube is read in part: some frames,
and every n-th row and column of large frames.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageError
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.reports.colour_scale import ColourScale, is_stretched
from hcss_twin.reports.power_spectrum import Rings
from hcss_twin.reports.shown_image import KELVIN, ShownVariable, with_kelvin

if TYPE_CHECKING:
    import xarray as xr


__all__ = ["Reader"]

SPECTRUM_SIDE = 32
"""Shortest side of an image with a spectrum, pixels."""

READ_PIXELS = 1_000_000
"""Maximum number of pixels read per plane; larger planes are thinned to every n-th row and column."""

READ_BYTES = 6_000_000_000
"""Maximum number of bytes read for all frames shown; at least one frame is read."""

WINDOW_PIXELS = 1024
"""Side of the central part of a frame whose spectrum is computed."""

PICTURE_BYTES = 6_400_000
"""Budget of all frame pictures in bytes; base64 in the page adds a third."""

FRAMES = 24
"""Frames shown of brightness temperature, or of the first quantity."""

OTHER_FRAMES = 8
"""Frames shown of every other quantity."""

HISTOGRAM_BINS = 120

_PICTURES = 480  # first quantity, then the others: fewer frames if there are very many bands
_FIRST_SHARE = 0.55  # fraction of the bytes for the first quantity
_UNITS = {"W m-2 sr-1": "W m⁻² sr⁻¹", "s-1": "s⁻¹", "1": ""}


@dataclass(frozen=True)
class Reader:
    """Reads planes of an open cube; for large frames only every ``step``-th row and column.

    Attributes
    ----------
    CURVES : tuple of str
        Quantities with a histogram, a spectrum and a time series of the mean; they are shown first.
    """

    CURVES: ClassVar = (KELVIN, "radiance")

    @dataclass(frozen=True)
    class Quantity:
        """A variable of a cube with image frames.

        Attributes
        ----------
        name : str
            Name of the variable.
        label, units : str
            Label and units as shown; units are empty for dimensionless values.
        dim : str or None
            The additional dimension besides time, y and x: ``band`` or ``layer``.
        parts : tuple of str
            Names along this dimension; one empty name without it.
        flags : tuple of str
            Meanings of 0, 1, ... of a variable of flags.
        shown : ShownVariable
            What its planes are read from.
        """

        name: str
        label: str
        units: str
        dim: str | None
        parts: tuple[str, ...]
        flags: tuple[str, ...]
        shown: ShownVariable

    dataset: xr.Dataset
    step: int

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Reader:
        """Return the reader of a cube."""
        pixels = dataset.sizes["y"] * dataset.sizes["x"]
        return cls(dataset, max(1, math.ceil(math.sqrt(pixels / READ_PIXELS))))

    def plane(self, quantity: Quantity, part: int, frame: int) -> NDArray[Any]:
        """Return one plane (y, x), thinned to every ``step``-th row and column."""
        every = slice(None, None, self.step)
        return self._read(quantity, part, frame, every, every)

    def mean(self, quantity: Quantity, part: int, frame: int) -> float:
        """Return the mean of the pixels of :meth:`plane`; NaN if none has a value."""
        return FrameNumbers.of(self.plane(quantity, part, frame)).mean

    def window(self, quantity: Quantity, part: int, frame: int) -> NDArray[Any]:
        """Return the centre of one plane at full resolution, at most ``WINDOW_PIXELS`` squared."""
        rows, columns = (_middle(self.dataset.sizes[dim]) for dim in ("y", "x"))
        return self._read(quantity, part, frame, rows, columns)

    def _read(self, quantity: Quantity, part: int, frame: int, rows: slice, columns: slice) -> NDArray[Any]:
        return quantity.shown.read(part, time=frame, y=rows, x=columns)

    def bytes_moved(self, quantity: Quantity) -> int:
        """Number of bytes read for one frame of all parts: whole tiles, else the selected rows."""
        data = quantity.shown.data
        whole = data.dtype.itemsize * data.size // max(1, data.sizes["time"])
        tiled = bool(data.encoding.get("chunks") or data.encoding.get("chunksizes"))
        return whole if tiled or self.step == 1 else whole // self.step

    @staticmethod
    def quantities(dataset: xr.Dataset) -> list[Reader.Quantity]:
        """Return all variables with frames, ordered: brightness temperature and radiance, terms, others."""
        listed = []
        for name, shown in with_kelvin(dataset).items():
            is_term = name.startswith(TERM_PREFIX)
            label = (f"{name.removeprefix(TERM_PREFIX)} (term)" if is_term else name).replace("_", " ")
            units = _UNITS.get(shown.units, shown.units)
            listed.append(Reader.Quantity(name, label, units, shown.dim, shown.parts, shown.flags, shown))
        order = {name: number for number, name in enumerate(Reader.CURVES)}
        return sorted(
            listed, key=lambda quantity: order.get(quantity.name, 2 if quantity.name.startswith(TERM_PREFIX) else 3)
        )

    @staticmethod
    def scale(quantity: Quantity, part: int, planes: NDArray[Any]) -> ColourScale:
        """Return the colour scale of planes (..., y, x) of one part."""
        colours, stretched = quantity.shown.colours(part), is_stretched(quantity.name)
        return ColourScale.of(planes, colours, quantity.flags, stretched)

    @staticmethod
    def spread(count: int, wanted: int) -> list[int]:
        """Return at most ``wanted`` evenly spaced numbers from 0 to ``count - 1``, including the ends."""
        chosen = np.unique(np.linspace(0, count - 1, min(count, max(1, wanted))).round().astype(int))
        return [int(number) for number in chosen]

    @staticmethod
    def binned(plane: NDArray[Any], binning: int, flags: bool) -> NDArray[Any]:
        """Return means over squares of pixels, cut off at the upper edges; flags are subsampled.

        Missing values are ignored; a square without values is missing.
        """
        if binning == 1:
            return plane
        if flags:
            return plane[::binning, ::binning]
        starts = [np.arange(0, size, binning) for size in plane.shape]

        def sums(values: NDArray[Any]) -> NDArray[Any]:
            partial = np.add.reduceat(values.astype(np.float64), starts[0], axis=0)
            total: NDArray[Any] = np.add.reduceat(partial, starts[1], axis=1)
            return total

        known = np.isfinite(plane)
        count = sums(known)
        with np.errstate(invalid="ignore"):
            return np.asarray(sums(np.where(known, plane, 0.0)) / np.where(count > 0, count, np.nan))


def _middle(size: int) -> slice:
    first = max(0, (size - WINDOW_PIXELS) // 2)
    return slice(first, min(size, first + WINDOW_PIXELS))


@dataclass(frozen=True)
class FrameSpectrum:
    """Power spectrum averaged over directions.

    Attributes
    ----------
    cycles_per_km : ndarray (K,)
        Mean wavenumber of each ring, four rings per octave.
    power : ndarray (K,)
        Mean power density in the ring, units of the image squared times km squared; its integral over the plane of
        wavenumbers is the variance.
    """

    cycles_per_km: Array
    power: Array


def frame_spectrum(images: Iterable[NDArray[Any]], pixel_size_m: float) -> FrameSpectrum | None:
    """Return the mean spectrum of images (y, x) of one shape, or None if no image has one.

    Images below 32 x 32 pixels, which have too few scales, with missing values, or that are exact planes have none.
    """
    spectra = []
    for image in images:
        if min(image.shape) >= SPECTRUM_SIDE:
            with suppress(ImageError):
                spectra.append(Rings.of(image))
    if not spectra:
        return None
    full = spectra[0].waves > 0
    pixel_km = pixel_size_m / 1e3
    power = np.mean([spectrum.power[full] for spectrum in spectra], axis=0)
    return FrameSpectrum(spectra[0].wavenumber[full] / pixel_km, power * pixel_km**2)


@dataclass(frozen=True)
class FrameNumbers:
    """Mean, minimum and maximum of the pixels read from one frame; NaN if none has a value."""

    mean: float
    lowest: float
    highest: float

    @classmethod
    def of(cls, plane: NDArray[Any]) -> FrameNumbers:
        """Return the statistics of a plane."""
        known = plane[np.isfinite(plane)] if plane.dtype.kind == "f" else plane.ravel()
        if not known.size:
            return cls(np.nan, np.nan, np.nan)
        return cls(float(known.mean(dtype=np.float64)), float(known.min()), float(known.max()))


@dataclass(frozen=True)
class Series:
    """The shown frames of a quantity in one band or layer.

    Attributes
    ----------
    quantity : Reader.Quantity
    part : str
        Name of the band or layer, or empty.
    frames : tuple of int
        Numbers of the shown frames in the cube.
    scale : ColourScale
    pictures : tuple of bytes
        A PNG for each frame.
    numbers : tuple of FrameNumbers
    histogram : (counts, edges) or None
        Histogram of all values read, for radiation.
    spectrum : FrameSpectrum or None
        Mean spectrum over the frames, for radiation.
    """

    quantity: Reader.Quantity
    part: str
    frames: tuple[int, ...]
    scale: ColourScale
    pictures: tuple[bytes, ...]
    numbers: tuple[FrameNumbers, ...]
    histogram: tuple[NDArray[Any], NDArray[Any]] | None
    spectrum: FrameSpectrum | None


@dataclass(frozen=True)
class FrameSelection:
    """Frames shown for a group of quantities, and the binning of the rows and columns read."""

    frames: tuple[int, ...]
    binning: int


def read_all(reader: Reader, shown: Sequence[Reader.Quantity]) -> tuple[list[Series], FrameSelection, FrameSelection]:
    """Read the data of a cube that the page shows.

    Returns
    -------
    series : list of Series
        Each part of each quantity.
    first, others : FrameSelection
        Selections for the first quantity and for the others.
    """
    groups = [list(shown[:1]), list(shown[1:])]
    left = float(PICTURE_BYTES)
    series: list[Series] = []
    selections = []
    for group, most in zip(groups, (FRAMES, OTHER_FRAMES), strict=True):
        budget = left * (_FIRST_SHARE if group is groups[0] and groups[1] else 1.0)
        selection = _select(reader, group, budget, most)
        group_series = _read(reader, group, selection)
        while _size(group_series) > budget and _side(group_series) > 1:
            larger = max(selection.binning + 1, math.floor(selection.binning * math.sqrt(_size(group_series) / budget)))
            selection = replace(selection, binning=larger)
            group_series = _read(reader, group, selection)
        left -= _size(group_series)
        series += group_series
        selections.append(selection)
    return series, selections[0], selections[1]


def _select(reader: Reader, group: Sequence[Reader.Quantity], budget: float, most: int) -> FrameSelection:
    parts = sum(len(quantity.parts) for quantity in group)
    if not parts:
        return FrameSelection((), 1)
    moved = sum(reader.bytes_moved(quantity) for quantity in group)
    affordable = int(READ_BYTES / 2 // max(1, moved))
    frames = Reader.spread(reader.dataset.sizes["time"], max(1, min(most, affordable, _PICTURES // parts)))
    # the size of the other planes is estimated from one plane of each quantity
    samples = [(quantity, reader.plane(quantity, 0, frames[len(frames) // 2])) for quantity in group]
    binning = 1
    while True:
        size = 0
        for quantity, plane in samples:
            shown = Reader.binned(plane, binning, bool(quantity.flags))
            size += len(reader.scale(quantity, 0, shown[None]).png(shown)) * len(quantity.parts) * len(frames)
        if size <= budget or max(shown.shape) == 1:
            return FrameSelection(tuple(frames), binning)
        binning = max(binning + 1, math.floor(binning * math.sqrt(size / budget)))


def _read(reader: Reader, group: Sequence[Reader.Quantity], selection: FrameSelection) -> list[Series]:
    orders: dict[tuple[str, ...], list[int]] = {}  # the same for all: a band has one place, and one line, on a page
    for quantity in group:
        orders[quantity.parts] = orders.get(quantity.parts) or quantity.shown.order()
    return [_series(reader, quantity, part, selection) for quantity in group for part in orders[quantity.parts]]


def _series(reader: Reader, quantity: Reader.Quantity, part: int, selection: FrameSelection) -> Series:
    frames = selection.frames
    planes = np.stack([reader.plane(quantity, part, frame) for frame in frames])
    shown = [Reader.binned(plane, selection.binning, bool(quantity.flags)) for plane in planes]
    scale = reader.scale(quantity, part, np.stack(shown))
    histogram = spectrum = None
    if quantity.name in Reader.CURVES:
        x = reader.dataset["x"]
        if planes.shape[2] > 1 and x.attrs.get("units") == "m":  # other images have no pixel size
            windows = (reader.window(quantity, part, frame) for frame in frames)
            spectrum = frame_spectrum(windows, float(x[1] - x[0]))
        known = planes[np.isfinite(planes)].astype(np.float64)
        if known.size and known.max() > known.min():
            histogram = np.histogram(known, HISTOGRAM_BINS)
    pictures = tuple(scale.png(plane) for plane in shown)
    numbers = tuple(FrameNumbers.of(plane) for plane in planes)
    return Series(quantity, quantity.parts[part], frames, scale, pictures, numbers, histogram, spectrum)


def _size(series: Sequence[Series]) -> int:
    return sum(len(picture) for part in series for picture in part.pictures)


def _side(series: Sequence[Series]) -> int:
    return max(png_size(series[0].pictures[0]))


def png_size(picture: bytes) -> tuple[int, int]:
    """Return width and height in pixels from the header of a PNG."""
    return int.from_bytes(picture[16:20], "big"), int.from_bytes(picture[20:24], "big")
