"""Surface provider ``raster``: classes and temperature from a GeoTIFF or NetCDF file.

The class of a point is that of the cell around it; temperature is bilinear between the centres of cells, and constant
beyond the outermost ones. Points outside the raster are an error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, ProviderError, choose_from
from hcss_twin.core.reading import Reading, require_size
from hcss_twin.models.surfaces.parameters import RasterParameters
from hcss_twin.providers import Declaration, SurfaceClass, SurfaceInputs, SurfaceMap


@dataclass(frozen=True)
class Grid:
    """Cells of a raster.

    Attributes
    ----------
    layers : mapping of str to ndarray (R, C)
        NaN where there is no value.
    to_cells : callable
        Maps latitude and longitude to row and column (...); the first cell extends from -0.5 to 0.5.
    extent : str
        What the raster covers.
    """

    layers: dict[str, Array]
    to_cells: Callable[[Array, Array], tuple[Array, Array]]
    extent: str


class Raster:
    """Map from a file.

    Parameters
    ----------
    inputs : SurfaceInputs
    parameters : RasterParameters

    Raises
    ------
    CatalogError
        If the file cannot be read, has no such layer, or the parameters contradict it.
    """

    def __init__(self, inputs: SurfaceInputs, parameters: RasterParameters) -> None:
        self._inputs, self._name = inputs, parameters.file
        path = inputs.catalog.file(parameters.file)
        is_netcdf = Reading(path, CatalogError).is_netcdf
        self._grid = (_netcdf if is_netcdf else _geotiff)(path)
        self._classes = self._temperature = None
        if parameters.classes:
            self._classes = self._layer(parameters.class_layer or ("surface_class" if is_netcdf else "1"))
        if parameters.temperature_layer is not None:
            self._temperature = self._layer(parameters.temperature_layer)
        if self._classes is None and self._temperature is None:
            raise CatalogError(f"'{self._name}': neither classes nor temperature_layer; allowed: one or both")
        self._numbers = np.array(sorted(parameters.classes), dtype=np.float64)
        given = {parameters.classes[int(number)]: None for number in self._numbers} or {"sea": None}
        for name in parameters.temperatures:
            if name not in given:
                raise CatalogError(f"temperatures: '{name}' is no class of '{self._name}'; {choose_from(name, given)}")
        self._names = [parameters.classes[int(number)] for number in self._numbers] or ["sea"]
        self._order = {name: number for number, name in enumerate(given)}
        field = None if self._temperature is None else self._field()
        self.classes = tuple(SurfaceClass(name, parameters.temperatures.get(name, field)) for name in given)
        self.declares = Declaration(notes=(f"raster: {self._grid.extent}",))

    def surface(self, time_s: float, rows: slice, columns: slice) -> SurfaceMap:
        """Return the classes, and the temperature if the raster has it."""
        latitude, longitude = self._inputs.ground(time_s, rows, columns)
        row, column = self._grid.to_cells(latitude, longitude)
        sizes = next(iter(self._grid.layers.values())).shape
        inside = (row >= -0.5) & (row <= sizes[0] - 0.5) & (column >= -0.5) & (column <= sizes[1] - 0.5)
        if not np.all(inside):
            worst = np.flatnonzero(~inside.ravel())[0]
            raise ProviderError(
                f"raster '{self._name}' covers {self._grid.extent}; {np.count_nonzero(~inside)} points of the scene "
                f"lie outside, e.g. latitude {latitude.ravel()[worst]:.5g}, longitude {longitude.ravel()[worst]:.5g}"
            )
        cell = tuple(
            np.clip(np.rint(position), 0, size - 1).astype(np.intp)
            for position, size in zip((row, column), sizes, strict=True)
        )
        number = np.zeros(row.shape, dtype=np.uint8)
        if self._classes is not None:
            number = self._number(self._classes[cell])
        if self._temperature is None:
            return SurfaceMap(number)
        kelvin = _bilinear(self._temperature, row, column)
        fields = [number for number, class_ in enumerate(self.classes) if isinstance(class_.temperature_K, tuple)]
        missing = np.isnan(kelvin) & np.isin(number, fields)
        if np.any(missing):
            raise ProviderError(
                f"raster '{self._name}' has no temperature at or beside {np.count_nonzero(missing)} points of the "
                "scene; allowed: values everywhere, or temperatures of their classes"
            )
        return SurfaceMap(number, kelvin)

    def _number(self, values: Array) -> NDArray[np.uint8]:
        index = np.searchsorted(self._numbers, values).clip(0, self._numbers.size - 1)
        unknown = self._numbers[index] != values
        if np.any(unknown):
            shown = ", ".join(f"{value:g}" for value in np.unique(values[unknown])[:5])
            raise ProviderError(
                f"raster '{self._name}' has the class {shown}, which parameters.classes does not name; allowed: "
                f"{', '.join(f'{number:g}' for number in self._numbers)}"
            )
        order = np.array([self._order[name] for name in self._names], dtype=np.uint8)
        numbers: NDArray[np.uint8] = order[index]
        return numbers

    def _layer(self, name: str) -> Array:
        layers = self._grid.layers
        if name not in layers:
            raise CatalogError(f"'{self._name}' has no layer '{name}'; {choose_from(name, layers)}")
        return layers[name]

    def _field(self) -> tuple[float, float]:
        """Return the lowest and highest temperature of the raster around the image, or of all if the platform moves."""
        values = self._temperature
        assert values is not None
        rows, columns = slice(0, self._inputs.grid.rows), slice(0, self._inputs.grid.columns)
        corner = slice(0, 1), slice(0, 1)
        if np.array_equal(self._inputs.ground(0.0, *corner), self._inputs.ground(1.0, *corner)):
            ends = (slice(0, 1), columns), (slice(rows.stop - 1, rows.stop), columns), (rows, slice(0, 1)), (
                rows, slice(columns.stop - 1, columns.stop))  # fmt: skip
            places = [self._grid.to_cells(*self._inputs.ground(0.0, *end)) for end in ends]
            near = []
            for positions, size in zip(zip(*places, strict=True), values.shape, strict=True):
                position = np.clip(np.concatenate([part.ravel() for part in positions]), 0, size - 1)
                margin = 0.5 * (position.max() - position.min()) + 2.0
                near.append(slice(max(int(position.min() - margin), 0), int(position.max() + margin) + 1))
            values = values[tuple(near)]
        known = values[np.isfinite(values)]
        if not known.size:
            raise CatalogError(f"'{self._name}' has no temperature around the image")
        low, high = float(known.min()), float(known.max())
        if not 150.0 <= low <= high <= 400.0:
            raise CatalogError(f"'{self._name}': temperatures are {low:g} to {high:g}; allowed: 150 to 400 K")
        return low, high


def _bilinear(values: Array, row: Array, column: Array) -> Array:
    """Interpolate between the centres of cells; constant beyond the outermost."""
    places = []
    for position, size in zip((row, column), values.shape, strict=True):
        inside = np.clip(position, 0.0, size - 1.0)
        low = np.minimum(inside.astype(np.intp), max(size - 2, 0))
        places.append((low, np.minimum(low + 1, size - 1), inside - low))
    (y, below, up), (x, beside, across) = places
    # A weight of 0 must not spread missing values.
    corners = ((y, x, (1 - up) * (1 - across)), (y, beside, (1 - up) * across), (below, x, up * (1 - across)),
               (below, beside, up * across))  # fmt: skip
    result = np.zeros(row.shape)
    for at_y, at_x, weight in corners:
        result += np.where(weight > 0.0, weight * values[at_y, at_x], 0.0)
    return result


def _geotiff(path: Path) -> Grid:
    try:
        import rasterio
        import rasterio.warp
    except ImportError as error:
        raise CatalogError(
            "the surface provider raster needs the package rasterio for GeoTIFF; install it with: "
            "pip install 'hcss-twin[geotiff]'"
        ) from error
    with Reading(path, CatalogError, "not a raster that can be read"), rasterio.open(path) as file:
        require_size(path, (file.count, file.height, file.width), CatalogError)
        crs, inverse = file.crs, ~file.transform
        layers = {
            str(band): np.ma.filled(file.read(band, masked=True).astype(np.float64), np.nan) for band in file.indexes
        }
        bounds = file.bounds
    if crs is None:
        raise CatalogError(f"{path}: it does not say where it is (no coordinate reference system)")
    west = bounds.left

    def to_cells(latitude: Array, longitude: Array) -> tuple[Array, Array]:
        if crs.is_geographic:
            x, y = west + np.mod(longitude - west, 360.0), latitude
        else:
            from_globe = "EPSG:4326", crs, longitude.ravel().tolist(), latitude.ravel().tolist()
            with Reading(path, CatalogError, "no place on the globe has a place in its projection"):
                x, y = (
                    np.reshape(coordinate, latitude.shape) for coordinate in rasterio.warp.transform(*from_globe)[:2]
                )
        column = inverse.a * np.asarray(x) + inverse.b * np.asarray(y) + inverse.c
        row = inverse.d * np.asarray(x) + inverse.e * np.asarray(y) + inverse.f
        return row - 0.5, column - 0.5

    edges = f"{bounds.left:g} to {bounds.right:g} east and {bounds.bottom:g} to {bounds.top:g} north"
    return Grid(layers, to_cells, f"{edges} ({crs.to_string() if crs.is_epsg_code else 'its own projection'})")


def _netcdf(path: Path) -> Grid:
    with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as file:
        (y_name, y), (x_name, x) = (_axis(path, file, kind) for kind in ("latitude", "longitude"))
        layers = {
            name: np.ma.filled(np.ma.asarray(variable[:]).astype(np.float64), np.nan).squeeze()
            for name, variable in file.variables.items()
            if variable.dimensions[-2:] in ((y_name, x_name), (x_name, y_name)) and variable.size == y.size * x.size
        }
        for name in layers:
            if file.variables[name].dimensions[-2:] == (x_name, y_name):
                layers[name] = layers[name].T
            layers[name] = layers[name].reshape(y.size, x.size)
    if not layers:
        raise CatalogError(f"{path}: no variable over latitude and longitude alone")

    def to_cells(latitude: Array, longitude: Array) -> tuple[Array, Array]:
        west = min(_edge(x, 0.0), _edge(x, x.size - 1.0))
        return _number_of(y, latitude), _number_of(x, west + np.mod(longitude - west, 360.0))

    edges = [sorted((_edge(axis, 0.0), _edge(axis, axis.size - 1.0))) for axis in (y, x)]
    return Grid(
        layers, to_cells, f"latitude {edges[0][0]:g} to {edges[0][1]:g}, longitude {edges[1][0]:g} to {edges[1][1]:g}"
    )


def _axis(path: Path, file: Any, kind: str) -> tuple[str, Array]:
    for name, variable in file.variables.items():
        known = name.lower() in (kind, kind[:3]) or getattr(variable, "standard_name", "") == kind
        if known and variable.dimensions == (name,) and variable.size > 1:
            values = np.ma.filled(variable[:], np.nan).astype(np.float64)
            steps = np.diff(values)
            if np.all(steps > 0.0) or np.all(steps < 0.0):
                return name, values
    raise CatalogError(f"{path}: no dimension of {kind} with two or more steadily changing values")


def _edge(axis: Array, end: float) -> float:
    """Return the outer edge of the first (0) or last cell of an axis."""
    at, beside = (0, 1) if end == 0.0 else (-1, -2)
    return float(axis[at] + 0.5 * (axis[at] - axis[beside]))


def _number_of(axis: Array, values: Array) -> Array:
    """Return the place of values between the centres of cells; half a cell beyond the ends, then farther out."""
    ends = np.array([_edge(axis, 0.0), _edge(axis, axis.size - 1.0)])
    known = np.concatenate((ends[:1], axis, ends[1:]))
    places = np.concatenate(([-0.5], np.arange(axis.size, dtype=np.float64), [axis.size - 0.5]))
    if known[0] > known[-1]:
        known, places = known[::-1], places[::-1]
    return np.interp(values, known, places, left=-np.inf, right=np.inf)
