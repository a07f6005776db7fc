"""Computation of frames: cloud thickness from the generators, window by window, and radiance by look-up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.packing import round_to_steps
from hcss_twin.cube.variables import ELEMENT_POINT_RADIANCE, ELEMENT_RADIANCE, TERM_PREFIX
from hcss_twin.cube.writer import round_bits
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.part_sample import SeenWindow
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.shadows import InstantShadows, Shadows
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import viewed_look_up
from hcss_twin.engine.tables.radiance_tables import TOTAL, RadianceTables, TableReader
from hcss_twin.engine.tables.waves import WaveStage
from hcss_twin.engine.truth import TOPS, Truth
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, relative, windows

if TYPE_CHECKING:
    from hcss_twin.engine.derived import DerivedStage
    from hcss_twin.engine.elements import ElementStage
    from hcss_twin.engine.light import LightStage
    from hcss_twin.engine.placed_points import Piece
    from hcss_twin.engine.tables.over_points import AnyLookUp
    from hcss_twin.engine.tables.over_surfaces import SurfaceStage
    from hcss_twin.engine.tables.over_tops import TopStage
    from hcss_twin.engine.tables.texture import TextureStage

Frame = dict[str, NDArray[Any]]


class PixelObserver(Protocol):
    """Observes the clouds of a part of a frame during computation, window by window."""

    def observe(self, seen: SeenWindow) -> None:
        """Take a window."""


def stream(
    plan: Plan, tables: RadianceTables | None, sample: PixelSample | None = None, frames: Sequence[int] | None = None
) -> Iterator[Frame]:
    """Yield each frame's requested variables; memory use does not depend on the number of frames.

    Nor does it depend on the number of points per pixel if the cloud generators compute windows.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.
    sample : PixelSample, optional
        Samples pixels of the frames during computation.
    frames : sequence of int, optional
        Frame numbers of the whole sequence, from 0; by default all.
    """
    maker = PartMaker(plan, tables)
    for index in range(plan.frame_times_s.size) if frames is None else frames:
        part = None if sample is None else sample.of_part(index)
        frame, radiance = maker.part(index, plan.extent, part)
        if sample is not None and part is not None:
            sample.add_frame(index, [part.drawn(radiance)])
        yield frame


def _of_sea(plan: Plan, tables: RadianceTables | None) -> RadianceTables | None:
    """Return the tables of the scenario's own sea, which alone has waves."""
    if plan.surfaces is None or tables is None:
        return tables
    return next(each for states in tables.over_surfaces for each in states if each.waves is not None)


