"""What makes a right provider wrong: one change of one argument or result of one member."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Wrong:
    """A wrong provider.

    Attributes
    ----------
    name : str
        Unique, and the same each time.
    right : str
        Name of the right provider that it wraps.
    sentence : str
        The mistake.
    wrap : callable
        Maps the right provider and the inputs it was made from to the wrong one.
    inputs : callable
        Maps inputs to what the right provider is made from instead.
    """

    name: str
    right: str
    sentence: str
    wrap: Callable = lambda provider, inputs: provider
    inputs: Callable = lambda inputs: inputs


class Changed:
    """A provider with another member; all else is the right one's."""

    def __init__(self, right, **members):
        self._right = right
        vars(self).update(members)

    def __getattr__(self, name):
        if name.startswith("__") or name == "_right":
            raise AttributeError(name)
        return getattr(self._right, name)


def argument(member, place, change):
    """A wrap that changes one argument, by its place; ``change`` maps all arguments to the new one."""

    def wrap(provider, inputs):
        def changed(*given):
            own = list(given)
            own[place] = change(*given)
            return getattr(provider, member)(*own)

        return Changed(provider, **{member: changed})

    return wrap


def result(member, change):
    """A wrap that changes the result; ``change`` maps it and all arguments to the new one."""

    def wrap(provider, inputs):
        return Changed(provider, **{member: lambda *given: change(getattr(provider, member)(*given), *given)})

    return wrap


FACTORS = {"double": 2.0, "half": 0.5}

FRACTION = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "percent": ("in percent", lambda x: 100.0 * x),
    "from-percent": ("divided by 100", lambda x: 0.01 * x),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "negative": ("with the other sign", lambda x: -x),
    "square": ("squared", lambda x: x**2),
    "root": ("its square root", np.sqrt),
    "log": ("its optical depth", lambda x: -np.log(np.maximum(x, 1e-300))),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "first-row": ("the first row for all", lambda x: np.repeat(x[:1], len(x), axis=0)),
    "last-row-lost": ("without the last row", lambda x: np.concatenate((x[:-1], 0.0 * x[-1:]))),
    "rows-reversed": ("in reverse order", lambda x: x[::-1]),
    "spectrum-reversed": ("with a reversed spectrum", lambda x: x[:, ::-1]),
    "first-wavenumber": ("that of the first wavenumber for all", lambda x: np.repeat(x[:, :1], x.shape[1], axis=1)),
    "spectral-mean": ("its mean over the wavenumbers", lambda x: np.repeat(x.mean(1)[:, None], x.shape[1], axis=1)),
}

WAVENUMBER = {
    "double": ("doubled", lambda nu: 2.0 * nu),
    "half": ("halved", lambda nu: 0.5 * nu),
    "um": ("in micrometres", lambda nu: np.sort(1e4 / nu)),
    "per-m": ("in m-1", lambda nu: 100.0 * nu),
    "from-per-m": ("taken for m-1", lambda nu: 0.01 * nu),
    "angular": ("times 2 pi", lambda nu: 2.0 * np.pi * nu),
    "next": ("of the next element", lambda nu: np.append(nu[1:], nu[-1])),
}

COSINE = {
    "sine": ("the sine instead of the cosine", lambda mu: np.sqrt(1.0 - mu**2)),
    "angle": ("the angle in radians instead of its cosine", lambda mu: np.clip(np.arccos(mu), 0.0, 1.0)),
    "complement": ("1 minus the cosine", lambda mu: 1.0 - mu),
    "dropped": ("ignored, taken for 1", np.ones_like),
    "half": ("half the cosine", lambda mu: 0.5 * mu),
    "square": ("the cosine squared", np.square),
}

AZIMUTH = {
    "turned": ("counted from the other side", lambda phi: np.pi - phi),
    "half": ("halved", lambda phi: 0.5 * phi),
    "degrees": ("in degrees", np.degrees),
    "from-degrees": ("taken for degrees", np.radians),
    "dropped": ("ignored, taken for 0", np.zeros_like),
    "quarter": ("off by a right angle", lambda phi: np.abs(phi - 0.5 * np.pi)),
}


def on_result(right, member, table, pick=lambda value: value, put=lambda value, new: new, label=None):
    """Wrong providers with each change of ``table`` in the result of ``member``, or in a part of it."""
    label = label or member
    for name, (words, change) in table.items():
        yield Wrong(
            f"{right}.{label}.{name}",
            right,
            f"{label} is returned {words}",
            result(member, lambda value, *given, change=change: put(value, change(pick(value)))),
        )


def on_argument(right, member, place, argument_name, table):
    """Wrong providers with each change of ``table`` in one argument of ``member``."""
    for name, (words, change) in table.items():
        yield Wrong(
            f"{right}.{member}.{argument_name}.{name}",
            right,
            f"{member} takes {argument_name} {words}",
            argument(member, place, lambda *given, change=change: change(given[place])),
        )
