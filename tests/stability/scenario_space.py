"""Strategies that draw valid scenarios over the whole space of what the keys allow."""

from datetime import datetime, timedelta, timezone

import numpy as np
from hypothesis import strategies as st

from hcss_twin.cube.variables import VARIABLES
from hcss_twin.physics.viewing import slant_range_m, view_zenith_deg

CLOUD_TYPES = ("cirrus", "cumulus", "simulated", "stratocumulus", "stratus", "fog", "deep-convection")
CATALOG_BANDS = ("mwir-3.7", "mwir-4.2-4.4", "mwir-3.4-4.1", "lwir-8.5", "lwir-9.7", "lwir-10.8", "swir-2.7-3.0")
# The mask of shadows is an error without them; the groups bring it.
VARIABLE_NAMES = (*(spec.name for spec in VARIABLES if spec.name != "shadow_mask"), "terms", "truth", "all")


def numbers(low, high, **options):
    return st.floats(low, high, allow_nan=False, **options)


def log_numbers(low, high):
    exponents = numbers(np.log10(low), np.log10(high))
    return st.one_of(exponents.map(lambda x: float(np.clip(10**x, low, high))), st.sampled_from([low, high]))


azimuths = numbers(0, 360, exclude_max=True)


@st.composite
def bands(draw):
    low = draw(numbers(2.5, 15.9))
    width = draw(st.sampled_from([0.001, 0.002, 0.02, 0.3]))
    return draw(st.one_of(st.sampled_from(CATALOG_BANDS), st.just([low, low + width])))


@st.composite
def layers(draw):
    base, depth = draw(numbers(0, 12_000)), draw(log_numbers(0.01, 7_000))
    low, high = sorted((draw(st.integers(0, 6)), draw(st.integers(0, 6))))
    shape = {
        "gamma": draw(numbers(1.01, 8)),
        "H": draw(numbers(0.01, 0.99)),
        "L": [draw(log_numbers(1e-3, 1e3)), draw(log_numbers(1e-3, 1e3))],
        "k": [low, high],
    }
    optional = {
        "base": base,
        "top": base + depth,
        "thickness_min": depth * draw(numbers(1e-3, 1)),
        "anchor": draw(st.sampled_from(["base", "top"])),
        "temperature": draw(numbers(150, 350)),
        "parameters": draw(st.sampled_from([shape, {"gamma": shape["gamma"]}, {"H": shape["H"]}, {"k": shape["k"]}])),
    }
    kept = draw(st.sets(st.sampled_from(list(optional))))
    return {
        "type": draw(st.sampled_from(CLOUD_TYPES)),
        "coverage": draw(st.one_of(numbers(0, 1), st.sampled_from([0.0, 1.0, 1e-9]))),
        **{key: optional[key] for key in kept},
    }


@st.composite
def pairs(draw):
    """Two layers, one above the other, in either order; they may touch."""
    low, high = draw(layers()), draw(layers())
    base, depth = draw(numbers(0, 6_000)), draw(log_numbers(0.01, 3_000))
    gap, height = draw(st.one_of(st.just(0.0), numbers(0, 3_000))), draw(log_numbers(0.01, 7_000))
    above = base + depth + gap
    for layer, bottom, top in ((low, base, base + depth), (high, above, above + height)):
        layer |= {"base": bottom, "top": top, "thickness_min": (top - bottom) * draw(numbers(1e-3, 1))}
    return {"layers": draw(st.permutations([low, high]))}


@st.composite
def radiances(draw, models):
    """A radiance model and some of its parameters."""
    model = draw(st.sampled_from(models))
    if model == "as-printed":
        parameters = {
            "glint_scale": draw(numbers(0, 10)),
            "cloud_sun_scale": draw(numbers(0, 10)),
            **{f"literal_eq{n}": draw(st.booleans()) for n in (14, 18, 19, 20)},
        }
    else:
        # Few streams: what is held against limits here is not their accuracy.
        sun_streams = draw(st.integers(2, 6))
        parameters = {
            "streams": draw(st.integers(2, 6)),
            "closure_order": draw(st.integers(0, 1)),
            "sun_streams": sun_streams,
            "azimuth_modes": draw(st.integers(1, 2 * sun_streams)),
            "cloud_temperature": draw(st.sampled_from(["profile", "isothermal-top"])),
        }
    return {"model": model, "parameters": parameters}


