"""Clouds of a plane larger than the image, which slant paths need, seen from the rows and columns of the image."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.plan.point_shifts import PointShifts, gathered
from hcss_twin.providers import CloudDeclaration, CloudGenerator


class DisplacedClouds:
    """A cloud generator for a plane larger than the image, addressed by the rows and columns of the image.

    All other attributes are delegated to the generator.

    Parameters
    ----------
    generator : CloudGenerator
        Made for the larger plane; can compute windows.
    margin : (int, int)
        Rows and columns of the plane before and after those of the image.
    view_shift : (int, int) or PointShifts
        Displacement of the cloud seen from each point, within the margin.
    """

    def __init__(
        self, generator: CloudGenerator, margin: tuple[int, int], view_shift: tuple[int, int] | PointShifts
    ) -> None:
        self._generator = generator
        self._margin = margin
        self._view_shift = view_shift

    @property
    def declares(self) -> CloudDeclaration:
        """Declaration of the generator."""
        return self._generator.declares

    def __getattr__(self, name: str) -> Any:
        # attributes of copies and unpickled objects are looked up before the generator is set
        if name.startswith("__") or name == "_generator":
            raise AttributeError(name)
        attribute = getattr(self._generator, name)
        # looked up here, so that hasattr() reflects the generator
        return self._thickness_around_m if name == "thickness_around_m" else attribute

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window of the image."""
        if isinstance(self._view_shift, tuple):
            return self.displaced_m(time_s, rows, columns, self._view_shift)
        shifts = self._view_shift.at(rows, columns)
        (down, right), (far_down, far_right) = shifts.min(axis=(1, 2)).tolist(), shifts.max(axis=(1, 2)).tolist()
        wide = slice(rows.start, rows.stop + far_down - down), slice(columns.start, columns.stop + far_right - right)
        return gathered(self.displaced_m(time_s, *wide, (down, right)), shifts, (down, right))

    def _thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window that may reach outside the image."""
        return self.thickness_m(time_s, rows, columns)

    def displaced_m(self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]) -> NDArray[np.float32]:
        """Return the thickness (y, x) displaced by ``shift`` rows north and columns east of a window of the image.

        Raises
        ------
        ValueError
            If the displacement exceeds the margin.
        """
        if any(abs(by) > room for by, room in zip(shift, self._margin, strict=True)):
            raise ValueError(f"shift: {shift} given, allowed: up to {self._margin}")
        moved = (
            slice(window.start + room + by, window.stop + room + by)
            for window, room, by in zip((rows, columns), self._margin, shift, strict=True)
        )
        # The sky of the generator may continue beyond the plane, like the window.
        around = getattr(self._generator, "thickness_around_m", None)
        if around is not None:
            sky: NDArray[np.float32] = around(time_s, *moved, None)
            return sky
        return self._generator.thickness_m(time_s, *moved)
