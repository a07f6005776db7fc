"""Point metrics for small targets: one detection for one target, counted by frame, pixel and SCR.

Detections are taken from the highest score on. Each takes the nearest target of its frame that is within the radius and
that no other has taken; all others are false alarms, whatever their size. Boxes of targets of one or two pixels do not
overlap well enough for measures of overlap.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_dataset.errors import DatasetError
from hcss_twin.core.reading import Reading

SCR_EDGES = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0, math.inf)
RATES = (1e-6, 1e-5, 1e-4)
"""False alarms a pixel at which the detection rate is stated."""

COLUMNS = ("key", "row", "column", "score")


@dataclass(frozen=True)
class Detection:
    """A detection in a frame; pixel n extends from n to n + 1, and the middle of the first pixel is 0.5.

    Attributes
    ----------
    pixels : int
        Size, for detectors that give masks.
    """

    row: float
    column: float
    score: float
    pixels: int = 1


@dataclass(frozen=True)
class Scored:
    """All detections of a data set from the highest score on, and what each is.

    Attributes
    ----------
    score : ndarray (N,)
        Descending.
    hit : ndarray of int (N,)
        Number of the target that each found, -1: a false alarm, -2: a target that does not count.
    pixels : ndarray of int (N,)
        Sizes.
    scr : ndarray (T,)
        Of the targets that count.
    frames, image_pixels : int
        Number of frames, and of their pixels together.
    most : int
        Largest number of detections in a frame: where a detector keeps no more, its curve ends.
    """

    score: NDArray[np.float64]
    hit: NDArray[np.int64]
    pixels: NDArray[np.int64]
    scr: NDArray[np.float64]
    frames: int
    image_pixels: int
    ignored: int = 0
    radius: float = field(default=3.0)
    most: int = 0

    def at_threshold(self, least_score: float) -> dict[str, float]:
        """Return the measures of the detections with at least a score."""
        kept = self.score >= least_score
        false = self.hit[kept] == -1
        found = int(np.sum(self.hit[kept] >= 0))
        false_count, false_pixels = int(false.sum()), int(self.pixels[kept][false].sum())
        return {
            "threshold": least_score,
            "found": found,
            "targets": int(self.scr.size),
            "detection_rate": found / self.scr.size if self.scr.size else math.nan,
            "false_alarms": false_count,
            "false_alarms_per_frame": false_count / self.frames,
            "false_alarms_per_pixel": false_count / self.image_pixels,
            "false_pixels": false_pixels,
            "false_pixel_share": false_pixels / self.image_pixels,
            "precision": found / (found + false_count) if found + false_count else math.nan,
        }

    def curve(self) -> dict[str, NDArray[np.float64]]:
        """Return the curve over all thresholds (FROC): score, detection rate and false alarms by frame and pixel."""
        last = np.append(np.diff(self.score) < 0.0, True) if self.score.size else np.zeros(0, dtype=np.bool_)
        found, false = (np.cumsum(each)[last] for each in (self.hit >= 0, self.hit == -1))
        return {
            "score": self.score[last],
            "detection_rate": found / max(self.scr.size, 1),
            "false_alarms_per_frame": false / self.frames,
            "false_alarms_per_pixel": false / self.image_pixels,
        }

    def threshold_at(self, per_pixel: float) -> float:
        """Return the lowest threshold with at most so many false alarms a pixel; infinite if there is none."""
        curve = self.curve()
        allowed = np.flatnonzero(curve["false_alarms_per_pixel"] <= per_pixel)
        return float(curve["score"][allowed[-1]]) if allowed.size else math.inf

    def by_scr(self, least_score: float, edges: Sequence[float] = SCR_EDGES) -> list[dict[str, float]]:
        """Return how many targets of each class of SCR are found with at least a score."""
        hits = self.hit[(self.score >= least_score) & (self.hit >= 0)]
        found = np.zeros(self.scr.size, dtype=np.bool_)
        found[hits] = True
        classes = []
        for low, high in pairwise(edges):
            inside = (self.scr >= low) & (self.scr < high)
            count, of_class = int(inside.sum()), int(found[inside].sum())
            classes.append(
                {
                    "scr_from": low,
                    "scr_to": high,
                    "targets": count,
                    "found": of_class,
                    "detection_rate": of_class / count if count else math.nan,
                }
            )
        return classes


def score(
    frames: Iterable[Mapping[str, Any]],
    detections: Mapping[str, Sequence[Detection]],
    radius: float = 3.0,
    least_snr: float = 1.0,
    band: int = 0,
) -> Scored:
    """Match detections to the targets of a data set.

    Parameters
    ----------
    frames : iterable of mapping
        Labels of the frames.
    detections : mapping of str to sequence of Detection
        By the key of the frame.
    radius : float
        Largest distance of a detection from the centroid of its target, pixels.
    least_snr : float
        Targets with less do not count, and detections of them are no false alarms: clouds hide them.

    Raises
    ------
    DatasetError
        If a detection is in no frame of the data set.
    """
    rows: list[tuple[float, int, int]] = []
    scr: list[float] = []
    keys, count, pixels, ignored = set[str](), 0, 0, 0
    for labels in frames:
        keys.add(labels["key"])
        count, pixels = count + 1, pixels + labels["rows"] * labels["columns"]
        numbers, places = [], []
        for target in labels["targets"]:
            snr = target["snr"][band]
            # Without noise there is no SNR: a target that adds something counts.
            counts = bool(target["peak"][band]) if snr is None else snr >= least_snr
            numbers.append(len(scr) if counts else -2)
            places.append(target["centroid"])
            if counts:
                scr.append(math.inf if target["scr"][band] is None else target["scr"][band])
            ignored += not counts
        given = detections.get(labels["key"], ())
        for each, hit in zip(*_matched(given, np.array(places).reshape(-1, 2), numbers, radius), strict=True):
            rows.append((each.score, hit, each.pixels))
    beyond = sorted(set(detections) - keys)
    if beyond:
        raise DatasetError(f"detections in frame '{beyond[0]}', which the data set does not have; allowed: its keys")
    rows.sort(key=lambda row: -row[0])
    scores, hits, sizes = (np.array([row[n] for row in rows]) for n in range(3))
    return Scored(
        scores.astype(np.float64),
        hits.astype(np.int64),
        sizes.astype(np.int64),
        np.array(scr, dtype=np.float64),
        count,
        pixels,
        ignored,
        radius,
        max(map(len, detections.values()), default=0),
    )


def _matched(
    given: Sequence[Detection], places: NDArray[np.float64], numbers: Sequence[int], radius: float
) -> tuple[list[Detection], list[int]]:
    """Return the detections of a frame from the highest score on, and the target of each; -1: none."""
    ordered = sorted(given, key=lambda each: -each.score)
    free, hits = np.ones(len(places), dtype=np.bool_), []
    for each in ordered:
        away = np.hypot(places[:, 0] - each.row, places[:, 1] - each.column)
        away[~free] = np.inf
        nearest = int(np.argmin(away)) if away.size else -1
        if nearest < 0 or not away[nearest] <= radius:
            hits.append(-1)
            continue
        free[nearest] = False
        hits.append(numbers[nearest])
    return ordered, hits


def read_detections(path: str | Path) -> dict[str, list[Detection]]:
    """Read detections: a CSV file, results of COCO (``.json``), or a folder of masks ``KEY.png`` or ``KEY.npy``.

    A CSV file has the columns key, row, column, score and optionally pixels. The middle of a box is its detection. The
    masks of a folder may have 8 or 16 bits; each group of pixels above 0 that touch is one detection, with its highest
    value as score.

    Raises
    ------
    DatasetError
        If the file is none of these; names line and value.
    """
    path = Path(path)
    with Reading(path, DatasetError):
        if path.is_dir():
            return _from_masks(path)
        if path.suffix == ".json":
            return _from_coco(path)
        return _from_table(path)


def _from_table(path: Path) -> dict[str, list[Detection]]:
    found: dict[str, list[Detection]] = {}
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = csv.DictReader(file, skipinitialspace=True)
        names = [name.strip() for name in rows.fieldnames or []]
        rows.fieldnames = names
        missing = [name for name in COLUMNS if name not in names]
        if missing:
            raise DatasetError(f"{path}: column '{missing[0]}' is missing; allowed: {', '.join(COLUMNS)} and pixels")
        for number, row in enumerate(rows, start=2):
            place = f"{path}: line {number}"
            y, x, value = (_finite(row[name], f"{place}: {name}") for name in COLUMNS[1:])
            pixels = int(_finite(row.get("pixels") or "1", f"{place}: pixels"))
            found.setdefault(str(row["key"]).strip(), []).append(Detection(y, x, value, pixels))
    return found


def _finite(text: str | None, where: str) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DatasetError(f"{where} = '{text}'; allowed: a finite number")
    return value


def _from_coco(path: Path) -> dict[str, list[Detection]]:
    from hcss_dataset.shards import key_of

    given = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(given, list):
        raise DatasetError(f"{path}: a list of results is needed: image_id, bbox and score of each")
    found: dict[str, list[Detection]] = {}
    for number, each in enumerate(given):
        try:
            x, y, width, height = (float(edge) for edge in each["bbox"])
            key, value = key_of(int(each["image_id"])), float(each["score"])
        except (KeyError, TypeError, ValueError) as error:
            raise DatasetError(f"{path}: result {number}: image_id, bbox and score are needed") from error
        found.setdefault(key, []).append(Detection(y + 0.5 * height, x + 0.5 * width, value))
    return found


def _from_masks(folder: Path) -> dict[str, list[Detection]]:
    from PIL import Image

    found: dict[str, list[Detection]] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix == ".npy":
            mask = np.load(path, allow_pickle=False)
        elif path.suffix == ".png":
            with Image.open(path) as opened:
                mask = np.array(opened)
        else:
            continue
        if mask.ndim != 2:
            raise DatasetError(f"{path}: {mask.ndim} axes; allowed: an image (y, x)")
        found[path.name.partition(".")[0]] = of_mask(mask)
    if not found:
        raise DatasetError(f"{folder}: no masks; allowed: files KEY.png or KEY.npy")
    return found


def of_mask(mask: NDArray[Any]) -> list[Detection]:
    """Return the detections of a mask (y, x): groups of pixels above 0 that touch at sides or corners."""
    from scipy import ndimage

    groups, count = ndimage.label(mask > 0, np.ones((3, 3)))
    found = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(groups, count), start=1):
        y, x = np.nonzero(groups[rows, columns] == number)
        values = mask[rows, columns][y, x]
        row, column = rows.start + y.mean() + 0.5, columns.start + x.mean() + 0.5
        found.append(Detection(float(row), float(column), float(values.max()), int(y.size)))
    return found
