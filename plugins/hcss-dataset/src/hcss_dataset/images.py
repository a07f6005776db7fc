"""Images of 16 bits in files: PNG, read with numpy alone, and lossless JPEG XL, a quarter smaller and faster.

JPEG XL is written and read by the package imagecodecs, the extra ``jpegxl``.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_dataset import png
from hcss_dataset.errors import DatasetError

Image = NDArray[np.uint16]

SUFFIXES = {"png": ".png", "jpegxl": ".jxl"}
"""End of the names of files, by the format."""

_EFFORT = 1
"""Of JPEG XL: the next one takes three times as long for 3 % less."""


def encoded(image: Image, form: str) -> bytes:
    """Return the file of an image (y, x) in a format of :data:`SUFFIXES`.

    Raises
    ------
    DatasetError
        If its package is not installed.
    """
    if form == "png":
        return png.encoded(image)
    content: bytes = codecs().jpegxl_encode(image, effort=_EFFORT, lossless=True, numthreads=1)
    return content


def decoded(file: bytes, name: str) -> Image:
    """Return the image (y, x) of a file that :func:`encoded` made, whose format its name tells.

    Raises
    ------
    ValueError
        If it is no such file.
    DatasetError
        If its package is not installed.
    """
    if name.endswith(SUFFIXES["png"]):
        return png.decoded(file)
    reader = codecs()
    try:
        image: Image = reader.jpegxl_decode(file, numthreads=1)
    except reader.JpegxlError as error:
        raise ValueError(f"no JPEG XL file: {error}") from error
    return image


def codecs() -> Any:
    """Return the package that codes JPEG XL."""
    try:
        return importlib.import_module("imagecodecs")
    except ImportError as error:
        raise DatasetError(
            "image.format = 'jpegxl' needs imagecodecs: pip install 'hcss-dataset[jpegxl]'; allowed without it: 'png'"
        ) from error


def versions_of(form: str) -> Mapping[str, str]:
    """Return the version of what decides the bytes of a format beside this package, by its name."""
    return {} if form == "png" else {"imagecodecs": str(codecs().__version__)}
