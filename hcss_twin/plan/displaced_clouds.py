"""Clouds beyond the image, which slant paths need, seen from the rows and columns of the image."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.cached_method import cached_method
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
    view_shift : (int, int)
        Displacement of the cloud seen from each point, within the margin.
    """

    def __init__(self, generator: CloudGenerator, margin: tuple[int, int], view_shift: tuple[int, int]) -> None:
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
        return self.displaced_m(time_s, rows, columns, self._view_shift)

    def _thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window that may reach outside the image."""
        return self.displaced_m(time_s, rows, columns, self._view_shift)

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


class CloudsAroundFrame:
    """A cloud generator whose coverage is that of the image, with the clouds around it, for slant paths.

    The sky of such a generator has no place of its own: it lies so that the image sees the coverage that was asked for.
    Displacements count from that of the line of sight. All other attributes are delegated to the generator.

    Parameters
    ----------
    generator : CloudGenerator
        With ``thickness_around_m``.
    view_shift : (int, int)
        Displacement of the cloud seen from each point.
    """

    def __init__(self, generator: CloudGenerator, view_shift: tuple[int, int]) -> None:
        self._generator = generator
        self._view_shift = view_shift
        self._summary = cached_method(self._summary_at, 1)

    @property
    def declares(self) -> CloudDeclaration:
        """Declaration of the generator."""
        return self._generator.declares

    def __getattr__(self, name: str) -> Any:
        # attributes of copies and unpickled objects are looked up before the generator is set
        if name.startswith("__") or name == "_generator":
            raise AttributeError(name)
        return getattr(self._generator, name)

    def displaced_m(self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]) -> NDArray[np.float32]:
        """Return the thickness (y, x) displaced by ``shift`` rows north and columns east of a window of the image."""
        moved = (
            slice(window.start + by - seen, window.stop + by - seen)
            for window, by, seen in zip((rows, columns), shift, self._view_shift, strict=True)
        )
        around: NDArray[np.float32] = self._generator.thickness_around_m(  # type: ignore[attr-defined]
            time_s, *moved, self._summary(time_s)
        )
        return around

    def _summary_at(self, time_s: float) -> Any:
        """Return what the frame tells of the clouds around it."""
        if self._generator.declares.tileable:
            return None
        return self._generator.frame_summary(time_s)  # type: ignore[attr-defined]
