"""Light in clouds that are not columns: an extension that replaces the look-up of independent columns.

A package names a class in the entry point group ``hcss_twin.light``; the name of the entry point is the value of
``radiance.light`` that selects it. The class is called with :class:`LightInputs` and has the members of
:class:`LightTransport`. Scenes with several layers of cloud take the class of the same name in the group
``hcss_twin.light_of_layers``, which has a ``stage`` of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.profile import Profile
from hcss_twin.providers.atmosphere import TransmittanceProvider
from hcss_twin.providers.clouds import CloudLayer
from hcss_twin.providers.column_states import Sun, View
from hcss_twin.providers.optics import Optics
from hcss_twin.providers.radiance import SolarIrradiance
from hcss_twin.providers.sea import SeaModel

__all__ = ["LightInputs"]


@dataclass(frozen=True)
class LightInputs:
    """Inputs of a light transport: geometry of one cloud layer, and the scene's providers.

    Attributes
    ----------
    layer : CloudLayer
        The lowest layer with cloud; columns of cloud extend from its anchor by their thickness.
    shape : {"uniform", "adiabatic"}
        Extinction within a column: the same at all heights, or growing as the power 2/3 of the height above its base.
    sun_zenith_deg, sun_azimuth_deg : ndarray (F,)
        The sun at the frames in which it is up and matters.
    reference_m : float
        Altitude at which the line of sight of a pixel meets the column of cloud that has its row and column.
    point_m : float
        Distance between columns.
    points, accuracy : int, float or None
        Columns of all frames, and the relative error that the scene allows.
    wavenumber_cm1, weights_cm1 : ndarray (V,), (B, V)
        Weighted wavenumbers of the radiance tables.
    clear, sea_sun : callable
        Return the radiance (V,) of the cloud-free column under a sun, W m-2 sr-1 (cm-1)-1, and what of it is direct
        sunlight that the sea reflects.
    air_sun : callable
        Returns what of it (V,) is sunlight that the air above an altitude scatters once into the view.
    sea : SeaModel
        The sea below.
    image : (int, int)
        Rows and columns of points of the image.
    clouds : callable
        Returns the thickness (y, x) of a window of points in or around the first frame, and the shares (Z, y, x) of
        heights between altitudes (Z + 1,), None if the generator has none.
    number : int
        Of the layer among all of the scene, from the lowest on.
    above : LightInputs, optional
        The same of the next layer with cloud above it.
    tops_vary : bool
        Whether clouds of the layer have tops of their own: then it is as high as all of them, and says nothing of a
        column's place in it.
    """

    layer: CloudLayer
    shape: Literal["uniform", "adiabatic"]
    view: View
    sun_zenith_deg: Array
    sun_azimuth_deg: Array
    reference_m: float
    point_m: float
    points: int
    accuracy: float | None
    wavenumber_cm1: Array
    weights_cm1: Array
    profile: Profile
    transmittance: TransmittanceProvider
    optics: Optics
    solar_irradiance: SolarIrradiance
    clear: Callable[[Sun | None], Array]
    sea_sun: Callable[[Sun], Array]
    air_sun: Callable[[Sun, float], Array]
    sea: SeaModel
    image: tuple[int, int]
    clouds: Callable[[slice, slice, Array], tuple[NDArray[np.float32], NDArray[np.float32] | None]]
    number: int = 0
    above: LightInputs | None = None
    tops_vary: bool = False

    @property
    def stack(self) -> tuple[LightInputs, ...]:
        """Return the inputs of this layer and of all above it."""
        return (self, *(() if self.above is None else self.above.stack))


class InstantLight(Protocol):
    """Light at one instant."""

    def correct(self, thickness_m: NDArray[np.float32]) -> tuple[Array, Array, Array]:
        """Return how the radiance of points differs from that of their columns.

        From the cloud (y, x) of points and of those within ``reach`` around them, rows to the north and columns to the
        east: the thickness (y, x) at which the tables are read, m, 0 to the layer's greatest (below its least they are
        linear), the share (B, y, x) of their radiance that counts, and the radiance (B, y, x) to add, W m-2 sr-1.
        Values of the points around are not used.
        """
        ...


class LightTransport(Protocol):
    """Light in broken clouds; ``reach``: rows, and columns, of points before and after others that matter to them.

    ``cost``: time for each pixel relative to other transports; infinite: the plan does not choose it.
    Optional ``stage``: a function of plan and tables that returns another
    :class:`~hcss_twin.engine.stages.light.LightStage`;
    ``over_views``: a method of plan that returns the expected errors and a note for an image whose view varies, which
    is refused without it; ``knows_surfaces``, ``knows_rays`` and ``knows_tops``: whether ``stage`` computes maps of the
    ground, images that are no grid on it, such as those of cameras, and clouds with tops of their own, which are
    refused without;
    ``check``: one of plan, tables and number of a frame, whose mapping with a ``text`` is part
    of the certificate.
    """

    reach: tuple[tuple[int, int], tuple[int, int]]
    cost: float

    def expected_errors(self) -> Sequence[float]:
        """Return the error (B,) to expect, rms over pixels relative to the mean radiance."""
        ...

    def errors_of_columns(self) -> Sequence[float]:
        """Return the error (B,) to expect of independent columns."""
        ...

    def at(self, sun: Sun | None) -> InstantLight:
        """Return the light under a sun; None at night."""
        ...
