"""Every key of a scenario, and values on both sides of each of its bounds, from the JSON schemas of the package."""

import math
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from hcss_twin.providers.registry.registry import Registry
from hcss_twin.scenario.reference import json_schema

_BOUNDS = {"minimum": -1, "exclusiveMinimum": -1, "maximum": 1, "exclusiveMaximum": 1}
_RENAMED = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}
"""Bounds of optional numbers that may have a unit, which pydantic does not rename."""

_SECTIONS = {
    **{name: name for name in ("clouds", "sea", "optics", "atmosphere", "radiance", "surfaces")},
    **{"elements": "elements.0", "sensors": "sensor", "variables": "output.derived.0"},
}
_SELECTORS = {"clouds": "generator", "sea": "model", "radiance": "model", "sensors": "model"}

CLOUD = {"type": "stratus", "coverage": 0.5}
COARSE = {"provider": "mie", "parameters": {"radius_nodes": 50, "spectral_step": 0.1, "moments": 16}}
LWIR = {"bands": ["lwir-10.8"]}
PHOTONS = {"noise": "photon", "aperture_diameter": 0.1, "pixel_angle": 1e-4, "integration_time": 1e-3}
PLATFORM = {"platform": {"altitude": 700_000.0}, "motion": {"wind_speed": 3.0}}
OPTICAL = PLATFORM | {
    "platform": {"altitude": 700_000.0, "focal_length": 1.0, "detector_pitch": 1e-5},
    "image": {"rows": 8, "columns": 8},
}
IMAGERY = {"generator": "imagery", "parameters": {"image": "image.npy"}}
SURROGATE = {"generator": "surrogate", "parameters": {"image": "image.npy"}}
STILL = {"motion": {"wind_speed": 0.0}, "image": {"rows": 8, "columns": 8, "pixel_size": 100.0}, "slant": {}}

TRACK = {"temperature": 400.0, "area": 10.0}
RASTER = {"provider": "raster", "parameters": {"file": "raster.nc", "classes": {"0": "sea", "1": "ice"}}}

CONTEXT: dict[str, dict[str, Any]] = {
    "bands.0.limits": {"bands": [{"name": "mine", "limits": [3.5, 4.0]}]},
    "bands.0.center_um": {"bands": [{"name": "mine", "center_um": 4.0, "fwhm_um": 0.2}]},
    "bands.0.fwhm_um": {"bands": [{"name": "mine", "center_um": 4.0, "fwhm_um": 0.2}]},
    "bands.0.name": {"bands": [{"name": "mine", "limits": [3.5, 4.0]}]},
    "bands.0.response": {"bands": [{"name": "mine", "response": "response.csv"}]},
    "bands.0.column": {"bands": [{"name": "mine", "response": "response.csv"}]},
    "bands.0.unit": {"bands": [{"name": "mine", "response": "response.csv"}]},
    "atmosphere.gases": {"atmosphere": {}},
    "atmosphere": {"atmosphere": {}},
    "clouds.layers.0": {"clouds": {"layers": [CLOUD]}} | LWIR,
    "clouds": {"clouds": CLOUD} | LWIR,
    "elements": {"elements": [{"provider": "point-sources", "parameters": {"tracks": [TRACK]}}]},
    "image.window": {"image": {"rows": 8, "columns": 8}},
    "optics": {"clouds": CLOUD} | LWIR | {"optics": COARSE},
    "output.derived": {"output": {"derived": []}},
    "platform": PLATFORM,
    "platform.off_nadir": PLATFORM | {"view": {"azimuth": 10.0}},
    "platform.focal_length": OPTICAL,
    "platform.detector_pitch": OPTICAL,
    "platform.mode": {"platform": {"altitude": 700_000.0}, "motion": {"wind_speed": 3.0}},
    "motion.platform_speed": {"platform": {"altitude": 700_000.0}},
    "sea": {"sea": {"temperature": 290.0, "wind_speed": 8.0}},
    "sea.temperature": {"sea": {"model": "cox-munk", "wind_speed": 8.0}},
    "sea.wind_speed": {"sea": {"temperature": 290.0}},
    "sensor.name": {"bands": ["lwir-10.8"], "sensor": {}, "image": {"rows": 8, "columns": 8, "pixel_size": 100.0}},
    "output.quantization": {"output": {"variables": ["radiance"]}, "accuracy": 0.1},
    "sensor": {"sensor": {"parameters": {}}, "image": {"rows": 8, "columns": 8, "pixel_size": 100.0}} | LWIR,
    "sensor.stages": {"sensor": {"stages": [{}]}} | LWIR,
    "slant": {"clouds": CLOUD | {"coverage_mode": "field"}, "place": {"latitude": 20.0, "longitude": 0.0}},
    "surfaces": {"surfaces": {"provider": "coast"}, "place": {"latitude": 40.0, "longitude": 5.0}},
}  # fmt: skip
"""Sections that a key needs, by the beginning of its name; the longest beginning counts."""

