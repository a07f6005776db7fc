"""Rasters for tests of surfaces."""

import netCDF4
import numpy as np


def write_netcdf(path, latitude, longitude, **layers):
    """Write layers (R, C) over latitude and longitude."""
    with netCDF4.Dataset(path, "w") as file:
        for name, values in (("latitude", latitude), ("longitude", longitude)):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        for name, values in layers.items():
            file.createVariable(name, "f8", ("latitude", "longitude"), fill_value=np.nan)[:] = values


def write_half(path, east=1, temperature=None):
    """Write a raster around 35 N 150 E with class 0 west of 150 degrees and another east of it."""
    latitude, longitude = np.linspace(34.98, 35.02, 201), np.linspace(149.98, 150.02, 200)
    classes = np.where(longitude > 150.0, east, 0) * np.ones((201, 1))
    layers = {"surface_class": classes}
    if temperature is not None:
        layers["temperature"] = temperature(*np.meshgrid(latitude, longitude, indexing="ij"))
    write_netcdf(path, latitude, longitude, **layers)
