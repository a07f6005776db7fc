"""View angles that vary over the image: whether they matter, and how many nodes they need.

The radiance of a column is a smooth function of its position in the image. It is computed at Chebyshev nodes in x and
y, from edge to edge of the image; pixels are interpolated by the polynomial through them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import error_of_columns
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.physics import quadrature
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.axis import Axis, place
from hcss_twin.plan.directions import SunlitView, Views
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import SAFETY_FACTOR, FewColumns, few_columns
from hcss_twin.plan.waves import TiltedSea, tilted_seas
from hcss_twin.providers import Grid, Sun, View
from hcss_twin.scenario.scenario import Scenario

EXTREMES = ((0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0))
"""Middle and corners of the image."""

EDGES = ((0.0, -1.0), (-1.0, 0.0), (1.0, 0.0), (0.0, 1.0))
"""Middles of its edges."""

NARROW = 0.1
"""Change of radiance and path over an image below which its errors are those of the middle: they change as little.

Radiance alone does not tell: in a window it changes by a tenth from nadir to a zenith of 75 degrees, because air as
warm as the sea emits what it absorbs; but wavenumbers that stand for the band at one path err by 1 % at the other."""


@dataclass(frozen=True)
class ViewAxis(Effect):
    """Nodes of the view over the image.

    Attributes
    ----------
    order_x, order_y : int
        Polynomial order along columns and rows; 0: the view at the middle is used for all.
    estimated_error : float
        Relative to the total, measured between the nodes during their placement.
    spread : float
        Largest change over the image, relative to the middle: of radiance, or of the path through the air.
    """

    kind = "views"

    order_x: int
    order_y: int
    estimated_error: float
    spread: float = math.inf

    @property
    def extremes(self) -> tuple[tuple[float, float], ...]:
        """Positions of the views for which numerics are chosen: the middle stands for a narrow field."""
        return EXTREMES if self.spread > NARROW else EXTREMES[:1]

    @property
    def of_spectra(self) -> tuple[tuple[tuple[float, float], ...], tuple[tuple[float, float], ...]]:
        """Positions of the views for which wavenumbers are fitted, and of those on which they are tried.

        Few weights that fit the middle alone may fit nothing else, however little spectra change.
        """
        if self.spread > NARROW:
            return EXTREMES, EDGES
        middle, *corners = EXTREMES
        return (middle, corners[0], corners[3]), (corners[1], corners[2])

    @property
    def edges(self) -> tuple[tuple[float, float], ...]:
        """Positions of further views from which those of all nodes are derived."""
        return EDGES if self.spread > NARROW else ()

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return orders, image and directions."""
        grid = assembly.grid
        views = [self.order_x, self.order_y, grid.rows, grid.columns, grid.pixel_size_m]
        return {
            "views": views if assembly.directions is None else [*views, repr(assembly.directions.at(EXTREMES + EDGES))]
        }

    def described(self) -> Mapping[str, Any]:
        """Return orders and error."""
        return {"views": vars(self)}

    def over(self, assembly: Assembly) -> Views:
        """Return the views from positions in the image of a scene."""
        return views_over_image(assembly)

    def together(self, assembly: Assembly) -> bool:
        """Whether tables toward the views share wavenumbers and thicknesses: one, or all in one air under one sun."""
        return not self.varies or not (assembly.air_over_field.varies or assembly.own_suns)

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the nodes, -1 to 1 from edge to edge; x varies fastest."""
        x, y = quadrature.nodes(self.order_x).tolist(), quadrature.nodes(self.order_y).tolist()
        return tuple((across, up) for up in y for across in x)

    def weights(self, grid: Grid) -> tuple[Array, Array]:
        """Return the weight of each node: (columns, X) along x and (rows, Y) along y."""
        return (
            quadrature.weights(self.order_x, _centres(grid.columns)),
            quadrature.weights(self.order_y, _centres(grid.rows)),
        )


class OneView(ViewAxis):
    """The view of the image centre for all pixels."""

    varies = False
    of_spectra = EXTREMES[:1], EXTREMES[:1]

    def over(self, assembly: Assembly) -> Views:
        """Return the one view from all positions."""
        return ImageViews(assembly.grid, None, assembly.view)


ONE_VIEW = OneView(0, 0, 0.0, 0.0)


@dataclass(frozen=True)
class ImageViews:
    """The view from any position in an image.

    Attributes
    ----------
    grid : Grid
        The image, in pixels.
    lines : LinesOfSight or None
        Lines of sight of the pixels; None for an orthographic view.
    parallel : View or None
        View of all pixels; required if ``lines`` is None.
    centre_deg : (float, float) or None
        Latitude and longitude of the image centre, if the air differs over the image.
    own_suns : bool
        Whether each place seen along ``lines`` has its own sun; not with air of its own.
    """

    grid: Grid
    lines: LinesOfSight | None
    parallel: View | None = None
    centre_deg: tuple[float, float] | None = None
    own_suns: bool = False

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge.

        Azimuths are measured from the plane's y axis, like those of sun and wind at the image centre.
        """
        x, y = np.array(list(places), dtype=np.float64).reshape(-1, 2).T
        size = 0.5 * self.grid.pixel_size_m
        east, north = x * size * self.grid.columns, y * size * self.grid.rows
        if self.lines is None:
            assert self.parallel is not None
            views = [self.parallel] * x.size
        else:
            seen = self.lines.from_points(east, north)
            angles = zip(seen.zenith_deg.tolist(), seen.plane_azimuth_deg.tolist(), strict=True)
            views = [View(zenith, azimuth) for zenith, azimuth in angles]
            if self.own_suns:
                centre_deg = self.lines.latitude_deg, self.lines.longitude_deg
                turn = seen.azimuth_deg - seen.plane_azimuth_deg
                return [*SunlitView.of_places(views, centre_deg, seen.latitude_deg, seen.longitude_deg, turn)]
        if self.centre_deg is None:
            return views
        places = zip(*(angles_deg.tolist() for angles_deg in to_geographic(east, north, *self.centre_deg)), strict=True)
        return [
            AirOverField.PlacedView(view.zenith_deg, view.azimuth_deg, *place)
            for view, place in zip(views, places, strict=True)
        ]


