"""Clouds met by slant paths: windows of the image cut from a larger plane, displaced."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.providers import CloudGenerator, CloudLayer, Declares


class DisplacedClouds:
    """The cloud generator of a plane that is larger than the image, asked in the image's rows and columns.

    All other attributes are those of the generator.

    Parameters
    ----------
    generator : CloudGenerator
        Made for the larger plane; gives windows.
    margin : (int, int)
        Rows and columns of the plane before and after those of the image.
    view_shift : (int, int)
        Displacement of what is seen from each point, within the margin.
    """

    def __init__(self, generator: CloudGenerator, margin: tuple[int, int], view_shift: tuple[int, int]) -> None:
        self._generator = generator
        self._margin = margin
        self._view_shift = view_shift

    @property
    def declares(self) -> Declares:
        """What the generator says about itself."""
        return self._generator.declares

    def __getattr__(self, name: str) -> Any:
        # copies and unpickled objects are asked for attributes before they have a generator
        if name.startswith("__") or name == "_generator":
            raise AttributeError(name)
        found = getattr(self._generator, name)
        # looked up here, so that hasattr() tells whether the generator has it
        return self._thickness_around_m if name == "thickness_around_m" else found

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window of the image."""
        return self.displaced_m(time_s, rows, columns, self._view_shift)

    def _thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window that may reach outside the image."""
        return self.displaced_m(time_s, rows, columns, self._view_shift)

    def displaced_m(self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]) -> NDArray[np.float32]:
        """Return the thickness (y, x) so many rows north and columns east of a window of the image.

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
        # Its sky may go on beyond the plane, where the window does.
        around = getattr(self._generator, "thickness_around_m", None)
        if around is not None:
            sky: NDArray[np.float32] = around(time_s, *moved, None)
            return sky
        return self._generator.thickness_m(time_s, *moved)


_REMEDY = "or slant.shadows = false and slant.parallax = false"


def require_one_sky(layer: CloudLayer, field: str, margin: tuple[int, int]) -> None:
    """Refuse a coverage that is that of the image where paths leave it.

    Raises
    ------
    ScenarioError
        Naming the layer's ``coverage_mode``.
    """
    if layer.coverage_mode == "field" or margin == (0, 0):
        return
    message = (
        f"\"frame\" fixes the coverage of the image, and slant paths meet '{layer.name}' up to {margin[0]} rows and "
        f'{margin[1]} columns of points outside it; allowed: "field", {_REMEDY}'
    )
    raise ScenarioError([Problem(f"{field}.coverage_mode", message)])


def require_windows(generator: CloudGenerator, layer: CloudLayer, field: str) -> None:
    """Refuse a generator that only makes whole frames.

    Raises
    ------
    ScenarioError
        Naming the layer's ``generator``.
    """
    if not generator.declares.tileable:
        message = (
            f"that of '{layer.name}' only makes whole frames, and slant paths meet clouds outside the image; allowed: "
            f"a generator that gives windows (closest is 'fractal'), {_REMEDY}"
        )
        raise ScenarioError([Problem(f"{field}.generator", message)])
