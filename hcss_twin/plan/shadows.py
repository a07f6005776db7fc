"""Shadows of clouds on the clear sea."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.windows import whole_image


class Shadows(Effect):
    """Shadows that the clouds of a scene cast; where they fall is decided in each frame."""

    kind = "shadows"

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return the image, by which the longest path of sunlight through a layer is limited."""
        return {"image": whole_image(scenario)}