def views_over_image(assembly: Assembly) -> Views:
    """Return the views over the image, which are all the same if pixels share one view and one air."""
    return views_over_grid(assembly) if assembly.directions is None else assembly.directions


def views_over_grid(assembly: Assembly) -> ImageViews:
    """Return the views over a grid on the ground."""
    air = assembly.air_over_field
    centre_deg = air.centre_deg if air.varies else None
    return ImageViews(assembly.grid, assembly.lines_of_sight, assembly.view, centre_deg, may_have_own_suns(assembly))


def may_have_own_suns(assembly: Assembly) -> bool:
    """Whether each place of an image has its own sun if the sensor has an altitude: in narrow fields of one air."""
    grid = assembly.grid
    half_m = 0.5 * grid.pixel_size_m * math.hypot(grid.rows, grid.columns)
    return assembly.directions is None and not assembly.air_over_field.varies and half_m <= SUNS_WITHIN_M


def _centres(count: int) -> Array:
    """Positions of pixel centres along one axis."""
    return (2.0 * np.arange(count) + 1.0 - count) / count


SUNS_WITHIN_M = 30e3
"""Half the diagonal of images whose places have suns of their own: these differ by up to a quarter of a degree.

Clouds are solved for each sun, which would take hours for the many views of wide fields."""


LINES = (-1.0, 0.0, 1.0)
"""Positions on the other axis at which nodes are tested: the edges and the middle of the image."""

MAX_ORDER = 16
"""Maximum order along either axis."""

AIR_SHARE = 6.0
"""Tolerance if the air varies over the image, or for directions of a pass, relative to that for views alone (30 % of
the accuracy).

Radiance as a function of the air has kinks, for example where the aerosol changes with humidity, and polynomials
converge slowly there.
"""

MAX_NODES = 289
"""Maximum number of views, with the largest order along both axes; each has its own tables."""

