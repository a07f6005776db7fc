"""What the table of a cube's variables says of one of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Kind = Literal["radiance", "truth", "derived", "coordinate", "geometry"]

FRAME = ("time", "y", "x")
BAND_FRAME = ("time", "band", "y", "x")
LAYER = "layer"
LAYER_FRAME = ("time", LAYER, "y", "x")


@dataclass(frozen=True)
class VariableSpec:
    """One variable of the cube.

    Attributes
    ----------
    name : str
        Name in the file.
    dims : tuple of str
        Dimensions, in order.
    dtype : str
        NumPy name of the type in the file; arrays given to the writer must have it already. Text is ``str``.
    units : str or None
        UDUNITS string; None for text.
    long_name : str
        One line for plots.
    kind : {"radiance", "truth", "derived", "coordinate", "geometry"}
        ``radiance``: total and its terms; ``truth``: state of the scene; ``derived``: computed from radiance;
        ``geometry``: coordinates of every pixel, written on request.
    description : str
        Definition, in a sentence or two; written as ``comment``.
    standard_name : str or None
        CF standard name.
    attributes : mapping
        Further attributes of the variable in the file.
    lowest, highest : float or None
        Inclusive limits of the values; None: no limit.
    may_be_missing : bool
        Whether NaN is a value, meaning that the quantity does not exist in the pixel.
    significant_bits : int or None
        Explicit bits of the mantissa to which values are rounded; None: all.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str | None
    long_name: str
    kind: Kind
    description: str
    standard_name: str | None = None
    attributes: Mapping[str, str | float | NDArray[np.uint8]] = field(default_factory=dict)
    lowest: float | None = None
    highest: float | None = None
    may_be_missing: bool = False
    significant_bits: int | None = None

    @property
    def needs_radiance(self) -> bool:
        """Whether the radiance of pixels has to be computed for it."""
        return self.kind in ("radiance", "derived")
