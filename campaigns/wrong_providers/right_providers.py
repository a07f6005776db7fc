"""Right providers of every kind, each as a kit class that makes it: what the conformance kit must accept.

They are those of this package with different parameters, the small ones of ``tests/contract/stranger``, the plain ones
of the kit, and two kinds of cloud generators that a kit may easily misjudge.
"""

from dataclasses import replace

import hcss_author
import numpy as np
import pytest
import right_maps_and_variables
import right_shutters
from right_kit import Right, builtin, kit

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.laws.samples import PlainScene
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import CloudDeclaration, Declaration, ElementPixels

from stranger import atmosphere, clouds, elements, optics, radiance, sea, sensor  # isort: skip


def field_mode(self, coverage=0.5, seed=1):
    inputs = hcss_author.sample_cloud_inputs(coverage, seed)
    return replace(inputs, layer=replace(inputs.layer, coverage_mode="field"))


def of_an_image(name, **parameters):
    """Kit of a generator that reads an image."""

    def make(folder):
        np.save(folder / "image.npy", np.random.default_rng(5).random((128, 160)))

        def make_inputs(self, coverage=0.5, seed=1):
            return hcss_author.sample_cloud_inputs(coverage, seed, catalog=Catalog(base=folder))

        make_one = kit(
            "clouds",
            lambda given: builtin("clouds", name, given, image="image.npy", method="coverage", **parameters),
            make_inputs=make_inputs,
            seeds=2,
        )
        return make_one(folder)

    return make


class Picture:
    """A picture of clouds, mirrored without end, with a coverage of its own: that of the layer has no influence."""

    image_coverage = 0.37

    def __init__(self, inputs):
        self._layer = inputs.layer
        rough = np.random.default_rng(3).random((90, 70))
        self._share = np.where(rough < self.image_coverage, rough / self.image_coverage, np.nan)
        motion, pixel = inputs.motion, inputs.grid.pixel_size_m
        wind = motion.cloud_velocity_m_s
        self._pixels_per_s = -wind[1] / pixel, (motion.platform_speed_m_s - wind[0]) / pixel
        self.declares = CloudDeclaration(depends_on=frozenset({"time"} if any(self._pixels_per_s) else ()))

    def thickness_m(self, time_s, rows, columns):
        spans = ((rows, self._share.shape[0]), (columns, self._share.shape[1]))
        y, x = (
            (np.arange(span.start, span.stop) + round(speed * time_s)) % size
            for (span, size), speed in zip(spans, self._pixels_per_s, strict=True)
        )
        layer, share = self._layer, self._share[y[:, None], x]
        thickness = layer.thickness_min_m + share * (layer.thickness_max_m - layer.thickness_min_m)
        return np.where(np.isnan(share), 0.0, thickness).astype(np.float32)


class Film(clouds.CloudStreets):
    """Cloud streets of a film of ten minutes: other times are an error."""

    def thickness_m(self, time_s, rows, columns):
        if not 0.0 <= time_s <= 600.0:
            raise ProviderError(f"film: time {time_s:g} s; allowed 0 to 600 s")
        return super().thickness_m(time_s, rows, columns)


class GlowingGas(hcss_author.PlainGas):
    """The kit's grey gas with its own path radiance, summed over the layers, and scattered sunlight."""

    def path_radiance(self, wavenumber_cm1, paths):
        result = np.zeros((len(paths), wavenumber_cm1.size))
        for row, path in enumerate(paths):
            (leg,) = path.legs
            inner = self._profile.altitude_m[(self._profile.altitude_m > leg.lower_m)]
            levels = np.concatenate(([leg.lower_m], inner[inner < leg.upper_m], [leg.upper_m]))
            through = self.transmittance(wavenumber_cm1, [to_space(level, leg.zenith_deg) for level in levels])
            ends = np.minimum(levels, self._profile.altitude_m[-1])
            kelvin = self._profile.temperature_at(0.5 * (ends[1:] + ends[:-1]))
            result[row] = np.sum(np.diff(through, axis=0) * planck(wavenumber_cm1, kelvin[:, None]), axis=0)
        return result

    def solar_path_radiance(self, wavenumber_cm1, paths, sun_zenith_deg, relative_azimuth_deg):
        both = [path + to_space(path.legs[0].lower_m, sun_zenith_deg) for path in paths]
        return 0.05 * (1.0 - self.transmittance(wavenumber_cm1, both))