MORE_PLACES = 2, 4
"""Factors by which both are larger for places with suns of their own, which share no solutions of the model."""

KINKS_LEAVE = 2.0
"""Factor of the tolerance within which the largest order is accepted for such places: at the kinks of the air the error
falls only as the inverse of the number of nodes."""


def choose_views(
    scenario: Scenario,
    assembly: Assembly,
    suns: Sequence[Sun | None],
    tolerance: float,
    left: float,
    waves: bool = False,
) -> ViewAxis:
    """Choose the views with tables.

    The view of the image centre suffices if the sensor altitude is unknown and there is one profile, if the change over
    the image is within the tolerance, or if providers support no other views, which is listed under the omissions.

    Parameters
    ----------
    suns : sequence of Sun or None
        Sun at some frames; empty if no radiance is requested.
    tolerance : float
        Relative to the total radiance of the band.
    left : float
        What others leave of theirs, for views of one air from a grid on the ground.
    waves : bool
        Whether clear pixels show resolved waves, whose tilted facets mirror the sun toward other views.

    Raises
    ------
    ScenarioError
        If view angles must vary over the image but a selected option does not support that.
    """
    views, has_directions = views_over_image(assembly), assembly.directions is not None
    corners = views.at(EXTREMES[1:])
    if not suns or (len(set(corners)) == 1 and not has_directions):
        return ONE_VIEW
    low, high = assembly.transmittance.declares.valid.get("view_zenith", (0.0, 90.0))
    if not all(low <= view.zenith_deg <= high for view in corners):
        if has_directions:
            message = f"allows view zeniths of {low:g} to {high:g} deg, and pixels have others; allowed: another one"
            raise ScenarioError([Problem("atmosphere.provider", message)])
        return ONE_VIEW
    if has_directions:  # directions over a whole pass, through glint
        tolerance *= AIR_SHARE
    elif not assembly.air_over_field.varies:
        tolerance += left
    more = MORE_PLACES if assembly.own_suns else (1, 1)
    most, largest = MAX_ORDER * more[0], MAX_NODES * more[1]
    # Safety factor, because few columns underestimate the error of all.
    axis_tolerance = 0.5 * tolerance / SAFETY_FACTOR
    try:
        tilts = tilted_seas(scenario, assembly) if waves else None
        values = _columns(assembly, views, suns, tilts)
        may_be_narrow = not has_directions and not assembly.air_over_field.varies
        spread = max(_spread(values), _spread_of_paths(views)) if may_be_narrow else math.inf
        (x, x_error), (y, y_error) = (_narrow(values, axis_tolerance) if spread <= NARROW else None) or _placed(
            values, axis_tolerance, most
        )
    except (ProviderError, ScenarioError):
        if has_directions:
            raise
        return ONE_VIEW
    if x == y == 0 and not has_directions:
        return ONE_VIEW
    error, nodes = SAFETY_FACTOR * (x_error + y_error), (x + 1) * (y + 1)
    tolerance *= 1.0 if has_directions or not assembly.air_over_field.varies else AIR_SHARE
    if assembly.own_suns and assembly.air_over_field.varies and most in (x, y):
        tolerance *= KINKS_LEAVE
    if error > tolerance or nodes > largest:
        many = f"{x + 1} x {y + 1} views"
        limit = (
            f"an error of {error:.1e} of the radiance remains with {many} (at most "
            f"{most + 1} along an axis); allowed: an error of {tolerance:.1e}"
            if error > tolerance
            else f"an error below {tolerance:.1e} of the radiance needs {many}, which are {nodes}; allowed: up to "
            f"{largest} views"
        )
        message = (
            f"{scenario.accuracy}: the {_what_varies(assembly)} changes over the image: {limit}, with a lower accuracy "
            "or a smaller image"
        )
        raise ScenarioError([Problem("accuracy", message)])
    return ViewAxis(x, y, error, spread)


Values = Callable[[Sequence[tuple[float, float]]], Sequence[Array]]
"""Terms (C, K, B) of columns for positions (x, y) in the image."""


