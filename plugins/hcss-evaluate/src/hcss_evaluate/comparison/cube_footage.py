"""Frames of a cube for comparison: one variable and band, with the brightness temperature of its radiance."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.comparison.footage import EvaluationChoice, Footage, Method, is_kelvin
from hcss_twin import brightness_temperature
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import Array, CubeError, HcssError, ImageError, choose_from

if TYPE_CHECKING:
    import xarray as xr


# Beyond this wavelength clouds are assumed to be colder than the sea, as in images.
_THERMAL_UM = 3.0
_TEMPERATURE, _RADIANCE, _MASK = "brightness_temperature", "radiance", "cloud_mask"


def cube_footage(
    title: str, dataset: xr.Dataset, path: Path, choice: EvaluationChoice, like: Footage | None
) -> Footage:
    """Select one variable and band of a cube, which must stay open while frames are read.

    ``title`` (REAL or SIM) and ``path`` are used in messages. Without a requested band, the band at the wavelength of
    ``like``, the other side, is selected. Raises CubeError if the cube lacks the variable, band or frame, and
    ImageError if an option does not apply to it.
    """
    variable = choice.variable
    if variable is None and _TEMPERATURE in dataset:
        variable = _TEMPERATURE
    notes: list[str] = []
    selection = FrameSelection.of(dataset, variable, (), choice.frames)
    if selection.plane_kind == "layer" and len(selection.planes) > 1:
        raise CubeError(
            f"variable '{selection.variable}': {len(selection.planes)} cloud layers; allowed: variables without layers"
        )
    if selection.plane_kind == "band":
        band = choice.band or _band_like(title, selection, path, like, notes)
        selection = FrameSelection.of(dataset, variable, (band,), choice.frames)
    elif choice.band:
        raise CubeError(f"band '{choice.band}': {selection.variable} is the same for all bands; allowed: none")
    plane = selection.planes[0]
    frames = selection.frames
    truth = _truth(dataset, choice.frames)
    method = _method(choice, selection.variable, truth is not None, path)
    kelvin = _kelvin(dataset, path, selection, plane, notes)
    known = None if selection.grid is None else abs(selection.grid.step_x_m)
    size = choice.pixel_size_m or known
    if known and size != known:
        notes.append(f"Pixels of {known:g} m are treated as pixels of {size:g} m.")

    def values(number: int) -> Array:
        return np.asarray(selection.values(frames[number])[0], dtype=np.float64)

    bright = _bright(choice, selection.variable, plane, values, truth, notes)
    return Footage(
        name=path.name,
        kind="cube",
        quantity=(selection.long_name or selection.variable).replace("_", " "),
        units="" if selection.units == "1" else selection.units,
        band="" if plane.central_um is None else f"{plane.name}, {plane.lower_um:.4g} to {plane.upper_um:.4g} um",
        wavelength_um=plane.central_um,
        shape=(selection.rows, selection.columns),
        pixel_size_m=size,
        is_nominal=False,
        labels=tuple(frame.time.replace(".000000Z", "Z") for frame in frames),
        seconds=tuple(frame.seconds - frames[0].seconds for frame in frames),
        bright_is_cloud=bright,
        method=method,
        notes=tuple(notes),
        values=values,
        truth=truth,
        kelvin=kelvin,
    )


def _band_like(title: str, selection: FrameSelection, path: Path, like: Footage | None, notes: list[str]) -> str:
    """Return the only band, or the one at the wavelength of the other file."""
    names = [plane.name for plane in selection.planes]
    if len(names) == 1:
        return names[0]
    if like is not None and like.wavelength_um is not None:
        at = like.wavelength_um
        around = [
            plane
            for plane in selection.planes
            if plane.lower_um is not None and plane.upper_um is not None and plane.lower_um <= at <= plane.upper_um
        ]
        if around:
            best = min(around, key=lambda plane: (plane.upper_um or 0.0) - (plane.lower_um or 0.0))
            notes.append(f"Band {best.name} of {', '.join(names)}: it holds {at:.4g} um, as {like.name} does.")
            return best.name
    option = f"--{title.lower()}-band {names[0]}"
    raise CubeError(f"{path}: {len(names)} bands; choose one, as {option}; {choose_from('', names)}")


def _truth(dataset: xr.Dataset, frames: tuple[int, ...]) -> Callable[[int], NDArray[np.bool_]] | None:
    if _MASK not in dataset:
        return None
    chosen = FrameSelection.of(dataset, _MASK, (), frames if "time" in dataset[_MASK].dims else ())

    def read(number: int) -> NDArray[np.bool_]:
        frame = chosen.frames[number if len(chosen.frames) > 1 else 0]
        return np.asarray(chosen.values(frame)[0] > 0)

    return read


def _method(choice: EvaluationChoice, variable: str, has_truth: bool, path: Path) -> Method:
    if choice.method == "truth" and not has_truth:
        raise ImageError(
            f"method 'truth': {path} has no {_MASK}; allowed: another method, or run the scenario with "
            f'--set \'output.variables=["radiance", "{_MASK}"]\''
        )
    if choice.method != "auto":
        return choice.method
    return "truth" if has_truth and variable.startswith("cloud_") else "otsu"


def _kelvin(
    dataset: xr.Dataset, path: Path, selection: FrameSelection, plane: FrameSelection.Plane, notes: list[str]
) -> Callable[[Array], Array] | None:
    """Return the conversion of the variable to brightness temperature; None if there is none."""
    if is_kelvin(selection.units):
        return lambda values: values
    if selection.variable != _RADIANCE:
        return None
    try:
        return _kelvin_of_band(dataset, plane.name)
    except HcssError as error:
        notes.append(f"Radiance cannot be turned into brightness temperature: {error}.")
        return None


def _kelvin_of_band(dataset: xr.Dataset, band: str) -> Callable[[Array], Array]:
    """Return the conversion of radiance (rows, columns) of a band to kelvin; an HcssError if the cube has no such."""
    import xarray as xr

    def kelvin(radiance: Array) -> Array:
        values = ("time", "band", "y", "x"), radiance[None, None]
        frame = xr.Dataset({_RADIANCE: values}, coords={"band": [band]}, attrs=dataset.attrs)
        return np.asarray(brightness_temperature(frame)[0, 0], dtype=np.float64)

    kelvin(np.ones((1, 1)))
    return kelvin


def _bright(
    choice: EvaluationChoice,
    variable: str,
    plane: FrameSelection.Plane,
    values: Callable[[int], Array],
    truth: Callable[[int], NDArray[np.bool_]] | None,
    notes: list[str],
) -> bool:
    """Whether large values are cloud: from the option, else from the cube's mask, else from the wavelength."""
    if choice.cloud_is != "auto":
        return choice.cloud_is == "bright"
    if truth is not None and not variable.startswith("cloud_"):
        first, mask = values(0), truth(0)
        known = ~np.isnan(first)
        cloudy, clear = first[mask & known], first[~mask & known]
        if cloudy.size and clear.size:
            bright = bool(np.mean(cloudy) > np.mean(clear))
            notes.append(f"Cloud is {'bright' if bright else 'dark'}, as the cube's own mask shows.")
            return bright
    radiometric = variable == _TEMPERATURE or variable.startswith(_RADIANCE)
    return not (radiometric and plane.central_um is not None and plane.central_um > _THERMAL_UM)