def standard_air():
    return hcss_author.sample_atmosphere_inputs(load_profile("us-standard-1976", Catalog()))


def with_wind(speed_m_s):
    return lambda: hcss_author.sample_sea_inputs(speed_m_s)


FEW_STREAMS = {"streams": 4, "sun_streams": 4, "azimuth_modes": 8}

COUNTS = {
    "psf": "airy",
    "aperture_diameter": 0.2,
    "pixel_angle": 3e-5,
    "integration_time": 0.01,
    "noise": "photon",
    "read_noise": 50.0,
    "well_depth": 3e7,
    "bits": 14,
}


def right_providers():
    """Return all of them."""
    here = (_clouds, _sea, _optics, _atmosphere, _radiance, _sensors, _elements)
    elsewhere = (right_maps_and_variables.surfaces, right_maps_and_variables.variables, right_shutters.sensors)
    return [Right(*each) for rows in (*here, *elsewhere) for each in rows()]


def _clouds():
    streets, fractal = clouds.CloudStreets, {"gamma": 2.0, "H": 0.6, "k": [0, 5]}
    for name, spacing_m, direction_deg in (("streets", 3000.0, 30.0), ("narrow-streets", 1500.0, 80.0)):
        parameters = clouds.Parameters(spacing_m=spacing_m, direction_deg=direction_deg)
        make = lambda inputs, parameters=parameters: streets(inputs, parameters)  # noqa: E731
        yield name, "clouds", f"streets {spacing_m:g} m apart", kit("clouds", make)
    frame = lambda inputs: builtin("clouds", "fractal", inputs, L=[2.0, 3.0], **fractal)  # noqa: E731
    yield "fractal", "clouds", "fractal clouds, exact in each frame", kit("clouds", frame)
    sky = lambda inputs: builtin("clouds", "fractal", inputs, L=[80.0, 90.0], **fractal)  # noqa: E731
    yield "fractal-sky", "clouds", "fractal clouds of one sky", kit("clouds", sky, make_inputs=field_mode)
    yield "imagery", "clouds", "an image as it is", of_an_image("imagery", reinterpret_pixel_size=True)
    yield "picture", "clouds", "a picture that has its own coverage", kit("clouds", Picture)
    film = lambda inputs: Film(inputs, clouds.Parameters())  # noqa: E731
    yield "film", "clouds", "streets of ten minutes", kit("clouds", film)


def _sea():
    for speed in (2.0, 10.0, 20.0):
        make = lambda inputs: builtin("sea", "cox-munk", inputs)  # noqa: E731
        yield f"cox-munk-{speed:g}", "sea", f"slopes of Cox and Munk, {speed:g} m/s", kit("sea", make, with_wind(speed))
    for name, parameters in {
        "rough-sea": {},
        "rough-sea-along-wind": {"slopes": "upwind-crosswind", "spectrum": "jonswap"},
    }.items():
        rough = lambda inputs, parameters=parameters: builtin("sea", "rough-sea", inputs, **parameters)  # noqa: E731
        yield name, "sea", f"shadowed facets {parameters or ''}", kit("sea", rough), False
    for emissivity in (0.98, 0.9):
        plain = lambda inputs, emissivity=emissivity: hcss_author.PlainSea(emissivity)  # noqa: E731
        yield f"plain-sea-{emissivity:g}", "sea", f"Lambertian, emissivity {emissivity:g}", kit("sea", plain)
    slush = lambda inputs: sea.Slush(inputs, sea.Parameters())  # noqa: E731
    yield "slush", "sea", "grains that scatter once", kit("sea", slush)


