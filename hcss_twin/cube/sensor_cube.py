"""The sensor cube: coordinates and truth of a finished clean cube, with measurements instead of radiance."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import Writing
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, Attribute, check_attributes
from hcss_twin.cube.requested_variables import INPUTS
from hcss_twin.cube.variables import BAND_FRAME, TERM_PREFIX, VARIABLES, VariableSpec, flags
from hcss_twin.cube.writer import variable_attributes

SENSOR_ATTRIBUTE = "hcss_sensor"
"""Global attribute of a sensor cube: description of the sensor (JSON)."""

MEASURED_RADIANCE = VariableSpec(
    "radiance", "W m-2 sr-1", "band-integrated radiance as measured", "radiance",
    "Band-integrated radiance after optics, detector and converter; noise may make it negative.", BAND_FRAME,
)  # fmt: skip

SENSOR_VARIABLES: tuple[VariableSpec, ...] = (
    VariableSpec("photon_rate", "s-1", "photons per second on the detector of the pixel", "derived",
                 "Photons of the scene that reach the pixel's detector per second, after blur and smear, before "
                 "noise and quantum efficiency.", BAND_FRAME),
    VariableSpec("digital_number", "1", "digital number", "derived", "Output of the converter.",
                 BAND_FRAME, "int32", lowest=0.0),
    VariableSpec("saturated", "1", "flag of values beyond the range of the sensor", "derived",
                 "1: detector or converter at the upper end of its range; 2: converter at 0. The radiance there is "
                 "that of the end.", BAND_FRAME, "uint8",
                 attributes=flags("within_range saturated cut_at_zero"), lowest=0.0, highest=2.0),
)  # fmt: skip


def measured_variables(names: tuple[str, ...]) -> tuple[VariableSpec, ...]:
    """Return the measured radiance and the named variables, in the order of the table."""
    return (MEASURED_RADIANCE, *(spec for spec in SENSOR_VARIABLES if spec.name in names))


def is_replaced(name: str, inputs: str = "") -> bool:
    """Whether a variable of the clean cube is a radiance or derived from it, which a sensor cube does not repeat.

    ``inputs`` is the attribute of variables of providers that names what they are derived from.
    """
    of_radiance = {spec.name for spec in VARIABLES if spec.needs_radiance}
    return any(variable in of_radiance or variable.startswith(TERM_PREFIX) for variable in (name, *inputs.split()))


RADIANCE = "radiance"
_LINKS = "coordinates", "grid_mapping"
"""Attributes that refer to other variables."""


class CubePair:
    """A clean cube and the sensor cube that is written from it, frame by frame.

    Attributes
    ----------
    frames : int
        Number of frames.
    """

    def __init__(self, clean: Any, measured: Any, variables: Sequence[VariableSpec], where: str) -> None:
        self._clean, self._measured = clean, measured
        if RADIANCE in clean.variables:
            clean[RADIANCE].set_auto_scale(True)
        self._variables, self._where = {spec.name: spec for spec in variables}, where
        self._along_time = [
            name
            for name, variable in clean.variables.items()
            if variable.dimensions[:1] == ("time",)
            and variable.ndim > 1
            and not is_replaced(name, getattr(variable, INPUTS, ""))
        ]
        self.frames = int(clean.dimensions["time"].size)

    def values(self, index: int, name: str) -> NDArray[Any]:
        """Read a variable of a frame of the clean cube."""
        return np.asarray(self._clean[name][index])

    def write_frame(self, index: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write the measurements of a frame, one array per variable of the type in its spec, and copy the truth.

        Raises
        ------
        CubeError
            If a value cannot be stored.
        """
        for name, spec in self._variables.items():
            array = arrays[name]
            if array.dtype.kind == "f" and not np.all(np.isfinite(array)):
                bad = int(np.count_nonzero(~np.isfinite(array)))
                raise CubeError(f"{self._where}: frame {index}, {name}: {bad} values do not fit {spec.dtype}")
            self._measured[name][index] = array
        for name in self._along_time:
            self._measured[name][index] = self._clean[name][index]


