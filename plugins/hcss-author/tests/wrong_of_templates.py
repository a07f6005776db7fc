# ruff: noqa: NPY002 - some of the mistakes
"""Wrong providers as an author may write them: each is a package of ``hcss new-plugin`` with one mistake."""

import re
import time
from dataclasses import dataclass, replace

import numpy as np
from hcss_author.new_plugin.templates import (
    atmosphere,
    clouds,
    elements,
    optics,
    radiance,
    sea,
    sensors,
    surfaces,
    variables,
)

from hcss_twin.providers import (
    AtmosphereDeclaration,
    ElementPixels,
    Leg,
    Measured,
    Path,
    SensorDeclaration,
    SingleScattering,
    SurfaceClass,
    SurfaceMap,
)


@dataclass(frozen=True)
class Wrong:
    """A wrong provider.

    Attributes
    ----------
    kind, name, sentence : str
        The mistake in a few words; names are unique and those of the classes.
    cls : type
    """

    kind: str
    name: str
    sentence: str
    cls: type


WRONG: list[Wrong] = []


def camel(sentence):
    """Return the first words as a part of a class name."""
    return "".join(re.sub(r"\W", "", word).capitalize() for word in sentence.split()[:5])


def wrong(kind, sentence):
    def note(cls):
        WRONG.append(Wrong(kind, cls.__name__, sentence, cls))
        return cls

    return note


# Seas: BRDF (1 - emissivity) / pi.


