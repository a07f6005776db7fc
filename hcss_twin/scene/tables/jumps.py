"""Naming who makes radiance jump as a cloud grows, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ProviderError
from hcss_twin.providers import CloudLayer

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Source:
    """Whose columns are tabulated.

    Attributes
    ----------
    model : str
        What messages call the radiance model.
    terms : tuple of str (K,)
        Names of its terms, in the order of the columns' second axis.
    """

    model: str
    terms: tuple[str, ...]


def worst(guess: Array, exact: Array) -> tuple[int, int]:
    """Return column and term of the largest remaining error, relative to the total; both are (N, K, B)."""
    whole = np.maximum(np.abs(np.sum(exact, axis=1)), np.finfo(float).tiny)
    away = np.abs(np.sum(guess - exact, axis=1)) / whole
    column, band = np.unravel_index(np.argmax(away), away.shape)
    return int(column), int(np.argmax(np.abs(guess - exact)[column, :, band]))


def jumping(
    what: str, source: Source, layer: CloudLayer, thickness_m: Array, place: tuple[int, int]
) -> ProviderError:
    """Return the error of radiance that does not converge.

    Parameters
    ----------
    what : str
        What does not converge to what.
    source : Source
    layer : CloudLayer
        The one that grows.
    thickness_m : ndarray (N,)
        Of the columns that were tried last.
    place : (int, int)
        As :func:`worst` returns it.
    """
    column, term = place
    at = float(thickness_m[column])
    face = layer.base_m + at if layer.anchor == "base" else layer.top_m - at
    moving = "top" if layer.anchor == "base" else "base"
    return ProviderError(
        f"{what}: term '{source.terms[term]}' of {source.model} seems to jump near {at:.6g} m ({moving} of layer "
        f"'{layer.name}' at {face:.6g} m); it must be continuous, and so must what it asks other providers for"
    )
