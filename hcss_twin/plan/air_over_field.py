"""Air that differs over the image: the profile and the transmittance provider of any place in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from hcss_twin.physics.profile import Profile
from hcss_twin.providers import TransmittanceProvider, View


@dataclass(frozen=True)
class PlacedView(View):
    """View from a place with air of its own."""

    latitude_deg: float
    longitude_deg: float


@dataclass(frozen=True, eq=False)
class Air:
    """Air of one place."""

    profile: Profile
    transmittance: TransmittanceProvider


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
        Yields, near the image centre, pairs of air: of a profile of the file, and interpolated without it; before
        them the factor from their difference to the error of interpolation between the places of the file.
    """

    centre_deg: tuple[float, float]
    at: Callable[[float, float], Air]
    left_out: Callable[[], Iterator[tuple[float, Air, Air]]]

    def of(self, view: View) -> Air:
        """Return the air of a view: of its own place, or of the image centre."""
        place = (view.latitude_deg, view.longitude_deg) if isinstance(view, PlacedView) else self.centre_deg
        return self.at(*place)