EXAMPLES: dict[str, list[Any]] = {
    "title": ["A title", ""],
    "time": ["2024-04-20T12:30:00Z", "1950-01-01T00:00:00-05:00"],
    "image.window.rows": [[0, 4]],
    "image.window.columns": [[2, 8]],
    "motion.platform_speed": [-1e5, 1e5, "orbit"],
    "motion.evolution_time": [1e-3, 1e12, "1 h", "by-scale"],
    "bands": [["mwir"], ["lwir-10.8", [3.5, 4.0]]],
    "bands.0.limits": [[3.5, 4.0], [0.75, 14.0]],
    "bands.0.name": ["a-name"],
    "bands.0.response": ["response.csv"],
    "bands.0.column": ["response"],
    **{f"atmosphere.gases.{gas}": [1e-6, 1.5, "1 ppm"] for gas in ("CO2", "CH4", "N2O", "CO")},
    "atmosphere.gases.O3": [1e-6, 1.5, "300 DU"],
    "radiance.light": ["auto", "columns"],
    "atmosphere.provider": ["band-model", "table"],
    "atmosphere.profile": ["tropical", "profile.csv"],
    "atmosphere.profile_above": ["us-standard-1976"],
    "atmosphere.parameters": [{"aerosol": "rural"}],
    "clouds.type": ["stratus", "cirrus"],
    "clouds.generator": ["fractal"],
    "clouds.material": ["ice", "water"],
    "clouds.optics.provider": ["bulk", "mie"],
    "clouds.optics.parameters": [{"phase_function": "henyey-greenstein"}],
    "clouds.parameters": [{"gamma": 2.0}, {"H": 0.4}],
    "clouds.layers": [[CLOUD], []],
    "sea.model": ["rough-sea", "cox-munk"],
    "sea.parameters": [{"water_index": "water"}],
    "optics.provider": ["bulk", "mie"],
    "optics.parameters": [{"phase_function": "henyey-greenstein"}],
    "radiance.model": ["as-printed", "physical-two-stream"],
    "radiance.parameters": [{"glint_scale": 0.5}],
    "elements": [[]],
    "elements.0.provider": ["point-sources"],
    "elements.0.parameters": [{"tracks": [TRACK]}],
    "surfaces.provider": ["coast"],
    "surfaces.parameters": [{"land": "forest"}],
    "output.variables": [["radiance"], ["all"]],
    "output.derived": [[]],
    "output.derived.0.provider": ["none"],
    "output.derived.0.parameters": [{}],
    "sensor.name": ["landsat-8-tirs"],
    "sensor.model": ["radiometer"],
    "sensor.parameters": [PHOTONS, {"noise": "nedt", "nedt": 0.1}],
    "sensor.seed": [7],
    "sensor.variables": [["all"], []],
    "sensor.stages": [[{"parameters": {"psf": "gaussian", "psf_sigma": 0.5}}, {}]],
    "sensor.stages.0.name": ["landsat-8-tirs"],
    "sensor.stages.0.model": ["radiometer"],
    "sensor.stages.0.parameters": [PHOTONS],
    "sensor.stages.0.seed": [3],
    "sweep": [{"seed": [1, 2]}],
    "clouds.parameters.L of fractal": [[8.0, 6.0]],
    "clouds.parameters.k of fractal": [[0, 0], [16, 16]],
    "clouds.parameters.variable of imagery": ["a"],
    "clouds.parameters.image of imagery": ["image.npy"],
    "clouds.parameters.entry of imagery": ["entry.nc"],
    "clouds.parameters.at of imagery": [{"time": 1}],
    "clouds.parameters.cloud_pixels of imagery": [[9, 900]],
    "clouds.parameters.limits_um of imagery": [[3.8, 4.0]],
    "clouds.parameters.limits_um of surrogate": [[3.8, 4.0]],
    "clouds.parameters.variable of surrogate": ["a"],
    "clouds.parameters.image of surrogate": ["image.npy"],
    "sea.parameters.water_index of cox-munk": ["water"],
    "sea.parameters.water_index of rough-sea": ["water"],
    "optics.parameters.water_index of bulk": ["water"],
    "optics.parameters.ice_index of bulk": ["ice"],
    "optics.parameters.ice_table of bulk": ["ice-yang-2013"],
    "optics.parameters.water_index of mie": ["water"],
    "optics.parameters.ice_index of mie": ["ice"],
    "atmosphere.parameters.file of band-model": ["band-model-rrtmgp"],
    "atmosphere.parameters.file of table": ["us-standard-1976-lowtran7"],
    "radiance.parameters.leave_out of physical": [["path_scattered_sun"]],
    "radiance.parameters.leave_out of physical-two-stream": [["sea_reflected_sun"]],
    "elements.0.parameters.tracks of point-sources": [[TRACK], []],
    "elements.0.parameters.tracks.0.x of point-sources": [10.0],
    "elements.0.parameters.tracks.0.y of point-sources": [-10.0],
    "elements.0.parameters.tracks.0.velocity of point-sources": [[3.0, 0.0, 0.0]],
    "elements.0.parameters.tracks.0.path of point-sources": [[[0.0, 0.0, 0.0, 0.0], [1e3, 10.0, 0.0, 0.0]]],
    "elements.0.parameters.tracks.0.intensity of point-sources": [5.0],
    "elements.0.parameters.file of point-sources": ["tracks.csv"],
    "surfaces.parameters.land of coast": ["forest"],
    "surfaces.parameters.file of raster": ["raster.nc"],
    "surfaces.parameters.classes of raster": [{"0": "sea", "1": "ice"}],
    "surfaces.parameters.class_layer of raster": ["surface_class"],
    "surfaces.parameters.temperature_layer of raster": ["temperature"],
    "surfaces.parameters.temperatures of raster": [{"ice": 260.0}],
    "sensor.parameters.psf_file of radiometer": ["psf.txt"],
    "sensor.parameters.transmission of radiometer": [0.8],
    "sensor.parameters.nedt of radiometer": [0.1],
    "sensor.parameters.nedt_temperature of radiometer": [290.0],
    "sensor.parameters.ner of radiometer": [0.01],
    "sensor.parameters.quantum_efficiency of radiometer": [0.7],
    "sensor.parameters.offset_radiance of radiometer": [0.01],
    "sensor.parameters.saturation_radiance of radiometer": [50.0],
    "sensor.parameters.radiance_per_number of radiometer": [0.01],
    "sensor.parameters.saturation_temperature of radiometer": [330.0],
    "sensor.parameters.drift of radiometer": [0.1, "-50 mK"],
    "instrument": ["generic-mwir"],
    "instrument.name": ["modis"],
    "instrument.model": ["radiometer"],
    "instrument.parameters": [{"gain_deviation": 0.01}],
    "instrument.response": ["response.csv"],
    "instrument.response_column": ["response"],
    "instrument.jitter": [0.2, "0.3 px"],
}
"""Values of keys that are no numbers, choices or switches."""

