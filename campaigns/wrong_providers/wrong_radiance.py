"""Wrong radiance models."""

from dataclasses import replace

import numpy as np
from changed import Changed, Wrong

from hcss_twin.providers import View

AS_PRINTED = ("cloud_emission", "cloud_reflected_sun", "sea_emission", "sea_reflected_sun", "path_emission")

SPECTRA = {
    "per-um": ("per um", lambda nu: nu**2 / 1e4),
    "per-m": ("per m-1", lambda nu: 0.01),
    "photons": ("in photons", lambda nu: 1.0 / (1.986e-23 * nu)),
    "hemispherical": ("over the hemisphere, times pi", lambda nu: np.pi),
    "over-pi": ("divided by pi", lambda nu: 1.0 / np.pi),
    "double": ("doubled", lambda nu: 2.0),
    "half": ("halved", lambda nu: 0.5),
    "per-cm2": ("per cm2", lambda nu: 1e-4),
    "milliwatt": ("in mW", lambda nu: 1e3),
    "negative": ("with the other sign", lambda nu: -1.0),
}

ARRAYS = {
    "transposed": ("with exchanged axes", lambda x: x.T),
    "first-row": ("the first column for all", lambda x: np.broadcast_to(x[:1], x.shape)),
    "rows-reversed": ("in reverse order", lambda x: x[::-1]),
    "last-row-lost": (
        "without the last column",
        lambda x: x * (np.arange(len(x)) < len(x) - 1)[(...,) + (None,) * (x.ndim - 1)],
    ),
    "spectrum-reversed": ("with a reversed spectrum", lambda x: x[..., ::-1]),
    "first-wavenumber": ("that of the first wavenumber", lambda x: np.broadcast_to(x[..., :1], x.shape)),
}


def changed_terms(change):
    """A wrap that changes all terms; ``change`` maps name, term and wavenumbers to the new term."""

    def wrap(provider, inputs):
        def columns(states, nu):
            return {name: change(name, term, nu) for name, term in provider.columns(states, nu).items()}

        return Changed(provider, columns=columns)

    return wrap


def changed_cloudy(change):
    """A wrap that changes the terms (N, V) of the columns with cloud."""

    def wrap(provider, inputs):
        def columns(states, nu):
            cloudy = np.any(states.thickness_m > 0.0, axis=1)
            return {name: _changed_rows(term, cloudy, change) for name, term in provider.columns(states, nu).items()}

        return Changed(provider, columns=columns)

    return wrap


def _changed_rows(term, rows, change):
    changed = change(term[rows])
    if changed.shape != term[rows].shape:
        return changed
    result = np.array(term)
    result[rows] = changed
    return result


def changed_thickness(change):
    """A wrap that changes the thickness (N, L) of the columns with cloud."""

    def wrap(provider, inputs):
        def columns(states, nu):
            cloudy = np.any(states.thickness_m > 0.0, axis=1)
            return provider.columns(replace(states, thickness_m=_changed_rows(states.thickness_m, cloudy, change)), nu)

        return Changed(provider, columns=columns)

    return wrap


def changed_settings(change):
    """A wrap that changes the setting of each column."""

    def wrap(provider, inputs):
        def columns(states, nu):
            return provider.columns(replace(states, settings=tuple(map(change, states.settings))), nu)

        return Changed(provider, columns=columns)

    return wrap


def changed_sun(change):
    return changed_settings(lambda setting: setting.under(setting.sun and change(setting.sun)))


def changed_spectrum(change):
    return lambda provider, inputs: Changed(provider, columns=lambda states, nu: provider.columns(states, change(nu)))


def of_the_inputs(*names):
    """A wrap that takes parts of the settings from the inputs."""

    def wrap(provider, inputs):
        own = {name: getattr(inputs.setting, name) for name in names}
        return changed_settings(lambda setting: replace(setting, **own))(provider, inputs)

    return wrap


OF_THE_INPUTS = {
    "view": ("the view", ("view",)),
    "sea": ("the sea", ("sea",)),
    "sea-temperature": ("the temperature of the sea", ("sea_temperature_K",)),
    "profile": ("the profile", ("profile",)),
    "transmittance": ("the transmittance", ("transmittance",)),
    "layers": ("the layers", ("layers",)),
}


