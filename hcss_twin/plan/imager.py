"""Image geometry of a plugin: frames that are no grid on the ground, such as those of a camera in orbit.

A plan with an imager has two images. ``plan.grid`` is the plane of the scene, in which generators, surfaces and
elements are defined; the cube has the rows and columns of the imager, which samples the scene along its own rays.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.cube.header import ImageLayout
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.plan.windows import Window
from hcss_twin.providers import View
from hcss_twin.scenario.scenario import Scenario

Plan = Any
"""A :class:`hcss_twin.plan.plan.Plan`, which holds the imager."""


class Views(Protocol):
    """The directions of view of a scene, as a rectangle of coordinates."""

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge."""
        ...


class Imager(Protocol):
    """Image geometry of a scenario; the object that a section's ``imager`` function returns.

    Attributes
    ----------
    rows, columns : int
        Of a frame.
    points : int
        Points along each side of a pixel, over which it is averaged.
    pixel_size_m : float
        Typical distance of neighbouring pixels on the ground, for sensors.
    view : View
        A typical direction toward the sensor.
    views : Views
        All directions of all frames; tables are made between its edges.
    notes : tuple of str
        Limits, for the plan.
    """

    rows: int
    columns: int
    points: int
    pixel_size_m: float
    view: View
    views: Views
    notes: tuple[str, ...]

    def variables(self, requested: tuple[VariableSpec, ...]) -> tuple[VariableSpec, ...]:
        """Return the variables of the cube: the requested ones, and coordinates of pixels (kind ``geometry``)."""
        ...

    def require_supported(self, plan: Plan) -> None:
        """Raise a :class:`ScenarioError` that names what frames of this geometry cannot show."""

    def layout(self, plan: Plan) -> ImageLayout:
        """Return coordinates and extent for the header of the cube."""
        ...

    def complete(self, frame: dict[str, NDArray[Any]], time_s: float, extent: Window) -> None:
        """Add the coordinates of the pixels to a part of the frame at a time, and mark those without a value."""

    def unseen(self, time_s: float, window: Window) -> NDArray[np.bool_] | None:
        """Return which pixels of a window do not show the ground; None if all do."""
        ...

    def views_of_pixels(self, time_s: float, rows: Sequence[int], columns: Sequence[int]) -> list[View]:
        """Return the exact view of single pixels of the frame at a time, for the certificate."""
        ...

    def clouds(self, plan: Plan, time_s: float) -> Any:
        """Return the clouds of a frame, with the members of :class:`hcss_twin.engine.stream.FrameClouds`."""

    def look_up(self, plan: Plan, time_s: float, look_ups: Sequence[Any]) -> Any:
        """Return the look-up of a frame from those toward the nodes of ``plan.views``, with ``of_part`` and ``fill``."""

    def surface_stage(self, plan: Plan, tables: Any) -> Any:
        """Return an object with the members of :class:`hcss_twin.engine.tables.over_surfaces.SurfaceStage`."""

    def element_stage(self, plan: Plan) -> Any:
        """Return an object with the members of :class:`hcss_twin.engine.elements.ElementStage`."""


def planned_imager(scenario: Scenario, catalog: Catalog) -> Imager | None:
    """Return the imager of a scenario; None if its image is the grid on the ground.

    Raises
    ------
    ScenarioError
        If its sections contradict each other or other keys.
    ProviderError
        If several sections bring an image geometry.
    """
    if not scenario.sections:
        return None
    from hcss_twin.core.sections import plugin_sections  # not for scenarios without such sections

    own = {name: owner for name, owner in plugin_sections().items() if name in scenario.sections}
    makers = dict.fromkeys((owner.spec.imager, owner) for owner in own.values() if owner.spec.imager is not None)
    if len({target for target, _ in makers}) > 1:
        raise ProviderError(f"sections {', '.join(own)} bring several image geometries; allowed: one")
    for target, owner in makers:
        imager: Imager = owner.load(str(target))(scenario, catalog)
        return imager
    return None