EXAMPLES |= {
    f"instrument.{key.removeprefix('sensor.parameters.').removesuffix(' of radiometer')}": value
    for key, value in EXAMPLES.items()
    if key.startswith(("sensor.parameters.", "bands")) and (" of " in key or key.startswith("bands"))
}


COMPANIONS: dict[tuple[str, Any], dict[str, Any]] = {
    ("sensor.parameters.psf", "gaussian"): {"sensor.parameters.psf_sigma": 1.0},
    ("sensor.parameters.psf", "airy"): {f"sensor.parameters.{name}": PHOTONS[name] for name in PHOTONS if "_" in name},
    ("sensor.parameters.psf", "file"): {"sensor.parameters.psf_file": "psf.txt"},
    ("sensor.parameters.noise", "photon"): {f"sensor.parameters.{name}": value for name, value in PHOTONS.items()},
    ("sensor.parameters.noise", "nedt"): {"sensor.parameters.nedt": 0.1},
    ("sensor.parameters.noise", "ner"): {"sensor.parameters.ner": 0.01},
    ("radiance.parameters.sun_streams", 2): {
        f"radiance.parameters.{name}": 4 for name in ("azimuth_modes", "sun_moments")
    },
    ("radiance.parameters.sun_moments", 128): {"radiance.parameters.sun_streams": 64},
    ("radiance.parameters.azimuth_modes", 128): {"radiance.parameters.sun_streams": 64},
    ("atmosphere.inversion.height", 200): {"atmosphere.inversion.cloud_base": 150.0},
    ("atmosphere.inversion.cloud_base", 3000): {"atmosphere.inversion.height": 3000.0},
    **{
        (f"{layer}.top", 1e-3): {f"{layer}.base": 0.0, f"{layer}.thickness_min": 1e-3}
        for layer in ("clouds", "clouds.layers.0")
    },
}
"""Other keys without which a value of a key is refused."""