def _columns(
    assembly: Assembly, views: Views, suns: Sequence[Sun | None], tilts: Sequence[TiltedSea] | None = None
) -> Values:
    """Return a cached function of position for the terms of clear sky and few clouds under the suns.

    With ``tilts``, clear sky over each of these seas, too.
    """
    columns = _few(assembly)
    clear = replace(columns, thickness_m=columns.thickness_m[:0])
    known: dict[tuple[float, float], Array] = {}

    def values(places: Sequence[tuple[float, float]]) -> list[Array]:
        new = [position for position in dict.fromkeys(places) if position not in known]
        of_new = views.at(new) if new else []
        for position, view, found in zip(new, of_new, columns.toward(assembly, of_new, suns), strict=True):
            tilted = [tilt(view, sun).setting(sun, view) for tilt in tilts or () for sun in suns]
            every = [*found, *clear.terms_in(assembly.model, tilted)] if tilted else found
            known[position] = np.concatenate([np.stack(list(under.values()), axis=1) for under in every])
        return [known[position] for position in places]

    return values


def _spread(values: Values) -> float:
    """Return the largest change of columns from the middle to corners and edges of the image."""
    middle, *others = values(EXTREMES + EDGES)
    return max(error_of_columns(middle, other) for other in others)


def _spread_of_paths(views: Views) -> float:
    """Return the largest change of the path through the air from the middle to corners and edges of the image."""
    middle, *others = (1.0 / math.cos(math.radians(view.zenith_deg)) for view in views.at(EXTREMES + EDGES))
    return max(abs(other / middle - 1.0) for other in others)


BETWEEN = ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5))
"""Positions at which the nodes of a narrow field are tested: on its diagonals, where terms of both axes add up."""


def _narrow(values: Values, tolerance: float) -> list[tuple[int, float]] | None:
    """Return order and error along x and along y, the least that suffices; None if the second order does not."""
    for order, tested in ((0, EXTREMES[1:] + EDGES), (1, EXTREMES[:1] + EDGES), (2, BETWEEN)):
        nodes = quadrature.nodes(order).tolist()
        known = np.stack(values([(x, y) for y in nodes for x in nodes]))
        across, up = (quadrature.weights(order, np.array(at)) for at in zip(*tested, strict=True))
        weights = (up[:, :, None] * across[:, None, :]).reshape(len(tested), -1)
        error = error_of_columns(np.tensordot(weights, known, 1), np.stack(values(tested)))
        if error <= tolerance:
            return [(order, 0.5 * error)] * 2
    return None


def _placed(values: Values, tolerance: float, most: int) -> list[tuple[int, float]]:
    """Return order and error along x and along y."""

    def along(along_x: bool, positions: Array) -> Array:
        """Columns (N, lines, C, K, B) at positions along one axis, on lines across the image."""
        pairs = [(position, line) for position in positions.tolist() for line in LINES]
        found = np.stack(values([(x, y) if along_x else (y, x) for x, y in pairs]))
        return found.reshape(positions.size, len(LINES), *found.shape[1:])

    orders = tuple(2**n for n in range(most.bit_length()))
    placed = [
        place(Axis(-1.0, 1.0), partial(along, along_x), tolerance, orders=(0, *orders), cut="never", fewest=True)
        for along_x in (True, False)
    ]
    return [(of_axis.nodes.size - 1, of_axis.error) for of_axis in placed]


def _few(assembly: Assembly) -> FewColumns:
    """Columns that bound the scene, and a cloud of medium thickness in each layer alone."""
    columns = few_columns(assembly)
    middling = [
        np.sqrt(layer.thickness_min_m * layer.thickness_max_m) * np.eye(len(assembly.layers))[index]
        for index, (layer, cloudy) in enumerate(zip(assembly.layers, assembly.cloudy_layers, strict=True))
        if cloudy
    ]
    if not middling:
        return columns
    return replace(columns, thickness_m=np.concatenate((columns.thickness_m, np.array(middling))))


def _what_varies(assembly: Assembly) -> str:
    return "air or the view" if assembly.air_over_field.varies else "view"
