"""Air that differs from place to place under rays that form no grid on the ground: the places whose air has tables.

Pixels of a grid have one view and one air each, which are nodes together (:mod:`.views`). Directions of other rays do
not tell the place: a camera sees many places in one direction, one after another. There the place is an axis of its
own, eastward and northward, with polynomials between few places.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.axis import Axis, Columns, PlacedAxis
from hcss_twin.plan.builder import attribute_to_field
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.plan.point_nodes import WAVENUMBERS, place_point_nodes
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Sun, View
from hcss_twin.scenario.scenario import Scenario

MAX_NODES = 17
"""Places along either axis."""

_ORDERS = (0, 1, 2, 4, 8)


@dataclass(frozen=True, eq=False)
class SeveralAirs:
    """The air of all places of a scene that rays see.

    Attributes
    ----------
    whole : Assembly
        The scene, with its profiles at several places.
    rays : Rays
    times_s : sequence of float
        Times at which they see it.
    """

    whole: Assembly
    rays: Rays
    times_s: Sequence[float]

    def at(self, assembly: Assembly, x_m: float = 0.0, y_m: float = 0.0) -> Assembly:
        """Return a scene with the air of one place everywhere.

        Raises
        ------
        ScenarioError
            If the profiles do not cover the place.
        """
        field, air_of = self.whole.air_over_field, self.whole.air_of
        latitude, longitude = to_geographic(np.array([x_m]), np.array([y_m]), *field.centre_deg)
        place = float(latitude[0]), float(longitude[0])
        with attribute_to_field("atmosphere.profile"):
            air = field.at(*place)

        def of_view(view: View, vapour_factor: float) -> AirOverField.Air:
            placed = AirOverField.PlacedView(view.zenith_deg, view.azimuth_deg, *place)
            return air if vapour_factor == 1.0 else air_of(placed, vapour_factor)

        here = replace(field, centre_deg=place, at=lambda *_: air, varies=False, is_of_place=True)
        profile, transmittance = air.profile, air.transmittance
        return replace(assembly, air_over_field=here, air_of=of_view, profile=profile, transmittance=transmittance)

    @cached_property
    def reach_m(self) -> tuple[float, float]:
        """How far from the centre along x and y the places are.

        Raises
        ------
        ScenarioError
            If a corner of the image does not see the ground.
        """
        reach_m = self.rays.reach_m(*self.times_s)
        misses = Excluded("atmosphere.profile", reach_m is None, "a field of several profiles", "one profile")
        Excluded.require_none("an image with corners that miss the ground", [misses])
        assert reach_m is not None
        return reach_m

    def at_corners(self, assembly: Assembly) -> Iterator[Assembly]:
        """Yield a scene in the air of the corners of the rectangle of places."""
        yield from (self.at(assembly, *corner) for corner in product(*((-far, far) for far in self.reach_m)))

    def planned(
        self, scenario: Scenario, assembly: Assembly, accuracy: RequestedAccuracy, sun: Sun | None
    ) -> AirByPlace:
        """Choose the places whose air has tables; one along an axis over which radiance hardly changes.

        Raises
        ------
        ScenarioError
            If more than ``MAX_NODES`` along either axis are needed.
        """
        columns, half = few_columns(assembly, WAVENUMBERS), replace(accuracy, relative=0.5 * accuracy.relative)
        lines = [(-far, 0.0, far) for far in self.reach_m]
        total = cache(lambda *place_m: columns.total(self.at(assembly, *place_m), sun))

        def along_x(x_m: Array) -> Array:
            return _stacked([[total(x, y) for y in lines[1]] for x in x_m.tolist()])

        def along_y(y_m: Array) -> Array:
            return _stacked([[total(x, y) for x in lines[0]] for y in y_m.tolist()])

        def placed(far_m: float, of_axis: Columns, way: str) -> PlacedAxis:
            axis, what = Axis(-far_m, far_m), f"air up to {far_m:g} m {way} of the centre"
            return place_point_nodes(scenario, half, axis, of_axis, what, _ORDERS, MAX_NODES)

        x_m, y_m = self.reach_m
        return AirByPlace(self, placed(x_m, along_x, "east and west"), placed(y_m, along_y, "north and south"))


def _stacked(totals: Sequence[Sequence[Array]]) -> Array:
    """Return totals (C, B) at places and lines as columns (places, lines x C, 1, B)."""
    of_places = np.array(totals)
    return of_places.reshape(len(of_places), -1, 1, of_places.shape[-1])


@dataclass(frozen=True)
class AirByPlace(Effect):
    """Places whose air has tables.

    Attributes
    ----------
    airs : SeveralAirs
    along_x, along_y : PlacedAxis
        Places eastward and northward of the centre, m.
    """

    kind = "air by place"

    airs: SeveralAirs
    along_x: PlacedAxis
    along_y: PlacedAxis

    @property
    def estimated_error(self) -> float:
        """Of the interpolation between places, relative to the total."""
        return self.along_x.error + self.along_y.error

    def described(self) -> Mapping[str, Any]:
        """Return places and error."""
        places = {"x_m": self.along_x.nodes.tolist(), "y_m": self.along_y.nodes.tolist()}
        return {"air_by_place": {**places, "estimated_error": self.estimated_error}}
