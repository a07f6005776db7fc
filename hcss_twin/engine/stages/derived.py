"""Variables of variable providers, computed from the other variables of a part of a frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.cube.geometry import PIXELS_AT_ONCE
from hcss_twin.engine.stages.stage import Frame, FramePart, Stage
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, cut, length, relative
from hcss_twin.providers.variables import GEOMETRY

_LOCATION, _VIEW, _SUN = GEOMETRY[:2], GEOMETRY[2:4], GEOMETRY[4:]


class DerivedStage(Stage):
    """Variables of the variable providers of a scene."""

    title = "variables of plugins"
    reads = ("truth", "elements", "radiance")
    writes = ("derived",)

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._geometry = {name for provider in plan.assembly.derived for name in provider.needs if name in GEOMETRY}

    def finish(self, part: FramePart, frame: Frame) -> None:
        """Add every variable of the providers."""
        frame |= self.values(frame, part.extent, part.time_s)

    def values(self, frame: Mapping[str, NDArray[Any]], extent: Window, time_s: float) -> dict[str, NDArray[Any]]:
        """Return every variable of the providers.

        Parameters
        ----------
        frame : mapping of str to ndarray (..., y, x)
            Variables of the part, before any rounding.
        extent : (slice, slice)
            Rows and columns of the part in the image.

        Raises
        ------
        ProviderError
            If a provider violates its contract.
        """
        known = {**frame, **self._angles(extent, time_s)}
        result: dict[str, NDArray[Any]] = {}
        for provider in self._plan.assembly.derived:
            fields = {name: known[name].view() for name in provider.needs}
            for values in fields.values():
                values.flags.writeable = False
            result |= provider.values(fields, time_s)
        return result

    def _angles(self, extent: Window, time_s: float) -> dict[str, Array]:
        """Geometry (y, x) of the part that a provider needs, degrees; of a pixel the same in every part."""
        plan, shape = self._plan, (length(extent[0]), length(extent[1]))
        angles = {name: np.empty(shape) for name in GEOMETRY if name in self._geometry}
        sun = plan.sun_track.at(time_s) if self._geometry & set(_SUN) else None
        # Intermediate arrays take much more memory than the result.
        for strip in cut(extent, max(1, PIXELS_AT_ONCE // shape[1]), shape[1]) if angles else ():
            in_part = relative(strip, extent)
            known: dict[str, Any] = {}
            if self._geometry & set(_LOCATION):
                known |= zip(_LOCATION, plan.rays.locations_deg(strip, time_s, plan.scenario), strict=True)
            if self._geometry & set(_VIEW):
                known |= zip(_VIEW, plan.rays.angles_deg(strip, time_s), strict=True)
            if sun is not None:
                known |= zip(_SUN, (sun.zenith_deg, sun.azimuth_deg), strict=True)
            for name, array in angles.items():
                array[in_part] = known[name]
        return angles
