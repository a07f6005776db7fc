"""Frames, pixels and files of a scenario that changes from request to request."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_explore.controls import changes_of, controls, has_camera
from hcss_explore.keys import Raw, as_toml, with_absolute_paths, with_changes
from hcss_twin import HcssError, Scenario, make_plan
from hcss_twin.core.files import Writing
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.scene_around import SceneAround
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Catalog, ScenarioError, cloudy_columns

LARGEST_AT_START = 320 * 320
"""Pixels of an image that is shown whole at first."""

SIDE_AT_START = 256
"""Rows and columns of a larger one."""

MOST_VALUES = 32_000_000
"""Pixels times bands of a frame that the page can hold."""

KEPT = 6
"""Scenes whose plans and tables stay in memory: a control that is set back costs nothing."""

AT_ONCE = 40
"""Wavenumbers of a spectrum that are computed before a newer request may take its turn."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,80}")


class ExploreError(HcssError):
    """A request cannot be answered."""


@dataclass(eq=False)
class Scene:
    """A planned scenario with its tables, ready for frames.

    Attributes
    ----------
    raw : dict
        Keys of the scenario, as they are saved.
    kelvin : BrightnessTemperature
        In the bands.
    seconds : dict of str to float
        Processor time of plan and tables.
    """

    raw: Raw
    plan: Plan
    tables: RadianceTables | None
    kelvin: BrightnessTemperature
    seconds: dict[str, float] = field(default_factory=dict)

    @cached_property
    def maker(self) -> PartMaker:
        """Maker of clean frames."""
        return PartMaker(self.plan, self.tables)

    @cached_property
    def around(self) -> SceneAround:
        """What the sensor sees."""
        return SceneAround(self.plan, self.tables, self.plan.sensor)

    @property
    def has_sensor(self) -> bool:
        """Whether a run would write a measured cube."""
        return bool(self.plan.sensor.stages)


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame for the page.

    Attributes
    ----------
    about : dict
        What the page shows beside it.
    radiance, kelvin : ndarray of float32 (B, y, x)
        W m-2 sr-1, and K, NaN where no black body has the radiance.
    thickness : ndarray of float32 (y, x)
        Of the clouds, m, summed over layers.
    """

    about: dict[str, Any]
    radiance: NDArray[np.float32]
    kelvin: NDArray[np.float32]
    thickness: NDArray[np.float32]


class Explorer:
    """Answers what the page asks about one scenario and changes of it; nothing of a request stays.

    Parameters
    ----------
    source : str
        Name of a shipped scenario, or a file.
    assignments : mapping
        Changes of its keys.

    Raises
    ------
    ScenarioError
        If it is invalid.
    """

    def __init__(self, source: str, assignments: Mapping[str, Any] | None = None) -> None:
        raw, self.base = Scenario.read_file(source)
        self.source, self.notes = source, list[str]()
        self.raw = with_changes(raw, assignments or {})
        scenario = self._scenario(self.raw)
        image = scenario.image
        # of a camera's scene, [image] is the plane below it and not what the page shows
        if image.rows * image.columns > LARGEST_AT_START and image.window is None and not has_camera(scenario):
            side = {"image.rows": min(image.rows, SIDE_AT_START), "image.columns": min(image.columns, SIDE_AT_START)}
            with suppress(HcssError):  # an instrument may decide on the size
                smaller = with_changes(self.raw, side)
                scenario, self.raw = self._scenario(smaller), smaller
                self.notes.append(
                    f"The scenario has {image.rows} x {image.columns} pixels; here the image begins with "
                    f"{scenario.image.rows} x {scenario.image.columns}, to answer quickly (Image and frames)."
                )
        self.catalog = Catalog(base=self.base)
        self.controls = controls(self.raw, scenario, self.catalog)
        self.title = scenario.title or source
        self._kept = OrderedDict[str, Scene]()
        self._last_kelvin: tuple[object, BrightnessTemperature] | None = None

    def scene(self, given: Mapping[str, Any], stage: Callable[[str], None]) -> Scene:
        """Return the scene of the page's controls, from memory or made now.

        Parameters
        ----------
        stage : callable
            Called with the name of each step before it begins; what it raises ends the work.

        Raises
        ------
        HcssError
            If a control holds what is not allowed.
        """
        raw = with_changes(self.raw, changes_of(given))
        name = json.dumps(raw, default=str, sort_keys=True)
        if name in self._kept:
            self._kept.move_to_end(name)
            return self._kept[name]
        stage("plan")
        begun = time.process_time()
        plan = make_plan(_for_page(self._scenario(raw)))
        size = plan.pixels[0] * plan.pixels[1] * len(plan.bands)
        if size > MOST_VALUES:
            raise ExploreError(
                f"image.rows, image.columns, bands: {size} values in a frame; allowed on this page: {MOST_VALUES}"
            )
        planned = time.process_time()
        stage("tables")
        tables = tables_of(plan) if plan.needs_radiance else None
        made = Scene(
            raw, plan, tables, self._kelvin_of(plan), {"plan": planned - begun, "tables": time.process_time() - planned}
        )
        self._kept[name] = made
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return made

    def picture(
        self, given: Mapping[str, Any], number: int, measured: bool, stage: Callable[[str], None] = lambda _name: None
    ) -> Picture:
        """Return a frame: of the cube, or with ``measured`` of the sensor's cube; raises HcssError."""
        before = set(map(id, self._kept.values()))
        scene = self.scene(given, stage)
        plan, kept = scene.plan, id(scene) in before
        number = min(max(number, 0), plan.frame_times_s.size - 1)
        stage("frame")
        begun = time.process_time()
        radiance, thickness = self._frame(scene, number)
        if measured and scene.has_sensor:
            wide, points = scene.around.frame(number, radiance)
            time_s = float(plan.frame_times_s[number])
            first = plan.scenario.frames.first
            radiance = scene.around.sensor.measure(wide, first + number, time_s, points)["radiance"]
        flat = scene.kelvin.where_known(radiance.reshape(len(radiance), -1).astype(np.float64))
        seconds = {name: 0.0 if kept else taken for name, taken in scene.seconds.items()}
        about = {
            **self._about(scene, number),
            "measured": measured and scene.has_sensor,
            "kept": kept,
            "seconds": {**seconds, "frame": time.process_time() - begun},
        }
        return Picture(about, radiance, flat.reshape(radiance.shape).astype(np.float32), thickness)

    def pixel(
        self,
        given: Mapping[str, Any],
        number: int,
        row: int,
        column: int,
        band: int,
        check: Callable[[], None] = lambda: None,
    ) -> dict[str, Any]:
        """Return the spectrum of a pixel's column in a band by parts; raises HcssError.

        The column is that of the mean thickness of each layer in the pixel, toward its own view, over the scenario's
        sea: without shadows, waves, texture, elements and tables, so that its radiance may differ from the image's.

        Parameters
        ----------
        check : callable
            Called between parts of the band; what it raises ends the work.
        """
        scene = self.scene(given, lambda _name: check())
        plan = scene.plan
        rows, columns = plan.pixels
        if not (0 <= row < rows and 0 <= column < columns and 0 <= number < plan.frame_times_s.size):
            raise ExploreError(f"pixel {row}, {column} of frame {number}; allowed: those of the image")
        if not 0 <= band < len(plan.bands):
            raise ExploreError(f"band {band}; allowed: 0 to {len(plan.bands) - 1}")
        variables, _ = scene.maker.part(number, _one(plan, row, column))
        thickness = _layers_of(variables)[: len(plan.layers), 0, 0].astype(np.float64)
        time_s = float(plan.frame_times_s[number])
        view = plan.rays.views_of_pixels([plan.extent[0].start + row], [plan.extent[1].start + column], time_s)[0]
        setting, model = plan.assembly.setting(plan.sun_up_at(time_s), view), plan.assembly.model
        weights = plan.spectral_grid.weights_cm1[band]
        inside = np.flatnonzero(weights)
        wavenumber, found = plan.spectral_grid.wavenumber_cm1[inside], []
        for some in np.array_split(wavenumber, -(-wavenumber.size // AT_ONCE)):
            check()
            found.append(cloudy_columns(model, setting, some, thickness[None]))
        terms = {name: np.concatenate([part[name][0] for part in found]) for name in model.terms}
        parts = {name: term @ weights[inside] for name, term in terms.items()}
        radiance = np.zeros((len(plan.bands), 1))
        radiance[band] = sum(parts.values())
        per_um = wavenumber**2 / 1e4  # W m-2 sr-1 (cm-1)-1 to W m-2 sr-1 um-1
        return {
            "row": row,
            "column": column,
            "band": plan.bands[band].name,
            "thickness_m": [float(value) for value in thickness],
            "wavelength_um": np.round(1e4 / wavenumber, 5),
            "parts": {name: term * per_um for name, term in terms.items() if np.any(term)},
            "band_parts": {name: float(part) for name, part in parts.items()},
            "meaning": dict(model.terms),
            "column_radiance": float(radiance[band, 0]),
            "column_kelvin": float(scene.kelvin.where_known(radiance)[band, 0]),
            "radiance": float(variables["radiance"][band, 0, 0]),
        }

    def toml(self, given: Mapping[str, Any]) -> str:
        """Return the scenario of the controls as a file; raises HcssError if it is invalid."""
        raw = with_changes(self.raw, changes_of(given))
        self._scenario(raw)
        return as_toml(raw)

    def save(self, given: Mapping[str, Any], name: str, replace: bool = False) -> Path:
        """Write the scenario beside the one that is explored, where its relative paths hold; return its path.

        Raises
        ------
        HcssError
            If it is invalid, or the name is not allowed or taken.
        """
        name = name.strip().removesuffix(".toml")
        if not _NAME.fullmatch(name):
            raise ExploreError(f"name: '{name[:80]}' given; allowed: letters, digits, blank, '.', '_' and '-'")
        text, path = self.toml(given), self.base / f"{name}.toml"
        with suppress(OSError):
            if path.exists() and path.samefile(self.source):
                raise ExploreError(f"name: {path.name} is the file that is explored; allowed: another name")
        if path.exists() and not replace:
            raise ExploreError(f"name: {path.name} exists; allowed: another name, or 'replace'")
        with Writing(path, ExploreError, "TOML") as draft:
            draft.write_text(text, encoding="utf-8")
        return path

    def run(self, given: Mapping[str, Any], wanted: Callable[[], bool]) -> dict[str, Any]:
        """Return what ``hcss run`` says of the scenario: it runs in a folder that is deleted.

        Parameters
        ----------
        wanted : callable
            Whether anybody still waits for it; if not, the run ends.
        """
        raw = with_changes(self.raw, changes_of(given))
        self._scenario(raw)
        with tempfile.TemporaryDirectory(prefix="hcss-explore-") as folder:
            Path(folder, "scene.toml").write_text(as_toml(with_absolute_paths(raw, self.base)), encoding="utf-8")
            command = [sys.executable, "-m", "hcss_twin", "run", "scene.toml", "-o", "scene.nc"]
            with subprocess.Popen(
                command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                encoding="utf-8", errors="replace",
            ) as process:  # fmt: skip
                while True:
                    try:
                        text, _ = process.communicate(timeout=0.2)
                        break
                    except subprocess.TimeoutExpired:
                        if not wanted():
                            process.terminate()
                            process.communicate()
                            return {"text": "", "code": None}
            return {"text": text, "code": process.returncode}

    def _kelvin_of(self, plan: Plan) -> BrightnessTemperature:
        """Return the brightness temperature in the bands of a plan: that of the last one, if they are the same."""
        grid, names = plan.spectral_grid, [band.name for band in plan.bands]
        key = grid.wavenumber_cm1.tobytes(), grid.weights_cm1.tobytes(), *names
        if self._last_kelvin is None or self._last_kelvin[0] != key:
            self._last_kelvin = key, BrightnessTemperature(grid, names)
        return self._last_kelvin[1]

    def _scenario(self, raw: Raw) -> Scenario:
        return Scenario.from_dict(raw, base=self.base, origin=self.source)

    def _frame(self, scene: Scene, number: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        if not scene.plan.needs_radiance:
            raise ExploreError("the scenario has no radiance to show")
        variables, _ = scene.maker.part(number, scene.plan.extent)
        return variables["radiance"], _layers_of(variables).sum(axis=0)

    def _about(self, scene: Scene, number: int) -> dict[str, Any]:
        plan = scene.plan
        time_s = float(plan.frame_times_s[number])
        rows, columns = plan.pixels
        return {
            "rows": rows,
            "columns": columns,
            "pixel_m": float(plan.image.pixel_size_m),
            "north_up": plan.is_grid,
            "bands": [{"name": band.name, "lower_um": band.lower_um, "upper_um": band.upper_um} for band in plan.bands],
            "number": number,
            "count": int(plan.frame_times_s.size),
            "time_s": time_s,
            "sun_zenith_deg": float(plan.sun_zenith_deg[number]),
            "sun_azimuth_deg": float(plan.sun_azimuth_deg[number]),
            "view_zenith_deg": float(plan.view.zenith_deg),
            "view_azimuth_deg": float(plan.view.azimuth_deg),
            "has_sensor": scene.has_sensor,
            "omissions": [
                {
                    "what": omission.what,
                    "why": omission.why,
                    "size": omission.size,
                    "sense": omission.sense,
                    "needs": omission.needs,
                    "decision": omission.decision,
                }
                for omission in sorted(plan.omissions, key=lambda omission: -(omission.size or 0.0))
            ],
            "share": float(plan.accuracy.relative),
            "filled_in": [item.as_dict() for item in plan.filled_in],
            "notes": [*self.notes, *plan.notes],
            "toml": as_toml(scene.raw),
        }


def problems_of(error: HcssError) -> list[dict[str, str]]:
    """Return the problems that an error lists, each with the field that it belongs to; empty: to none."""
    if isinstance(error, ScenarioError):
        return [{"field": problem.field, "message": problem.message} for problem in error.problems]
    return [{"field": "", "message": str(error)}]


def _one(plan: Plan, row: int, column: int) -> tuple[slice, slice]:
    first = plan.extent[0].start + row, plan.extent[1].start + column
    return slice(first[0], first[0] + 1), slice(first[1], first[1] + 1)


def _for_page(scenario: Scenario) -> Scenario:
    """Return the scenario with the variables that a frame of the page needs, whatever it writes."""
    thickness = "cloud_layer_thickness" if scenario.clouds.layers else "cloud_thickness"
    output = scenario.output.model_copy(update={"variables": ("radiance", thickness)})
    return scenario.model_copy(update={"output": output})


def _layers_of(variables: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
    """Return the thickness of each layer (L, y, x), or of a clear sky (1, y, x)."""
    found: NDArray[np.float32] | None = variables.get("cloud_layer_thickness")
    return variables["cloud_thickness"][None] if found is None else found
