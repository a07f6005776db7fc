"""Columns under another sun, from those under a first one: the difference is small and smooth and needs few nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.scene.tables.curve import spline_through
from hcss_twin.scene.tables.thickness_axis import ColumnsAt, relative, total

Array = NDArray[np.float64]
Places = NDArray[np.intp]

FIRST_NODES = 5


def single_layer(columns: ColumnsAt, thickness_m: Array, known: Array, tolerance: float) -> Array:
    """Return columns at all thicknesses, of which some are computed.

    The difference from the known columns is interpolated by a spline in ln(thickness); nodes are halved until it
    predicts every new column.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to terms (N, K, B).
    thickness_m : ndarray (E,)
        Ascending.
    known : ndarray (E, K, B)
        Terms under the first sun.
    tolerance : float
        Of the total of any band, relative.

    Returns
    -------
    ndarray (E, K, B)
    """
    places = _first_places(thickness_m.size)
    values = columns(thickness_m[places])
    while places.size < thickness_m.size:
        new = _between(places)
        guess = known[new] + spline_through(thickness_m[places], values - known[places])(
            np.log(thickness_m[new])
        )
        exact = columns(thickness_m[new])
        error = relative(total(guess), total(exact))
        order = np.argsort(np.concatenate((places, new)))
        places = np.concatenate((places, new))[order]
        values = np.concatenate((values, exact))[order]
        if error <= tolerance:
            break
    difference = spline_through(thickness_m[places], values - known[places])(np.log(thickness_m))
    # A term that fades to nothing would swing below it.
    found: Array = np.maximum(known + difference, np.minimum(np.min(values, axis=0), 0.0))
    found[places] = values
    return found


def layer_pair(
    columns: ColumnsAt, low_m: Array, high_m: Array, known: Array, tolerance: float
) -> Array | None:
    """Return columns with cloud in two layers, (E, F, K, B), or None where the difference needs too many nodes.

    Parameters
    ----------
    columns : callable
        Maps pairs of thicknesses (N, 2), low and high, to terms (N, K, B).
    low_m, high_m : ndarray (E,), (F,)
        Ascending.
    known : ndarray (E, F, K, B)
        Terms under the first sun.
    tolerance : float
        Of the total of any band, relative.
    """
    low, high = _first_places(low_m.size), _first_places(high_m.size)
    for _ in range(2):
        if low.size == low_m.size or high.size == high_m.size:
            return None
        values = _product(columns, low_m[low], high_m[high])
        across = spline_through(high_m[high], np.moveaxis(values - known[np.ix_(low, high)], 1, 0))(
            np.log(high_m)
        )
        difference = spline_through(low_m[low], np.moveaxis(across, 0, 1))(np.log(low_m))
        found: Array = np.maximum(known + difference, np.minimum(np.min(values, axis=(0, 1)), 0.0))
        between = _between(low), _between(high)
        exact = _product(columns, low_m[between[0]], high_m[between[1]])
        guess = found[np.ix_(*between)]
        if relative(np.sum(guess, axis=2), np.sum(exact, axis=2)) <= tolerance:
            return found
        low, high = (np.union1d(old, new) for old, new in zip((low, high), between, strict=True))
    return None


def _first_places(size: int) -> Places:
    return np.unique(np.linspace(0, size - 1, FIRST_NODES).round().astype(np.intp))


def _between(places: Places) -> Places:
    """Middles of the intervals that have one."""
    middle = (places[:-1] + places[1:]) // 2
    return np.setdiff1d(middle, places)


def _product(columns: ColumnsAt, low_m: Array, high_m: Array) -> Array:
    found = columns(np.stack(np.meshgrid(low_m, high_m, indexing="ij"), axis=-1).reshape(-1, 2))
    return found.reshape(low_m.size, high_m.size, *found.shape[1:])