THICKNESS = {
    "double": ("doubled", lambda z: 2.0 * z),
    "half": ("halved", lambda z: 0.5 * z),
    "km": ("in km", lambda z: 1e-3 * z),
    "cm": ("in cm", lambda z: 100.0 * z),
    "square": ("squared", lambda z: 1e-2 * z**2),
    "dropped": ("ignored, taken for 400 m", lambda z: np.where(z > 0.0, 400.0, 0.0)),
    "rows-reversed": ("of the other columns", lambda z: z[::-1]),
    "root": ("its square root", lambda z: 10.0 * np.sqrt(z)),
}


def sun(**changes):
    return lambda given: replace(given, **{name: change(getattr(given, name)) for name, change in changes.items()})


SUN = {
    "zenith-radians": ("zenith in radians", sun(zenith_deg=np.radians)),
    "zenith-dropped": ("the sun at the zenith", sun(zenith_deg=lambda x: 0.0)),
    "elevation": ("elevation for zenith", sun(zenith_deg=lambda x: 90.0 - x)),
    "zenith-half": ("half the zenith", sun(zenith_deg=lambda x: 0.5 * x)),
    "azimuth-opposite": ("azimuth from the south", sun(azimuth_deg=lambda x: x + 180.0)),
    "azimuth-radians": ("azimuth in radians", sun(azimuth_deg=np.radians)),
    "azimuth-dropped": ("the sun in the north", sun(azimuth_deg=lambda x: 0.0)),
    "azimuth-counterclockwise": ("azimuth counted the other way", sun(azimuth_deg=lambda x: -x)),
    "azimuth-mathematical": ("azimuth counted from the east", sun(azimuth_deg=lambda x: 90.0 - x)),
    "distance-dropped": ("the sun at 1 au", sun(distance_au=lambda x: 1.0)),
    "distance-inverse": ("the inverse distance", sun(distance_au=lambda x: 1.0 / x)),
    "distance-root": ("irradiance in inverse proportion to distance", sun(distance_au=np.sqrt)),
    "distance-m": ("the distance in m", sun(distance_au=lambda x: 1.496e11 * x)),
}


def times(provider, **factors):
    """The same provider with methods whose results are multiplied."""
    members = {
        name: (lambda *given, name=name, factor=factor: factor * getattr(provider, name)(*given))
        for name, factor in factors.items()
    }
    return Changed(provider, **members)


def complement(provider, *names):
    members = {name: (lambda *given, name=name: 1.0 - getattr(provider, name)(*given)) for name in names}
    return Changed(provider, **members)


def view(change):
    return lambda setting: replace(setting, view=change(setting.view))


def layers(**changes):
    def change(setting):
        return replace(
            setting,
            layers=tuple(
                replace(each, **{name: make(getattr(each, name)) for name, make in changes.items()})
                for each in setting.layers
            ),
        )

    return change


def cooler(setting):
    profile = replace(setting.profile, temperature_K=setting.profile.temperature_K - 30.0)
    return replace(setting, profile=profile)


SETTINGS = {
    "sea-celsius": ("the sea 20 K too warm", lambda s: replace(s, sea_temperature_K=s.sea_temperature_K + 20.0)),
    "sea-dropped": ("a sea of 300 K always", lambda s: replace(s, sea_temperature_K=300.0)),
    "sea-of-air": (
        "the air's temperature for the sea",
        lambda s: replace(s, sea_temperature_K=float(s.profile.temperature_K[0])),
    ),
    "air-cold": ("air 30 K too cold", cooler),
    "emissivity-complement": ("1 minus emissivity", lambda s: replace(s, sea=complement(s.sea, "emissivity"))),
    "emissivity-half": ("half the emissivity", lambda s: replace(s, sea=times(s.sea, emissivity=0.5))),
    "brdf-double": ("twice the BRDF", lambda s: replace(s, sea=times(s.sea, brdf=2.0))),
    "brdf-pi": ("pi times the BRDF", lambda s: replace(s, sea=times(s.sea, brdf=np.pi))),
    "brdf-dropped": ("no BRDF", lambda s: replace(s, sea=times(s.sea, brdf=0.0))),
    "absorptance": (
        "absorptance for transmittance",
        lambda s: replace(s, transmittance=complement(s.transmittance, "transmittance")),
    ),
    "transmittance-half": (
        "half the transmittance",
        lambda s: replace(s, transmittance=times(s.transmittance, transmittance=0.5)),
    ),
    "view-radians": ("view zenith in radians", view(lambda v: View(float(np.radians(v.zenith_deg)), v.azimuth_deg))),
    "view-nadir": ("a view from the zenith", view(lambda v: View(0.0, v.azimuth_deg))),
    "view-elevation": ("elevation for zenith of the view", view(lambda v: View(90.0 - v.zenith_deg, v.azimuth_deg))),
    "view-opposite": ("the view from the other side", view(lambda v: View(v.zenith_deg, v.azimuth_deg + 180.0))),
    "view-north": ("a view from the north", view(lambda v: View(v.zenith_deg, 0.0))),
    "cloud-temperature-dropped": ("no cloud temperature of its own", layers(temperature_K=lambda t: None)),
    "cloud-celsius": ("cloud temperature 20 K too warm", layers(temperature_K=lambda t: t and t + 20.0)),
    "cloud-base-km": ("altitudes of clouds in km", layers(base_m=lambda z: 1e-3 * z, top_m=lambda z: 1e-3 * z)),
    "cloud-low": ("clouds at half their altitude", layers(base_m=lambda z: 0.5 * z, top_m=lambda z: 0.5 * z)),
    "particles-double": (
        "twice the particles",
        layers(microphysics=lambda m: replace(m, number_density_m3=2.0 * m.number_density_m3)),
    ),
    "particles-per-cm3": (
        "particles per cm3",
        layers(microphysics=lambda m: replace(m, number_density_m3=1e-6 * m.number_density_m3)),
    ),
    "layers-dropped": (
        "particles of the first layer for all",
        lambda s: (
            replace(s, layers=s.layers)
            if len(s.layers) < 2
            else replace(s, layers=tuple(replace(each, microphysics=s.layers[0].microphysics) for each in s.layers))
        ),
    ),
}


