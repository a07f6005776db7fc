"""The run of a case: time steps, pictures, statistics, checkpoints, and the file that is left."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hcss_skies.les import clouds, statistics
from hcss_skies.les.case import Case
from hcss_skies.les.checkpoint import Checkpoint
from hcss_skies.les.model import Model
from hcss_twin.core.files import Writing
from hcss_twin.providers import HcssError, NetcdfFile

FORMAT = "hcss_skies_simulation"
"""Global attribute of output files; its value is the version of their format."""

SAVE_EVERY_S = 120.0
"""Seconds of the clock between checkpoints."""

WATER_LIMIT = {"single": 1e-7, "double": 1e-10}
"""Water that a step may make or lose by rounding, as a part of all water."""

ICE_K = 258.0
"""Temperature of cloud tops below which clouds often have ice."""

PICTURES = {
    "liquid_water_path": ("g m-2", "cloud water of the column"),
    "optical_thickness": ("1", "optical thickness of cloud droplets, visible"),
    "cloud_top": ("m", "top of the highest cloudy cell; missing without cloud"),
    "cloud_base": ("m", "base of the lowest cloudy cell; missing without cloud"),
}
"""Fields of pictures with units and description."""

Progress = Callable[[Iterable[float], int], Iterator[float]]
"""Shows the progress of an iteration over a number of times."""


@dataclass(frozen=True)
class Times:
    """When a run looks at its state: whole numbers of seconds from the start."""

    pictures: list[float]
    statistics: list[float]
    volumes: list[float]

    @classmethod
    def of_case(cls, case: Case) -> Times:
        """Return the times of a case; the last statistics are those of the end."""
        out = case.output
        end = 3600.0 * out.hours
        first = 3600.0 * out.spin_up_hours
        pictures = [float(t) for t in np.arange(first, end + 1e-6, out.picture_s)]
        means = [float(t) for t in np.arange(0.0, end + 1e-6, out.statistics_s)]
        volumes = [] if out.volume_s is None else [float(t) for t in np.arange(first, end + 1e-6, out.volume_s)]
        return cls(pictures, means if means[-1] == end else [*means, end], volumes)

    @property
    def all(self) -> list[float]:
        """All times, ascending."""
        return sorted({*self.pictures, *self.statistics, *self.volumes})


def simulate_case(case: Case, output: Path, progress: Progress, restart: bool = False) -> Model:
    """Run a case, or go on with it, and write its file; return the last state.

    Parameters
    ----------
    case : Case
        What to simulate.
    output : Path
        NetCDF file.
    progress : callable
        Shows the progress over the times of the case that are left.
    restart : bool
        Forget what an earlier run left.

    Raises
    ------
    HcssError
        If the state is not finite, or water is made or lost; the last checkpoint stays.
    """
    Writing(output, HcssError, "NetCDF").check()
    model, times, checkpoint = Model(case), Times.of_case(case), Checkpoint(output, case)
    if checkpoint.exists() and not restart:
        checkpoint.load(model)
    else:
        checkpoint.start()
        _look(model, times, checkpoint)
    left = [t for t in times.all if t > model.time_s]
    saved = time.monotonic()
    try:
        for until in progress(left, len(left)):
            model.run_until(until)
            _require_budget(model)
            _look(model, times, checkpoint)
            if time.monotonic() - saved > SAVE_EVERY_S:
                checkpoint.save(model)
                saved = time.monotonic()
    except BaseException:
        # within a step the state is neither the old nor the new one: what is left is the last checkpoint, if there is
        # one
        if not checkpoint.exists():
            checkpoint.remove()
        raise
    checkpoint.save(model)
    _write(output, model, times, checkpoint)
    checkpoint.remove()
    return model


def remarks(model: Model) -> list[str]:
    """Return what of the last state leaves the ranges in which the model is a model of clouds, in words."""
    found = []
    last = statistics.series(model)
    case, reference, mesh = model.case, model.reference, model.mesh
    top = last["highest_top"]
    if top == 0.0:
        found.append("there is no cloud at the end")
    sponge = mesh.floor_m + case.grid.sponge_bottom_m
    if top > sponge:
        found.append(f"clouds reach {top:.0f} m, into the sponge above {sponge:g} m; the box is too low")
    cloudy = np.flatnonzero((model.liquid > clouds.CLOUDY_G_KG).any(axis=(0, 1)))
    if len(cloudy):
        k = cloudy[-1]
        theta = reference.theta_0_K + float(model.theta_l[:, :, k].min())
        kelvin = theta * float(reference.exner[k])
        if kelvin < ICE_K:
            found.append(f"cloud tops of {kelvin:.0f} K would have ice, which the model has not")
    if last["mean_liquid_water_path"] > 300.0 and case.rain is None:
        found.append(f"a mean of {last['mean_liquid_water_path']:.0f} g m-2 of water would rain; the case has no rain")
    side = min(n * mesh.side_m for n in mesh.columns)
    if side < 1.5 * (top - mesh.floor_m):
        depth = top - mesh.floor_m
        found.append(
            f"the box is {side:.0f} m wide, clouds reach {depth:.0f} m above its floor: its sides confine them"
        )
    return found


def _require_budget(model: Model) -> None:
    error = model.budget.water_error
    limit = WATER_LIMIT[model.case.precision]
    if not abs(error) <= limit:
        raise HcssError(
            f"{model.case.title}: a step of {model.step_s:.3g} s at {model.time_s:.0f} s changed the water of the box "
            f"by {error:.2g} of it without a source; allowed: {limit:g}"
        )


def _look(model: Model, times: Times, checkpoint: Checkpoint) -> None:
    if model.time_s in times.pictures:
        checkpoint.keep("picture", times.pictures.index(model.time_s), clouds.picture(model))
    if model.time_s in times.volumes:
        volume = clouds.extinction(model).transpose(2, 1, 0).astype(np.float32)
        checkpoint.keep("volume", times.volumes.index(model.time_s), {"extinction": volume})
    if model.time_s in times.statistics:
        means = {**statistics.profiles(model), **statistics.series(model)}
        checkpoint.keep("statistics", times.statistics.index(model.time_s), means)


def _write(output: Path, model: Model, times: Times, checkpoint: Checkpoint) -> None:
    """Write the output from the parts of the run."""
    case, mesh = model.case, model.mesh
    side = mesh.side_m
    with Writing(output, HcssError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
        file.setncatts(
            {
                "title": case.title, "source": f"Large-eddy simulation by hcss-skies. {case.source}", FORMAT: 1,
                "Conventions": "CF-1.8", "case": case.model_dump_json(), "precision": case.precision,
                "frame_m_s": np.array(case.air.frame_m_s),
            }
        )  # fmt: skip
        axes = {
            "time": (np.array(times.pictures), "s", "time of pictures since the start"),
            "statistics_time": (np.array(times.statistics), "s", "time of statistics since the start"),
            **(
                {"volume_time": (np.array(times.volumes), "s", "time of volumes since the start")}
                if times.volumes
                else {}
            ),
            "z": (mesh.floor_m + mesh.centres_m, "m", "altitude of cell centres"),
            "y": (side * (np.arange(mesh.columns[1]) + 0.5), "m", "distance along y in the moving frame; periodic"),
            "x": (side * (np.arange(mesh.columns[0]) + 0.5), "m", "distance along x in the moving frame; periodic"),
        }
        for name, (values, units, what) in axes.items():
            file.createDimension(name, len(values))
            _variable(file, name, "f8", (name,), units, what)[:] = values
        profile = {"density": ("kg m-3", model.reference.density), "pressure": ("Pa", model.reference.pressure_Pa)}
        for name, (units, values) in profile.items():
            _variable(file, name, "f8", ("z",), units, f"{name} of the reference state")[:] = values
        means = [checkpoint.kept("statistics", n) for n in range(len(times.statistics))]
        for table, shape in (
            (statistics.PROFILES, ("statistics_time", "z")),
            (statistics.SERIES, ("statistics_time",)),
        ):
            for name, (units, what) in table.items():
                target = f"mean_{name}" if name in ("theta_l", "u", "v") else name
                _variable(file, target, "f8", shape, units, what)[:] = np.stack([each[name] for each in means])
        for name, (units, what) in PICTURES.items():
            _variable(file, name, "f4", ("time", "y", "x"), units, what)
        for n in range(len(times.pictures)):
            for name, field in checkpoint.kept("picture", n).items():
                file.variables[name][n] = field
        if times.volumes:
            what = "extinction of cloud droplets, visible"
            _variable(file, "extinction", "f4", ("volume_time", "z", "y", "x"), "m-1", what)
        for n in range(len(times.volumes)):
            file.variables["extinction"][n] = checkpoint.kept("volume", n)["extinction"]


def _variable(file: Any, name: str, kind: str, axes: tuple[str, ...], units: str, what: str) -> Any:
    variable = file.createVariable(name, kind, axes, zlib=len(axes) > 1, fill_value=np.nan if kind == "f4" else None)
    variable.setncatts({"units": units, "long_name": what})
    return variable
