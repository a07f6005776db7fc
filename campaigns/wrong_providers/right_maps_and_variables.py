"""Right surfaces and variables."""

from dataclasses import replace

import hcss_author
import netCDF4
import numpy as np
from right_kit import builtin, kit

from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import Declaration, OutputVariable, SurfaceClass, SurfaceMap

from hcss_examples import ice_map, split_window  # isort: skip
from stranger import surfaces as floes  # isort: skip
from stranger import variables as slants  # isort: skip

MAP = np.linspace(34.0, 36.0, 81), np.linspace(149.0, 151.0, 61)
"""Latitude and longitude of the files."""


KNOWN_ICE = (
    hcss_author.KnownSurface(34.8, 150.5, "sea"),
    hcss_author.KnownSurface(35.1, 149.55, "ice", 264.7),
    hcss_author.KnownSurface(35.4, 150.5, "ice", 259.0),
)
KNOWN_FLOE = (hcss_author.KnownSurface(34.9, 150.0, "sea"), hcss_author.KnownSurface(35.05, 150.0, "floe", 266.0))
KNOWN_COAST = (
    hcss_author.KnownSurface(35.70, 139.50, "forest", 295.0),  # Tokyo
    hcss_author.KnownSurface(35.00, 139.50, "sea"),  # Sagami Bay
    hcss_author.KnownSurface(35.45, 139.80, "sea"),  # Tokyo Bay
    hcss_author.KnownSurface(36.50, 138.50, "forest"),
    hcss_author.KnownSurface(35.00, 142.00, "sea"),
)
KNOWN_FLAT = (
    hcss_author.KnownSurface(35.0, 150.0, "sea"),
    hcss_author.KnownSurface(35.0, 150.0, "flat", 286.0, time_s=5.0),
    hcss_author.KnownSurface(35.0, 149.99, "sea", time_s=4.0),
)


def of_a_file(make, **members):
    """Kit of a surface that reads ``map.nc``: ice in the north, colder toward the east."""

    def make_kit(folder):
        with netCDF4.Dataset(folder / "map.nc", "w") as file:
            for name, values in zip(("latitude", "longitude"), MAP, strict=True):
                file.createDimension(name, values.size)
                file.createVariable(name, "f8", (name,))[:] = values
            north, east = np.meshgrid(*MAP, indexing="ij")
            share = np.clip(0.5 + 4.0 * (north - 35.0) + 0.5 * (east - 150.0), 0.0, 1.0)
            layers = {
                "concentration": share,
                "surface_class": 3 + (share >= 0.5),
                "temperature": 262 - 6 * (east - 150),
            }
            for name, values in layers.items():
                file.createVariable(name, "f8", ("latitude", "longitude"))[:] = values

        def inputs():
            return replace(hcss_author.sample_surface_inputs(), catalog=Catalog(base=folder))

        return kit("surfaces", make, inputs, **members)(folder)

    return make_kit


class TidalFlat:
    """Sand that falls dry as the tide goes out, seaward of a straight shore."""

    declares = Declaration()

    def __init__(self, inputs):
        self._ground = inputs.ground
        self.classes = (SurfaceClass("sea"), SurfaceClass("flat", inputs.air_temperature_K - 2.0, floes.Grey()))

    def surface(self, time_s, rows, columns):
        _, longitude = self._ground(time_s, rows, columns)
        return SurfaceMap((longitude > 150.01 - 0.004 * time_s).astype(np.uint8))


class Plain:
    """The same land everywhere."""

    declares = Declaration()
    classes = (SurfaceClass("vegetation"),)

    def __init__(self, inputs):
        pass

    def surface(self, time_s, rows, columns):
        return SurfaceMap(np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.uint8))


def at_a_coast(inputs):
    """Move the sample to the coast of Honshu."""
    sample = inputs.ground

    def ground(*window):
        latitude, longitude = sample(*window)
        return latitude + 0.65, longitude - 10.15

    return replace(inputs, ground=ground)


def surfaces():
    floe = lambda inputs: floes.Floe(inputs, floes.Parameters())  # noqa: E731
    yield "floe", "surfaces", "ice that is colder toward the north", kit("surfaces", floe, known=KNOWN_FLOE)
    coast = lambda inputs: builtin("surfaces", "coast", inputs, land="forest", land_temperature=295.0)  # noqa: E731
    yield (
        "coast",
        "surfaces",
        "a coast with forest",
        kit("surfaces", coast, lambda: at_a_coast(hcss_author.sample_surface_inputs()), known=KNOWN_COAST),
    )
    layers = {"classes": {3: "sea", 4: "ice"}, "temperature_layer": "temperature", "temperatures": {"sea": 271.5}}
    raster = lambda inputs: builtin("surfaces", "raster", inputs, file="map.nc", **layers)  # noqa: E731
    yield "raster", "surfaces", "classes and temperature of a file", of_a_file(raster, known=KNOWN_ICE)
    ice = lambda inputs: ice_map.IceMap(inputs, ice_map.Parameters(file="map.nc"))  # noqa: E731
    yield "ice-map", "surfaces", "ice where its concentration is large", of_a_file(ice, known=KNOWN_ICE)
    yield "tidal-flat", "surfaces", "sand that falls dry", kit("surfaces", TidalFlat, is_still=False, known=KNOWN_FLAT)
    yield "plain", "surfaces", "the same land everywhere", kit("surfaces", Plain)


