"""Image geometry of a plugin: frames that are no grid on the ground, such as those of a camera in orbit.

A plan with an imager has two images. ``plan.grid`` is the plane of the scene, in which generators, surfaces and
elements are defined; the cube has the rows and columns of the imager, which samples the scene along its own rays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Protocol, TypeAlias

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.air_over_field import Air, AirOverField
from hcss_twin.providers import SeaModel, View
from hcss_twin.scenario.scenario import Scenario


class Views(Protocol):
    """The directions of view of a scene, as a rectangle of coordinates."""

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge."""
        ...


Climate: TypeAlias = Callable[[Callable[[Profile], Air], Callable[[float], SeaModel]], AirOverField]
"""Returns air and sea of an imager's places, from functions for the air of a profile and the sea of a temperature."""

Imager: TypeAlias = Any
"""The object that a section's ``imager`` function returns. Plan and engine use these members:

``rows``, ``columns``, ``points`` (along a pixel, which is their mean), ``pixel_size_m`` (typical), ``view`` (typical),
``views`` (all directions, :class:`Views`: tables are made between its edges; with ``suns(view)``, those of a view's
place at some frames, places have suns of their own), ``climate`` (:class:`Climate` or None), ``notes`` and
``filled_in`` (for the plan);
``variables(requested)`` of the cube; ``require_supported(plan)``, which raises what frames cannot show;
``layout(plan)``, an :class:`~hcss_twin.cube.header.ImageLayout`; ``views_of_pixels(time_s, rows, columns)``, exact, for
the certificate; ``solve(solved, columns, accuracy)``, which returns the values of the columns of a certificate's pixel
from a function that solves columns; ``unseen(time_s, window)``, a mask of pixels without ground, or None;
``complete(frame, time_s, extent)``, which adds coordinates of pixels; and what takes the place of the engine's
``FrameClouds``, look-up, ``SurfaceStage`` and ``ElementStage``: ``clouds(plan, time_s)``, ``look_up(plan, time_s,
look_ups)``, ``surface_stage(plan, tables)``, ``element_stage(plan)``.
"""


def planned_imager(scenario: Scenario, catalog: Catalog) -> Imager | None:
    """Return the imager of a scenario; None if its image is the grid on the ground."""
    if not scenario.sections:
        return None
    from hcss_twin.core.sections import plugin_sections  # not for scenarios without such sections

    owners = [owner for name, owner in plugin_sections().items() if name in scenario.sections]
    makers = {owner.spec.imager: owner for owner in owners if owner.spec.imager is not None}
    if len(makers) > 1:
        raise ProviderError(f"several image geometries: {', '.join(map(str, makers))}; allowed: one")
    return next((owner.load(str(target))(scenario, catalog) for target, owner in makers.items()), None)
