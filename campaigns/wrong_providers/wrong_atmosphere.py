"""Wrong transmittance providers."""

from dataclasses import replace

import numpy as np
from changed import FRACTION, WAVENUMBER, Changed, Wrong, on_argument, on_result, result

from hcss_twin.physics.paths import SPACE, Path
from hcss_twin.physics.planck import planck


def legs(change):
    """A change of each leg of each path."""
    return lambda paths: [Path(tuple(change(leg) for leg in path.legs)) for path in paths]


def zenith(change):
    return legs(lambda leg: replace(leg, zenith_deg=float(np.clip(change(leg.zenith_deg), 0.0, 89.0))))


def altitudes(change):
    return legs(lambda leg: replace(leg, lower_m=change(leg.lower_m), upper_m=change(leg.upper_m)))


PATHS = {
    "zenith-radians": ("with zenith in radians", zenith(np.radians)),
    "zenith-double": ("with twice the zenith", zenith(lambda x: 2.0 * x)),
    "zenith-half": ("with half the zenith", zenith(lambda x: 0.5 * x)),
    "zenith-dropped": ("as if all were vertical", zenith(lambda x: 0.0)),
    "elevation": ("with elevation for zenith", zenith(lambda x: 90.0 - x)),
    "km": ("with altitudes in km", altitudes(lambda x: 1e-3 * x)),
    "from-km": ("with altitudes taken for km", altitudes(lambda x: 1e3 * x)),
    "feet": ("with altitudes in feet", altitudes(lambda x: 3.28 * x)),
    "altitude-double": ("with twice the altitudes", altitudes(lambda x: 2.0 * x)),
    "altitude-half": ("with half the altitudes", altitudes(lambda x: 0.5 * x)),
    "lower-dropped": ("as if all began at the sea", legs(lambda leg: replace(leg, lower_m=0.0))),
    "upper-dropped": ("as if all legs went to space", legs(lambda leg: replace(leg, upper_m=SPACE))),
    "upper-for-lower": (
        "with the part below the lower end",
        legs(lambda leg: replace(leg, lower_m=0.0, upper_m=leg.lower_m or leg.upper_m)),
    ),
    "first-leg-only": ("without all legs but the first", lambda paths: [Path(path.legs[:1]) for path in paths]),
    "last-leg-only": ("without all legs but the last", lambda paths: [Path(path.legs[-1:]) for path in paths]),
    "legs-twice": ("with each leg twice", lambda paths: [path + path for path in paths]),
    "each-leg-once": ("with equal legs once", lambda paths: [Path(tuple(dict.fromkeys(p.legs))) for p in paths]),
    "one-zenith": (
        "with the zenith of the first leg for all",
        lambda paths: [
            Path(tuple(replace(leg, zenith_deg=path.legs[0].zenith_deg) for leg in path.legs)) for path in paths
        ],
    ),
    "reversed": ("in reverse order", lambda paths: list(paths)[::-1]),
}


def legs_multiplied(provider, inputs):
    """Transmittances of legs are multiplied, instead of one of the whole path."""

    def transmittance(nu, paths):
        each = [[provider.transmittance(nu, [Path((leg,))])[0] for leg in path.legs] for path in paths]
        return np.array([np.prod(one, axis=0) if one else np.ones(nu.size) for one in each])

    return amounts_gone(provider, transmittance=transmittance)


def amounts_gone(provider, **members):
    """A changed provider of the right one's members without its short cut, which would be right."""

    class Plain(Changed):
        def __getattr__(self, name):
            if name in ("absorber_amounts", "transmittance_of_amounts"):
                raise AttributeError(name)
            return super().__getattr__(name)

    return Plain(provider, **members)


def without_amounts(wrong):
    """The same mistake in a provider that knows paths only."""
    wrap = wrong.wrap
    return replace(wrong, wrap=lambda provider, inputs: amounts_gone(wrap(provider, inputs)))


def leg_averaged(provider, inputs):
    def transmittance(nu, paths):
        each = [[provider.transmittance(nu, [Path((leg,))])[0] for leg in path.legs] for path in paths]
        return np.array([np.mean(one, axis=0) if one else np.ones(nu.size) for one in each])

    return amounts_gone(provider, transmittance=transmittance)