class SolarTime:
    """Mean solar time, which is later toward the east."""

    declares = Declaration()
    needs = ("longitude",)
    variables = {  # noqa: RUF012
        "solar_time": OutputVariable("h", "mean solar time", "Hours after midnight.", lowest=0.0, highest=24.0)
    }

    def __init__(self, inputs):
        pass

    def values(self, fields, time_s):
        return {"solar_time": np.mod(3.0 + fields["longitude"] / 15.0 + time_s / 3600.0, 24.0)}


class CloudEmissivity:
    """Emissivity of a cloud along the line of sight, and the radiance that a black one would add."""

    declares = Declaration()
    needs = ("cloud_optical_thickness", "view_zenith", "radiance")
    variables = {  # noqa: RUF012
        "slant_emissivity": OutputVariable(
            "1", "cloud emissivity", "Without scattering.", per_band=True, lowest=0.0, highest=1.0
        ),
        "emitted": OutputVariable("W m-2 sr-1", "share of the radiance", "By emissivity.", per_band=True),
    }

    def __init__(self, inputs):
        pass

    def values(self, fields, time_s):
        depth = fields["cloud_optical_thickness"] / np.cos(np.radians(fields["view_zenith"]))
        emissivity = 1.0 - np.exp(-depth.astype(float))
        return {"slant_emissivity": emissivity, "emitted": emissivity * fields["radiance"]}


class InCelsius:
    """Brightness temperature in degrees Celsius, and whether it freezes."""

    declares = Declaration()
    needs = ("brightness_temperature",)
    variables = {  # noqa: RUF012
        "brightness_celsius": OutputVariable(
            "degC", "brightness temperature", "In degrees Celsius.", standard_name="brightness_temperature",
            per_band=True
        ),
        "freezing": OutputVariable("1", "freezing", "Below 0 degC in the first band.", dtype="uint8",
                                   flag_meanings=("above", "below")),
    }  # fmt: skip

    def __init__(self, inputs):
        pass

    def values(self, fields, time_s):
        celsius = fields["brightness_temperature"] - 273.15
        return {"brightness_celsius": celsius, "freezing": (celsius[0] < 0.0).astype(np.uint8)}


def of_slant(self, inputs, fields, time_s):
    """Path and angle between directions as vectors."""
    view, sun = (_upward(fields[f"{name}_zenith"], fields[f"{name}_azimuth"]) for name in ("view", "sun"))
    mirrored = sun * np.array([-1.0, -1.0, 1.0])[:, None, None]
    thickness = fields["cloud_thickness"]
    return {
        "cloud_path": np.where(thickness > 0.0, thickness / view[2], np.nan),
        "glint_angle": np.degrees(np.arccos(np.sum(view * mirrored, axis=0))),
    }


def _upward(zenith_deg, azimuth_deg):
    zenith, azimuth = np.radians(zenith_deg), np.radians(azimuth_deg)
    return np.stack((np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)))


def of_bands(self, inputs, fields, time_s):
    mid, long = fields["brightness_temperature"]
    return {"split_window_difference": mid - long, "split_window_class": 1 * (mid >= long + 2.0)}


def of_longitude(self, inputs, fields, time_s):
    return {"solar_time": ((time_s + 10800.0) / 3600.0 + fields["longitude"] / 15.0) % 24.0}


def of_depth(self, inputs, fields, time_s):
    slant = fields["cloud_optical_thickness"] / np.sin(np.radians(90.0 - fields["view_zenith"]))
    return {"slant_emissivity": -np.expm1(-slant), "emitted": -np.expm1(-slant) * fields["radiance"]}


def of_kelvin(self, inputs, fields, time_s):
    kelvin = fields["brightness_temperature"]
    return {"brightness_celsius": kelvin - 273.15, "freezing": 1 * (kelvin[0] < 273.15)}


def variables():
    slant = lambda inputs: slants.Slant(inputs, slants.Parameters())  # noqa: E731
    yield "slant", "variables", "path in cloud, and the angle from the mirror", kit("variables", slant, known=of_slant)
    two = split_window.Parameters(bands=("mid", "long"))
    split = lambda inputs: split_window.SplitWindow(inputs, two)  # noqa: E731
    yield "split-window", "variables", "a difference of two bands, and a flag", kit("variables", split, known=of_bands)
    yield "solar-time", "variables", "mean solar time", kit("variables", SolarTime, known=of_longitude)
    yield (
        "cloud-emissivity",
        "variables",
        "emissivity of a slant path",
        kit("variables", CloudEmissivity, known=of_depth),
    )
    yield (
        "in-celsius",
        "variables",
        "brightness temperature in degrees Celsius",
        kit("variables", InCelsius, known=of_kelvin),
    )
