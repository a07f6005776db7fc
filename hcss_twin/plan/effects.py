"""Effects: decisions of the plan that let pixels of a scene differ beyond their clouds.

Views and air over the image, surfaces, tops of clouds, texture, waves, light between columns and the sensor are each
planned alone; a scene that does not need one has none. What tables depend on, and what the plan says as plain values,
are loops over ``plan.effects``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.windows import whole_image


class Effect:
    """One decision; the base of what ``plan.effects`` holds.

    Attributes
    ----------
    kind : str
        By which the engine finds the stage that applies it to frames, and its tables; views, tops and effects of points
        have axes of the look-up instead.
    varies : bool
        Whether pixels differ by it; one that stands for a scene without the effect is not among ``plan.effects``.
    """

    kind: ClassVar[str]
    varies: ClassVar[bool] = True

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return what tables depend on, beyond sea, air and layers of a scenario (plain values); by default nothing."""
        return {}

    def described(self) -> Mapping[str, Any]:
        """Return what the plan says as plain values, by name; by default nothing."""
        return {}


class Shadows(Effect):
    """Shadows that the clouds of a scene cast; where they fall is decided in each frame."""

    kind = "shadows"

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return the image, by which the longest path of sunlight through a layer is limited."""
        return {"image": whole_image(scenario)}
