"""From a draw to frames with labels: clean radiance, targets and noise by the engine, and what is measured on them.

A draw is a scenario with one sky; its frames are those that ``hcss run`` computes. The clean image of a frame is what
the sensor would give without targets and noise: a target's own image is drawn by the same optics onto nothing.
"""

from __future__ import annotations

import json
import math
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_dataset.distribution import MAX_ATTEMPTS, Distribution, without_sky
from hcss_dataset.errors import DatasetError
from hcss_dataset.noise import noise_rms
from hcss_dataset.targets import Target, all_tracks, draw_targets, seen_at
from hcss_twin import CatalogError, Scenario, make_plan
from hcss_twin.core.kernels import kernel
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stages.element_paths import ElementPaths
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Points, Problem, ScenarioError

Image = NDArray[np.uint16]

STAMP = 65
"""Side of the square in which a target's own image is drawn, pixels."""

LARGEST_NUMBER = 2**16 - 1
_NUMBER_AT_ZERO = 2000
"""Number of an image without a converter at zero radiance, so that noise is not clipped."""

_OPTICS = ("psf", "psf_sigma", "psf_file", "aperture_diameter", "pixel_angle", "integration_time", "jitter", "smear")
_SHOWN = ("radiance", "element_transmittance", "element_share", "element_source")
_KEPT_STATES = 256
TARGETS_OF_A_SKY = 10
"""Draws of targets that may be refused before the sky is drawn again, too."""
_LARGEST_SIDE = 16.0
"""Side in pixels up to which sensors draw bodies through their point spread."""


@dataclass(frozen=True)
class Scale:
    """From numbers of an image to radiance, by band: radiance = offset + step * number.

    Attributes
    ----------
    step, offset : ndarray (B,)
        W m-2 sr-1.
    largest : int
        Largest number.
    """

    step: Array
    offset: Array
    largest: int

    def numbers(self, radiance: NDArray[Any]) -> Image:
        """Return the numbers (B, y, x) of radiance, within the range."""
        numbers = np.empty(radiance.shape, np.uint16)
        for of_band, image, step, offset in zip(numbers, radiance, self.step, self.offset, strict=True):
            _fill_numbers(of_band.ravel(), np.ascontiguousarray(image).ravel(), step, offset, self.largest)
        return numbers

    def radiance(self, numbers: Image) -> Array:
        """Return the radiance (B, y, x) of numbers."""
        result: Array = self.offset[:, None, None] + self.step[:, None, None] * numbers.astype(np.float64)
        return result


@kernel()
def _fill_numbers(numbers, radiance, step, offset, largest):  # type: ignore[no-untyped-def]
    for n in range(numbers.size):
        value = np.rint((np.float64(radiance[n]) - offset) / step)
        numbers[n] = np.uint16(min(max(value, 0.0), np.float64(largest)))


@dataclass(frozen=True)
class Frame:
    """A frame of a data set.

    Attributes
    ----------
    image, clean : ndarray of uint16 (B, y, x)
        As measured, and without targets and noise.
    labels : mapping
        As in the JSON of the frame.
    """

    image: Image
    clean: Image
    labels: Mapping[str, Any]


@dataclass(frozen=True)
class OwnImage:
    """What a target alone adds to the image of a sensor without noise.

    Attributes
    ----------
    radiance : ndarray (B, STAMP, STAMP)
        Its image.
    corner : (int, int)
        Row and column of its first pixel in the image.
    places : ndarray (N, 2)
        Row and column of the pieces of the target.
    light : ndarray (B, N)
        What each adds to its pixel.
    """

    radiance: Array
    corner: tuple[int, int]
    places: Array
    light: Array

    def times(self, factor: float) -> OwnImage:
        """Return the image of a target brighter by a factor."""
        return replace(self, radiance=self.radiance * factor, light=self.light * factor)

    def peak(self, band: int) -> float:
        """Return the value farthest from 0."""
        return float(self.radiance[band].flat[np.argmax(np.abs(self.radiance[band]))])


def checked_draw(source: str, overrides: Mapping[str, Any], progress: object = None) -> tuple[str, dict[str, int]]:
    """Check the file of a data set and its first draw without computing frames, for ``hcss validate``.

    One plan shows no ``progress``.

    Raises
    ------
    ScenarioError
        With all problems of the file, or why the first draw is refused.
    """
    if overrides:
        message = "a data set takes no keys from the command line; allowed: in the file, below [base]"
        raise ScenarioError([Problem(next(iter(overrides)), message)], source)
    distribution = Distribution.load(source)
    studio = Studio(distribution)
    first = studio.sequence(0)
    counts = {"drawn_keys": len(distribution.draw), "frames_per_draw": int(first.scenario.frames.count)}
    drawn, frames = counts.values()
    return f"data set, {drawn} drawn keys, {frames} frames a draw; the first draw was planned", counts


