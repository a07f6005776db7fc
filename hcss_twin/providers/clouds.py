"""Cloud generators: fields of cloud thickness."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.common import Declares


@dataclass(frozen=True)
class Grid:
    """The image plane: ``rows`` x ``columns`` square pixels of ``pixel_size_m``; x along columns.

    A cloud generator gets the plane of the points it is asked for: with n x n points per pixel of the image there
    are n times the rows and columns, of an n-th of the size, and each point is the centre of its square.
    """

    rows: int
    columns: int
    pixel_size_m: float


@dataclass(frozen=True)
class Motion:
    """What moves: the platform's ground speed along +x, the wind that carries the clouds, and evolution.

    Attributes
    ----------
    platform_speed_m_s : float
        Speed of the image's ground footprint in +x (columns).
    cloud_velocity_m_s : (float, float)
        Velocity (x, y) of the cloud field over the ground.
    evolution_time_s : float
        Lattice cell of the time dimension at the coarsest octave; infinity freezes the shapes.
    frame_interval_s : float
        Time between frames.
    """

    platform_speed_m_s: float
    cloud_velocity_m_s: tuple[float, float]
    evolution_time_s: float
    frame_interval_s: float


@dataclass(frozen=True)
class Microphysics:
    """Particles of one cloud layer: n(r) = a r^alpha exp(-b r^nu), the modified gamma distribution.

    Attributes
    ----------
    phase : {"water", "ice"}
        Thermodynamic phase, which selects the refractive index.
    alpha, b, nu : float
        Shape, scale (um^-nu) and exponent for a radius in micrometres.
    number_density_m3 : float
        Particles per cubic metre; fixes ``a`` by normalisation.
    radius_range_um : (float, float)
        Limits of integration r1, r2.
    """

    phase: Literal["water", "ice"]
    alpha: float
    b: float
    nu: float
    number_density_m3: float
    radius_range_um: tuple[float, float]


@dataclass(frozen=True)
class CloudLayer:
    """One cloud layer: where it is and what it is made of.

    Attributes
    ----------
    name : str
        Cloud type, for people.
    base_m, top_m : float
        Altitudes of the layer's base and of its highest possible top.
    anchor : {"base", "top"}
        Which of the two stays where it is when the cloud is thinner than ``top_m - base_m``.
    thickness_min_m : float
        Thickness of the thinnest cloudy pixel.
    coverage : float
        Fraction of cloudy pixels, 0 to 1.
    temperature_K : float or None
        Cloud temperature; None takes the profile's at the cloud top.
    microphysics : Microphysics
        Particles.
    coverage_mode : {"frame", "field"}
        ``frame``: exactly ``coverage`` in every frame. ``field``: one threshold for the unbounded field,
        exact in the mean, so that every window and every sensor sees the same clouds.
    edge_taper : float
        0 to 1: part of the cloudy area, from the edge inward, over which thickness rises smoothly from
        its minimum; 0 is eq 7 as printed.
    """

    name: str
    base_m: float
    top_m: float
    anchor: Literal["base", "top"]
    thickness_min_m: float
    coverage: float
    temperature_K: float | None
    microphysics: Microphysics
    coverage_mode: Literal["frame", "field"] = "frame"
    edge_taper: float = 0.0

    @property
    def thickness_max_m(self) -> float:
        """Greatest geometric thickness."""
        return self.top_m - self.base_m

    def cloud_top_m(self, thickness_m: Array) -> Array:
        """Altitude of the cloud top, same shape as ``thickness_m``."""
        if self.anchor == "base":
            return self.base_m + thickness_m
        return np.full_like(thickness_m, self.top_m)


@dataclass(frozen=True)
class CloudInputs:
    """What a cloud generator is built from.

    Attributes
    ----------
    layer : CloudLayer
        Where the cloud is, how thick, and how much of the sky it covers.
    grid : Grid
        Plane of the points asked for.
    motion : Motion
        What moves, and how shapes evolve.
    seed : int
        0 to below 2^63; another for each layer. All randomness follows from it.
    catalog : Catalog
        Reader of data files.
    type_parameters : mapping of str to anything
        What the catalog knows of the shapes of this cloud type, by the fractal generator's names; may be empty.
    """

    layer: CloudLayer
    grid: Grid
    motion: Motion
    seed: int
    catalog: Catalog
    type_parameters: Mapping[str, Any] = field(default_factory=dict)


@runtime_checkable
class CloudGenerator(Protocol):
    """Fields of cloud thickness."""

    declares: Declares

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) of a window of the image at ``time_s``; 0 is clear sky.

        ``time_s`` counts from the scenario's start and is 0 or more. Both slices state start and stop, and no step.
        A pixel's value must not depend on the window
        (unless ``declares.tileable`` is False, when only whole frames are asked for), on earlier
        calls, or on the number of threads.
        """
        ...


class CloudGeneratorOptions(Protocol):
    """What a cloud generator may have beside ``CloudGenerator``, as attributes set when it is made.

    Attributes
    ----------
    skipped : sequence of (str, str)
        What it leaves out and why, each a few words; listed in the plan.
    image_coverage : float or None
        Cloudy fraction, 0 to 1, where it follows from an image and not from ``layer.coverage``; None where the
        layer's holds. With a number, a layer of coverage 0 has cloud.
    honours : collection of str
        Which of ``coverage_mode`` and ``edge_taper`` of the layer it keeps to. A scenario that sets another one gets a
        note in plan and cube that it may have no influence.
    """

    skipped: Sequence[tuple[str, str]]
    image_coverage: float | None
    honours: Collection[str]

    def frame_summary(self, time_s: float) -> Any:
        """Return what a window of the frame at ``time_s`` needs to know of the rest of it.

        For generators that only make whole frames (``declares.tileable`` is False), together with
        ``thickness_in_frame_m``: frames of more than 4096 x 4096 points are then made by windows. Its memory must not
        grow with the frame. The result can be pickled and is handed back as it is.
        """
        ...

    def thickness_in_frame_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window, to the bit what ``thickness_m`` has there in the whole frame."""
        ...

    def thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image, to negative rows and columns too.

        For generators whose sky has no edge: sensors whose optics blur see clouds beyond the image. Inside it pixels
        are to the bit what ``thickness_m`` has there. ``summary`` is that of ``frame_summary``, which
        generators of whole frames need for it; None where windows are given without one.
        """
        ...
