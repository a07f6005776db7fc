"""The scales on which chains move: unbounded or nearly so, and on which a population is normal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scale:
    """A rising function of a parameter.

    Attributes
    ----------
    kind : {"value", "logarithm", "probit"}
        The parameter itself, its natural logarithm, or the normal quantile of a fraction.
    """

    kind: Literal["value", "logarithm", "probit"]

    def of(self, value: Array) -> Array:
        """Take parameters (any shape) to the scale; ends of the range may be infinite."""
        with np.errstate(divide="ignore"):
            if self.kind == "logarithm":
                return np.asarray(np.log(value))
            return np.asarray(ndtri(value)) if self.kind == "probit" else np.asarray(value)

    def back(self, position: Array) -> Array:
        """Take positions on the scale to parameters."""
        if self.kind == "logarithm":
            return np.asarray(np.exp(position))
        return np.asarray(ndtr(position)) if self.kind == "probit" else np.asarray(position)

    def log_slope(self, position: Array) -> Array:
        """Return ln(d parameter / d position), which takes a density from the one to the other."""
        if self.kind == "logarithm":
            return np.asarray(position)
        if self.kind == "probit":
            return np.asarray(-0.5 * position * position - 0.5 * math.log(2.0 * math.pi))
        return np.zeros_like(position)


@dataclass(frozen=True)
class ParameterKind:
    """What is known of a parameter before any image.

    Attributes
    ----------
    long_name : str
        Meaning.
    low, high : float
        Open limits of what the generator takes.
    scale : Scale
        Where chains move.
    widest : float
        Greatest spread of a population on the scale, by default.
    """

    long_name: str
    low: float
    high: float
    scale: Scale
    widest: float


KINDS = {
    "H": ParameterKind("Hurst exponent", 0.0, 1.0, Scale("value"), 0.5),
    "gamma": ParameterKind(
        "gap parameter, ratio of cells of one octave to the last", 1.01, 8.0, Scale("logarithm"), 0.7
    ),
    "Lx": ParameterKind("lattice cells per 16 km along x at k = 0", 0.0, math.inf, Scale("logarithm"), 2.0),
    "Ly": ParameterKind("lattice cells per 16 km along y at k = 0", 0.0, math.inf, Scale("logarithm"), 2.0),
    "coverage": ParameterKind("cloudy fraction of the unbounded sky", 0.0, 1.0, Scale("probit"), 2.0),
}
"""Parameters of one image, in the order of all arrays."""

SHAPE = ("H", "gamma", "Lx", "Ly")
"""Those of the field's variogram."""
