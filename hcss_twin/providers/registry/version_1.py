"""Version 1 of the provider API in terms of version 2.

Providers of version 1 declare all kinds of properties in one class, ``hcss_twin.providers.Declares``. The engine uses
them as :func:`adapted`, with the declaration of their kind; everything else of version 1 is part of version 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from hcss_twin.core.arrays import Array
from hcss_twin.providers.common import DEPENDENCIES, RANGES
from hcss_twin.providers.declarations import Declaration, among


@dataclass(frozen=True)
class Declares:
    """The declaration of a provider of version 1, of any kind: the engine converts it to that of its kind.

    All have defaults. Declare every dependence: the engine may reuse one result for all values of other variables.

    Attributes
    ----------
    depends_on : frozenset of str
        Among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``, ``thickness``, ``time``.
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1`` for every kind but the radiance model; for a
        transmittance provider also ``view_zenith`` (degrees) and ``target_altitude_m`` (of the lower ends of legs).
    native_grid_cm1 : ndarray (N,), optional
        For a transmittance provider: ascending spectral nodes; calls use only these and band edges.
    resolution_cm1 : float
        Spectral resolution of the results; 0: monochromatic.
    evolves : bool
        Whether a cloud field changes in other ways than by translation.
    tileable : bool
        Whether a cloud generator can give any window of a frame alone.
    notes : tuple of str
        Notes for users; copied into plan and cube.
    legs : {"any", "to_space"}
        Paths of a transmittance provider: any legs, or only legs from one target to space. The radiance model fits a
        law to the latter for other paths.
    notes_by_phase : mapping of str to tuple of str
        Notes of an optics provider for layers with particles of that phase ("water", "ice").
    own_errors : tuple of str
        Provider-stated accuracy with its reference, quoted in the certificate in addition to the engine's error.
    reach_pixels : int or None
        For a sensor: largest distance in rows or columns at which one pixel affects another; 0: none, None: the whole
        frame. The engine computes so much of the scene around the frames.
    remembers : bool
        Whether measurements depend on earlier frames, so that a sensor needs all of them in order.
    """

    depends_on: frozenset[str] = field(default=frozenset(), metadata=among(*DEPENDENCIES))
    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict, metadata=among(*RANGES))
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


class _Adapted:
    """A provider of version 1 with the declaration of version 2."""

    def __init__(self, provider: Any, declaration: type[Declaration]) -> None:
        self._provider, self._declaration = provider, declaration

    @property
    def declares(self) -> Declaration:
        """The declaration, converted."""
        return _converted(self._provider.declares, self._declaration)

    def __getattr__(self, name: str) -> Any:
        # copying and unpickling look up attributes before there is a provider
        if name.startswith("__") or name in ("_provider", "_declaration"):
            raise AttributeError(name)
        return getattr(self._provider, name)


def adapted(provider: Any, declaration: type[Declaration]) -> Any:
    """Return a provider of version 1 as one of version 2, of the kind with this declaration."""
    return _Adapted(provider, declaration)


def _converted(declares: Declares, declaration: type[Declaration]) -> Declaration:
    """Return the part of a declaration that providers of the kind can say; version 1 ignored the rest."""
    values: dict[str, Any] = {}
    for each in fields(declaration):
        if each.name in ("materials", "numerical_levels"):  # those of version 1 are the default
            continue
        value: Any = getattr(declares, _NAMES_IN_1.get(each.name, each.name))
        if "among" in each.metadata:
            known = frozenset(each.metadata["among"]).intersection(value)
            value = {name: value[name] for name in known} if isinstance(value, Mapping) else known
        values[each.name] = value
    return declaration(**values)


_NAMES_IN_1 = {"notes_by_material": "notes_by_phase"}
