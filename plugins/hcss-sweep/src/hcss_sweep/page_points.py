"""The points of a sweep, from its folder or dataset, and the data read from their cubes for the page."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_sweep.dataset import MARK, open_sweep
from hcss_sweep.errors import SweepError
from hcss_sweep.folder import FORMAT, INDEX
from hcss_twin import open_cube
from hcss_twin.core.reading import Reading
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import HcssError
from hcss_twin.reports.cube_frames import Reader
from hcss_twin.reports.provenance import Provenance

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    import xarray as xr


CubeOpener: TypeAlias = "Callable[[], AbstractContextManager[xr.Dataset]]"


@dataclass(frozen=True)
class PointEntry:
    """One point.

    Attributes
    ----------
    number : int
    values : mapping
        The swept keys with their values.
    state : str
        ``done``, ``failed``, ``pending``, or ``missing`` where its cube was removed.
    error : str or None
        Reason for a failure, if known.
    cube : callable or None
        Opens its cube in a ``with`` block; None if there is no cube.
    """

    number: int
    values: Mapping[str, Any]
    state: str
    error: str | None
    cube: CubeOpener | None


@dataclass(frozen=True)
class Sweep:
    """A sweep.

    Attributes
    ----------
    title : str
    keys : tuple of str
        The swept keys.
    combine : str
        Combination of values: ``product`` or ``zip``.
    points : tuple of PointEntry
    about : mapping
        Other properties of the sweep, by name.
    """

    title: str
    keys: tuple[str, ...]
    combine: str
    points: tuple[PointEntry, ...]
    about: Mapping[str, str]


@contextmanager
def opened(path: Path) -> Iterator[Sweep]:
    """Open a sweep while the block runs.

    Raises
    ------
    SweepError
        If the index of the folder cannot be read.
    CubeError
        If a file is not a dataset of a sweep.
    """
    if path.is_dir():
        yield _of_folder(path)
    else:
        with open_sweep(path) as dataset:
            yield _of_dataset(dataset, path)


def _index(path: Path) -> dict[str, Any]:
    with Reading(path, SweepError):
        index = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(index, dict) or index.get("format") != FORMAT or not isinstance(index.get("points"), list):
        raise SweepError(f"{path} is not a sweep index of this version")
    return index


def _of_folder(folder: Path) -> Sweep:
    index = _index(folder / INDEX)
    points = []
    for entry in index["points"]:
        file = folder / entry["file"] if entry.get("file") else None
        state, error, cube = entry["state"], entry.get("error"), None
        if file is not None and file.is_file():
            cube = partial(open_cube, file)
        elif file is not None:
            state, error = "missing", f"its cube {file.name} is no longer there"
        points.append(PointEntry(entry["point"], entry["values"], state, error, cube))
    about = {
        "folder": folder.resolve().name,
        "hash of the sweep": str(index["sweep"]),
        "versions": Provenance.versions(index.get("versions", {})),
        "size": f"{sum(entry.get('bytes') or 0 for entry in index['points']) / 1e6:.1f} MB",
        "computing time": f"{sum(entry.get('seconds') or 0.0 for entry in index['points']):.1f} s",
    }
    keys = tuple(index.get("keys") or dict.fromkeys(key for point in points for key in point.values))
    return Sweep(str(index.get("title") or ""), keys, str(index.get("combine", "product")), tuple(points), about)


def _of_dataset(dataset: xr.Dataset, path: Path) -> Sweep:
    dims = [str(dim) for dim in dataset["point_state"].dims]
    keys = {dim: str(dataset[dim].attrs.get("hcss_key", dim)) for dim in dims}
    values = {dim: [_plain(value) for value in dataset[dim].to_numpy()] for dim in dims}
    errors = _errors_beside(path, str(dataset.attrs[MARK]))
    states, numbers = dataset["point_state"].to_numpy(), dataset["point_number"].to_numpy()
    points = []
    for position in np.ndindex(*states.shape):
        where, number = dict(zip(dims, position, strict=True)), int(numbers[position])
        point_values = {keys[dim]: values[dim][index] for dim, index in where.items()}
        if states[position]:
            error = errors.get(number, "the error is in the index of the sweep's folder")
            points.append(PointEntry(number, point_values, "failed", error, None))
        else:
            points.append(PointEntry(number, point_values, "done", None, partial(_cube_of, dataset, where)))
    about = {
        "file": path.name,
        "hash of the sweep": str(dataset.attrs[MARK]),
        "written": str(dataset.attrs.get("date_created", "")),
        "versions": Provenance.versions(Provenance.value(dataset.attrs, "hcss_versions", {})),
    }
    return Sweep(str(dataset.attrs.get("title", "")), tuple(keys.values()), "product", tuple(points), about)


@contextmanager
def _cube_of(dataset: xr.Dataset, where: dict[str, int]) -> Iterator[xr.Dataset]:
    cube = dataset.isel(where)
    # a property that differs between points is a variable in the dataset, but a global attribute in a cube
    attributes = {
        f"hcss_{str(name).removeprefix('point_')}": cube[name].item()
        for name in cube.coords
        if str(name).startswith("point_") and not cube[name].ndim
    }
    yield cube.assign_attrs(attributes)


def _errors_beside(path: Path, digest: str) -> dict[int, str]:
    """Return the errors of points by number, if the dataset is in the folder of its sweep."""
    try:
        index = _index(path.parent / INDEX)
    except SweepError:
        return {}
    if index.get("sweep") != digest:
        return {}
    return {entry["point"]: str(entry["error"]) for entry in index["points"] if entry.get("error")}


def _plain(value: Any) -> Any:
    if isinstance(value, np.datetime64):
        return f"{np.datetime_as_string(value, unit='s')}Z"
    return value.item() if isinstance(value, np.generic) else value


READ_POINTS = 400
"""Maximum number of points whose cubes are read, evenly spread."""

READ_FRAMES = 4
"""Maximum number of frames read from each cube, evenly spread."""

PICTURES = 8
"""Maximum number of pictures per band, from evenly spread points."""

PICTURE_SIDE = 240
"""Longest side of a picture in pixels."""

_MEANS_OF = (*Reader.CURVES, "cloud_fraction", "cloud_mask")


@dataclass(frozen=True)
class PointSummary:
    """One point: means by (quantity, band) over the pixels and frames read, and the text of its certificate, if any."""

    point: PointEntry
    means: Mapping[tuple[str, str], float]
    certificate: str


@dataclass(frozen=True)
class Look:
    """The first frames (y, x) of some points in one band of a quantity."""

    quantity: Reader.Quantity
    part: int
    planes: list[tuple[PointEntry, NDArray[np.float64]]] = field(default_factory=list)


@dataclass(frozen=True)
class SweepSummary:
    """Data read from a sweep.

    Attributes
    ----------
    points : sequence of PointSummary
        Summaries of the points read.
    looks : sequence of Look
        Pictures for each band of the first quantity, that with most to see first.
    columns : mapping of (quantity, band) to Reader.Quantity
        Quantities and bands with means.
    step : int
        Step of the rows and columns read.
    frames : int
        Largest number of frames read from a point.
    unreadable : sequence of (PointEntry, str)
        Points with unreadable cubes, and the reasons.
    """

    points: Sequence[PointSummary]
    looks: Sequence[Look]
    columns: Mapping[tuple[str, str], Reader.Quantity]
    step: int
    frames: int
    unreadable: Sequence[tuple[PointEntry, str]]


def read(points: Sequence[PointEntry]) -> SweepSummary:
    """Read the cubes of points."""
    with_cube = [point for point in points if point.cube is not None]
    chosen = [with_cube[number] for number in Reader.spread(len(with_cube), READ_POINTS)] if with_cube else []
    shown = {chosen[number].number for number in Reader.spread(len(chosen), PICTURES)} if chosen else set()
    summaries: list[PointSummary] = []
    unreadable: list[tuple[PointEntry, str]] = []
    looks: dict[tuple[str, int], Look] = {}
    columns: dict[tuple[str, str], Reader.Quantity] = {}
    step = most = 1
    for point in chosen:
        assert point.cube is not None
        try:
            with point.cube() as opened:
                dataset = FrameSelection.as_seen(opened)
                present = Reader.quantities(dataset)
                reader = Reader.of(dataset)
                frames = Reader.spread(dataset.sizes["time"], READ_FRAMES)
                means: dict[tuple[str, str], float] = {}
                for quantity in [quantity for quantity in present if quantity.name in _MEANS_OF] or present[:1]:
                    for part in quantity.shown.order():
                        name = quantity.parts[part]
                        numbers = [reader.mean(quantity, part, frame) for frame in frames]
                        means[quantity.name, name] = float(np.mean(numbers))
                        columns.setdefault((quantity.name, name), quantity)
                summaries.append(PointSummary(point, means, str(dataset.attrs.get("hcss_certificate", ""))))
                step, most = max(step, reader.step), max(most, len(frames))
                if point.number in shown and present:
                    for part in present[0].shown.order():
                        look = looks.setdefault((present[0].name, part), Look(present[0], part))
                        look.planes.append((point, _small(reader, present[0], part)))
        except HcssError as error:
            unreadable.append((point, str(error)))
    return SweepSummary(summaries, list(looks.values()), columns, step, most, unreadable)


def _small(reader: Reader, quantity: Reader.Quantity, part: int) -> NDArray[np.float64]:
    plane = reader.plane(quantity, part, 0)
    binning = max(1, -(-max(plane.shape) // PICTURE_SIDE))
    return np.asarray(Reader.binned(plane, binning, bool(quantity.flags)), dtype=np.float64)
