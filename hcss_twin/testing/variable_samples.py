"""Sample inputs of variable providers: every variable of the engine, and its geometry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import VariableInputs
from hcss_twin.testing.samples import sample_element_inputs

_COLDEST_K, _WARMEST_K = 220.0, 305.0

_TERMS = (
    *("cloud_emission", "cloud_reflected_sun", "sea_emission", "sea_reflected_sun", "path_emission"),
    *("reflected_air_emission", "path_scattered_sun"),
)

_PIXELS: Mapping[str, tuple[float, float, str]] = {
    "cloud_mask": (0, 2, "uint8"),
    "shadow_mask": (0, 2, "uint8"),
    "cloud_fraction": (0.01, 1, "float32"),
    "cloud_thickness": (50, 800, "float32"),
    "cloud_top_altitude": (1050, 1800, "float32"),
    "cloud_top_temperature": (276, 281, "float32"),
    "sea_slope_x": (-0.2, 0.2, "float32"),
    "sea_slope_y": (-0.2, 0.2, "float32"),
    "sea_temperature": (285, 300, "float32"),
    "water_vapour_factor": (0.8, 1.2, "float32"),
    "surface_class": (0, 2, "uint8"),
    "surface_temperature": (270, 310, "float32"),
    "element": (0, 3, "uint8"),
    "element_share": (0, 1, "float32"),
    "element_source": (1, 5, "float32"),
    "element_altitude": (0, 9000, "float32"),
    "element_row": (0, 8, "float32"),
    "element_column": (0, 8, "float32"),
    "element_row_rate": (-5, 5, "float32"),
    "element_column_rate": (-5, 5, "float32"),
    "latitude": (34, 36, "float64"),
    "longitude": (149, 151, "float64"),
    "view_zenith": (10, 50, "float64"),
    "view_azimuth": (80, 100, "float64"),
    "sun_zenith": (20, 70, "float64"),
    "sun_azimuth": (0, 360, "float64"),
}
"""Range and type of variables with one value per pixel; whole numbers exclude the upper end."""

_CLOUDY = ("cloud_fraction", "cloud_thickness", "cloud_optical_thickness", "cloud_layer_thickness")
_TOPS = ("cloud_top_altitude", "cloud_top_temperature")


def sample_variable_inputs(bands: int = 2) -> VariableInputs:
    """Return inputs of a variable provider over :func:`sample_grid`."""
    element = sample_element_inputs(bands)
    return VariableInputs(element.bands, element.grid, element.view, element.catalog)


def sample_fields(inputs: VariableInputs, seed: int = 1) -> dict[str, NDArray[Any]]:
    """Return every variable of the engine, and its geometry, with random values of usual size, by name.

    Radiance and brightness temperature are those of bodies of 220 to 305 K; clear pixels, a third of all, have no cloud
    top. Terms and variables of elements have the names of this package's providers.
    """
    random, count = np.random.default_rng(seed), len(inputs.bands)
    shape = inputs.grid.rows, inputs.grid.columns
    fields = {name: random.uniform(low, high, shape).astype(dtype) for name, (low, high, dtype) in _PIXELS.items()}
    black_body = sample_element_inputs(count).black_body
    cold, warm = (black_body(kelvin)[:, None, None] for kelvin in (_COLDEST_K, _WARMEST_K))
    for name in ("radiance", "element_radiance", "element_point_radiance", *(f"radiance_{term}" for term in _TERMS)):
        share = random.random((count, *shape))
        fields[name] = (cold + (warm - cold) * share).astype(np.float32)
    of_bands = {
        "brightness_temperature": (_COLDEST_K, _WARMEST_K),
        "cloud_optical_thickness": (0.5, 30.0),
        "element_transmittance": (0.0, 1.0),
    }
    fields |= {name: random.uniform(*ends, (count, *shape)).astype(np.float32) for name, ends in of_bands.items()}
    fields["cloud_layer_thickness"] = fields["cloud_thickness"][None].copy()
    clear = random.random(shape) < 1.0 / 3.0
    fields["cloud_mask"] = (~clear).astype(np.uint8)
    none = fields["element"] == 0
    missing = [name for name in fields if name.startswith("element_") and not name.endswith(("share", "radiance"))]
    for name in missing:
        fields[name][..., none] = np.nan
    for names, value in ((_CLOUDY, 0.0), (_TOPS, np.nan)):
        for name in names:
            fields[name][..., clear] = value
    return fields