class PartMaker:
    """Computes parts of frames; consecutive calls for the same frame are most efficient.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.

    Attributes
    ----------
    drawn : dict of (int, int) to list of Piece
        What small elements added to the pixels of the last part, which sensors draw.
    """

    drawn: dict[tuple[int, int], list[Piece]]

    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        self._plan = plan
        self._quantities = () if tables is None else tables.quantities.names
        self._surfaces: SurfaceStage | None = None
        if plan.surfaces is not None:
            from hcss_twin.engine.tables.over_surfaces import SurfaceStage  # not for scenes of sea alone

            self._surfaces = SurfaceStage(plan, tables)
        self._tops: TopStage | None = None
        if plan.tops is not None and tables is not None:
            from hcss_twin.engine.tables.over_tops import TopStage  # not for layers with tops of their own

            self._tops = TopStage(plan, tables)
        each = (
            ()
            if tables is None or self._surfaces is not None or self._tops is not None
            else tables.over_views or (tables,)
        )
        self._readers = [TableReader(toward) for toward in each]
        self._look_ups: Sequence[LookUp | None] = [None] * len(self._readers)
        self._truth = Truth(plan)
        of_classes: tuple[RadianceTables | None, ...] = (tables,)
        if self._surfaces is not None and tables is not None:
            of_classes = tuple(own[0] for own in tables.over_surfaces)
        self._shadows = [Shadows(plan, own) for own in of_classes]
        self._waves = (
            None
            if plan.waves is None
            else WaveStage(plan.waves, _of_sea(plan, tables), plan.scenario.sea.wind_from, plan.samples_per_pixel)
        )
        self._texture: TextureStage | None = None
        if plan.texture is not None and (tables is not None or any(each.needs == "texture" for each in plan.computed)):
            from hcss_twin.engine.tables.texture import TextureStage  # not for scenes without texture

            self._texture = TextureStage(plan, plan.texture, tables)
        self._elements: ElementStage | None = None
        if plan.assembly.elements:
            from hcss_twin.engine.elements import ElementStage  # not for scenes without elements

            self._elements = ElementStage(plan)
        self._light: LightStage | None = None
        if plan.light is not None and tables is not None:
            from hcss_twin.engine.light import LightStage  # not for independent columns

            self._light = getattr(plan.light.transport, "stage", LightStage)(plan, tables)
        self._derived: DerivedStage | None = None
        if plan.assembly.derived:
            from hcss_twin.engine.derived import DerivedStage  # not for scenes without such variables

            self._derived = DerivedStage(plan)
        self._bits = {spec.name: spec.significant_bits for spec in plan.variables if spec.significant_bits is not None}
        self._packings = {spec.name: spec.packing for spec in plan.variables if spec.packing is not None}
        self._requested = {spec.name for spec in plan.variables}
        self._names = {spec.name for spec in plan.computed}
        self._temperature = (
            BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])
            if "brightness_temperature" in self._names
            else None
        )
        # Current frame: number and time, look-up, shadows and clouds.
        self._instant: tuple[tuple[int, float], AnyLookUp | None, list[InstantShadows | None], FrameClouds] | None = (
            None
        )

    def part(
        self,
        index: int,
        extent: Window,
        sample: PixelObserver | None = None,
        summaries: Sequence[Any] | None = None,
        time_s: float | None = None,
    ) -> tuple[Frame, NDArray[np.float32]]:
        """Return the requested variables of a part of a frame, and its radiance (Q, B, y, x) as stored in the cube.

        With light between columns the second is that of independent columns, which the certificate checks. The result
        for a pixel is bit-identical in every part.

        Parameters
        ----------
        index : int
            Number of the frame.
        extent : (slice, slice)
            Rows and columns of the image.
        sample : PixelObserver, optional
            Observes the pixels, for example for the certificate.
        summaries : sequence, optional
            As in :class:`FrameClouds`.
        time_s : float, optional
            Time after the start; by default that of the frame.
        """
        plan, bands = self._plan, len(self._plan.bands)
        time_s = float(plan.frame_times_s[index]) if time_s is None else time_s
        look_up, shadows, clouds = self._at(index, time_s, summaries)
        if look_up is not None and not isinstance(look_up, LookUp):
            look_up = look_up.of_part(extent)
        elements = None if self._elements is None else self._elements.at(index, time_s, clouds, look_up)
        size = length(extent[0]), length(extent[1])
        radiance = np.empty((len(self._quantities) * bands, *size), dtype=np.float32)
        shown = radiance if self._light is None else np.empty_like(radiance)
        wanted = self._names & {ELEMENT_RADIANCE, ELEMENT_POINT_RADIANCE}
        added = {name: np.zeros((bands, *size), dtype=np.float32) for name in wanted}
        self._truth.start(*size)
        for number, window in enumerate(windows(plan.image, plan.samples_per_pixel, inside=extent)):
            place = relative(window, extent)
            thickness = clouds.thickness_m(window)
            self._truth.fill(place, thickness, self._tops_at(time_s, window))
            # Without layers the first window fills the whole part, to which waves and elements are added.
            if look_up is not None and (thickness or number == 0):
                corner = place[0].start, place[1].start
                look_up.fill(radiance, thickness, plan.samples_per_pixel, corner)
            if self._light is not None:
                self._light.fill(shown, window, place, time_s, clouds, look_up)
            if self._texture is not None and (thickness or number == 0):
                filled = place if thickness else (slice(0, size[0]), slice(0, size[1]))
                columns = None if self._light is None else radiance[:, *filled].copy()
                self._texture.fill(radiance, self._truth.variables, extent, filled, thickness, time_s)
                if columns is not None:  # light between columns changes the radiance, not the texture's part of it
                    shown[:, *filled] = np.maximum(shown[:, *filled] + (radiance[:, *filled] - columns), 0.0)
            ground = None if self._surfaces is None else self._surfaces.at(time_s, window)
            over_sea, surface = thickness, None
            if self._surfaces is not None and ground is not None:
                self._surfaces.tell(self._truth.variables, ground, place)
                surface = None if sample is None else self._surfaces.main_class(ground)
                over_sea = [*thickness, self._surfaces.other_than(self._surfaces.sea, ground)]
            if self._waves is not None:
                self._waves.fill(radiance, self._truth.variables, window, over_sea, time_s, place)
            shaded = None
            for number, shadow in enumerate(shadows):
                if shadow is None:
                    continue
                own = thickness
                if self._surfaces is not None and ground is not None and len(shadows) > 1:
                    own = [*thickness, self._surfaces.other_than(number, ground)]
                cast = shadow.cast(window, own, radiance, self._truth.variables, place)
                shaded = cast if shaded is None else shaded | cast
            present = None
            if elements is not None:
                present = elements.add(window, thickness, radiance, added, self._truth.variables, place)
            if sample is not None:
                unseen = plan.rays.unseen(window, time_s)
                sample.observe(SeenWindow(place, thickness, shaded, present, surface, over_sea, unseen))
        frame: Frame = dict(self._truth.variables)
        for number, name in enumerate(self._quantities):
            values = shown[number * bands : (number + 1) * bands]
            frame[TOTAL if name == TOTAL else TERM_PREFIX + name] = values
        frame |= added
        self.drawn = {} if elements is None else elements.drawn
        if self._temperature is not None:
            frame["brightness_temperature"] = self._temperature(frame[TOTAL])
        if self._derived is not None:
            frame |= self._derived.values(frame, extent, time_s)
        plan.rays.complete(frame, time_s, extent)
        for name, bits in self._bits.items():
            round_bits(frame[name], bits)
        for name, packing in self._packings.items():
            round_to_steps(frame[name], packing, f"frame {index}, {name}")
        requested = {name: values for name, values in frame.items() if name in self._requested}
        return requested, radiance.reshape(len(self._quantities), bands, *size)

    def element_windows(self, index: int, area: Window, time_s: float | None = None) -> list[Window]:
        """Return windows of an area of the image that hold all small elements of a frame that sensors draw."""
        if self._elements is None:
            return []
        time_s = float(self._plan.frame_times_s[index]) if time_s is None else time_s
        _, _, clouds = self._at(index, time_s)
        return self._elements.at(index, time_s, clouds, None).windows(area)

    def _at(
        self, index: int, time_s: float, summaries: Sequence[Any] | None = None
    ) -> tuple[AnyLookUp | None, list[InstantShadows | None], FrameClouds]:
        """Return look-up, shadows and clouds of an instant."""
        if self._instant is None or self._instant[0] != (index, time_s):
            self._instant = None  # one whole frame of clouds at a time
            clouds = FrameClouds(self._plan, time_s, summaries)
            shadows = [each.at(time_s) for each in self._shadows]
            self._instant = (index, time_s), self._look_up(time_s), shadows, clouds
        return self._instant[1:]

    def _tops_at(self, time_s: float, window: Window) -> NDArray[np.float32] | None:
        """Return the altitudes of cloud tops for the truth; None if they are those of the layers."""
        if self._plan.tops is None or self._names.isdisjoint(TOPS):
            return None
        from hcss_twin.engine.tables.over_tops import cloud_tops_m

        return cloud_tops_m(self._plan, time_s, window)

    def _look_up(self, time_s: float) -> AnyLookUp | None:
        """Return the look-up at an instant; None if there is no radiance."""
        if self._surfaces is not None and self._quantities:
            return self._surfaces.look_up(time_s)
        if self._tops is not None:
            return self._tops.look_up(time_s)
        pairs = zip(self._readers, self._look_ups, strict=True)
        look_ups = [LookUp(reader.at(time_s), before) for reader, before in pairs]
        self._look_ups = look_ups
        if self._plan.views is not None and look_ups:
            return viewed_look_up(self._plan, time_s, look_ups)
        return look_ups[0] if look_ups else None