class Studio:
    """Makes the sequences of a distribution; what draws share is kept.

    Parameters
    ----------
    distribution : Distribution
        What is drawn.
    """

    def __init__(self, distribution: Distribution) -> None:
        self.distribution = distribution
        self.shelf = ResultCache(several=True)
        self._states: OrderedDict[str, _State] = OrderedDict()
        self._optics: dict[str, _Optics] = {}

    def sequence(self, draw: int) -> DrawnSequence:
        """Return the sequence of a draw; a draw that is refused as unphysical is drawn again.

        Where targets are refused, they alone are drawn again as long as there is hope: frames with targets would have
        other clouds than those without.

        Raises
        ------
        ScenarioError
            If too many draws in a row are refused; names the last reason.
        """
        refused: list[str] = []
        before: list[Problem] = []
        skies = of_targets = 0
        for attempt in range(MAX_ATTEMPTS):
            try:
                return self._attempt(draw, (skies, attempt), tuple(refused))
            except (ScenarioError, CatalogError) as error:
                problems = error.problems if isinstance(error, ScenarioError) else (Problem("draw", str(error)),)
                self._refuse_constant(problems, before)
                before = list(problems)
                refused.append("; ".join(map(str, problems)))
                hidden = all(each.field.startswith("targets") for each in problems)
                of_targets = of_targets + 1 if hidden else 0
                skies += not hidden or of_targets % TARGETS_OF_A_SKY == 0
        message = f"draw {draw}: {MAX_ATTEMPTS} draws in a row are refused, the last because of: {refused[-1]}"
        raise ScenarioError([Problem("draw", message)], self.distribution.origin)

    def _refuse_constant(self, problems: Sequence[Problem], before: Sequence[Problem]) -> None:
        """Refuse the file at once where its constant parts are wrong, as no other draw would help.

        They are planned without what is drawn. A description of a draw is wrong if its problem is the same with other
        random numbers, and so is a key of targets that is not drawn.

        Raises
        ------
        ScenarioError
            With the problems of the constant parts.
        """
        ours = [each for each in problems if each.field.partition(".")[0] in ("targets", "draw")]
        wrong = [each for each in ours if each in before and self.distribution.is_constant(each)]
        if not ours:
            wrong = [each for each in problems if each in self._constant_problems]
        if wrong:
            raise ScenarioError(wrong, self.distribution.origin)

    @cached_property
    def _constant_problems(self) -> Sequence[Problem]:
        try:
            self.plan(self._scenario({}), {})
        except ScenarioError as error:
            return error.problems
        except CatalogError:
            pass  # of keys that are drawn
        return ()

    def frames_per_draw(self) -> int:
        """Return the number of frames of each draw."""
        return int(self._scenario({}).frames.count)

    def _attempt(self, draw: int, attempt: tuple[int, int], refused: tuple[str, ...]) -> DrawnSequence:
        distribution = self.distribution
        values, number = distribution.values(draw, attempt[0])
        state = self._state(values)
        targets = draw_targets(distribution, draw, attempt[1], state.plan)
        for target in targets:
            side = math.sqrt(target.area_m2 or 0.0) / state.plan.grid.pixel_size_m
            if side > _LARGEST_SIDE:
                raise ScenarioError(
                    [Problem("targets.strength.area", f"a side of {side:.3g} pixels; allowed: up to {_LARGEST_SIDE:g}")]
                )
        about = {"sky": distribution.sky_of(draw), "state": number, "values": values, "refused": refused}
        return DrawnSequence(self, draw, state, targets, about)

    def _scenario(self, values: Mapping[str, Any], seed: int = 0, noise_seed: int = 0) -> Scenario:
        distribution = self.distribution
        changes = {**distribution.overrides, **values, "seed": seed}
        if "sensor" in distribution.scenario or any(key.startswith("sensor") for key in changes):
            changes["sensor.seed"] = noise_seed
        raw, base, origin = distribution.scenario, distribution.base, distribution.origin
        return Scenario.from_dict(raw, changes, base=base, origin=origin, shelf=self.shelf)

    def scenario_of(self, draw: int, values: Mapping[str, Any], targets: Sequence[Target]) -> Scenario:
        """Return a draw with its targets as a scenario."""
        distribution = self.distribution
        seeds = distribution.sky_seed(distribution.sky_of(draw)), distribution.noise_seed(draw)
        return self._again(self._scenario(values, *seeds), _elements(targets))

    def _again(self, scenario: Scenario, changes: Mapping[str, Any], drop: Sequence[str] = ()) -> Scenario:
        raw = {key: value for key, value in json.loads(scenario.to_json()).items() if key not in drop}
        return Scenario.from_dict(raw | dict(changes), base=scenario.base, origin=scenario.origin, shelf=self.shelf)

    def plan(self, scenario: Scenario, changes: Mapping[str, Any], drop: Sequence[str] = ()) -> Plan:
        """Return the plan of a scenario with changes, of which only radiance and the truth of targets are wanted."""
        output = json.loads(scenario.to_json())["output"]
        wanted = _SHOWN if "elements" in changes else _SHOWN[:1]
        output |= {"variables": list(wanted), "certificate": 0, "packing": None, "derived": []}
        plan = make_plan(self._again(scenario, {**changes, "output": output}, drop), shelf=self.shelf)
        if not plan.is_grid:
            raise DatasetError("a data set needs a grid on the ground; allowed: a scenario without a camera in orbit")
        return plan

    def _state(self, values: Mapping[str, Any]) -> _State:
        """Return what draws share whose values differ in nothing but their sky.

        It is made for values of the sky that no draw has: it must not depend on which draw asks first.
        """
        plain, _ = without_sky(values)
        key = json.dumps(plain, sort_keys=True, default=str)
        if key not in self._states:
            scenario = self._scenario(plain)
            plan = self.plan(scenario, {})
            self._states[key] = _State(self, scenario, plan, tables_of(plan), self.optics(plan))
            while len(self._states) > _KEPT_STATES:
                self._states.popitem(last=False)
        self._states.move_to_end(key)
        return self._states[key]

    def optics(self, plan: Plan) -> _Optics:
        """Return the sensor of a plan without noise, the same for all scenes of one geometry."""
        if not plan.sensor.stages:
            return _Optics(None, None)
        stages = plan.sensor.stages
        about = stages[0].as_dict()
        if len(stages) > 1 or about["model"] != "radiometer" or about["distribution"] != "hcss-twin":
            names = ", ".join(f"'{stage.as_dict()['model']}'" for stage in stages)
            raise DatasetError(
                f"sensor {names}: labels need the sensor without noise, which is known of 'radiometer' only; allowed: "
                "one stage of this model, or no sensor"
            )
        given = {name: about["parameters"][name] for name in _OPTICS if about["parameters"][name] is not None}
        if given["psf"] != "airy":
            given.pop("aperture_diameter", None)
            given.pop("pixel_angle", None)
        scenario = plan.scenario
        of_image = [getattr(scenario, name).model_dump(mode="json") for name in ("image", "motion")]
        key = json.dumps([given, of_image, [band.name for band in plan.bands], scenario.frames.interval], default=str)
        if key not in self._optics:
            sensor = {"sensor": {"model": "radiometer", "parameters": given}}
            image = json.loads(scenario.to_json())["image"] | {"rows": STAMP, "columns": STAMP, "window": None}
            scenes = [sensor, sensor | {"image": image}]
            dropped = "elements", "instrument"
            whole, stamp = (self.plan(scenario, each, dropped).sensor for each in scenes)
            if whole.given != plan.sensor.given:
                raise DatasetError("the sensor without noise needs other surroundings of the image than with it")
            self._optics[key] = _Optics(whole, stamp)
        return self._optics[key]