SOURCES = (
    {"x": -2300.0, "y": 900.0, "altitude": 4000.0, "velocity": (150.0, -70.0, 12.0), "intensity": 2e3},
    {"x": 1100.0, "y": -640.0, "altitude": 800.0, "velocity": (-90.0, 30.0, 0.0), "intensity": 7e2},
)
BODY = {"x": 400.0, "y": -1330.0, "altitude": 200.0, "velocity": (30.0, 80.0, 0.0), "temperature": 900.0, "area": 12.0}


def mean_of(tracks, inputs, time_s, strengths):
    """The closed form of sources in straight lines: the kit weights each alike, whatever its strength."""
    x, y, z = np.mean(
        [np.add((each["x"], each["y"], each["altitude"]), np.multiply(each["velocity"], time_s)) for each in tracks], 0
    )
    return hcss_author.KnownElement(float(x), float(y), float(z), np.sum(strengths, axis=0))


class Flare:
    """A light that flickers at random and burns for ten seconds."""

    declares = Declaration()
    variables = {"brightness": ("1", "Brightness of the flare, of 1.")}  # noqa: RUF012

    def __init__(self, inputs):
        self._count = len(inputs.bands)

    def pixels(self, time_s, rows, columns, scene):
        bright = scene.random.random() * (1.0 - time_s / 10.0)
        place = [
            np.floor(each).astype(int) for each in scene.project(*(np.full(1, each) for each in (90.0, 50.0, 300.0)))
        ]
        if not (
            0.0 <= time_s < 10.0
            and all(s.start <= at[0] < s.stop for s, at in zip((rows, columns), place, strict=True))
        ):
            return []
        light = np.full(self._count, 500.0 * bright)
        truth = {"brightness": np.array([bright])}
        return [ElementPixels(*place, np.ones(1), 300.0, intensity=light, truth=truth)]


class InPixels:
    """Points that the provider itself draws in the pixels that they cover."""

    def __init__(self, provider):
        self._provider = provider
        self.declares, self.variables = provider.declares, provider.variables

    def pixels(self, time_s, rows, columns, scene):
        return PlainScene.shown(scene, self._provider, time_s, rows, columns)  # of a scene that may be a wrong one


def _elements():
    def points(tracks, footprint=0.0):
        return lambda inputs: builtin("elements", "point-sources", inputs, tracks=tracks, footprint=footprint)

    def sources(tracks, footprint=0.0):
        return lambda inputs: InPixels(points(tracks, footprint)(inputs))

    def of_tracks(self, inputs, time_s):
        return mean_of(SOURCES, inputs, time_s, [np.full(2, each["intensity"]) for each in SOURCES])

    def of_body(self, inputs, time_s):
        return mean_of([BODY], inputs, time_s, [12.0 * inputs.black_body(900.0)])

    def of_deck(self, inputs, time_s):
        area_m2 = 9 * 200.0**2 * np.cos(np.radians(inputs.view.zenith_deg))
        return hcss_author.KnownElement(300.0, 300.0, 10.0, area_m2 * inputs.black_body(310.0))

    yield (
        "tracks",
        "elements",
        "two sources spread over a square",
        kit("elements", sources(SOURCES, 520.0), known=of_tracks),
    )
    yield "points", "elements", "two sources as points", kit("elements", points(SOURCES, 520.0), known=of_tracks)
    yield "one-pixel", "elements", "two sources in one pixel each", kit("elements", sources(SOURCES))
    yield "hot-body", "elements", "a hot body that moves", kit("elements", sources([BODY], 300.0), known=of_body)
    deck = lambda inputs: elements.Ship(inputs, elements.Parameters())  # noqa: E731
    yield "deck", "elements", "a warm square of nine pixels", kit("elements", deck, known=of_deck)
    yield "flare", "elements", "a light that flickers", kit("elements", Flare)


