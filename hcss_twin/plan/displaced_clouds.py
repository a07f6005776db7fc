"""Clouds beyond the image, which slant paths need, seen from the rows and columns of the image."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.cached_method import cached_method
from hcss_twin.plan.point_shifts import PointShifts, gathered
from hcss_twin.providers import CloudDeclaration, CloudGenerator


class DisplacedClouds:
    """A cloud generator that is addressed by the rows and columns of the image, and knows the clouds around it.

    All other attributes are delegated to the generator. The sky of clouds whose coverage is that of the image has no
    place of its own: it lies so that the image sees it, and displacements count from that of the line of sight.

    Parameters
    ----------
    generator : CloudGenerator
        Of a larger plane of which it can compute windows, or of the image, with ``thickness_around_m``.
    margin : (int, int)
        Rows and columns of the plane before and after those of the image.
    view_shift : (int, int) or PointShifts
        Displacement of the cloud seen from each point, within the margin of a larger plane.
    of_image : bool
        Whether the clouds are those that the image sees, made for its plane.
    """

    def __init__(
        self,
        generator: CloudGenerator,
        margin: tuple[int, int],
        view_shift: tuple[int, int] | PointShifts,
        of_image: bool = False,
    ) -> None:
        self._generator = generator
        self._margin = margin
        self._view_shift = view_shift
        self._origin = (0, 0)
        if of_image:
            self._origin = view_shift if isinstance(view_shift, tuple) else view_shift.middle
        self._of_image = of_image
        self._summary = cached_method(self._summary_at, 1)

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
        own = {"thickness_around_m": self._thickness_around_m, "thickness_in_frame_m": self._thickness_around_m}
        return own.get(name, attribute)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window of the image."""
        return self._seen_m(time_s, rows, columns, self._generator.thickness_m)

    def _seen_m(
        self, time_s: float, rows: slice, columns: slice, of_image: Callable[..., NDArray[np.float32]]
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window; ``of_image`` gives that of clouds that the image sees."""
        if isinstance(self._view_shift, tuple):
            if self._of_image:
                return of_image(time_s, rows, columns)
            return self.displaced_m(time_s, rows, columns, self._view_shift)
        shifts = self._view_shift.at(rows, columns)
        (down, right), (far_down, far_right) = shifts.min(axis=(1, 2)).tolist(), shifts.max(axis=(1, 2)).tolist()
        wide = slice(rows.start, rows.stop + far_down - down), slice(columns.start, columns.stop + far_right - right)
        return gathered(self.displaced_m(time_s, *wide, (down, right)), shifts, (down, right))

    def _thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window that may reach outside the image."""

        def around(*window: Any) -> NDArray[np.float32]:
            sky: NDArray[np.float32] = self._generator.thickness_around_m(*window, summary)  # type: ignore[attr-defined]
            return sky

        return self._seen_m(time_s, rows, columns, around)

    def displaced_m(self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]) -> NDArray[np.float32]:
        """Return the thickness (y, x) displaced by ``shift`` rows north and columns east of a window of the image.

        Raises
        ------
        ValueError
            If the displacement exceeds the margin.
        """
        if not self._of_image and any(abs(by) > room for by, room in zip(shift, self._margin, strict=True)):
            raise ValueError(f"shift: {shift} given, allowed: up to {self._margin}")
        moved = (
            slice(window.start + room + by - seen, window.stop + room + by - seen)
            for window, room, by, seen in zip((rows, columns), self._margin, shift, self._origin, strict=True)
        )
        # The sky of the generator may continue beyond the plane, like the window.
        around = getattr(self._generator, "thickness_around_m", None)
        if around is not None:
            sky: NDArray[np.float32] = around(time_s, *moved, self._summary(time_s))
            return sky
        return self._generator.thickness_m(time_s, *moved)

    def _summary_at(self, time_s: float) -> Any:
        """Return what the frame tells of the clouds around it."""
        if self._generator.declares.tileable:
            return None
        return self._generator.frame_summary(time_s)  # type: ignore[attr-defined]
