"""Variables: output of the cube that is derived from radiance, truth and geometry."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import choose_from
from hcss_twin.providers.clouds import Grid
from hcss_twin.providers.column_states import View
from hcss_twin.providers.declarations import Declaration
from hcss_twin.providers.sensor import SensorBand

DTYPES = ("float32", "float64", "int32", "int16", "uint8")
"""Allowed types of output variables."""

GEOMETRY = ("latitude", "longitude", "view_zenith", "view_azimuth", "sun_zenith", "sun_azimuth")
"""Inputs of variable providers that are no variables of the cube: degrees, one value per pixel."""

_NAME = re.compile("[a-z][a-z0-9_]*")


@dataclass(frozen=True)
class OutputVariable:
    """An output variable, as the cube describes it.

    Attributes
    ----------
    units : str
        UDUNITS text; ``"1"`` for a number without dimension.
    long_name : str
        Label for plots.
    description : str
        Definition in one or two sentences.
    standard_name : str or None
        Name in the CF standard name table; None if there is none.
    per_band : bool
        Whether it has one value per band (B, y, x) or one per pixel (y, x).
    dtype : {"float32", "float64", "int32", "int16", "uint8"}
        Type in the cube.
    lowest, highest : float or None
        Inclusive limits of the values; None: no limit.
    may_be_missing : bool
        Whether NaN is allowed, for pixels where the quantity does not exist; floating-point types only.
    flag_meanings : tuple of str
        Meaning in one word of each of the values 0, 1, 2, ...; integer types only.

    Raises
    ------
    ValueError
        If a field is malformed.
    """

    units: str
    long_name: str
    description: str
    standard_name: str | None = None
    per_band: bool = False
    dtype: Literal["float32", "float64", "int32", "int16", "uint8"] = "float32"
    lowest: float | None = None
    highest: float | None = None
    may_be_missing: bool = False
    flag_meanings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("units", "long_name", "description"):
            text = getattr(self, name)
            if not isinstance(text, str) or not text.strip() or not text.isprintable():
                raise ValueError(f"{name} is {text!r}; expected a line of text")
        if self.standard_name is not None and not _is_name(self.standard_name):
            raise ValueError(
                f"standard_name is {self.standard_name!r}; expected None or lower-case letters, digits, underscores"
            )
        if self.dtype not in DTYPES:
            raise ValueError(f"dtype is {self.dtype!r}; {choose_from(str(self.dtype), DTYPES)}")
        whole = not self.dtype.startswith("float")
        if whole and self.may_be_missing:
            raise ValueError(f"may_be_missing is True for {self.dtype}; allowed: float32 or float64, which have NaN")
        if self.flag_meanings and not (whole and all(map(_is_name, self.flag_meanings))):
            raise ValueError(
                f"flag_meanings is {self.flag_meanings!r} for {self.dtype}; expected names of lower-case letters, "
                "digits and underscores, and an integer type"
            )
        low, high = self.limits
        if not low <= high:
            raise ValueError(f"lowest is {self.lowest!r}, highest {self.highest!r}; expected lowest <= highest")

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest value that can be stored."""
        whole = not self.dtype.startswith("float")
        info: Any = np.iinfo(self.dtype) if whole else np.finfo(self.dtype)
        low, high = float(info.min), float(info.max)
        if self.flag_meanings:
            low, high = 0.0, float(len(self.flag_meanings) - 1)
        return (
            low if self.lowest is None else max(low, float(self.lowest)),
            high if self.highest is None else min(high, float(self.highest)),
        )


@dataclass(frozen=True)
class VariableInputs:
    """Inputs of a variable provider.

    Attributes
    ----------
    bands : tuple of SensorBand (B,)
        Bands of the scene.
    grid : Grid
        The image plane, in pixels.
    view : View
        Direction from the image centre to the sensor.
    catalog : Catalog
        Reader of data files.
    """

    bands: tuple[SensorBand, ...]
    grid: Grid
    view: View
    catalog: Catalog


@runtime_checkable
class VariableProvider(Protocol):
    """Output variables that are a function of other variables of the same pixel.

    Attributes
    ----------
    variables : mapping of str to OutputVariable
        What it gives, by names of lower-case letters, digits and underscores that no variable of the engine has; an
        attribute of the class. Scenarios request them in ``output.variables``.
    needs : tuple of str
        Inputs, which the engine computes even if they are not requested: names of variables of the cube
        (``radiance``, ``brightness_temperature``, ``radiance_TERM``, truth such as ``cloud_thickness``), and of
        geometry: ``latitude``, ``longitude``, ``view_zenith``, ``view_azimuth``, ``sun_zenith``, ``sun_azimuth``.
    """

    declares: Declaration
    variables: Mapping[str, OutputVariable]
    needs: tuple[str, ...]

    def values(self, fields: Mapping[str, NDArray[Any]], time_s: float) -> Mapping[str, NDArray[Any]]:
        """Return every variable of a part of a frame, ``time_s`` after the start.

        ``fields`` has the inputs in ``needs``, (B, y, x) or (y, x), of the type in the cube before any rounding;
        geometry is (y, x), float64, in degrees. Without ``platform.altitude`` the view is that of the image centre; the
        sun is always that of the image centre, with a zenith above 90 below the horizon. A pixel's values must depend
        on this pixel alone.
        """
        ...


def check_output_variables(variables: Any, needs: Any) -> None:
    """Check the declared variables and inputs of a variable provider.

    Raises
    ------
    ValueError
        If ``variables`` is not a mapping of names to OutputVariable with at least one, or ``needs`` no tuple of names.
    """
    good = isinstance(variables, Mapping) and variables and all(map(_is_name, variables))
    if not good or not all(isinstance(variable, OutputVariable) for variable in variables.values()):
        raise ValueError(
            f"variables is {variables!r}; expected a mapping of names (lower-case letters, digits, underscores) to "
            "OutputVariable, at least one"
        )
    if not isinstance(needs, tuple) or not needs or not all(map(_is_name, needs)) or len(set(needs)) < len(needs):
        raise ValueError(f"needs is {needs!r}; expected a tuple of distinct names of inputs, at least one")


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and _NAME.fullmatch(value) is not None
