"""A window of the image: the part of a larger scene that is computed."""

from __future__ import annotations

from pydantic import Field
from pydantic_core import PydanticCustomError

from hcss_twin.scenario.section import Section
from hcss_twin.scenario.units import Whole
from hcss_twin.scenario.wording import shown

Range = tuple[Whole, Whole]


class ImageWindow(Section):
    """Rows and columns of the image that are computed: to the bit what the whole image has there.

    Places on the ground, sun and clouds stay those of the whole image. Numbers count from 0; the end is not included.
    """

    rows: Range | None = Field(None, description="[first, end] of the rows; default: all.")
    columns: Range | None = Field(None, description="[first, end] of the columns; default: all.")

    def within(self, rows: int, columns: int) -> ImageWindow:
        """Return the window itself.

        Raises
        ------
        PydanticCustomError
            If it does not lie within an image of so many rows and columns.
        """
        for name, size in (("rows", rows), ("columns", columns)):
            given: Range | None = getattr(self, name)
            if given is None or 0 <= given[0] < given[1] <= size:
                continue
            first = min(max(given[0], 0), size - 1)
            nearest = [first, min(max(given[1], first + 1), size)]
            raise PydanticCustomError(
                "window",
                f"{name} = {shown(list(given))}; allowed: [first, end] with 0 <= first < end <= {size}, the image's "
                f"{name}; closest valid choice is {nearest}",
            )
        return self

    def slices(self, rows: int, columns: int) -> tuple[slice, slice]:
        """Return rows and columns as slices of an image of so many rows and columns."""
        return slice(*(self.rows or (0, rows))), slice(*(self.columns or (0, columns)))