COMPANIONS |= {
    (key.replace("sensor.parameters", "instrument"), value): {
        name.replace("sensor.parameters", "instrument"): each for name, each in more.items()
    }
    for (key, value), more in COMPANIONS.items()
    if key.startswith("sensor.parameters")
}


@dataclass(frozen=True)
class Trial:
    """A value of a key.

    ``side`` is ``inside`` or ``outside`` of the bound ``end`` (``lower`` or ``upper``); values of keys without bounds
    have ``end`` ``""``. ``context`` has the sections that the key needs.
    """

    key: str
    value: Any
    end: str = ""
    side: str = "inside"
    context: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self):
        """Return what is counted: a key, or one side of a bound."""
        return f"{self.key} {self.side} {self.end}" if self.end else self.key


TOGETHER = 4
"""Most values beyond bounds of one scenario."""


def groups():
    """Return the trials by scenario: one inside of its bounds, or a few beyond theirs that need the same sections."""
    every, _ = trials()
    outside: dict[Any, list[Trial]] = {}
    for trial in every:
        if trial.side == "outside":
            outside.setdefault((repr(trial.context), trial.end), []).append(trial)
    inside = [[trial] for trial in every if trial.side == "inside"]
    beyond = [own[at : at + TOGETHER] for own in outside.values() for at in range(0, len(own), TOGETHER)]
    return inside, beyond


@cache
def trials():
    """Return the trials of all keys, and the keys without any."""
    found, without = [], []
    entries = list(leaves(json_schema(), "")) + list(parameters_of())
    for key in dict.fromkeys(key for key, *_ in entries):
        own = [each for name, leaf, context in entries if name == key for each in _of_key(key, leaf, context)]
        example = EXAMPLES.get(key, EXAMPLES.get(key.replace("clouds.layers.0.", "clouds."), []))
        context = next((given for name, _, given in entries if name == key and given is not None), context_of(key))
        own += [Trial(key, value, context=context) for value in example]
        found += own
        if not own:
            without.append(key)
    return found, without


