"""Air that differs over the image: the profile and the transmittance provider of any place in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from hcss_twin.core.result_cache import OwnMemory
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import SeaModel, TransmittanceProvider, View

__all__ = ["AirOverField"]

T = TypeVar("T")


@dataclass(frozen=True)
class AirOverField:
    """Air at the places of an image.

    Attributes
    ----------
    centre_deg : (float, float)
        Latitude and longitude of the image centre.
    at : callable
        Returns the air at a latitude and longitude.
    left_out : callable
        Yields, near the image centre, the air of a profile of the file and the air interpolated without that profile,
        preceded by the factor that converts their difference into the interpolation error.
    varies : bool
        Whether places have air of their own; not that of a scenario with one profile.
    is_of_place : bool
        Whether it is the air of one place, everywhere, of several that a scene has (:mod:`.air_by_place`).
    """

    @dataclass(frozen=True, eq=False)
    class Air:
        """Profile and transmittance of the air at one place, and the sea below it if it differs from the scenario's.

        ``memory``: where scenes with the same air keep it.
        """

        profile: Profile
        transmittance: TransmittanceProvider
        sea: SeaModel | None = None
        sea_temperature_K: float = 0.0
        memory: OwnMemory | None = None

        def sea_or(self, sea: SeaModel, kelvin: float) -> tuple[SeaModel, float]:
            """Return the sea below and its temperature, or another one if it has none of its own."""
            return (sea, kelvin) if self.sea is None else (self.sea, self.sea_temperature_K)

    @dataclass(frozen=True)
    class PlacedView(View):
        """View of a place that has its own air.

        Attributes
        ----------
        own_sun : bool
            Whether it has its own sun, too; azimuths then count from its own north.
        """

        latitude_deg: float
        longitude_deg: float
        own_sun: bool = False

    centre_deg: tuple[float, float]
    at: Callable[[float, float], AirOverField.Air]
    left_out: Callable[[], Iterator[tuple[float, AirOverField.Air, AirOverField.Air]]]
    varies: bool = True
    is_of_place: bool = False

    def of(self, view: View) -> AirOverField.Air:
        """Return the air of a view: that of its place, or of the image centre if it has none."""
        position_deg = (
            (view.latitude_deg, view.longitude_deg) if isinstance(view, AirOverField.PlacedView) else self.centre_deg
        )
        return self.at(*position_deg)

    def together(self, items: Sequence[T]) -> list[Sequence[T]]:
        """Return views, or what has one, that are computed together: all, or one by one with air that needs 60 MB."""
        return [[item] for item in items] if self.varies else [items]


Climate: TypeAlias = Callable[[Callable[[Profile], AirOverField.Air], Callable[[float], SeaModel]], AirOverField]
"""Returns air and sea of the places that rays see, from functions for the air of a profile and the sea of a
temperature."""