@st.composite
def sections(draw, models):
    """Every section of a valid scenario, over the whole allowed space, but of few pixels."""
    zone = timezone(timedelta(minutes=draw(st.integers(-14 * 60, 14 * 60))))
    # Now and then any year, and a series as long as the keys allow.
    extreme = draw(st.integers(0, 19)) == 7
    years = (1, 9999) if extreme else (1900, 2100)
    time = draw(st.datetimes(datetime(years[0], 1, 1), datetime(years[1], 12, 31))).replace(tzinfo=zone)
    return {
        "seed": draw(st.one_of(st.integers(0, 100), st.integers(0, 2**63 - 1))),
        "accuracy": draw(log_numbers(1e-4, 0.1)),
        "time": time,
        "place": {
            "latitude": draw(st.one_of(numbers(-90, 90), st.sampled_from([-90.0, 90.0]))),
            "longitude": draw(st.one_of(numbers(-180, 360), st.sampled_from([-180.0, 360.0]))),
        },
        "view": {"zenith": draw(st.one_of(numbers(0, 85), st.sampled_from([0.0, 85.0]))), "azimuth": draw(azimuths)},
        "image": {
            "rows": draw(st.integers(1, 8)),
            "columns": draw(st.integers(1, 8)),
            "pixel_size": draw(log_numbers(0.01, 1e5)),
            "samples_per_pixel": draw(st.sampled_from([1, 1, 2, 3, 64])),
        },
        "frames": {
            "count": draw(st.integers(1, 2)),
            "interval": draw(log_numbers(1e-3, 1e6 if extreme else 100)),
            "first": draw(st.one_of(st.integers(0, 10), st.integers(0, 10_000_000))),
        },
        "motion": {
            "platform_speed": draw(st.one_of(numbers(-1e5, 1e5), st.just(7500.0))),
            "wind_speed": draw(numbers(0, 150)),
            "wind_from": draw(azimuths),
            "evolution_time": draw(st.one_of(st.just("frozen"), log_numbers(1e-3, 1e12))),
        },
        "bands": draw(st.lists(bands(), min_size=1, max_size=2, unique_by=str)),
        "clouds": draw(st.one_of(layers(), layers(), pairs(), st.just({}))),
        "slant": {name: draw(st.sampled_from(["auto", "on", "off"])) for name in ("shadows", "parallax")},
        "sea": {
            "model": draw(st.sampled_from(["cox-munk", "rough-sea"])),
            "temperature": draw(numbers(260, 330)),
            "wind_speed": draw(st.one_of(numbers(0, 60), st.sampled_from([0.0, 60.0]))),
            "wind_from": draw(azimuths),
        },
        "optics": {"provider": draw(st.sampled_from(["mie", "bulk"]))},
        "radiance": draw(radiances(models)),
        "output": {
            "variables": draw(st.lists(st.sampled_from(VARIABLE_NAMES), min_size=1, max_size=4)),
            "compression": draw(st.sampled_from([0, 0, 0, 1, 9])),
        },
    }


PAPER = ("as-printed",)
"""The model that takes least."""
PHYSICAL = ("physical", "physical-two-stream")


@st.composite
def scenarios(draw, models=PAPER):
    """A valid scenario that leaves out any of the sections that may be left out."""
    whole = draw(sections(models))
    needed = ("time", "place", "image", "frames", "bands", "radiance")
    left_out = draw(st.sets(st.sampled_from([key for key in whole if key not in needed]), max_size=3))
    return {key: value for key, value in whole.items() if key not in left_out}


PROFILES = ("tropical", "midlatitude-winter", "subarctic-winter", "us-standard-1976", "ascent.csv")
SHAPES = ((1, 1), (1, 4096), (4096, 1), (2, 700), (70, 3), (5, 5))
"""Rows and columns of images beside small ones."""