def _of_key(key, leaf, context):
    context = context_of(key) if context is None else context
    leaf = {_RENAMED.get(name, name): value for name, value in leaf.items()}
    for name, sign in _BOUNDS.items():
        if name in leaf:
            bound, whole = leaf[name], leaf["type"] == "integer"
            step = 1 if whole else None
            beyond = bound + sign if whole else math.nextafter(float(bound), sign * math.inf)
            within = bound - sign * step if whole else bound - sign * (1e-6 * abs(bound) or 1e-6)
            end = "lower" if sign < 0 else "upper"
            is_open = name.startswith("exclusive")
            yield Trial(key, within if is_open else bound, end, "inside", context)
            yield Trial(key, bound if is_open else beyond, end, "outside", context)
    values = leaf.get(
        "enum", [leaf["const"]] if "const" in leaf else [False, True] if leaf.get("type") == "boolean" else []
    )
    for value in values:
        yield Trial(key, value, context=context)


def context_of(key):
    fitting = [name for name in CONTEXT if f"{key}.".startswith(f"{name}.")]
    return CONTEXT[max(fitting, key=len)] if fitting else {}


def leaves(entry, path, definitions=None):
    """Yield key, JSON schema and None for each value of a schema."""
    definitions = entry.get("$defs", {}) if definitions is None else definitions
    if "$ref" in entry:
        yield from leaves(definitions[entry["$ref"].rpartition("/")[2]], path, definitions)
    elif "properties" in entry:
        for name, each in entry["properties"].items():
            yield from leaves(each, f"{path}.{name}".lstrip("."), definitions)
    elif "anyOf" in entry or "oneOf" in entry:
        for each in entry.get("anyOf", entry.get("oneOf")):
            yield from leaves(each, path, definitions)
    elif entry.get("type") == "array":
        yield path, {"type": "array"}, None
        items = entry.get("items")
        if isinstance(items, dict):
            yield from (leaf for leaf in leaves(items, f"{path}.0", definitions) if leaf[0] != f"{path}.0")
    elif entry.get("type") != "null":
        yield path, entry, None


def parameters_of(distribution="hcss-twin"):
    """Yield the same for the parameters of providers (None: of all packages), with the section that selects them."""
    registry = Registry.discover()
    for entry in registry.entries():
        model = registry.parameters_model(entry)
        if (
            model is None
            or str(entry.kind) not in _SECTIONS
            or entry.distribution != (distribution or entry.distribution)
        ):
            continue
        section = _SECTIONS[str(entry.kind)]
        context = context_of(section) | _PROVIDERS.get(entry.name, {})
        for key, leaf, _ in leaves(model.model_json_schema(), f"{section}.parameters"):
            own = _PARAMETERS.get(f"{entry.name} {key.rpartition('.')[2]}", {})
            merged = _with_provider(context, section, entry, own)
            yield f"{key} of {entry.name}", leaf, merged


ASH = Path(__file__).parents[2] / "plugins/hcss-examples/scenarios/ash-type.toml"

