"""States of columns: all that the radiance of a column of sea, cloud and air depends on, for many columns at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.result_cache import OwnMemory
from hcss_twin.physics.profile import Profile
from hcss_twin.providers.atmosphere import TransmittanceProvider
from hcss_twin.providers.clouds import CloudLayer
from hcss_twin.providers.sea import SeaModel


@dataclass(frozen=True)
class View:
    """Direction from the surface point to the sensor."""

    zenith_deg: float
    azimuth_deg: float

    def sun(self, of_centre: Sun | None) -> Sun | None:
        """Return the sun of the place that is seen, from that of the image centre: one sun unless a view knows more."""
        return of_centre


@dataclass(frozen=True)
class Sun:
    """The sun seen from the surface point.

    Attributes
    ----------
    zenith_deg, azimuth_deg : float
        Apparent (refracted) zenith and bearing.
    distance_au : float
        Earth-Sun distance.
    time_s : float or None
        After the start of the scene, if the time decides which places are seen; otherwise None, as one sun may stand
        for several times.
    """

    zenith_deg: float
    azimuth_deg: float
    distance_au: float
    time_s: float | None = None

    @property
    def is_up(self) -> bool:
        """Whether the sun is above the horizon of the surface point."""
        return self.zenith_deg < 90.0


@dataclass(frozen=True, eq=False)
class ColumnSetting:
    """All of a column but the thickness of its clouds. Settings are equal if they have the same providers and values.

    Attributes
    ----------
    view : View
        Direction toward the sensor.
    sun : Sun or None
        None below the horizon, or where sunlight is left out.
    sea : SeaModel
        Emissivity and reflection of the surface: of the sea, of a tilted part of it, or of ground.
    sea_temperature_K : float
        Of the skin of water or ground.
    profile : Profile
        The air.
    transmittance : TransmittanceProvider
        Of gas and aerosol.
    layers : tuple of CloudLayer (L,)
        From the lowest to the highest, without overlap; may be empty.
    air_memory : OwnMemory or None
        Where a model may keep arrays for other columns in the same air, by a hash of all else that they depend on.
    """

    view: View
    sun: Sun | None
    sea: SeaModel
    sea_temperature_K: float
    profile: Profile
    transmittance: TransmittanceProvider
    layers: tuple[CloudLayer, ...]
    air_memory: OwnMemory | None = None
    _key: tuple[Any, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        providers = id(self.sea), id(self.profile), id(self.transmittance)
        object.__setattr__(self, "_key", (self.view, self.sun, self.sea_temperature_K, self.layers, *providers))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ColumnSetting) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def under(self, sun: Sun | None) -> ColumnSetting:
        """Return the same setting under another sun."""
        return self if sun == self.sun else replace(self, sun=sun)


class ColumnGroup(NamedTuple):
    """Columns of one setting.

    Attributes
    ----------
    rows : ndarray (n,)
        Their numbers among all columns.
    setting : ColumnSetting
    thickness_m : ndarray (n, L)
        In the order of ``setting.layers``; 0: no cloud in that layer.
    """

    rows: NDArray[np.intp]
    setting: ColumnSetting
    thickness_m: Array


@dataclass(frozen=True, eq=False)
class ColumnStates:
    """States of N columns: the setting of each, and the thickness of its clouds.

    Attributes
    ----------
    settings : tuple of ColumnSetting (S,)
        Different ones, with equal numbers of layers.
    setting_of : ndarray (N,)
        Index of the setting of each column.
    thickness_m : ndarray (N, L)
        Finite, 0 or more; 0: no cloud in that layer.

    Raises
    ------
    ValueError
        If shapes do not fit, an index is out of range, or a thickness is negative.
    """

    settings: tuple[ColumnSetting, ...]
    setting_of: NDArray[np.intp]
    thickness_m: Array

    def __post_init__(self) -> None:
        layers = {len(setting.layers) for setting in self.settings}
        shape = (len(self), *layers)
        if len(layers) != 1 or self.thickness_m.shape != shape:
            raise ValueError(f"thickness_m: shape {self.thickness_m.shape}; allowed (N, L), N and L {shape}")
        if len(self) and not 0 <= np.min(self.setting_of) <= np.max(self.setting_of) < len(self.settings):
            raise ValueError(f"setting_of: allowed 0 to {len(self.settings) - 1}")
        if not np.all((self.thickness_m >= 0.0) & np.isfinite(self.thickness_m)):
            raise ValueError("thickness_m: allowed finite numbers, 0 or more")

    def __len__(self) -> int:
        return int(self.setting_of.size)

    @classmethod
    def of(cls, settings: Sequence[ColumnSetting], thickness_m: Array) -> ColumnStates:
        """Return columns of thickness (N, L), each in its one of N settings, which may repeat."""
        different = tuple(dict.fromkeys(settings))
        number = {setting: index for index, setting in enumerate(different)}
        return cls(different, np.array([number[setting] for setting in settings], dtype=np.intp), thickness_m)

    @classmethod
    def product(cls, settings: Sequence[ColumnSetting], thickness_m: Array) -> ColumnStates:
        """Return columns of each thickness (n, L) in each of S settings: n of the first setting, and so on."""
        clear = cls.of(settings, np.zeros((len(settings), *thickness_m.shape[1:])))
        setting_of = np.repeat(clear.setting_of, len(thickness_m))
        return cls(clear.settings, setting_of, np.tile(thickness_m, (len(settings), 1)))

    def groups(self) -> Iterator[ColumnGroup]:
        """Yield the columns of each setting."""
        for number, setting in enumerate(self.settings):
            rows = np.flatnonzero(self.setting_of == number)
            if rows.size:
                yield ColumnGroup(rows, setting, self.thickness_m[rows])

    def empty(self, terms: Iterable[str], wavenumber_cm1: Array) -> dict[str, Array]:
        """Return an uninitialised array (N, V) for each term."""
        return {name: np.empty((len(self), wavenumber_cm1.size)) for name in terms}


class SolvesColumns(Protocol):
    """What computes the radiance of columns."""

    terms: Mapping[str, str]

    def columns(self, states: ColumnStates, wavenumber_cm1: Array) -> Mapping[str, Array]:
        """Return each term (N, V)."""
        ...


def clear_column(model: SolvesColumns, setting: ColumnSetting, wavenumber_cm1: Array) -> dict[str, Array]:
    """Return each term (V,) of the column without cloud in a setting."""
    states = ColumnStates.product([setting], np.zeros((1, len(setting.layers))))
    return {name: term[0] for name, term in model.columns(states, wavenumber_cm1).items()}


def cloudy_columns(
    model: SolvesColumns, setting: ColumnSetting, wavenumber_cm1: Array, thickness_m: Array
) -> Mapping[str, Array]:
    """Return each term (N, V) of columns with layers of thickness (N, L) in a setting."""
    return model.columns(ColumnStates.product([setting], thickness_m), wavenumber_cm1)


def spectra_of(
    model: SolvesColumns, settings: Sequence[ColumnSetting], wavenumber_cm1: Array, thickness_m: Array
) -> Array:
    """Return the terms (S, N, K, V) of columns (N, L) in each of S settings, computed together."""
    if not len(settings) or not len(thickness_m):
        return np.empty((len(settings), len(thickness_m), len(model.terms), wavenumber_cm1.size))
    terms = model.columns(ColumnStates.product(settings, thickness_m), wavenumber_cm1)
    stacked = np.stack([np.asarray(terms[name]) for name in model.terms], axis=1)
    return stacked.reshape(len(settings), len(thickness_m), *stacked.shape[1:])