@wrong("sea", "emissivity has a NaN")
class SeaNan(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        found = super().emissivity(wavenumber_cm1, mu)
        found[0, 0] = np.nan
        return found


@wrong("sea", "emissivity is 1.02")
class SeaBright(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return super().emissivity(wavenumber_cm1, mu) + 0.04


@wrong("sea", "emissivity is in percent")
class SeaPercent(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return 100.0 * super().emissivity(wavenumber_cm1, mu)


@wrong("sea", "reflectance is returned as emissivity")
class SeaComplement(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return 1.0 - super().emissivity(wavenumber_cm1, mu)


@wrong("sea", "the BRDF has the wrong sign")
class SeaNegative(sea.Provider):
    def brdf(self, *given):
        return -super().brdf(*given)


@wrong("sea", "the BRDF lacks the division by pi: more is reflected than arrives")
class SeaWithoutPi(sea.Provider):
    def brdf(self, *given):
        return np.pi * super().brdf(*given)


@wrong("sea", "a quarter of the light is lost")
class SeaLoses(sea.Provider):
    def brdf(self, *given):
        return 0.25 * super().brdf(*given)


@wrong("sea", "the BRDF is not reciprocal")
class SeaOneWay(sea.Provider):
    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        return 1.5 * mu_in[:, None] * super().brdf(wavenumber_cm1, mu_out, mu_in, relative_azimuth)


@wrong("sea", "axes are exchanged")
class SeaTransposed(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return super().emissivity(wavenumber_cm1, mu).T


@wrong("sea", "results are single precision")
class SeaSingle(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return super().emissivity(wavenumber_cm1, mu).astype(np.float32)


@wrong("sea", "it emits most toward the horizon")
class SeaUpsideDown(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return super().emissivity(wavenumber_cm1, mu) - 0.02 * mu[:, None]


@wrong("sea", "emissivity near the horizon is NaN")
class SeaGrazing(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        with np.errstate(invalid="ignore"):
            return super().emissivity(wavenumber_cm1, mu) + 0.0 * np.sqrt(mu - 0.02)[:, None]


@wrong("sea", "the BRDF near the horizon is infinite")
class SeaGrazingBrdf(sea.Provider):
    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        found = super().brdf(wavenumber_cm1, mu_out, mu_in, relative_azimuth)
        return np.where(mu_out[:, None] < 0.02, np.inf, found)


@wrong("sea", "one buffer is returned again and again")
class SeaBuffer(sea.Provider):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._buffers = {}

    def emissivity(self, wavenumber_cm1, mu):
        shape = mu.size, wavenumber_cm1.size
        buffer = self._buffers.setdefault(shape, np.empty(shape))
        buffer[:] = super().emissivity(wavenumber_cm1, mu) - 0.01 * (1.0 - mu[:, None])
        return buffer


@wrong("sea", "a kept array is returned, which the caller may change")
class SeaKept(SeaBuffer):
    def emissivity(self, wavenumber_cm1, mu):
        shape = mu.size, wavenumber_cm1.size
        return self._buffers.setdefault(shape, sea.Provider.emissivity(self, wavenumber_cm1, mu))


@wrong("sea", "it writes into the cosines that it gets")
class SeaWrites(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        mu *= 0.5
        return super().emissivity(wavenumber_cm1, mu)


@wrong("sea", "results have noise of numpy's global random numbers")
class SeaGlobalNoise(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return super().emissivity(wavenumber_cm1, mu) - 1e-3 * np.random.random()


@wrong("sea", "it seeds numpy's global random numbers")
class SeaSeeds(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        np.random.seed(3)
        return super().emissivity(wavenumber_cm1, mu) - 1e-3 * np.random.random()


@wrong("sea", "each call has another result")
class SeaAges(sea.Provider):
    calls = 0

    def emissivity(self, wavenumber_cm1, mu):
        self.calls += 1
        return super().emissivity(wavenumber_cm1, mu) - 1e-4 * self.calls


@wrong("sea", "a direction's result depends on the others of the call")
class SeaBatch(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return super().emissivity(wavenumber_cm1, mu) - 1e-3 * np.mean(mu)


@wrong("sea", "it fails for more than one direction")
class SeaScalar(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        return (
            np.full((1, wavenumber_cm1.size), float(mu) and 0.98)
            if mu.size > 1
            else super().emissivity(wavenumber_cm1, mu)
        )


@wrong("sea", "it prints")
class SeaPrints(sea.Provider):
    def emissivity(self, wavenumber_cm1, mu):
        print("emissivity of", mu.size, "directions")
        return super().emissivity(wavenumber_cm1, mu)


# Optics: grey particles, twice their cross-section.


class ChangedOptics(optics.Provider):
    def single_scattering(self, cloud, wavenumber_cm1):
        return replace_bulk(super().single_scattering(cloud, wavenumber_cm1), **self.changed(cloud, wavenumber_cm1))

    def changed(self, cloud, wavenumber_cm1):
        raise NotImplementedError


def replace_bulk(bulk, extinction=None, albedo=None, moments=None):
    """Apply functions to parts of bulk properties."""
    parts = (bulk.extinction_m1, extinction), (bulk.albedo, albedo), (bulk.moments, moments)
    return SingleScattering(*(part if change is None else change(part) for part, change in parts))


def changing(sentence, **changes):
    """Note optics of which parts are changed by functions."""
    name = "Optics" + camel(sentence)

    def changed(self, cloud, wavenumber_cm1):
        return changes

    cls = type(name, (ChangedOptics,), {"changed": changed, "__module__": __name__})
    globals()[name] = wrong("optics", sentence)(cls)


changing("extinction is per kilometre", extinction=lambda x: 1e3 * x)
changing("extinction takes diameters for radii", extinction=lambda x: 4.0 * x)
changing("extinction has the wrong sign", extinction=np.negative)
changing("extinction is in um2 cm-3", extinction=lambda x: 1e6 * x)
changing("albedo is 1.2", albedo=lambda x: 1.2 + 0.0 * x)
changing("albedo is in percent", albedo=lambda x: 100.0 * x)
changing("albedo is the share that is absorbed", albedo=lambda x: 1.0 - x)
changing("albedo is NaN", albedo=lambda x: np.nan * x)
changing("moment 0 is one half", moments=lambda x: 0.5 * x)
changing("moments carry 2k + 1", moments=lambda x: x * np.array([[1.0], [3.0]]))
changing("particles scatter back", moments=lambda x: x * np.array([[1.0], [-1.0]]))
changing("moments have exchanged axes", moments=np.transpose)
changing("results are in single precision", extinction=np.float32, albedo=np.float32)


@wrong("optics", "extinction ignores the number of particles")
class OpticsOneNumber(optics.Provider):
    def single_scattering(self, cloud, wavenumber_cm1):
        return super().single_scattering(replace(cloud, number_density_m3=1e8), wavenumber_cm1)


@wrong("optics", "the particles of the first call are kept for all")
class OpticsFirst(optics.Provider):
    first = None

    def single_scattering(self, cloud, wavenumber_cm1):
        self.first = self.first or cloud
        return super().single_scattering(self.first, wavenumber_cm1)


@wrong("optics", "wavenumbers are converted in place")
class OpticsInPlace(optics.Provider):
    def single_scattering(self, cloud, wavenumber_cm1):
        wavenumber_cm1 /= 1e4
        return super().single_scattering(cloud, wavenumber_cm1)


@wrong("optics", "a misspelt attribute")
class OpticsMisspelt(optics.Provider):
    def single_scattering(self, cloud, wavenumber_cm1):
        return super().single_scattering(replace(cloud, alpha=cloud.aplha), wavenumber_cm1)


# Transmittance: a grey absorber that is well mixed.


class ChangedGas(atmosphere.Provider):
    """Changes paths before, and results after."""

    def path(self, path):
        return path

    def result(self, through, wavenumber_cm1, paths):
        return through

    def transmittance(self, wavenumber_cm1, paths):
        paths = [self.path(path) for path in paths]
        return self.result(super().transmittance(wavenumber_cm1, paths), wavenumber_cm1, paths)


def gas(sentence, result=None, leg=None):
    """Note a gas with a changed result, or changed legs."""
    name = "Gas" + camel(sentence)
    members = {"__module__": __name__}
    if result is not None:
        members["result"] = lambda self, through, wavenumber_cm1, paths: result(through)
    if leg is not None:
        members["path"] = lambda self, path: Path(tuple(leg(each) for each in path.legs))
    globals()[name] = wrong("atmosphere", sentence)(type(name, (ChangedGas,), members))


gas("absorptance instead of transmittance", lambda x: 1.0 - x)
gas("optical depth instead of transmittance", lambda x: -np.log(x))
gas("transmittance in percent", lambda x: 100.0 * x)
gas("transmittance of 1.05", lambda x: x + 0.05)
gas("transmittance with the wrong sign", np.negative)
gas("one wavenumber instead of all", lambda x: x[:, :1])
gas("axes exchanged", np.transpose)
gas("single precision result", lambda x: x.astype(np.float32))
gas("slant ignored", leg=lambda leg: Leg(leg.lower_m, leg.upper_m, 0.0))
gas("altitudes taken for kilometres", leg=lambda leg: Leg(1e3 * leg.lower_m, 1e3 * leg.upper_m, leg.zenith_deg))
gas("altitudes divided by 1000", leg=lambda leg: Leg(1e-3 * leg.lower_m, 1e-3 * leg.upper_m, leg.zenith_deg))
gas("no more air beyond 60 degrees", leg=lambda leg: Leg(leg.lower_m, leg.upper_m, min(leg.zenith_deg, 60.0)))
gas("angles at the top", leg=lambda leg: Leg(leg.lower_m, leg.upper_m, 0.5 * leg.zenith_deg))


@wrong("atmosphere", "transmittance rises and falls with the zenith angle")
class GasWaves(ChangedGas):
    def result(self, through, wavenumber_cm1, paths):
        zenith = np.array([sum(leg.zenith_deg for leg in path.legs) for path in paths])
        return through * (1.0 - 0.05 * np.sin(np.radians(8.0 * zenith)) ** 2)[:, None]


@wrong("atmosphere", "NaN for paths near the horizon")
class GasGrazing(ChangedGas):
    def result(self, through, wavenumber_cm1, paths):
        low = np.array([any(leg.zenith_deg > 84.0 for leg in path.legs) for path in paths])
        return np.where(low[:, None], np.nan, through)


@wrong("atmosphere", "only the last leg of a path counts")
class GasLastLeg(ChangedGas):
    def path(self, path):
        return Path(path.legs[-1:])


@wrong("atmosphere", "transmittances are relative to the best path of the call")
class GasBatch(ChangedGas):
    def result(self, through, wavenumber_cm1, paths):
        return through / max(1e-9, float(through.max(initial=1e-9)))


@wrong("atmosphere", "noise that no seed repeats")
class GasNoise(ChangedGas):
    def result(self, through, wavenumber_cm1, paths):
        return through * (1.0 - 1e-3 * np.random.default_rng().random())


@wrong("atmosphere", "results depend on the clock")
class GasClock(ChangedGas):
    def result(self, through, wavenumber_cm1, paths):
        return through * (1.0 - 1e-3 * (time.perf_counter() % 1.0))


@wrong("atmosphere", "one buffer is filled again and again")
class GasBuffer(ChangedGas):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._buffers = {}

    def result(self, through, wavenumber_cm1, paths):
        buffer = self._buffers.setdefault(through.shape, np.empty(through.shape))
        buffer[:] = through
        return buffer


@wrong("atmosphere", "the profile of the scene is warmed by 10 K")
class GasWarms(ChangedGas):
    def result(self, through, wavenumber_cm1, paths):
        kelvin = self._profile.temperature_K
        kelvin.flags.writeable = True
        kelvin += 10.0
        return through


@wrong("atmosphere", "it declares paths of any legs and knows none but to space")
class GasOnlyToSpace(ChangedGas):
    declares = AtmosphereDeclaration()

    def path(self, path):
        if any(leg.upper_m < 1e5 for leg in path.legs):
            raise KeyError("no such path")
        return path


# Radiance models: clouds and air that absorb and emit.


class ChangedModel(radiance.Provider):
    """Changes settings before, and terms after."""

    def setting(self, setting):
        return setting

    def changed(self, terms, states):
        return terms

    def columns(self, states, wavenumber_cm1):
        settings = [self.setting(setting) for setting in states.settings]
        seen = replace(states, settings=tuple(settings))
        return self.changed(super().columns(seen, wavenumber_cm1), states)


def model(sentence, setting=None, **changes):
    """Note a model with changed settings, or terms changed by functions."""
    name = "Model" + camel(sentence)
    members = {"__module__": __name__}
    if setting is not None:
        members["setting"] = lambda self, given: setting(given)
    if changes:
        members["changed"] = lambda self, terms, states: {
            term: changes.get(term, lambda x: x)(values) for term, values in terms.items()
        }
    globals()[name] = wrong("radiance", sentence)(type(name, (ChangedModel,), members))


model("radiance per um instead of cm-1", sea=lambda x: 1e2 * x, clouds=lambda x: 1e2 * x, air=lambda x: 1e2 * x)
model("clouds have the wrong sign", clouds=np.negative)
model("air counts twice", air=lambda x: 2.0 * x)
model("the sea's emission is divided by pi", sea=lambda x: x / np.pi)
model("clouds are NaN in columns with cloud", clouds=lambda x: np.where(x > 0.0, np.nan, x))
model("results in single precision", sea=np.float32, clouds=np.float32, air=np.float32)
model("terms have exchanged axes", sea=np.transpose)
model("view of the zenith for all", lambda given: replace(given, view=replace(given.view, zenith_deg=0.0)))
model("sea in degrees Celsius", lambda given: replace(given, sea_temperature_K=given.sea_temperature_K - 273.15))
model("the highest layer alone", lambda given: replace(given, layers=given.layers[-1:] * len(given.layers)))
model(
    "clouds have the temperature of their base",
    lambda given: replace(
        given,
        layers=tuple(
            replace(layer, temperature_K=float(given.profile.temperature_at(layer.base_m))) for layer in given.layers
        ),
    ),
)
model(
    "cloud tops are 20 K too warm",
    lambda given: replace(
        given,
        layers=tuple(
            replace(layer, temperature_K=20.0 + float(given.profile.temperature_at(layer.top_m)))
            for layer in given.layers
        ),
    ),
)


@wrong("radiance", "the setting of the constructor for all columns")
class ModelFirstSetting(ChangedModel):
    def setting(self, setting):
        return self._inputs.setting


@wrong("radiance", "a term is missing")
class ModelMissingTerm(ChangedModel):
    def changed(self, terms, states):
        return {"sea": terms["sea"], "clouds": terms["clouds"]}


@wrong("radiance", "clouds thinner than 100 m are left out")
class ModelJumps(ChangedModel):
    def columns(self, states, wavenumber_cm1):
        thick = np.where(states.thickness_m < 100.0, 0.0, states.thickness_m)
        return super().columns(replace(states, thickness_m=thick), wavenumber_cm1)


@wrong("radiance", "the path through clouds is vertical from any view")
class ModelVertical(radiance.Provider):
    def columns(self, states, wavenumber_cm1):
        mu = np.array([np.cos(np.radians(setting.view.zenith_deg)) for setting in states.settings])
        thickness = states.thickness_m * mu[states.setting_of][:, None]
        return super().columns(replace(states, thickness_m=thickness), wavenumber_cm1)


@wrong("radiance", "clouds are thinner from the side than from above")
class ModelSecant(radiance.Provider):
    def columns(self, states, wavenumber_cm1):
        mu = np.array([np.cos(np.radians(setting.view.zenith_deg)) for setting in states.settings])
        thickness = states.thickness_m * mu[states.setting_of][:, None] ** 2
        return super().columns(replace(states, thickness_m=thickness), wavenumber_cm1)


@wrong("radiance", "thickness is converted to kilometres in place")
class ModelInPlace(radiance.Provider):
    def columns(self, states, wavenumber_cm1):
        states.thickness_m.flags.writeable = True
        states.thickness_m[...] *= 1.0 + 1e-6
        return super().columns(states, wavenumber_cm1)


@wrong("radiance", "results are kept by the number of columns")
class ModelKept(radiance.Provider):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._kept = {}

    def columns(self, states, wavenumber_cm1):
        key = len(states), wavenumber_cm1.size
        if key not in self._kept:
            self._kept[key] = super().columns(states, wavenumber_cm1)
        return self._kept[key]


# Clouds: bars along y that drift.


class ChangedClouds(clouds.Provider):
    def thickness_m(self, time_s, rows, columns):
        return self.changed(super().thickness_m(time_s, rows, columns), rows, columns)

    def changed(self, field, rows, columns):
        return field


def cloud(sentence, changed=None, inputs=None):
    """Note a generator with a changed field, or made from changed inputs."""
    name = "Clouds" + camel(sentence)
    members = {"__module__": __name__}
    if changed is not None:
        members["changed"] = lambda self, field, rows, columns: changed(field)
    if inputs is not None:
        members["__init__"] = lambda self, given, parameters: clouds.Provider.__init__(self, inputs(given), parameters)
    globals()[name] = wrong("clouds", sentence)(type(name, (ChangedClouds,), members))


def with_coverage(inputs, coverage):
    return replace(inputs, layer=replace(inputs.layer, coverage=coverage))


cloud("thickness in kilometres", lambda field: 1e-3 * field)
cloud("thickness above the layer's greatest", lambda field: 1.2 * field)
cloud("double precision field", lambda field: field.astype(np.float64))
cloud("exchanged rows and columns", np.transpose)
cloud("NaN between clouds", lambda field: np.where(field > 0.0, field, np.nan).astype(np.float32))
cloud("clear sky of -1 m", lambda field: np.where(field > 0.0, field, -1.0).astype(np.float32))
cloud("flipped within the window", lambda field: np.ascontiguousarray(field[:, ::-1]))
cloud("sum of the window sets the scale", lambda field: (field * (0.9 + 0.1 * np.mean(field > 0.0))).astype(np.float32))
cloud("the seed is ignored", inputs=lambda given: replace(given, seed=7))
cloud("coverage is the clear share", inputs=lambda given: with_coverage(given, 1.0 - given.layer.coverage))
cloud("coverage is ignored", inputs=lambda given: with_coverage(given, 0.5 if given.layer.coverage < 0.4 else 0.9))
cloud("coverage squared", inputs=lambda given: with_coverage(given, given.layer.coverage**2))
cloud(
    "wind has the wrong sign",
    inputs=lambda given: replace(
        given,
        motion=replace(given.motion, cloud_velocity_m_s=tuple(-speed for speed in given.motion.cloud_velocity_m_s)),
    ),
)
cloud(
    "the platform stands still",
    inputs=lambda given: replace(given, motion=replace(given.motion, platform_speed_m_s=0.0)),
)


@wrong("clouds", "time is ignored, and declared")
class CloudsOfOneTime(clouds.Provider):
    def thickness_m(self, time_s, rows, columns):
        return super().thickness_m(0.0, rows, columns)


@wrong("clouds", "columns are counted from the window's first")
class CloudsFromWindow(clouds.Provider):
    def thickness_m(self, time_s, rows, columns):
        return super().thickness_m(time_s, slice(0, rows.stop - rows.start), slice(0, columns.stop - columns.start))


@wrong("clouds", "each window has random clouds of its own")
class CloudsOfWindows(clouds.Provider):
    def thickness_m(self, time_s, rows, columns):
        shape, layer = (rows.stop - rows.start, columns.stop - columns.start), self._layer
        random = np.random.default_rng(11).random(shape)
        return np.where(random < layer.coverage, layer.thickness_max_m, 0.0).astype(np.float32)


@wrong("clouds", "the phase is of numpy's global random numbers")
class CloudsGlobal(clouds.Provider):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._phase = np.random.random()


@wrong("clouds", "clouds move with every call")
class CloudsCount(clouds.Provider):
    def thickness_m(self, time_s, rows, columns):
        self._phase += 0.13
        return super().thickness_m(time_s, rows, columns)


@wrong("clouds", "it fails for windows that do not begin at 0")
class CloudsWhole(clouds.Provider):
    def thickness_m(self, time_s, rows, columns):
        return (
            super()
            .thickness_m(time_s, rows, columns)[rows, columns]
            .reshape(rows.stop - rows.start, columns.stop - columns.start)
        )


@wrong("clouds", "one buffer for all frames")
class CloudsBuffer(clouds.Provider):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._buffer = np.empty((inputs.grid.rows, inputs.grid.columns), np.float32)

    def thickness_m(self, time_s, rows, columns):
        self._buffer[rows, columns] = super().thickness_m(time_s, rows, columns)
        self._buffer[rows, columns][0] *= 1.0
        window = self._buffer[rows, columns]
        window[...] = np.where(window > 0.0, window, 0.0)
        if columns.start > 0:
            self._buffer[0, 0] = self._layer.thickness_max_m
        return window


# Elements: a square that covers a part of the central pixel.


class ChangedElements(elements.Provider):
    def pixels(self, time_s, rows, columns, scene):
        return [self.changed(part, rows, columns) for part in super().pixels(time_s, rows, columns, scene)]

    def changed(self, part, rows, columns):
        return part


def element(sentence, **changes):
    """Note an element with attributes that functions of the part replace."""
    name = "Element" + camel(sentence)

    def changed(self, part, rows, columns):
        return replace(part, **{field: change(part) for field, change in changes.items()})

    cls = type(name, (ChangedElements,), {"changed": changed, "__module__": __name__})
    globals()[name] = wrong("elements", sentence)(cls)


element("share of 130 percent", share=lambda part: part.share + 1.0)
element("share is NaN", share=lambda part: np.nan * part.share)
element("radiance has the wrong sign", radiance=lambda part: -part.radiance)
element("radiance is the temperature", radiance=lambda part: np.full(part.radiance.shape, part.temperature_K))
element(
    "radiance per um and not of the band",
    radiance=lambda part: part.radiance * np.array([7.0, 0.4])[: part.radiance.size],
)
element("temperature in degrees Celsius", temperature_K=lambda part: part.temperature_K - 273.15)
element("radiance and intensity", intensity=lambda part: part.radiance)
element("truth that was not declared", truth=lambda part: {"count": part.share})
element("a radiance for one band", radiance=lambda part: part.radiance[:0])
element("pixels outside the window", rows=lambda part: part.rows + 1000)
element("below the sea", altitude_m=lambda part: -10.0)


@wrong("elements", "the square is in the middle of each window")
class ElementOfWindow(ChangedElements):
    def pixels(self, time_s, rows, columns, scene):
        middle = np.array([(rows.start + rows.stop) // 2]), np.array([(columns.start + columns.stop) // 2])
        one = np.ones(1)
        return [ElementPixels(*middle, 0.3 * one, 0.0, self._radiance.copy(), None, None, {"number": one})]


@wrong("elements", "the place is of numpy's global random numbers")
class ElementGlobal(ChangedElements):
    def changed(self, part, rows, columns):
        return replace(part, share=0.5 * np.random.random(1) + 0.01)


@wrong("elements", "it fades with every call")
class ElementFades(ChangedElements):
    calls = 0

    def changed(self, part, rows, columns):
        self.calls += 1
        return replace(part, share=part.share / self.calls)


# Surfaces: an island of sand.


class ChangedSurface(surfaces.Provider):
    def surface(self, time_s, rows, columns):
        return self.changed(super().surface(time_s, rows, columns).number, rows, columns)

    def changed(self, number, rows, columns):
        return SurfaceMap(number)


@wrong("surfaces", "a class that is not declared")
class SurfaceThird(ChangedSurface):
    def changed(self, number, rows, columns):
        return SurfaceMap((number + 1).astype(np.uint8))


@wrong("surfaces", "class numbers are reals")
class SurfaceReal(ChangedSurface):
    def changed(self, number, rows, columns):
        return SurfaceMap(number.astype(np.float64))


@wrong("surfaces", "rows and columns exchanged")
class SurfaceTransposed(ChangedSurface):
    def changed(self, number, rows, columns):
        return SurfaceMap(number.T)


@wrong("surfaces", "the island is in each window")
class SurfaceOfWindow(ChangedSurface):
    def changed(self, number, rows, columns):
        found = np.zeros(number.shape, np.uint8)
        found[number.shape[0] // 2 :] = 1
        return SurfaceMap(found)


@wrong("surfaces", "the island grows with every call")
class SurfaceGrows(ChangedSurface):
    calls = 0

    def changed(self, number, rows, columns):
        self.calls += 1
        return SurfaceMap((np.cumsum(number, axis=1) > self.calls).astype(np.uint8))


@wrong("surfaces", "temperature in degrees Celsius")
class SurfaceCelsius(ChangedSurface):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self.classes = SurfaceClass("sea"), SurfaceClass("sand", 27.0)


@wrong("surfaces", "a random shore of numpy's global random numbers")
class SurfaceGlobal(ChangedSurface):
    def changed(self, number, rows, columns):
        return SurfaceMap((number * (np.random.random(number.shape) < 0.9)).astype(np.uint8))


@wrong("surfaces", "a map without numbers")
class SurfaceNothing(ChangedSurface):
    def changed(self, number, rows, columns):
        return number


# Variables: a difference of brightness temperatures, and a flag.


class ChangedVariables(variables.Provider):
    def values(self, fields, time_s):
        found = super().values(fields, time_s)
        return {**found, "temperature_difference": self.changed(found["temperature_difference"], fields)}

    def changed(self, kelvin, fields):
        return kelvin


def variable(sentence, changed):
    """Note variables of which the first is changed."""
    name = "Variable" + camel(sentence)
    members = {"changed": lambda self, kelvin, fields: changed(kelvin, fields), "__module__": __name__}
    globals()[name] = wrong("variables", sentence)(type(name, (ChangedVariables,), members))


variable("one row is lost", lambda kelvin, fields: kelvin[1:])
variable("axes exchanged", lambda kelvin, fields: kelvin.T)
variable("NaN where none is declared", lambda kelvin, fields: np.where(kelvin > 0.0, kelvin, np.nan))
variable("text instead of numbers", lambda kelvin, fields: kelvin.astype(str))
variable("the mean of the image is subtracted", lambda kelvin, fields: kelvin - kelvin.mean())
variable("each pixel takes its neighbour", lambda kelvin, fields: np.roll(kelvin, 1, axis=1))
variable("an input is returned", lambda kelvin, fields: fields["brightness_temperature"][0])
variable("noise of numpy's global random numbers", lambda kelvin, fields: kelvin + np.random.random())


@wrong("variables", "its inputs are changed in place")
class VariableInPlace(ChangedVariables):
    def values(self, fields, time_s):
        fields["brightness_temperature"] -= 273.15
        return super().values(fields, time_s)


@wrong("variables", "a variable is missing")
class VariableMissing(ChangedVariables):
    def values(self, fields, time_s):
        return {"difference_flag": super().values(fields, time_s)["difference_flag"]}


@wrong("variables", "values add up over calls")
class VariableSums(ChangedVariables):
    total = 0.0

    def changed(self, kelvin, fields):
        self.total = self.total + 0.01
        return kelvin + self.total


# Sensors: a converter without noise.


class ChangedSensor(sensors.Provider):
    def __init__(self, inputs, parameters):
        super().__init__(inputs, parameters)
        self._inputs = inputs

    def before(self, radiance, frame):
        return radiance

    def after(self, measured, radiance, frame):
        return measured

    def measure(self, radiance, frame, time_s):
        given = self.before(radiance, frame)
        return self.after(super().measure(given, frame, time_s), radiance, frame)


def sensor(sentence, before=None, **changes):
    """Note a sensor with a changed frame, or attributes of the measurement that functions replace."""
    name = "Sensor" + camel(sentence)
    members = {"__module__": __name__}
    if before is not None:
        members["before"] = lambda self, radiance, frame: before(self, radiance, frame)
    if changes:
        members["after"] = lambda self, measured, radiance, frame: replace(
            measured, **{field: change(measured) for field, change in changes.items()}
        )
    globals()[name] = wrong("sensors", sentence)(type(name, (ChangedSensor,), members))


def noise(random, radiance):
    return radiance + 0.02 * random.normal(size=radiance.shape)


sensor("radiance in mW", radiance=lambda measured: 1e3 * measured.radiance)
sensor("radiance has the wrong sign", radiance=lambda measured: -measured.radiance)
sensor("radiance is NaN", radiance=lambda measured: np.nan * measured.radiance)
sensor("one band for all", radiance=lambda measured: np.repeat(measured.radiance[:1], len(measured.radiance), axis=0))
sensor("the first band alone", radiance=lambda measured: measured.radiance[0])
sensor("digital numbers are reals", digital_number=lambda measured: measured.digital_number + 0.5)
sensor("digital numbers below 0", digital_number=lambda measured: measured.digital_number - 10_000)
sensor(
    "dark pixels are saturated",
    saturated=lambda measured: (measured.digital_number < np.median(measured.digital_number)).astype(np.uint8),
)
sensor("saturation is missing", saturated=lambda measured: None)
sensor("rows are counted from below", before=lambda self, radiance, frame: radiance[:, ::-1])
sensor("bands are exchanged", before=lambda self, radiance, frame: radiance[::-1])
sensor(
    "blur of neighbours that is not declared",
    before=lambda self, radiance, frame: 0.5 * (radiance + np.roll(radiance, 1, axis=2)),
)
sensor(
    "contrast of the frame", before=lambda self, radiance, frame: radiance * (0.9 + 0.1 * radiance / radiance.mean())
)
sensor("noise without a seed", before=lambda self, radiance, frame: noise(np.random.default_rng(), radiance))
sensor("noise of one seed", before=lambda self, radiance, frame: noise(np.random.default_rng(frame), radiance))
sensor(
    "noise of numpy's global random numbers",
    before=lambda self, radiance, frame: radiance + 0.02 * np.random.normal(size=radiance.shape),
)
sensor(
    "noise ignores the place in the image",
    before=lambda self, radiance, frame: noise(np.random.default_rng((self._inputs.seed, frame)), radiance),
)


@wrong("sensors", "the frame that it gets is changed in place")
class SensorInPlace(ChangedSensor):
    def before(self, radiance, frame):
        radiance[...] = np.maximum(radiance, 0.6)
        return radiance


@wrong("sensors", "the frame that it gets is returned")
class SensorReturns(ChangedSensor):
    variables = ()

    def measure(self, radiance, frame, time_s):
        return Measured(radiance)


@wrong("sensors", "earlier frames matter, which it does not declare")
class SensorRemembers(ChangedSensor):
    last = None

    def before(self, radiance, frame):
        last, self.last = radiance if self.last is None else self.last, np.array(radiance)
        return 0.8 * radiance + 0.2 * last


@wrong("sensors", "one buffer for all frames")
class SensorBuffer(ChangedSensor):
    declares = SensorDeclaration(reach_pixels=0)
    buffer = None

    def after(self, measured, radiance, frame):
        if self.buffer is None or self.buffer.shape != radiance.shape:
            self.buffer = np.empty(radiance.shape)
        self.buffer[:] = measured.radiance
        return replace(measured, radiance=self.buffer)


@wrong("sensors", "it fails in the second frame")
class SensorSecond(ChangedSensor):
    def before(self, radiance, frame):
        return radiance + ([0.0][frame] if frame else 0.0)