def _optics():
    for name, parameters in {"mie": {}, "mie-asymmetry": {"phase_function": "henyey-greenstein"}}.items():
        mie = lambda inputs, parameters=parameters: builtin("optics", "mie", inputs, **parameters)  # noqa: E731
        yield name, "optics", f"Mie scattering of droplets {parameters or ''}", kit("optics", mie)
    bulk = lambda inputs: builtin("optics", "bulk", inputs)  # noqa: E731
    yield "bulk", "optics", "cold droplets", kit("optics", bulk)
    crystals = pytest.fixture(lambda self: hcss_author.sample_microphysics("ice"))
    yield "crystals", "optics", "rough crystals", kit("optics", bulk, cloud=crystals)
    for name, values in {"grey": (), "bright-grey": (1.8e-10, 0.9, 0.85), "absorbing-grey": (1e-10, 0.0, 0.0)}.items():
        grey = lambda inputs, values=values: hcss_author.PlainOptics(*values)  # noqa: E731
        yield name, "optics", f"grey particles {values or ''}", kit("optics", grey)
    soft = lambda inputs: optics.SoftParticles(inputs, optics.Parameters())  # noqa: E731
    yield "soft", "optics", "anomalous diffraction", kit("optics", soft)


def _atmosphere():
    for aerosol in ("none", "maritime"):
        band = lambda inputs, aerosol=aerosol: builtin("atmosphere", "band-model", inputs, aerosol=aerosol)  # noqa: E731
        yield (
            f"band-model-{aerosol}",
            "atmosphere",
            f"band model, aerosol {aerosol}",
            kit("atmosphere", band, standard_air),
        )
    table = lambda inputs: builtin("atmosphere", "table", inputs)  # noqa: E731
    yield "table", "atmosphere", "tabulated transmittance to space", kit("atmosphere", table, standard_air)
    for depth in (0.0, 0.3, 5.0):
        grey = lambda inputs, depth=depth: hcss_author.PlainGas(inputs.profile, depth)  # noqa: E731
        yield f"grey-gas-{depth:g}", "atmosphere", f"grey gas of depth {depth:g}", kit("atmosphere", grey)
    glowing = lambda inputs: GlowingGas(inputs.profile)  # noqa: E731
    yield "glowing-gas", "atmosphere", "grey gas with its own path radiance", kit("atmosphere", glowing)
    for depth in (0.5, 5.0):
        parameters = atmosphere.Parameters(depth=depth)
        malkmus = lambda inputs, parameters=parameters: atmosphere.Malkmus(inputs, parameters)  # noqa: E731
        yield f"malkmus-{depth:g}", "atmosphere", f"lines that saturate, depth {depth:g}", kit("atmosphere", malkmus)


def _radiance():
    printed = lambda inputs: builtin("radiance", "as-printed", inputs)  # noqa: E731
    known = {"expected_failures": AsPrinted.expected_failures}
    yield "as-printed", "radiance", "the equations as printed", kit("radiance", printed, **known)
    for name in ("physical-two-stream", "physical"):
        model = lambda inputs, name=name: builtin("radiance", name, inputs, **FEW_STREAMS)  # noqa: E731
        yield name, "radiance", "composite paths and a closed energy balance", kit("radiance", model), False
    absorbing = lambda inputs: radiance.Absorbing(inputs, radiance.Parameters())  # noqa: E731
    yield "absorbing", "radiance", "clouds that do not scatter", kit("radiance", absorbing)


def _sensors():
    for name, parameters in {
        "ideal": {},
        "counting": COUNTS,
        "noise-of-a-size": {"noise": "nedt", "nedt": {"mid": 0.1, "long": 0.05}, "fixed_pattern": "row"},
    }.items():
        meter = lambda inputs, parameters=parameters: builtin("sensors", "radiometer", inputs, **parameters)  # noqa: E731
        yield name, "sensors", f"radiometer {name}", kit("sensors", meter)
    lagging = lambda inputs: sensor.Lagging(inputs, sensor.Parameters())  # noqa: E731
    yield "lagging", "sensors", "detectors that keep a part of the last frame", kit("sensors", lagging)
