"""The points of a sweep, from its folder or from its dataset, in one form.

What is read of the cubes of a sweep: means of every band, and a few pictures.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import HcssError, SweepError
from hcss_twin.cube.reader import open_cube
from hcss_twin.report.cube_report.choice import CURVES
from hcss_twin.report.cube_report.content import Quantity, Reader, quantities, spread
from hcss_twin.report.cube_report.series import FrameNumbers, binned
from hcss_twin.sweeps.dataset import MARK, open_sweep
from hcss_twin.sweeps.folder import FORMAT, INDEX

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    import xarray as xr


CubeOpener: TypeAlias = "Callable[[], AbstractContextManager[xr.Dataset]]"


@dataclass(frozen=True)
class Point:
    """One point.

    Attributes
    ----------
    number : int
    values : mapping
        The swept keys with their values.
    state : str
        ``done``, ``failed``, ``pending``, or ``missing`` where its cube was removed.
    error : str or None
        Why it failed, where that is known.
    cube : callable or None
        Gives its cube, to be used in a ``with`` block; None where there is none.
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
        What is swept.
    combine : str
        How values are combined: ``product`` or ``zip``.
    points : tuple of Point
    about : mapping
        What else is told of it as a whole, by name.
    """

    title: str
    keys: tuple[str, ...]
    combine: str
    points: tuple[Point, ...]
    about: Mapping[str, str]


@contextmanager
def opened(path: Path) -> Iterator[Sweep]:
    """Open a sweep while the block runs.

    Raises
    ------
    SweepError
        If the index of the folder cannot be read.
    CubeError
        If a file is no dataset of a sweep.
    """
    if path.is_dir():
        yield _of_folder(path)
    else:
        with open_sweep(path) as dataset:
            yield _of_dataset(dataset, path)


def _index(path: Path) -> dict[str, Any]:
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SweepError(f"{path} cannot be read: {error}") from error
    if not isinstance(known, dict) or known.get("format") != FORMAT or not isinstance(known.get("points"), list):
        raise SweepError(f"{path} is no index of a sweep of this version")
    return known


def _of_folder(folder: Path) -> Sweep:
    known = _index(folder / INDEX)
    points = []
    for each in known["points"]:
        file = folder / each["file"] if each.get("file") else None
        there = file is not None and file.is_file()
        state, error = each["state"], each.get("error")
        if file is not None and not there:
            state, error = "missing", f"its cube {file.name} is no longer there"
        opener = _opener(file) if there and file is not None else None
        points.append(Point(each["point"], each["values"], state, error, opener))
    about = {
        "folder": str(folder.resolve().name),
        "hash of the sweep": str(known["sweep"]),
        "versions": ", ".join(f"{name} {version}" for name, version in known.get("versions", {}).items()),
        "size": f"{sum(each.get('bytes') or 0 for each in known['points']) / 1e6:.1f} MB",
        "computing time": f"{sum(each.get('seconds') or 0.0 for each in known['points']):.1f} s",
    }
    keys = tuple(known.get("keys") or dict.fromkeys(key for point in points for key in point.values))
    return Sweep(str(known.get("title") or ""), keys, str(known.get("combine", "product")), tuple(points), about)


def _opener(file: Path) -> CubeOpener:
    return lambda: open_cube(file)


def _of_dataset(dataset: xr.Dataset, path: Path) -> Sweep:
    dims = [str(dim) for dim in dataset["point_state"].dims]
    keys = {dim: str(dataset[dim].attrs.get("hcss_key", dim)) for dim in dims}
    values = {dim: [_plain(each) for each in dataset[dim].to_numpy()] for dim in dims}
    errors = _errors_beside(path, str(dataset.attrs[MARK]))
    states = dataset["point_state"].to_numpy()
    numbers = dataset["point_number"].to_numpy()
    points = []
    for place in np.ndindex(*states.shape):
        which = dict(zip(dims, place, strict=True))
        failed, number = bool(states[place]), int(numbers[place])
        points.append(
            Point(
                number,
                {keys[dim]: values[dim][index] for dim, index in which.items()},
                "failed" if failed else "done",
                errors.get(number, "the error is in the index of the sweep's folder") if failed else None,
                None if failed else _selector(dataset, which),
            )
        )
    about = {"file": path.name, "hash of the sweep": str(dataset.attrs[MARK])}
    for name, key in (("written", "date_created"), ("versions", "hcss_versions")):
        if key in dataset.attrs:
            about[name] = str(dataset.attrs[key])
    if "versions" in about:
        about["versions"] = ", ".join(f"{name} {each}" for name, each in json.loads(about["versions"]).items())
    title = str(dataset.attrs.get("title", ""))
    return Sweep(title, tuple(keys.values()), "product", tuple(points), about)


def _selector(dataset: xr.Dataset, which: dict[str, int]) -> CubeOpener:
    @contextmanager
    def chosen() -> Iterator[xr.Dataset]:
        cube = dataset.isel(which)
        # what differs between points is a variable there, and a global attribute of a cube
        own = {
            f"hcss_{str(name).removeprefix('point_')}": cube[name].item()
            for name in cube.coords
            if str(name).startswith("point_") and not cube[name].ndim
        }
        yield cube.assign_attrs(own)

    return chosen


def _errors_beside(path: Path, digest: str) -> dict[int, str]:
    """Return the errors of points by number, where the folder of the dataset is that of its sweep."""
    index = path.parent / INDEX
    if not index.is_file():
        return {}
    try:
        known = _index(index)
    except SweepError:
        return {}
    if known.get("sweep") != digest:
        return {}
    return {each["point"]: str(each["error"]) for each in known["points"] if each.get("error")}


def _plain(value: Any) -> Any:
    if isinstance(value, np.datetime64):
        return f"{np.datetime_as_string(value, unit='s')}Z"
    return value.item() if isinstance(value, np.generic) else value


READ_POINTS = 400
"""Points whose cubes are read, evenly spread."""

READ_FRAMES = 4
"""Of each of them, evenly spread."""

PICTURES = 8
"""Of each band, of points evenly spread."""

PICTURE_SIDE = 240
"""Longest side of a picture in pixels."""

_ALSO = ("cloud_fraction", "cloud_mask")

Means = Mapping[tuple[str, str], float]


@dataclass(frozen=True)
class Summary:
    """What was read of one point.

    Attributes
    ----------
    point : Point
    means : mapping of (quantity, band) to float
        Over pixels and frames that were read.
    certificate : str
        Of its cube, in words; empty where it has none.
    """

    point: Point
    means: Means
    certificate: str


@dataclass(frozen=True)
class Look:
    """Pictures to be of one band: the first frame of some points.

    Attributes
    ----------
    quantity : Quantity
    part : int
    planes : sequence of (Point, ndarray (y, x))
    """

    quantity: Quantity
    part: int
    planes: Sequence[tuple[Point, NDArray[np.float64]]]


@dataclass(frozen=True)
class Findings:
    """What was read of a sweep.

    Attributes
    ----------
    summaries : sequence of Summary
        Of the points that were read.
    looks : sequence of Look
        Of each band of radiance, or of the first quantity there is.
    columns : mapping of (quantity, band) to Quantity
        What there are means of.
    step : int
        Every so many rows and columns were read.
    frames : int
        Most frames of a point that were read.
    """

    summaries: Sequence[Summary]
    looks: Sequence[Look]
    columns: Mapping[tuple[str, str], Quantity]
    step: int
    frames: int


def read(points: Sequence[Point]) -> tuple[Findings, list[tuple[Point, str]]]:
    """Read the cubes of points.

    Returns
    -------
    Findings
    list of (Point, str)
        Points whose cube cannot be read, and why.
    """
    with_cube = [point for point in points if point.cube is not None]
    chosen = [with_cube[place] for place in spread(len(with_cube), READ_POINTS)] if with_cube else []
    shown = {chosen[place].number for place in spread(len(chosen), PICTURES)} if chosen else set()
    summaries: list[Summary] = []
    unreadable: list[tuple[Point, str]] = []
    planes: dict[tuple[str, int], list[tuple[Point, NDArray[np.float64]]]] = {}
    kinds: dict[str, Quantity] = {}
    columns: dict[tuple[str, str], Quantity] = {}
    step = most = 1
    for point in chosen:
        assert point.cube is not None
        try:
            with point.cube() as dataset:
                found = quantities(dataset)
                reader = Reader.of(dataset)
                frames = spread(dataset.sizes["time"], READ_FRAMES)
                wanted = [each for each in found if each.name in (*CURVES, *_ALSO)]
                means: dict[tuple[str, str], float] = {}
                for quantity in wanted or found[:1]:
                    for part, name in enumerate(quantity.parts):
                        numbers = [FrameNumbers.of(reader.plane(quantity, part, frame)).mean for frame in frames]
                        means[quantity.name, name] = float(np.mean(numbers))
                        columns.setdefault((quantity.name, name), quantity)
                summaries.append(Summary(point, means, str(dataset.attrs.get("hcss_certificate", ""))))
                step, most = max(step, reader.step), max(most, len(frames))
                if point.number in shown and found:
                    kinds.setdefault(found[0].name, found[0])
                    for part in range(len(found[0].parts)):
                        planes.setdefault((found[0].name, part), []).append((point, _small(reader, found[0], part)))
        except HcssError as error:
            unreadable.append((point, str(error)))
    looks = [Look(kinds[name], part, listed) for (name, part), listed in planes.items()]
    return Findings(summaries, looks, columns, step, most), unreadable


def _small(reader: Reader, quantity: Quantity, part: int) -> NDArray[np.float64]:
    plane = reader.plane(quantity, part, 0)
    return np.asarray(
        binned(plane, max(1, -(-max(plane.shape) // PICTURE_SIDE)), bool(quantity.flags)), dtype=np.float64
    )
