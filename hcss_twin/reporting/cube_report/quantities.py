"""What a cube holds that can be looked at as images, in the order in which it is shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hcss_twin.cube.variables import TERM_PREFIX

if TYPE_CHECKING:
    import xarray as xr

PLANE = ("time", "y", "x")

_FIRST = ("radiance", "brightness_temperature")
_UNITS = {"W m-2 sr-1": "W m⁻² sr⁻¹", "s-1": "s⁻¹", "1": ""}


@dataclass(frozen=True)
class Quantity:
    """A variable with frames.

    Attributes
    ----------
    name : str
        Of the variable.
    label, units : str
        As they are shown; units are empty for plain numbers.
    dim : str or None
        The dimension beside time, y and x: ``band``, ``layer``.
    parts : tuple of str
        Names along it; one empty name where there is none.
    flags : tuple of str
        Meanings of 0, 1, ... where the numbers are flags.
    """

    name: str
    label: str
    units: str
    dim: str | None
    parts: tuple[str, ...]
    flags: tuple[str, ...] = ()

    @property
    def is_radiation(self) -> bool:
        """Whether it is what a sensor sees: radiance, a term of it or brightness temperature."""
        return self.name in _FIRST or self.name.startswith(TERM_PREFIX)


def pretty_units(units: str) -> str:
    """Return units as they are printed; plain numbers have none."""
    return _UNITS.get(units, units)


def quantities(dataset: xr.Dataset) -> list[Quantity]:
    """Return all variables with frames: radiance and brightness temperature, terms, then what else there is."""
    found = []
    for key, data in dataset.data_vars.items():
        others = [str(dim) for dim in data.dims if dim not in PLANE]
        if not set(PLANE) <= set(data.dims) or len(others) > 1:
            continue
        name, dim = str(key), others[0] if others else None
        parts = tuple(str(each) for each in dataset[dim].to_numpy()) if dim is not None else ("",)
        flags = tuple(word.replace("_", " ") for word in str(data.attrs.get("flag_meanings", "")).split())
        label = (
            f"{name.removeprefix(TERM_PREFIX)} (term)" if name.startswith(TERM_PREFIX) else name
        ).replace("_", " ")
        units = pretty_units(str(data.attrs.get("units", "")))
        found.append(Quantity(name, label, units, dim, parts, flags))
    order = {name: place for place, name in enumerate(_FIRST)}
    return sorted(found, key=lambda each: order.get(each.name, 2 if each.is_radiation else 3))
