"""Synthetic scenes of known cover in the units of images, and what independent readers find in the files."""

import netCDF4
import numpy as np
import rasterio
import xarray
from PIL import Image
from scipy.ndimage import gaussian_filter

SHAPE = 40, 56

RANGES = {  # clear from, clear to, cloud from, cloud to: the classes do not overlap, so Otsu's threshold separates them
    "grey": (18.0, 42.0, 150.0, 250.0),
    "counts": (900.0, 2400.0, 30000.0, 60000.0),
    "counts12": (60.0, 300.0, 2000.0, 4000.0),
    "reflectance": (0.02, 0.06, 0.4, 0.95),
    "percent": (2.0, 6.0, 40.0, 95.0),
    "radiance": (8.0, 20.0, 280.0, 560.0),
    "kelvin": (288.0, 292.0, 250.0, 212.0),
    "celsius": (15.0, 19.0, -23.0, -61.0),
    "thermal": (95.0, 100.0, 60.0, 20.0),
    "haze": (152.0, 165.0, 215.0, 254.0),
    "dark12": (155.0, 170.0, 280.0, 345.0),
    "anomaly": (-1.2, -0.8, 1.5, 3.5),
    "thickness": (0.0, 0.0, 400.0, 1000.0),
}


def scene(quantity, seed, shape=SHAPE):
    """Return values (rows, columns) of a quantity and where cloud is."""
    random = np.random.default_rng([40, seed])
    field = gaussian_filter(random.normal(size=shape), 3.0)
    cover = random.uniform(0.2, 0.6)
    cloud = field > np.quantile(field, 1.0 - cover)
    depth = np.zeros(shape)
    depth[cloud] = (field[cloud] - field[cloud].min()) / np.ptp(field[cloud])
    clear_0, clear_1, cloud_0, cloud_1 = RANGES[quantity]
    clear = clear_0 + (clear_1 - clear_0) * random.uniform(size=shape)
    return np.where(cloud, cloud_0 + (cloud_1 - cloud_0) * depth, clear), cloud


def patch(seed, shape=SHAPE, size=5):
    """Return where pixels have no value: a square patch and single pixels."""
    random = np.random.default_rng([41, seed])
    hidden = random.uniform(size=shape) < 0.01
    row, column = random.integers(3, shape[0] - size - 3), random.integers(3, shape[1] - size - 3)
    hidden[row : row + size, column : column + size] = True
    return hidden


def independent(path, variable=None):
    """Return the values of a file, NaN where invisible, by numpy, xarray, rasterio (GDAL) or Pillow."""
    suffix = path.suffix
    if suffix == ".npy":
        return np.load(path).astype(float)
    if suffix == ".npz":
        with np.load(path) as archive:
            return archive[variable or archive.files[0]].astype(float)
    if suffix == ".nc":
        with xarray.open_dataset(path, mask_and_scale=True) as dataset:
            item = dataset[variable or "image"].load()
            values = item.values.squeeze().astype(float)
            about = item.encoding | item.attrs
            for name, beyond in (("valid_min", np.less), ("valid_max", np.greater)):
                limit = about.get(name, np.ravel(about.get("valid_range", [-np.inf, np.inf]))[int(name == "valid_max")])
                stored = (values - about.get("add_offset", 0.0)) / about.get("scale_factor", 1.0)
                values[beyond(np.round(stored, 6), limit)] = np.nan
            if not about.keys() & {"_FillValue", "missing_value", "valid_min", "valid_max", "valid_range"}:
                unset = netCDF4.default_fillvals.get(f"{about['dtype'].kind}{about['dtype'].itemsize}", np.nan)
                values[np.isclose(stored, unset)] = np.nan  # xarray does not know the library's own fill values
            if item.attrs.get("units") == "degC":
                values = values + 273.15
            return values
    if suffix == ".tif":
        with rasterio.open(path) as dataset:
            if dataset.count >= 3 and dataset.dtypes[0] == "uint8" and variable is None:
                red, green, blue = dataset.read([1, 2, 3]).astype(float)
                grey = 0.299 * red + 0.587 * green + 0.114 * blue
                return np.where(dataset.dataset_mask() > 0, grey, np.nan)
            band = int(variable or 1)
            values = dataset.read(band).astype(float) * dataset.scales[band - 1] + dataset.offsets[band - 1]
            return np.where(dataset.read_masks(band) > 0, values, np.nan)
    with Image.open(path) as picture:
        if picture.mode == "1" or (picture.mode.startswith("I") and "transparency" not in picture.info):
            return np.asarray(picture).astype(float)
        if picture.mode.startswith("I"):
            values = np.asarray(picture).astype(float)
            return np.where(values == picture.info["transparency"], np.nan, values)
        red, green, blue, alpha = np.moveaxis(np.asarray(picture.convert("RGBA"), dtype=float), -1, 0)
    return np.where(alpha > 0, 0.299 * red + 0.587 * green + 0.114 * blue, np.nan)