@contextmanager
def measured_cube(
    clean_path: Path, path: Path, variables: Sequence[VariableSpec], attributes: Mapping[str, Attribute | None]
) -> Iterator[CubePair]:
    """Create a sensor cube for a finished cube; it is renamed to ``path`` if the block raises no exception.

    Dimensions, coordinates, truth variables, storage and global attributes are copied from the clean cube.

    Parameters
    ----------
    clean_path, path : Path
        The finished cube, and the new one.
    variables : sequence of VariableSpec
        Variables of each frame and band that replace the radiance variables of the clean cube, if it has any.
    attributes : mapping
        Global attributes to add or replace; None removes one.

    Raises
    ------
    CubeError
        If a file cannot be read or written.
    """
    check_attributes({name: value for name, value in attributes.items() if value is not None})
    if not path.parent.is_dir():
        raise CubeError(f"cannot write {path}: there is no folder {path.parent}")
    if path.exists() and os.path.samefile(clean_path, path):
        raise CubeError(f"cannot write {path}: it is the clean cube")
    with (
        Writing(path, CubeError, "NetCDF") as draft,
        NetcdfFile(clean_path) as clean,
        NetcdfFile(draft, "w") as measured,
    ):
        for dataset in (clean, measured):
            dataset.set_auto_maskandscale(False)
        measured.set_fill_off()
        _define(clean, measured, variables, attributes)
        yield CubePair(clean, measured, variables, str(path))
        measured.setncattr(FORMAT_ATTRIBUTE, np.int32(FORMAT_VERSION))


def _define(
    clean: Any, measured: Any, variables: Sequence[VariableSpec], attributes: Mapping[str, Attribute | None]
) -> None:
    copied = {name: clean.getncattr(name) for name in clean.ncattrs() if name != FORMAT_ATTRIBUTE}
    for name, value in {**copied, **attributes}.items():
        if value is not None:
            measured.setncattr(name, value)
    for name, dimension in clean.dimensions.items():
        measured.createDimension(name, dimension.size)
    for name, source in clean.variables.items():
        if not is_replaced(name, getattr(source, INPUTS, "")):
            _copy_definition(measured, name, source)
    dimensions, layout, links = _pattern(clean)
    for spec in variables:
        variable = measured.createVariable(spec.name, spec.dtype, dimensions, fill_value=False, **layout)
        variable.setncatts({**variable_attributes(spec), **links})


def _pattern(clean: Any) -> tuple[tuple[str, ...], dict[str, Any], dict[str, str]]:
    """Return dimensions, storage and links of measurements: as of the radiance, or of another variable of frames."""
    of_frames = [source for source in clean.variables.values() if source.dimensions[:1] == ("time",)]
    source = clean[RADIANCE] if RADIANCE in clean.variables else next(each for each in of_frames if each.ndim > 2)
    layout, links = _layout(source), {name: getattr(source, name) for name in _LINKS if name in source.ncattrs()}
    if source.name == RADIANCE:
        return source.dimensions, layout, links
    dimensions = "time", "band", *source.dimensions[-2:]
    if "chunksizes" in layout:
        layout["chunksizes"] = 1, 1, *layout["chunksizes"][-2:]
    listed = [name for name, of_bands in clean.variables.items() if of_bands.dimensions == ("band",)]
    listed += [name for name in links["coordinates"].split() if {*clean[name].dimensions} <= {*dimensions}]
    return dimensions, layout, {**links, "coordinates": " ".join(listed)}


def _copy_definition(measured: Any, name: str, source: Any) -> None:
    """Define a variable as in the clean cube; copy its values unless they are written frame by frame."""
    given = {attribute: source.getncattr(attribute) for attribute in source.ncattrs()}
    fill = given.pop("_FillValue", None if source.dtype is str else False)
    layout = {} if source.dtype is str else _layout(source)
    variable = measured.createVariable(name, source.dtype, source.dimensions, fill_value=fill, **layout)
    variable.setncatts(given)
    if source.dimensions[:1] == ("time",) and source.ndim > 1:
        return
    if source.ndim:
        variable[:] = source[:]
    elif source.dtype != np.dtype("S1"):  # attribute containers have no value
        variable.assignValue(source.getValue())


def _layout(source: Any) -> dict[str, Any]:
    """Storage settings of a variable, for use with another."""
    filters, chunks = source.filters() or {}, source.chunking()
    if not source.ndim:
        return {}
    if chunks == "contiguous" or chunks is None:
        return {"contiguous": True}
    layout: dict[str, Any] = {"chunksizes": chunks}
    if filters.get("zlib"):
        layout |= {"compression": "zlib", "complevel": filters["complevel"], "shuffle": filters["shuffle"]}
    return layout
