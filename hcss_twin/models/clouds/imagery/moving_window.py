"""A window of a scene that moves over an image, by whole pixels: every frame shows original pixels of the image."""

from __future__ import annotations

import math

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.providers import Grid, Motion


def pixels_per_second(motion: Motion, grid: Grid) -> tuple[float, float]:
    """Return the speed of the scene relative to the clouds along y (north) and x (east), pixels per second."""
    wind_x, wind_y = motion.cloud_velocity_m_s
    return -wind_y / grid.pixel_size_m, (motion.platform_speed_m_s - wind_x) / grid.pixel_size_m


def whole_pixels(speed: float, time_s: float) -> int:
    """Return the displacement at ``time_s`` to the nearest whole pixel, halves upward."""
    return math.floor(speed * time_s + 0.5)


class MovingWindow:
    """Window of a scene on an image with rows northward and columns eastward.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the image.
    grid : Grid
        The scene, not larger than the image.
    motion : Motion
        Motion of platform and clouds.
    origins : (int or None, int or None)
        First image row and column of the scene, counted as stored; None centres the scene.
    turned : (bool, bool)
        Whether the stored rows run southward and the stored columns westward.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        grid: Grid,
        motion: Motion,
        origins: tuple[int | None, int | None],
        turned: tuple[bool, bool],
    ) -> None:
        self._shape = shape
        self._sizes = (grid.rows, grid.columns)
        self._origins = tuple(
            (whole - size) // 2 if given is None else whole - size - given if is_turned else given
            for given, whole, size, is_turned in zip(origins, shape, self._sizes, turned, strict=True)
        )
        self._speed = pixels_per_second(motion, grid)

    @property
    def moves(self) -> bool:
        """Whether the window moves."""
        return any(self._speed)

    def at(self, time_s: float) -> tuple[slice, slice]:
        """Return the rows and columns of the image (south and west first) seen at ``time_s``.

        Raises
        ------
        ScenarioError
            If the footprint has left the image.
        """
        slices = []
        for name, origin, speed, size, whole in zip(
            ("rows", "columns"), self._origins, self._speed, self._sizes, self._shape, strict=True
        ):
            start = origin + whole_pixels(speed, time_s)
            if not 0 <= start <= whole - size:
                room = whole - size - origin if speed * time_s > 0.0 else origin
                last = math.copysign((room + 0.5) / abs(speed), time_s)
                outside = max(-start, start + size - whole)
                problem = Problem(
                    "motion",
                    f"at {time_s:g} s the footprint lies outside the image by {outside} of its {size} {name}; "
                    f"allowed: less than {last:.6g} s, a larger image, or another {name[:-1]}_origin",
                )
                raise ScenarioError([problem], origin="imagery clouds")
            slices.append(slice(start, start + size))
        return slices[0], slices[1]

    @staticmethod
    def problems(shape: tuple[int, int], grid: Grid, origins: tuple[int | None, int | None]) -> list[Problem]:
        """List the axes along which a scene does not fit into an image of ``shape`` (rows, columns)."""
        problems = []
        sizes = (("rows", grid.rows), ("columns", grid.columns))
        for (name, size), whole, origin in zip(sizes, shape, origins, strict=True):
            if size > whole:
                problems.append(
                    Problem(
                        f"image.{name}",
                        f"{size} is more than the image has ({shape[0]} rows, {shape[1]} columns); closest is {whole}",
                    )
                )
            elif origin is not None and origin + size > whole:
                problems.append(
                    Problem(
                        f"clouds.parameters.{name[:-1]}_origin",
                        f"{origin} puts {size} {name} beyond the image's {whole}; allowed: 0 to {whole - size}, "
                        f"closest is {whole - size}",
                    )
                )
        return problems