def write_files(folder):
    """Write the files that :func:`wide_scenarios` names; returns the folder."""
    random = np.random.default_rng(5)
    for name, low, high in RESPONSES:
        wavelength = np.linspace(low, high, 9)
        response = np.concatenate([[0.0], random.random(7), [0.0]])
        rows = [f"{x!r},{y!r}" for x, y in zip(wavelength.tolist(), response.tolist(), strict=True)]
        (folder / f"{name}.csv").write_text("\n".join(["wavelength_um,response", *rows]))
    levels = (
        "1013.2,17.3,80",
        "925,11.8,75",
        "850,7.9,48",
        "700,-1,30",
        "500,-16.4,22",
        "300,-42.6,25",
        "200,-55,10",
        "100,-60,3",
    )
    head = "pressure_hPa,temperature_C,relative_humidity_percent"
    (folder / "ascent.csv").write_text("\n".join([head, *levels]))
    (folder / "psf.txt").write_text("0.1 0.2 0.1\n0.2 1.0 0.3\n0.0 0.2 0.1\n")
    np.save(folder / "image.npy", random.random((96, 90)).cumsum(axis=0).cumsum(axis=1) % 37.0)
    return folder


RESPONSES = (("narrow", 3.7, 3.701), ("wide", 0.75, 2.5), ("long-wave", 8.1, 14.2))


@st.composite
def wide_bands(draw):
    """Anywhere from 0.7 um (the band model begins at 14285 cm-1) to 14.3 um, of 1 nm and more."""
    kind = draw(st.sampled_from(["limits", "limits", "limits", "name", "response"]))
    if kind == "name":
        return draw(st.sampled_from(CATALOG_BANDS))
    if kind == "response":
        name = draw(st.sampled_from(RESPONSES))[0]
        return {"name": name, "response": f"{name}.csv"}
    width = draw(st.sampled_from([0.001, 0.001, 0.01, 0.3]))
    low = draw(st.one_of(numbers(0.7001, 14.3 - width), st.sampled_from([0.7001, 14.3 - width])))
    return [low, low + width]


@st.composite
def airs(draw):
    """An atmosphere, with all that may be said about it."""
    if draw(st.integers(0, 5)) == 0:
        return {"provider": "table"}
    chosen = {"provider": "band-model", "profile": draw(st.sampled_from(PROFILES))}
    amount = draw(st.sampled_from([None, "water_vapour_scale", "water_vapour_column"]))
    if amount is not None:
        # Most profiles cannot hold ten times their water vapour: that is refused.
        chosen[amount] = draw(numbers(0, 1.2) if amount == "water_vapour_scale" else numbers(0, 10))
    if amount != "water_vapour_column" and draw(st.integers(0, 3)) == 0:
        chosen["inversion"] = draw(inversions())
    chosen["parameters"] = {
        "aerosol": draw(st.sampled_from(["none", "maritime", "rural", "urban"])),
        "visibility_km": draw(st.one_of(numbers(2, 50), st.sampled_from([2.0, 50.0]))),
        "season": draw(st.sampled_from(["spring-summer", "fall-winter"])),
    }
    return chosen


@st.composite
def inversions(draw):
    """A trade inversion of any height and strength; over warm air the strongest are refused."""
    height = draw(numbers(200, 3000))
    return {
        "height": height,
        "strength": draw(st.one_of(numbers(0, 25), st.just(25.0))),
        "cloud_base": height * draw(st.one_of(numbers(0, 1), st.sampled_from([0.0, 1.0]))),
        "humidity_above": draw(numbers(0.01, 1)),
        "surface_temperature": draw(numbers(250, 310)),
    }


@st.composite
def seas(draw):
    """A sea, with all that may be said about it."""
    sea = {
        "model": draw(st.sampled_from(["cox-munk", "rough-sea"])),
        "temperature": draw(numbers(263.15, 318.15)),
        "wind_speed": draw(st.one_of(numbers(0, 60), st.sampled_from([0.0, 60.0]))),
        "wind_from": draw(azimuths),
        "waves": "off",
    }
    if sea["model"] == "rough-sea":
        sea["waves"] = draw(st.sampled_from(["off", "off", "auto", "on"]))
        sea["parameters"] = {
            "salinity_psu": draw(numbers(0, 45)),
            "slopes": draw(st.sampled_from(["isotropic", "upwind-crosswind"])),
            "shadowing": draw(st.sampled_from(["none", "separable", "height-correlated"])),
            "re_reflection": draw(st.booleans()),
            "foam": draw(st.booleans()),
            "foam_emissivity": draw(numbers(0, 1)),
            "spectrum": draw(st.sampled_from(["pierson-moskowitz", "jonswap"])),
            "fetch_m": draw(log_numbers(1e3, 2e6)),
        }
    return sea


