"""What the providers of all kinds share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Numbers as the contract wants them everywhere but in cloud fields: float64."""


@dataclass(frozen=True)
class Declares:
    """What a provider says about itself; it only removes work or places nodes.

    Leave out what you do not know, but never a dependence: what ``depends_on`` leaves out may be asked for once and
    used everywhere.

    Attributes
    ----------
    depends_on : frozenset of str
        Among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``, ``thickness``, ``time``.
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1`` of every kind but the radiance model, and of a
        transmittance provider also ``view_zenith`` (degrees) and ``target_altitude_m`` (of the lower ends of legs).
        Asking outside is an error.
    native_grid_cm1 : ndarray (N,), optional
        Of a transmittance provider: ascending spectral nodes to which calls are restricted between band edges.
    resolution_cm1 : float
        Spectral resolution of its results; 0 where the provider is pointwise.
    evolves : bool
        Whether a cloud field changes other than by translation.
    tileable : bool
        Whether a cloud generator can give any window of a frame alone.
    notes : tuple of str
        What a user should know; copied into plan and cube.
    legs : {"any", "to_space"}
        Paths a transmittance provider knows: any legs, or only such as reach from one target to space. For the
        latter the radiance model fits a law that serves other paths.
    notes_by_phase : mapping of str to tuple of str
        The same of an optics provider, told only where a layer has particles of that phase ("water", "ice").
    own_errors : tuple of str
        How far the provider itself may be off, with against what that was found: quoted beside the engine's error in
        the certificate of a cube, never added to it.
    reach_pixels : int or None
        Of a sensor: how many rows or columns away a pixel can be that has a share in what another one measures; 0
        where each pixel stands alone, None where the whole frame has. As much of the scene is computed around frames.
    remembers : bool
        Whether what a sensor measures depends on earlier frames, so that it needs all of them in order.
    """

    depends_on: frozenset[str] = frozenset()
    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    native_grid_cm1: Array | None = None
    resolution_cm1: float = 0.0
    evolves: bool = False
    tileable: bool = True
    notes: tuple[str, ...] = ()
    legs: Literal["any", "to_space"] = "any"
    notes_by_phase: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    own_errors: tuple[str, ...] = ()
    reach_pixels: int | None = 0
    remembers: bool = False