_PROVIDERS: dict[str, dict[str, Any]] = {
    "imagery": STILL | {"clouds": CLOUD | IMAGERY},
    "surrogate": STILL | {"clouds": CLOUD | SURROGATE},
    "bulk": {"clouds": CLOUD},
    "mie": {"clouds": CLOUD},
    "ash": {"clouds": CLOUD | {"type": str(ASH)}},
    "raster": {"surfaces": RASTER, "place": {"latitude": 35.0, "longitude": 150.0}, "view": {"zenith": 0.0}} | STILL,
}
_PHOTON = (
    *("integration_time", "smear", "photon_temperature", "shot_noise", "read_noise", "dark_current", "transmission"),
    *("fixed_pattern", "offset_electrons", "well_depth", "electrons_per_number", "quantum_efficiency"),
    *("aperture_diameter", "pixel_angle"),
)
_PARAMETERS: dict[str, dict[str, Any]] = {
    **{f"radiometer {name}": PHOTONS for name in _PHOTON},
    "radiometer fixed_pattern": PHOTONS | {"gain_deviation": 0.01},
    "radiometer electrons_per_number": PHOTONS | {"well_depth": 1e5, "bits": 12},
    "radiometer psf_sigma": {"psf": "gaussian"},
    "radiometer psf_file": {"psf": "file"},
    "radiometer nedt": {"noise": "nedt"},
    "radiometer nedt_temperature": {"noise": "nedt", "nedt": 0.1},
    "radiometer ner": {"noise": "ner"},
    "radiometer bits": {"saturation_radiance": 50.0},
    "radiometer radiance_per_number": {"bits": 12, "saturation_radiance": 50.0},
    "radiometer optics_temperature": PHOTONS | {"transmission": 0.8},
    "radiometer housing_temperature": PHOTONS | {"housing_etendue": 0.5},
    "radiometer housing_etendue": PHOTONS | {"housing_temperature": 290.0},
    "radiometer drift": {"calibration_cycle": 600.0},
    "radiometer calibration_cycle": {"drift": 0.1},
    "radiometer number_offset": {"bits": 24, "saturation_radiance": 50.0},
    "imagery window_pixels": {"method": "local"},
    "surrogate window_pixels": {"method": "local"},
    "imagery variable": {"image": "image.npz"},
    "surrogate variable": {"image": "image.npz"},
    "imagery at": {"image": "stack.nc"},
    "imagery entry": {"image": None},
    "imagery turned": {"image": None, "entry": "entry.nc", "placement": "single-clouds"},
    "imagery cloud_pixels": {"image": None, "entry": "entry.nc", "placement": "single-clouds"},
    "imagery placement": {"image": None, "entry": "entry.nc"},
    "rough-sea fetch_m": {"spectrum": "jonswap"},
    "band-model wind_24h_m_s": {"aerosol": "navy-maritime"},
    "band-model air_mass_character": {"aerosol": "navy-maritime"},
    "raster temperature_layer": {"classes": {"0": "sea", "1": "ice"}},
}
"""Parameters that a parameter needs."""


_ALONE = {"sensor": {}, "platform": {}, "frames": {"interval": 1e4}} | LWIR
_ALONE |= {"image": {"rows": 8, "columns": 8, "pixel_size": 100.0}}
_OF_INSTRUMENT = {
    **{name.removeprefix("radiometer "): own for name, own in _PARAMETERS.items() if name.startswith("radiometer ")},
    "cold_shield": PHOTONS | {"f_number": 1000.0, "housing_temperature": 290.0},
}
CONTEXT |= {
    "instrument": _ALONE | {"instrument": {}},
    "instrument.name": {name: each for name, each in _ALONE.items() if name != "bands"} | {"instrument": {}},
    **{f"instrument.{name}": _ALONE | {"instrument": own} for name, own in _OF_INSTRUMENT.items()},
    **{
        f"instrument.{side}": _ALONE | {"instrument": {}, "image": {"pixel_size": 100.0}}
        for side in ("rows", "columns")
    },
    **{f"instrument.{key}": _ALONE | {"instrument": own} for key, own in CONTEXT.items() if key.startswith("bands.")},
}


def _with_provider(context, section, entry, own):
    kind = str(entry.kind)
    top = section.partition(".")[0]
    old = context.get(top, {})
    old = old[0] if isinstance(old, list) else old
    usual = old.get("parameters", {}) if entry.distribution == "hcss-twin" else {}
    parameters = {name: value for name, value in {**usual, **own}.items() if value is not None}
    new = {**old, _SELECTORS.get(kind, "provider"): entry.name, "parameters": parameters}
    return {**context, top: [new] if section.endswith(".0") else new}