@st.composite
def wide_layers(draw, particles):
    """A layer of any generator, taper, mode of coverage and particles."""
    layer = draw(layers())
    if not {"base", "top"} <= set(layer):
        for key in ("base", "top", "thickness_min"):
            layer.pop(key, None)
    layer["coverage_mode"] = draw(st.sampled_from(["frame", "field"]))
    layer["edge_taper"] = draw(st.one_of(st.just(0.0), numbers(0, 1)))
    generator = draw(st.sampled_from(["fractal", "fractal", "imagery", "imagery"]))
    if generator != "fractal":
        layer |= {"generator": generator, "edge_taper": 0.0, "coverage_mode": "frame"}
        layer["parameters"] = {"image": "image.npy", "method": draw(st.sampled_from(["otsu", "local", "coverage"]))}
        if layer["parameters"]["method"] != "coverage":
            layer.pop("coverage")
    elif "parameters" in layer:
        layer["parameters"] = layer["parameters"] | {"brightness_exponent": draw(log_numbers(0.05, 20))}
    if particles:
        optional = {
            "material": draw(st.sampled_from(["water", "ice"])),
            # Few values, because each is a table of optics that takes seconds.
            "effective_radius": draw(st.sampled_from([4.0, 10.0, 40.0])),
            "effective_variance": 0.1,
            "water_content": draw(log_numbers(1e-6, 100)),
        }
        layer |= {key: optional[key] for key in draw(st.sets(st.sampled_from(list(optional)), max_size=2))}
    return layer


@st.composite
def wide_scenarios(draw, models=PAPER, particles=False):
    """A valid scenario whose surroundings, clouds and image are drawn from the whole space too.

    Files are those of :func:`write_files`.
    """
    raw = draw(scenarios(models))
    raw["bands"] = draw(st.lists(wide_bands(), min_size=1, max_size=2, unique_by=str))
    raw |= {"atmosphere": draw(airs()), "sea": draw(seas())}
    if raw["atmosphere"]["provider"] == "table":  # which begins at 1 um
        raw["bands"] = draw(st.lists(bands(), min_size=1, max_size=2, unique_by=str))
    raw["clouds"] = draw(st.one_of(wide_layers(particles), wide_layers(particles), pairs()))
    if raw["clouds"].get("generator", "fractal") != "fractal":
        # What would leave the image is refused.
        raw["image"] = {"rows": draw(st.integers(1, 60)), "columns": draw(st.integers(1, 60)), "pixel_size": 100.0}
        raw["motion"] = {"wind_speed": 0.0}
    elif draw(st.booleans()):
        rows, columns = draw(st.sampled_from(SHAPES))
        raw["image"] = {"rows": rows, "columns": columns, "pixel_size": draw(log_numbers(0.1, 1e4))}
    if raw["clouds"].get("coverage_mode") != "field":
        raw["slant"] = {}
    if raw["sea"]["waves"] == "off" and "output" in raw:
        kept = [name for name in raw["output"]["variables"] if not name.startswith("sea_slope")]
        raw["output"]["variables"] = kept or ["all"]
    return raw