AMOUNTS = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "offset": ("with an offset", lambda x: x + 0.1),
    "square": ("squared", np.square),
}

RADIANCE = {
    "per-um": ("per um", lambda nu: nu**2 / 1e4),
    "double": ("doubled", lambda nu: 2.0),
    "half": ("halved", lambda nu: 0.5),
    "hemispherical": ("over the hemisphere, times pi", lambda nu: np.pi),
    "per-cm2": ("per cm2", lambda nu: 1e-4),
    "milliwatt": ("in mW", lambda nu: 1e3),
    "negative": ("with the other sign", lambda nu: -1.0),
}

MISTAKEN_EMISSION = (
    ("transmittance", "has transmittance for absorptance", lambda through, nu, kelvin: through * planck(nu, kelvin[0])),
    ("black", "is that of black air", lambda through, nu, kelvin: planck(nu, kelvin[0]) + 0.0 * through),
    ("celsius", "is of Celsius", lambda through, nu, kelvin: (1.0 - through) * planck(nu, kelvin[0] - 273.15)),
    ("hot", "is of twice the temperature", lambda through, nu, kelvin: (1.0 - through) * planck(nu, 2.0 * kelvin[0])),
    ("zero", "is 0", lambda through, nu, kelvin: 0.0 * through),
    (
        "depth",
        "has optical depth for absorptance",
        lambda through, nu, kelvin: -np.log(through) * planck(nu, kelvin[0]),
    ),
)


def wrong_providers():
    for wrong in on_argument("band-model-none", "transmittance", 1, "paths", PATHS):
        yield without_amounts(wrong)
    for wrong in on_result("band-model-none", "transmittance", FRACTION):
        yield without_amounts(wrong)
    for right in ("band-model-none", "malkmus-5"):
        yield Wrong(f"{right}.legs-multiplied", right, "transmittances of legs are multiplied", legs_multiplied)
        yield Wrong(f"{right}.legs-averaged", right, "transmittances of legs are averaged", leg_averaged)
    for wrong in on_argument("band-model-none", "transmittance", 0, "wavenumber", WAVENUMBER):
        yield without_amounts(wrong)
    yield from on_result("band-model-none", "absorber_amounts", AMOUNTS)
    yield from on_argument("band-model-none", "transmittance_of_amounts", 1, "amounts", AMOUNTS)
    yield from on_argument("band-model-none", "absorber_amounts", 0, "paths", PATHS)
    yield from on_result(
        "band-model-none",
        "transmittance_of_amounts",
        {name: FRACTION[name] for name in ("double", "half", "complement", "square", "transposed")},
    )
    for wrong in on_argument("glowing-gas", "path_radiance", 1, "paths", PATHS):
        if not wrong.name.endswith(("leg-only", "legs-twice", "each-leg-once", "one-zenith")):  # its paths have one leg
            yield wrong
    for name, (words, factor) in RADIANCE.items():
        yield Wrong(
            f"glowing-gas.path_radiance.{name}",
            "glowing-gas",
            f"path_radiance is returned {words}",
            result("path_radiance", lambda value, nu, paths, factor=factor: factor(nu) * value),
        )
    for name, words, change in MISTAKEN_EMISSION:
        wrap = lambda provider, inputs, change=change: Changed(  # noqa: E731
            provider,
            path_radiance=lambda nu, paths: change(provider.transmittance(nu, paths), nu, inputs.profile.temperature_K),
        )
        yield Wrong(f"glowing-gas.path_radiance.{name}", "glowing-gas", f"path_radiance {words}", wrap)
    for name in ("double", "percent", "negative", "complement", "transposed", "rows-reversed", "first-row"):
        words, change = FRACTION[name]
        yield Wrong(
            f"glowing-gas.solar_path_radiance.{name}",
            "glowing-gas",
            f"solar_path_radiance is returned {words}",
            result("solar_path_radiance", lambda value, *given, change=change: change(value)),
        )