@dataclass(frozen=True)
class _State:
    """What draws of one state share, with any sky and any targets.

    Attributes
    ----------
    scenario : Scenario
        Of the state, with a sky of its own.
    plan : Plan
        Without targets; it also tells where points of the scene appear.
    """

    studio: Studio
    scenario: Scenario
    plan: Plan
    tables: RadianceTables
    optics: _Optics
    _with_targets: dict[str, Plan] = field(default_factory=dict)

    @cached_property
    def paths(self) -> ElementPaths:
        """Air before targets."""
        return ElementPaths(self.plan)

    def drawn(self, draw: int, values: Mapping[str, Any], targets: Sequence[Target]) -> Plan:
        """Return the plan of a draw."""
        distribution, elements = self.studio.distribution, _elements(targets).get("elements", [])
        seeds = distribution.sky_seed(distribution.sky_of(draw)), distribution.noise_seed(draw)
        plan = self.plan
        if elements:
            key = json.dumps([{name: each for name, each in one.items() if name != "parameters"} for one in elements])
            if key not in self._with_targets:
                self._with_targets[key] = self.studio.plan(self.scenario, {"elements": elements})
            plan = self._with_targets[key]
        _, of_layers = without_sky(values)
        sky = [of_layers.get(layer, {}) for layer in range(len(plan.scenario.clouds.layers))]
        return plan.redrawn(seeds[0], sky, [one["parameters"] for one in elements] or None, seeds[1])