@st.composite
def sensors(draw):
    """A radiometer whose parameters all have an influence; the file of a point-spread function is written elsewhere."""
    chosen = {"noise": draw(st.sampled_from(["none", "photon", "nedt", "ner"]))}
    chosen["psf"] = draw(st.sampled_from(["none", "gaussian", "airy", "file"]))
    match chosen["psf"]:
        case "gaussian":
            chosen["psf_sigma"] = draw(log_numbers(0.01, 30))
        case "file":
            chosen["psf_file"] = "psf.txt"
    counts = chosen["noise"] == "photon"
    if counts or chosen["psf"] == "airy":
        chosen |= {"aperture_diameter": draw(log_numbers(0.01, 10)), "pixel_angle": draw(log_numbers(1e-7, 0.1))}
    if counts:
        chosen |= {
            "integration_time": draw(log_numbers(1e-6, 10)),
            "smear": draw(st.booleans()),
            "transmission": draw(numbers(0.01, 1)),
            "quantum_efficiency": draw(numbers(0.01, 1)),
            "shot_noise": draw(st.booleans()),
            "read_noise": draw(log_numbers(0.1, 1e4)),
            "dark_current": draw(log_numbers(1, 1e9)),
            "offset_electrons": draw(log_numbers(0.1, 1e4)),
        }
    elif chosen["noise"] != "none":
        chosen[chosen["noise"]] = draw(log_numbers(1e-6, 10))
        if chosen["noise"] == "nedt":
            chosen["nedt_temperature"] = draw(numbers(150, 400))
        chosen["offset_radiance"] = draw(log_numbers(1e-6, 1))
    if draw(st.booleans()):
        chosen |= {"gain_deviation": draw(numbers(0, 1)), "fixed_pattern": draw(st.sampled_from(["pixel", "row"]))}
    match draw(st.sampled_from(["no converter", "full", "full and counted"])):
        case "full and counted":
            chosen["bits"] = draw(st.integers(1, 24))
            chosen["well_depth" if counts else "saturation_radiance"] = draw(
                log_numbers(10, 1e9) if counts else log_numbers(1e-6, 100)
            )
        case "full":
            chosen["well_depth" if counts else "saturation_radiance"] = draw(
                log_numbers(10, 1e9) if counts else log_numbers(1e-6, 100)
            )
    return {"parameters": chosen, "variables": ["all"], "seed": draw(st.integers(0, 2**63 - 1))}


@st.composite
def platforms(draw, raw):
    """Say in other words, with the keys of a platform, where a scenario is seen from; changes it."""
    platform = {"altitude": draw(st.one_of(log_numbers(1e5, 4.2e7), st.just(3.6e7)))}
    view, image, motion = (dict(raw.get(key, {})) for key in ("view", "image", "motion"))
    if draw(st.booleans()):
        view.pop("zenith", None)
        # Beyond some angle the Earth is missed, or seen at more than 85 degrees: that is refused.
        platform["off_nadir"] = draw(numbers(0, 60 if platform["altitude"] < 1e6 else 9))
    if draw(st.booleans()):
        image.pop("pixel_size", None)
        platform |= {"focal_length": draw(log_numbers(0.05, 20)), "detector_pitch": draw(log_numbers(5e-6, 1e-3))}
    if draw(st.booleans()):
        motion.pop("platform_speed", None)
        platform["mode"] = draw(st.sampled_from(["staring", "push-broom"]))
    raw |= {"platform": platform, "view": view, "image": image, "motion": motion}


def agree(raw, parameters):
    """Change the parameters of a sensor that other keys state, too: contradictions are refused."""
    frames, platform = raw.get("frames", {}), raw.get("platform")
    if "integration_time" in parameters and frames.get("count", 8) > 1:
        parameters["integration_time"] = min(parameters["integration_time"], frames.get("interval", 1.0))
    if platform is None or "pixel_angle" not in parameters:
        return
    if "detector_pitch" in platform:
        parameters["pixel_angle"] = platform["detector_pitch"] / platform["focal_length"]
        return
    zenith, altitude = raw["view"].get("zenith", 0.0), platform["altitude"]
    if "off_nadir" in platform:
        zenith = min(view_zenith_deg(platform["off_nadir"], altitude), 85.0)
    parameters["pixel_angle"] = raw["image"].get("pixel_size", 20.0) / slant_range_m(zenith, altitude)


@st.composite
def seen_scenarios(draw, models=PAPER):
    """A scenario with a sensor, a platform or both. The file ``psf.txt`` is that of :func:`write_files`."""
    raw = draw(scenarios(models))
    raw["image"] = {**raw["image"], "samples_per_pixel": draw(st.sampled_from([1, 1, 2]))}
    if draw(st.booleans()):
        draw(platforms(raw))
    raw["sensor"] = draw(sensors())
    agree(raw, raw["sensor"]["parameters"])
    asked = draw(st.sets(st.sampled_from(["brightness_temperature", "cloud_mask", "terms", "cloud_top_altitude"])))
    raw["output"] = {"variables": ["radiance", *sorted(asked)]}
    # Slant paths want more of clouds than most of these have.
    raw.pop("slant", None)
    return raw


def window_of(draw, image):
    """Draw a part of an image."""
    parts = {}
    for key in ("rows", "columns"):
        first = draw(st.integers(0, image[key] - 1))
        parts[key] = [first, draw(st.integers(first + 1, image[key]))]
    return parts
