"""Effects of points: what a package adds to let the columns of a scene differ from place to place."""

from __future__ import annotations

from typing import Protocol

from hcss_twin.core.arrays import Array
from hcss_twin.providers.column_states import ColumnSetting


class PointEffect(Protocol):
    """One number at each place of the scene, on which sea or air of its column depend.

    The plan finds out how many values of it need tables, points are interpolated between them, and the certificate
    solves columns in their exact state.

    Attributes
    ----------
    low, high : float
        Range of the number in the scene, low below high.
    kinks : tuple of float
        Values within at which radiance may have kinks, ascending; may be empty.
    """

    @property
    def low(self) -> float:
        """As above."""
        ...

    @property
    def high(self) -> float:
        """As above."""
        ...

    @property
    def kinks(self) -> tuple[float, ...]:
        """As above."""
        ...

    def values(self, x_m: Array, y_m: Array, time_s: float) -> Array:
        """Return the number, within its range, at places east and north of the centre of the scene: same shape."""
        ...

    def apply(self, setting: ColumnSetting, value: float) -> ColumnSetting:
        """Return a setting with other providers of sea or air, for one value of the number."""
        ...