def irradiance(change):
    return lambda inputs: replace(inputs, solar_irradiance=lambda nu: change(inputs.solar_irradiance(nu), nu))


INPUTS = {
    "sun-double": ("twice the irradiance", irradiance(lambda e, nu: 2.0 * e)),
    "sun-per-um": ("the irradiance per um", irradiance(lambda e, nu: e * nu**2 / 1e4)),
    "sun-over-pi": ("the irradiance over pi", irradiance(lambda e, nu: e / np.pi)),
}


def term_changes(right, terms):
    """One term wrong, the others right."""
    for term in terms:
        for name, words, factor in (
            ("double", "doubled", 2.0),
            ("lost", "0", 0.0),
            ("pi", "times pi", np.pi),
            ("negative", "with the other sign", -1.0),
        ):
            yield Wrong(
                f"{right}.term-{term}.{name}",
                right,
                f"the term {term} is {words}",
                changed_terms(
                    lambda own, value, nu, term=term, factor=factor: factor * value if own == term else value
                ),
            )


def wrong_providers():
    right = "as-printed"
    for name, (words, factor) in SPECTRA.items():
        change = lambda own, term, nu, factor=factor: factor(nu) * term  # noqa: E731
        yield Wrong(f"{right}.terms.{name}", right, f"all terms are returned {words}", changed_terms(change))
    for name, (words, each) in ARRAYS.items():
        yield Wrong(f"{right}.cloudy.{name}", right, f"terms of cloudy are returned {words}", changed_cloudy(each))
    for name, (words, each) in THICKNESS.items():
        yield Wrong(f"{right}.thickness_m.{name}", right, f"thickness_m is taken {words}", changed_thickness(each))
    for name, (words, each) in SUN.items():
        yield Wrong(f"{right}.sun.{name}", right, f"sun is taken with {words}", changed_sun(each))
    for name, factor in (("double", 2.0), ("half", 0.5), ("per-m", 100.0)):
        each = lambda nu, factor=factor: factor * nu  # noqa: E731
        yield Wrong(
            f"{right}.wavenumber.{name}", right, f"wavenumber is taken times {factor:g}", changed_spectrum(each)
        )
    um = changed_spectrum(lambda nu: np.sort(1e4 / nu))
    yield Wrong(f"{right}.wavenumber.um", right, "wavenumber is taken in um", um)
    for name, (words, each) in SETTINGS.items():
        yield Wrong(f"{right}.inputs.{name}", right, f"columns are those of {words}", changed_settings(each))
    for name, (words, names) in OF_THE_INPUTS.items():
        yield Wrong(
            f"{right}.states.{name}-dropped", right, f"{words} of the inputs for all columns", of_the_inputs(*names)
        )
    for name, (words, each) in INPUTS.items():
        yield Wrong(f"{right}.inputs.{name}", right, f"the model is made with {words}", inputs=each)
    yield from term_changes(right, AS_PRINTED)
