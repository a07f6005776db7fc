"""Computation of frames: cloud thickness from the generators, window by window, and radiance by look-up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.packing import round_to_steps
from hcss_twin.cube.variables import ELEMENT_POINT_RADIANCE, ELEMENT_RADIANCE, TERM_PREFIX
from hcss_twin.cube.writer import round_bits
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.part_sample import SeenWindow
from hcss_twin.engine.shadows import InstantShadows, Shadows
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_views import ViewedLookUp
from hcss_twin.engine.tables.radiance_tables import TOTAL, RadianceTables, TableReader
from hcss_twin.engine.tables.waves import WaveStage
from hcss_twin.engine.truth import TOPS, Truth
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.clouds import sums_up
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, points_of, relative, windows
from hcss_twin.providers import CloudGenerator, Grid

if TYPE_CHECKING:
    from hcss_twin.engine.derived import DerivedStage
    from hcss_twin.engine.elements import ElementStage
    from hcss_twin.engine.light import LightStage
    from hcss_twin.engine.placed_points import Piece
    from hcss_twin.engine.tables.over_points import AnyLookUp
    from hcss_twin.engine.tables.over_surfaces import SurfaceStage
    from hcss_twin.engine.tables.over_tops import TopStage
    from hcss_twin.engine.tables.texture import TextureStage

Thickness = NDArray[np.float32]

WHOLE_POINTS = 2**24
"""Maximum points (4096 x 4096) of a frame computed whole by a generator that could also use a summary."""


class FrameClouds:
    """Thickness of every layer at the points of one instant.

    Parameters
    ----------
    summaries : sequence, optional
        Result of :func:`summaries_of` at the same instant, if already known.
    """

    def __init__(self, plan: Plan, time_s: float, summaries: Sequence[Any] | None = None) -> None:
        self._plan, self._time_s = plan, time_s
        self._clouds = _generators(plan)
        self._summaries = summaries_of(plan, time_s) if summaries is None else summaries

    def thickness_m(self, window: Window) -> list[Thickness]:
        """Thickness of each layer at the points of a window in or around the image.

        Outside the image, only for generators with ``thickness_around_m``.
        """
        rows, columns = (points_of(pixels, self._plan.samples_per_pixel) for pixels in window)
        inside, layers = _is_inside(window, self._plan.grid), []
        for index, (generator, cloudy) in enumerate(self._clouds):
            if not cloudy:
                layers.append(np.zeros((length(rows), length(columns)), dtype=np.float32))
            elif not inside:
                layers.append(generator.thickness_around_m(self._time_s, rows, columns, self._around[index]))
            elif (whole := self._whole[index]) is not None:
                layers.append(whole[rows, columns])
            elif (summary := self._summaries[index]) is not None:
                layers.append(generator.thickness_in_frame_m(self._time_s, rows, columns, summary))
            else:
                layers.append(generator.thickness_m(self._time_s, rows, columns))
        return layers

    @cached_property
    def _whole(self) -> list[Thickness | None]:
        """Frames of the layers that are computed whole."""
        plan, samples = self._plan, self._plan.samples_per_pixel
        points = slice(0, plan.grid.rows * samples), slice(0, plan.grid.columns * samples)
        return [
            generator.thickness_m(self._time_s, *points)
            if cloudy and not generator.declares.tileable and not _is_summed_up(plan, generator)
            else None
            for generator, cloudy in self._clouds
        ]

    @cached_property
    def _around(self) -> list[Any]:
        """Frame summaries that windows around the image need."""
        return [
            generator.frame_summary(self._time_s)
            if cloudy and summary is None and not generator.declares.tileable
            else summary
            for (generator, cloudy), summary in zip(self._clouds, self._summaries, strict=True)
        ]


def summaries_of(plan: Plan, time_s: float) -> list[Any]:
    """Return the frame summary that the windows of each layer need; None if none is needed or there is no cloud.

    This takes two to three times as long as computing the frame, without its memory.
    """
    return [
        generator.frame_summary(time_s) if cloudy and _is_summed_up(plan, generator) else None
        for generator, cloudy in _generators(plan)
    ]


def _generators(plan: Plan) -> tuple[tuple[Any, bool], ...]:
    """Return the generator of each layer, possibly with optional methods, and whether it has cloud."""
    return tuple(zip(plan.assembly.generators, plan.assembly.cloudy_layers, strict=True))


def _is_summed_up(plan: Plan, generator: CloudGenerator) -> bool:
    points = plan.grid.rows * plan.grid.columns * plan.samples_per_pixel**2
    return not generator.declares.tileable and points > WHOLE_POINTS and sums_up(generator)


def _is_inside(window: Window, grid: Grid) -> bool:
    return all(
        pixels.start >= 0 and pixels.stop <= size
        for pixels, size in zip(window, (grid.rows, grid.columns), strict=True)
    )


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
            from hcss_twin.engine.tables.over_surfaces import surface_stage  # not for scenes of sea alone

            self._surfaces = surface_stage(plan, tables)
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

            self._elements = ElementStage(plan) if plan.imager is None else plan.imager.element_stage(plan)
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
        plan, bands, imager = self._plan, len(self._plan.bands), self._plan.imager
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
                unseen = None if imager is None else imager.unseen(time_s, window)
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
        if imager is not None:
            imager.complete(frame, time_s, extent)
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
            plan, imager = self._plan, self._plan.imager
            clouds = FrameClouds(plan, time_s, summaries) if imager is None else imager.clouds(plan, time_s)
            shadows = [each.at(time_s) for each in self._shadows]
            self._instant = (index, time_s), self._look_up(time_s), shadows, clouds
        return self._instant[1:]

    def _tops_at(self, time_s: float, window: Window) -> Thickness | None:
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
        if self._plan.imager is not None and look_ups:
            look_up: AnyLookUp = self._plan.imager.look_up(self._plan, time_s, look_ups)
            return look_up
        if self._plan.views is not None and look_ups:
            return ViewedLookUp(self._plan.views, self._plan.grid, look_ups)
        return look_ups[0] if look_ups else None
