"""16-bit PNG: one greyscale image per frame and band, with scale and offset for conversion to values.

Values are ``offset + scale * sample``; both are in text chunks of the file (section 11.3.4 of the PNG specification,
third edition, W3C 2025) and in the accompanying JSON.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_export.description import ascii_text, count_missing, description, first_row, image_name, json_text
from hcss_export.projection import Projection
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import CubeError

LARGEST = 65535
"""Largest sample."""


@dataclass(frozen=True)
class Scaling:
    """Conversion of samples to values: ``offset + scale * sample``.

    Attributes
    ----------
    scale, offset : float
    missing_sample : int or None
        Sample of a missing value; None if none can be missing.
    largest_error : float
        Largest error of rounding to samples.
    lowest, highest : float or None
        Values of the samples 1 (or 0 if none can be missing) and 65535; None if there are no values.
    """

    scale: float
    offset: float
    missing_sample: int | None
    largest_error: float
    lowest: float | None
    highest: float | None


def scalings(selection: FrameSelection, limits: tuple[float, float] | None) -> tuple[Scaling, ...]:
    """Return the scaling of each plane, common to all its frames.

    Whole numbers from 0 to 65535 (masks, digital numbers) are their own samples. Other values use 1 to 65535 between
    the smallest and the largest of all frames, or between the limits; 0 is a missing value.

    Parameters
    ----------
    limits : (float, float) or None
        Values of the samples 1 and 65535 of every plane.

    Raises
    ------
    CubeError
        If a value lies outside the limits, or is infinite.
    """
    lowest = np.full(len(selection.planes), np.inf)
    highest = np.full(len(selection.planes), -np.inf)
    for frame in selection.frames:
        for index, image in enumerate(selection.values(frame)):
            span = _range(image)
            if span is None:
                continue
            if np.any(np.isinf(span)):
                where = image_name(frame, selection.planes[index])
                raise CubeError(f"{selection.variable}, {where}: a value is infinite, which PNG cannot store")
            if limits is not None and not limits[0] <= span[0] <= span[1] <= limits[1]:
                raise CubeError(
                    f"{selection.variable}, {image_name(frame, selection.planes[index])}: values from {span[0]:g} to "
                    f"{span[1]:g}; the limits {limits[0]:g} to {limits[1]:g} must include all of them"
                )
            lowest[index], highest[index] = min(lowest[index], span[0]), max(highest[index], span[1])
    whole = selection.dtype.kind in "iu" and limits is None
    if whole and lowest.min() >= 0 and highest.max() <= LARGEST:
        return (Scaling(1.0, 0.0, None, 0.0, 0.0, float(LARGEST)),) * len(selection.planes)
    return tuple(_between(*(limits or (float(low), float(high)))) for low, high in zip(lowest, highest, strict=True))


def write_png(
    selection: FrameSelection,
    projection: Projection | None,
    source: str,
    frame: FrameSelection.Frame,
    scaling: tuple[Scaling, ...],
    paths: Sequence[Path],
) -> int:
    """Write the images of one frame, northernmost row first; return the number of missing values.

    Parameters
    ----------
    projection : Projection or None
        Of the cube.
    source : str
        Name of the cube's file.
    frame : FrameSelection.Frame
        One of the selection.
    scaling : tuple of Scaling
        One per plane.
    paths : sequence of Path
        New files, one per plane.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    values = selection.values(frame)
    for image, plane, how, path in zip(values, selection.planes, scaling, paths, strict=True):
        notes = PngInfo()
        for key, text in _notes(selection, projection, source, frame, plane, how).items():
            notes.add_text(key, text)
        picture = Image.fromarray(_samples(image[::-1], how))
        picture.save(path, format="PNG", pnginfo=notes)
    return count_missing(values)


def sidecar(
    selection: FrameSelection,
    projection: Projection | None,
    source: str,
    scaling: tuple[Scaling, ...],
    names: Sequence[Sequence[str]],
) -> str:
    """Return the accompanying JSON text: the description, and each image with its scaling.

    Parameters
    ----------
    names : sequence of sequence of str
        File names of the images by frame and plane.
    """
    pictures = [
        {"file": name, "plane": plane.name, "frame": frame.number, "time": frame.time, **asdict(how)}
        for frame, of_frame in zip(selection.frames, names, strict=True)
        for name, plane, how in zip(of_frame, selection.planes, scaling, strict=True)
    ]
    return json_text(
        {
            **description(selection, projection, source),
            "row_order": f"{first_row(selection)} first",
            "formula": "value = offset + scale * sample",
            "pictures": pictures,
        }
    )


def _range(image: NDArray[Any]) -> tuple[float, float] | None:
    """Return the smallest and largest values; None if all are missing."""
    low, high = np.fmin.reduce(image, axis=None), np.fmax.reduce(image, axis=None)
    if np.isnan(low):
        return None
    return float(low), float(high)


def _between(low: float, high: float) -> Scaling:
    if low > high:
        return Scaling(0.0, 0.0, 0, 0.0, None, None)
    step = (high - low) / (LARGEST - 1)
    # sample 1 is the lowest value, so that 0 is free for missing values
    return Scaling(step, low - step, 0, 0.5 * step, low, high)


def _samples(image: NDArray[Any], how: Scaling) -> NDArray[np.uint16]:
    if how.missing_sample is None:
        return image.astype(np.uint16)
    missing = np.isnan(image)
    steps = np.where(missing, 0.0, image - np.float64(how.lowest or 0.0))
    samples = 1.0 + (np.rint(steps / how.scale) if how.scale > 0.0 else np.zeros_like(steps))
    # rounding errors must not raise a sample above the largest
    whole: NDArray[np.uint16] = np.where(missing, 0.0, np.minimum(samples, LARGEST)).astype(np.uint16)
    return whole


def _notes(
    selection: FrameSelection,
    projection: Projection | None,
    source: str,
    frame: FrameSelection.Frame,
    plane: FrameSelection.Plane,
    how: Scaling,
) -> dict[str, str]:
    return {
        "Title": ascii_text(f"{selection.variable}, {image_name(frame, plane)}"),
        "Source": ascii_text(source),
        "Description": f"value = {how.offset!r} + {how.scale!r} * sample; in {selection.units or 'no unit'}",
        "hcss_variable": selection.variable,
        "hcss_units": selection.units,
        "hcss_scale": repr(how.scale),
        "hcss_offset": repr(how.offset),
        "hcss_missing_sample": "none" if how.missing_sample is None else str(how.missing_sample),
        "hcss_plane": ascii_text(plane.name),
        "hcss_frame": "all" if frame.number is None else str(frame.number),
        "hcss_time": frame.time,
        "hcss_description": json_text(
            {
                **description(selection, projection, source),
                "frames": [vars(frame)],
                "planes": [vars(plane)],
                "row_order": f"{first_row(selection)} first",
            }
        ),
    }