@dataclass(frozen=True)
class _Optics:
    """A sensor without noise, for whole images and for those of single targets; None: no sensor."""

    whole: Any
    stamp: Any

    def clean(self, scene: NDArray[np.float32], number: int, time_s: float) -> NDArray[Any]:
        """Return the image (B, y, x) of a scene without targets."""
        if self.whole is None:
            return scene
        provider: Any = self.whole.stages[0].provider
        rows, columns = _inner(self.whole)
        found = provider.arrays(scene.shape)
        provider.measure_into(scene, number, found, lines=(rows.start, rows.stop), time_s=time_s)
        return np.ascontiguousarray(found["radiance"][:, rows, columns])

    def own_image(self, pieces: Sequence[Any], place: tuple[float, float], bands: int) -> OwnImage:
        """Return the image of the pieces of a target that appears at a place."""
        half = STAMP // 2
        corner = math.floor(place[0]) - half, math.floor(place[1]) - half
        places = np.array([(piece.row, piece.column) for piece in pieces]).reshape(-1, 2)
        light = np.array([piece.radiance for piece in pieces], dtype=np.float64).reshape(-1, bands).T
        if self.stamp is None or not pieces:
            radiance = np.zeros((bands, STAMP, STAMP))
            for piece in pieces:
                row, column = piece.pixel[0] - corner[0], piece.pixel[1] - corner[1]
                if 0 <= row < STAMP and 0 <= column < STAMP:
                    radiance[:, row, column] += piece.radiance
            return OwnImage(radiance, corner, places, light)
        rows, columns = self.stamp.given
        rates = np.array([piece.rate for piece in pieces])
        # Light of the size of 1: single precision is relative to it, whatever the units of the scene.
        size = float(np.abs(light).max()) or 1.0
        points = Points(
            places[:, 0] - corner[0] - rows.start,
            places[:, 1] - corner[1] - columns.start,
            rates[:, 0],
            rates[:, 1],
            light / size,
        )
        nothing = np.zeros((bands, rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        drawn = self.stamp.measure(nothing, 0, 0.0, points)["radiance"]
        return OwnImage(drawn.astype(np.float64) * size, corner, places, light)


class DrawnSequence:
    """The frames of one draw, whose targets have the intensities that their SCR needs."""

    def __init__(
        self, studio: Studio, draw: int, state: _State, targets: tuple[Target, ...], about: Mapping[str, Any]
    ) -> None:
        self._studio, self.draw, self.targets, self._about = studio, draw, targets, about
        self._optics, self.tables, self._paths = state.optics, state.tables, state.paths
        self.plan = state.drawn(draw, about["values"], targets)
        self._maker = PartMaker(self.plan, self.tables)
        self._scene: tuple[int, NDArray[np.float32], Any, dict[str, NDArray[Any]]] | None = None
        self._shown: tuple[int, NDArray[np.float32]] | None = None
        self._places: dict[tuple[int, int], tuple[float, float]] = {}
        self._drawn: tuple[int, list[OwnImage]] | None = None
        # Plumes are drawn with the intensities of the plan, and what they add is proportional to it.
        self._factors = [1.0] * len(targets)
        if any(target.scr is not None for target in targets):
            self._set_strengths()

    @property
    def scenario(self) -> Scenario:
        """The draw as a scenario, whose run gives the same frames."""
        return self._studio.scenario_of(self.draw, self._about["values"], self.targets)

    @property
    def split(self) -> str:
        """Name of the split of its sky."""
        return self._studio.distribution.split_of(self._about["sky"])

    @property
    def refused(self) -> tuple[str, ...]:
        """Why earlier draws of this number were refused."""
        found: tuple[str, ...] = self._about["refused"]
        return found

    @cached_property
    def scale(self) -> Scale:
        """From numbers to radiance, the same in all frames of a data set."""
        sensor = self.plan.sensor
        if sensor.stages and self._has_converter:
            parameters, worked_out = (sensor.stages[-1].as_dict()[name] for name in ("parameters", "worked_out"))
            of_bands = [worked_out["bands"][band.name] for band in self.plan.bands]
            if parameters["bits"] > 16:
                raise DatasetError(f"sensor.parameters.bits = {parameters['bits']}; allowed in a data set: up to 16")
            return Scale(
                np.array([each["radiance_per_number"] for each in of_bands]),
                np.array([each["radiance_at_number_0"] for each in of_bands]),
                2 ** parameters["bits"] - 1,
            )
        kelvin = self._studio.distribution.step_K
        step = np.array(
            [float(f"{kelvin * sensor.radiance_per_kelvin(band, 300.0):.6g}") for band in sensor.inputs.bands]
        )
        return Scale(step, -_NUMBER_AT_ZERO * step, LARGEST_NUMBER)

    @cached_property
    def _has_converter(self) -> bool:
        stages = self.plan.sensor.stages
        return bool(stages) and stages[-1].as_dict()["parameters"].get("bits") is not None

    def _set_strengths(self) -> None:
        """Give the targets the intensities that give the wanted SCR in the first frame.

        Raises
        ------
        ScenarioError
            If a target would need more than its largest intensity: clouds hide it.
        """
        clean = self._clean(0)
        noise = self._noise(clean)
        found, factors = [], []
        for target, own in zip(self.targets, self._own_images(0), strict=True):
            if target.scr is None or target.intensity is None:  # a strength is by SCR for all targets of a set
                raise AssertionError("a target without SCR beside others")
            _, total = self._clutter(clean, noise, target, 0)
            peak, wanted = abs(own.peak(0)), target.scr * float(total[0])
            largest = max(target.intensity.values())
            if peak * target.intensity_max / largest < wanted or not peak > 0.0:
                needed = wanted / peak * largest if peak > 0.0 else math.inf
                message = (
                    f"scr = {target.scr:g} of a target at {target.position_m[2]:g} m needs {needed:.3g} W/sr: clouds "
                    f"or air hide it; allowed: up to intensity_max = {target.intensity_max:g}"
                )
                raise ScenarioError([Problem("targets.strength.scr", message)])
            found.append(target.brighter(wanted / peak))
            factors.append(_ratio(found[-1].intensity, target.intensity))
        self.targets, self._factors = tuple(found), factors

    def frames(self) -> Iterator[Frame]:
        """Yield the frames in the order of time."""
        for index in range(self.plan.frame_times_s.size):
            yield self._frame(index)

    def clean_radiance(self, index: int) -> NDArray[np.float32]:
        """Return the radiance (B, y, x) of a frame at the sensor, without targets."""
        scene, _, _ = self._rendered(index)
        return scene[:, *_inner(self.plan.sensor)] if self.plan.sensor.stages else scene

    @property
    def _window(self) -> tuple[slice, slice]:
        sensor = self.plan.sensor
        return sensor.given if sensor.stages else self.plan.extent

    def _rendered(self, index: int) -> tuple[NDArray[np.float32], Any, dict[str, NDArray[Any]]]:
        """Return the radiance of a frame and its surroundings without targets, the pieces of these, and their truth."""
        if self._scene is None or self._scene[0] != index:
            window = self._window
            arrays, _ = self._maker.part(index, window)
            scene, drawn = arrays["radiance"].copy(), self._maker.drawn
            for (row, column), pieces in drawn.items():
                scene[:, row - window[0].start, column - window[1].start] = pieces[0].behind
            self._scene = index, scene, drawn, {name: arrays[name] for name in _SHOWN[1:] if name in arrays}
        return self._scene[1:]

    def _pieces(self, index: int) -> list[list[Any]]:
        """Return the pieces of each target in a frame, with the intensities of the plan, and last those of parts
        without a label.
        """
        _, drawn, _ = self._rendered(index)
        shown = [(target, n) for n, target in enumerate(self.targets)]
        others = len(shown)
        shown += [(part, n if part.labelled else others) for target, n in shown for part in target.parts]
        places = np.array([self._place(index, each) for each, _ in shown]).reshape(-1, 2)
        found: list[list[Any]] = [[] for _ in range(others + 1)]
        for piece in (piece for pieces in drawn.values() for piece in pieces):
            away = np.max(np.abs(places - (piece.row, piece.column)), axis=1)
            nearest = int(np.argmin(away))
            found[shown[nearest][1]].append(piece)
        return found

    def _own_images(self, index: int) -> list[OwnImage]:
        """Return the image of each target in a frame, with the intensities of the targets."""
        if self._drawn is None or self._drawn[0] != index:
            every, bands = zip(self.targets, self._pieces(index)[:-1], strict=True), len(self.plan.bands)
            images = [self._optics.own_image(pieces, self._place(index, target), bands) for target, pieces in every]
            self._drawn = index, images
        return [image.times(factor) for image, factor in zip(self._drawn[1], self._factors, strict=True)]

    def _place(self, index: int, target: Target) -> tuple[float, float]:
        if (index, target.track) not in self._places:
            time_s = float(self.plan.frame_times_s[index])
            self._places[index, target.track] = seen_at(self.plan, target.at(time_s), time_s)
        return self._places[index, target.track]

    def _measured(self, index: int, points: Points | None) -> tuple[Image, NDArray[np.bool_]]:
        """Return the numbers (B, y, x) of a frame as measured, and which pixels are saturated."""
        plan, clean = self.plan, self._clean(index)
        if not plan.sensor.stages:
            numbers = self.scale.numbers(clean if points is None else _with_points(clean, points))
            return numbers, numbers == self.scale.largest
        provider: Any = plan.sensor.stages[0].provider
        rows, columns = _inner(plan.sensor)
        at = plan.scenario.frames.first + index, float(plan.frame_times_s[index])
        measured = provider.measure_blurred(clean, points, *at, (rows.start, columns.start))
        if not self._has_converter:
            numbers = self.scale.numbers(measured.radiance)
            return numbers, numbers == self.scale.largest
        saturated, numbers = measured.saturated, measured.digital_number
        saturated = np.zeros(1) if saturated is None else saturated
        return numbers.astype(np.uint16), (saturated != 0) | (numbers >= self.scale.largest)

    def _clean(self, index: int) -> NDArray[np.float32]:
        """Return the clean image (B, y, x) of a frame."""
        if self._shown is None or self._shown[0] != index:
            scene, _, _ = self._rendered(index)
            number, time_s = self.plan.scenario.frames.first + index, float(self.plan.frame_times_s[index])
            self._shown = index, self._optics.clean(scene, number, time_s)
        return self._shown[1]

    def _noise(self, clean: NDArray[Any]) -> Array:
        """Return the rms noise (B,) of the sensor in a frame."""
        stages, names = self.plan.sensor.stages, [band.name for band in self.plan.bands]
        if not stages:
            return np.zeros(len(names))
        return noise_rms(stages[-1].as_dict(), names, clean, self.scale.step)

    def _clutter(self, clean: NDArray[Any], noise: Array, target: Target, index: int) -> tuple[Array, Array]:
        """Return the standard deviation (B,) of the clean image around a target, and with noise."""
        row, column = self._place(index, target)
        near = [
            slice(
                max(math.floor(at) - size // 2 - first.start, 0), max(math.floor(at) + size // 2 + 1 - first.start, 0)
            )
            for at, size, first in zip((row, column), (self._labels.window,) * 2, self.plan.extent, strict=True)
        ]
        around = clean[:, *near].astype(np.float64)
        clutter = around.std(axis=(1, 2)) if around.size else np.full(len(clean), np.nan)
        return clutter, np.hypot(clutter, noise)

    @property
    def _labels(self) -> Any:
        return self._studio.distribution.labels

    def _frame(self, index: int) -> Frame:
        plan = self.plan
        _, _, truth = self._rendered(index)
        clean, pieces = self._clean(index), self._pieces(index)
        points = _points(pieces, (*self._factors, 1.0), plan.extent)
        image, saturated = self._measured(index, points)
        own = self._own_images(index)
        noise = self._noise(clean)
        described = [
            self._label(index, target, rate, of_target, clean, noise, truth, saturated)
            for target, rate, of_target in zip(self.targets, map(_rate, pieces[:-1]), own, strict=True)
            if self._is_inside(self._place(index, target))
        ]
        distribution, about, scale = self._studio.distribution, self._about, self.scale
        time_s = float(plan.frame_times_s[index])
        labels = {
            "draw": self.draw,
            "frame": index,
            "time_s": time_s,
            "interval_s": float(plan.scenario.frames.interval),
            "start": plan.scenario.time.isoformat(),
            "split": self.split,
            "sky": about["sky"],
            "sky_seed": distribution.sky_seed(about["sky"]),
            "noise_seed": distribution.noise_seed(self.draw),
            "state": about["state"],
            "drawn": json.loads(json.dumps(about["values"], default=str)),
            "refused": list(about["refused"]) if index == 0 else [],
            "bands": [band.name for band in plan.bands],
            "rows": int(image.shape[1]),
            "columns": int(image.shape[2]),
            "radiance_per_number": scale.step.tolist(),
            "radiance_at_number_0": scale.offset.tolist(),
            "largest_number": scale.largest,
            "noise": _plain(noise),
            "saturated_pixels": [int(band.sum()) for band in saturated],
            "table_error": float(f"{self.tables.errors.total:.3g}"),
            "accuracy": float(f"{plan.accuracy.relative:.3g}"),
            "targets": described,
        }
        return Frame(image, scale.numbers(clean), labels)

    def _is_inside(self, place: tuple[float, float]) -> bool:
        return all(pixels.start <= at < pixels.stop for at, pixels in zip(place, self.plan.extent, strict=True))

    def _label(
        self,
        index: int,
        target: Target,
        rate: tuple[float, float],
        own: OwnImage,
        clean: NDArray[Any],
        noise: Array,
        truth: Mapping[str, NDArray[Any]],
        saturated: NDArray[np.bool_],
    ) -> dict[str, Any]:
        """Return what is known of a target in a frame; rows and columns count from the first pixel of the image."""
        plan, place = self.plan, self._place(index, target)
        first = tuple(pixels.start for pixels in plan.extent)
        peaks = np.array([own.peak(band) for band in range(len(plan.bands))])
        clutter, total = self._clutter(clean, noise, target, index)
        mask, box = _mask(own, self._labels.mask_share, first, clean.shape[1:])
        transmittance, visible = self._visibility(target, index, truth)
        weights = np.abs(own.light[0]) if own.light.size else np.zeros(0)
        centroid = weights @ own.places / weights.sum() if weights.sum() > 0.0 else np.array(place)
        pixel = tuple(
            min(math.floor(at) - edge, size - 1) for at, edge, size in zip(place, first, clean.shape[1:], strict=True)
        )
        time_s = float(plan.frame_times_s[index])
        row_rate, column_rate = rate
        light = own.light.sum(axis=1) if own.light.size else np.zeros(len(plan.bands))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = {"snr": np.abs(peaks) / noise, "scr": np.abs(peaks) / total}
        strength: dict[str, Any] = {"intensity_W_sr": None, "temperature_K": None, "area_m2": None, "emissivity": None}
        if target.intensity is not None:
            strength["intensity_W_sr"] = [target.intensity[band.name] for band in plan.bands]
        else:
            strength |= {"temperature_K": target.temperature_K, "area_m2": target.area_m2}
            strength["emissivity"] = target.emissivity
        return {
            "track": target.track,
            "kind": target.kind,
            "family": target.family,
            "centroid": [float(at - edge) for at, edge in zip(centroid, first, strict=True)],
            "place": [at - edge for at, edge in zip(place, first, strict=True)],
            "box": box,
            "mask": mask,
            "altitude_m": target.at(time_s)[2],
            "position_m": list(target.at(time_s)[:2]),
            "velocity_m_s": list(target.velocity_at(time_s)),
            "pixels_per_s": [float(row_rate), float(column_rate)],
            **strength,
            "transmittance": _plain(transmittance),
            "visible": _plain(visible),
            "flux": _plain(light),
            "peak": _plain(peaks),
            "clutter": _plain(clutter),
            **{name: _plain(values) for name, values in ratios.items()},
            "saturated": [bool(band[pixel]) for band in saturated],
        }

    def _visibility(self, target: Target, index: int, truth: Mapping[str, NDArray[Any]]) -> tuple[Array, Array]:
        """Return the transmittance (B,) of air and clouds before a target, and the share (B,) that clouds and higher
        targets leave of it.
        """
        plan, bands = self.plan, len(self.plan.bands)
        time_s = float(plan.frame_times_s[index])
        place = self._place(index, target)
        (view,) = plan.views_of_pixels([math.floor(place[0])], [math.floor(place[1])], time_s)
        air = self._paths.air(target.at(time_s)[2], view.zenith_deg)
        clear = self._paths.band_mean(air, target.temperature_K)
        reaches = math.ceil(0.5 * math.sqrt(target.area_m2 or 0.0) / plan.grid.pixel_size_m) + 2
        near = tuple(
            slice(max(math.floor(at) - reaches - pixels.start, 0), max(math.floor(at) + reaches + 1 - pixels.start, 0))
            for at, pixels in zip(place, self._window, strict=True)
        )
        source, share, reach = (
            truth[f"element_{name}"][..., near[0], near[1]] for name in ("source", "share", "transmittance")
        )
        mine = source == target.track
        if not mine.any():
            return np.zeros(bands), np.zeros(bands)
        weights = share[mine].astype(np.float64)
        seen = reach[:, mine].astype(np.float64) @ weights
        whole = weights.sum()
        if target.area_m2 is not None:
            area = plan.rays.pixel_area_m2(*place, time_s)
            inside = self._share_inside(place, target, area)
            whole = max(target.area_m2 / area * inside, whole)
        transmittance = seen / weights.sum()
        with np.errstate(divide="ignore", invalid="ignore"):
            visible = np.where(clear > 0.0, seen / (whole * clear), 0.0)
        return transmittance, np.minimum(visible, 1.0)

    def _share_inside(self, place: tuple[float, float], target: Target, area_m2: float) -> float:
        """Return the share of a body's square that the computed window holds."""
        half = 0.5 * math.sqrt(max((target.area_m2 or 0.0) / area_m2, 1e-12))
        share = 1.0
        for at, pixels in zip(place, self._window, strict=True):
            share *= max(min(at + half, pixels.stop) - max(at - half, pixels.start), 0.0) / (2.0 * half)
        return share


def _inner(sensor: Any) -> tuple[slice, slice]:
    """Return the rows and columns of a measured area that are in the cube."""
    rows, columns = (
        slice(part.start - whole.start, part.stop - whole.start)
        for part, whole in zip(sensor.cube, sensor.given, strict=True)
    )
    return rows, columns


def _elements(targets: Sequence[Target]) -> dict[str, Any]:
    """Return the section of a scenario for targets; none without."""
    tracks = all_tracks(targets)
    return {"elements": [{"parameters": {"tracks": tracks}}]} if tracks else {}


def _rate(pieces: Sequence[Any]) -> tuple[float, float]:
    """Return the rows and columns per second of a target."""
    return pieces[0].rate if pieces else (0.0, 0.0)


def _ratio(after: Mapping[str, float] | None, before: Mapping[str, float]) -> float:
    assert after is not None
    band = max(before, key=lambda name: before[name])
    return after[band] / before[band]


def _points(
    of_targets: Sequence[Sequence[Any]], factors: Sequence[float], window: tuple[slice, slice]
) -> Points | None:
    """Return the pieces of targets, whose light has a factor each, as points of a window."""
    pieces = [(piece, factor) for found, factor in zip(of_targets, factors, strict=True) for piece in found]
    if not pieces:
        return None
    return Points(
        np.array([piece.row - window[0].start for piece, _ in pieces]),
        np.array([piece.column - window[1].start for piece, _ in pieces]),
        np.array([piece.rate[0] for piece, _ in pieces]),
        np.array([piece.rate[1] for piece, _ in pieces]),
        np.stack([piece.radiance * factor for piece, factor in pieces], axis=1),
    )


def _with_points(scene: NDArray[np.float32], points: Points) -> NDArray[np.float32]:
    """Return a scene (B, y, x) with each point in the pixel that holds it."""
    shown = scene.astype(np.float64)
    for n, (row, column) in enumerate(zip(points.row, points.column, strict=True)):
        shown[:, math.floor(row), math.floor(column)] += points.radiance[:, n]
    return np.maximum(shown, 0.0).astype(np.float32)


def _mask(
    own: OwnImage, share: float, first: Sequence[int], size: Sequence[int]
) -> tuple[dict[str, Any] | None, list[int] | None]:
    """Return the mask of a target as run lengths of COCO, and its box [x, y, width, height]; None if it is hidden.

    Pixels have at least a share of the highest one in the first band.
    """
    bright = np.abs(own.radiance[0])
    if not bright.max() > 0.0:
        return None, None
    stamp_rows, stamp_columns = np.nonzero(bright >= share * bright.max())
    rows, columns = stamp_rows + own.corner[0] - first[0], stamp_columns + own.corner[1] - first[1]
    inside = (rows >= 0) & (rows < size[0]) & (columns >= 0) & (columns < size[1])
    rows, columns = rows[inside], columns[inside]
    if not rows.size:
        return None, None
    box = [int(columns.min()), int(rows.min()), int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1]
    return {"size": [int(size[0]), int(size[1])], "counts": run_lengths(rows, columns, size)}, box


def run_lengths(rows: NDArray[Any], columns: NDArray[Any], size: Sequence[int]) -> list[int]:
    """Return run lengths of a mask, down the columns, from 0 pixels on: uncompressed RLE of COCO."""
    places = np.sort(columns.astype(np.int64) * size[0] + rows)
    gaps = np.flatnonzero(np.diff(places) > 1)
    starts = places[np.concatenate(([0], gaps + 1))]
    stops = places[np.concatenate((gaps, [places.size - 1]))] + 1
    edges = np.stack((starts, stops), axis=1).ravel()
    counts = np.diff(np.concatenate(([0], edges, [size[0] * size[1]])))
    return [int(each) for each in (counts if counts[-1] else counts[:-1])]


def _plain(values: Array) -> list[float | None]:
    """Return numbers for JSON with 7 digits, which a single-precision radiance has."""
    return [float(f"{each:.7g}") if math.isfinite(each) else None for each in np.asarray(values).tolist()]
