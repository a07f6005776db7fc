"""Laws of radiance models that need no reference: columns of which the radiance is known in closed form."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, near, require
from hcss_twin.laws.samples import (
    PlainGas,
    PlainOptics,
    PlainSea,
    flat_sun,
    sample_high_layer,
    sample_layer,
    sample_profile,
)
from hcss_twin.physics.geometry import relative_azimuth_rad
from hcss_twin.physics.planck import planck
from hcss_twin.providers import (
    Array,
    ColumnSetting,
    Optics,
    RadianceInputs,
    RadianceModel,
    SeaDeclaration,
    Sun,
    View,
    clear_column,
    cloudy_columns,
)

Make = Callable[[RadianceInputs], RadianceModel]
"""Maps inputs to the model under test."""

EXACT = 0.03
"""Allowed relative difference from a closed form."""

CLOUD_LOSS = 0.4
"""Part of the radiance that an approximate cloud may lose in isothermal surroundings."""


class SidedSea(PlainSea):
    """A sea of which the BRDF is greater on the side of the glint."""

    def __init__(self, emissivity: float = 0.9) -> None:
        super().__init__(emissivity)
        self.declares = SeaDeclaration(depends_on=frozenset({"relative_azimuth"}))

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return (1 - emissivity) / pi (1 - 0.8 cos azimuth), (M, V)."""
        side = 1.0 - 0.8 * np.cos(relative_azimuth)
        return super().brdf(wavenumber_cm1, mu_out, mu_in, relative_azimuth) * side[:, None]


@dataclasses.dataclass(frozen=True)
class LawScene:
    """A model under test and the setting of a law."""

    model: RadianceModel
    setting: ColumnSetting

    def clear(self, wavenumber_cm1: Array, sun: Sun | None = None) -> dict[str, Array]:
        """Return each term (V,) of the column without cloud."""
        return clear_column(self.model, self.setting.under(sun), wavenumber_cm1)

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None = None) -> Mapping[str, Array]:
        """Return each term (N, V) of columns with clouds."""
        return cloudy_columns(self.model, self.setting.under(sun), wavenumber_cm1, thickness_m)


def _scene(
    make: Make,
    inputs: RadianceInputs,
    depth: float = 0.0,
    air_K: float | None = None,
    optics: Optics | None = None,
    **changes: Any,
) -> LawScene:
    """Scene of grey gas, black sea and sample cloud, with another optics provider or setting if given."""
    profile = sample_profile(air_K)
    plain: dict[str, Any] = {
        "profile": profile,
        "transmittance": PlainGas(profile, depth),
        "sea": PlainSea(1.0),
        "layers": (sample_layer(),),
    }
    setting = dataclasses.replace(inputs.setting, **(plain | changes))
    model = make(
        dataclasses.replace(inputs, setting=setting, optics=optics or PlainOptics(), solar_irradiance=flat_sun)
    )
    return LawScene(model, setting)


def below_a_transparent_sky_the_scene_is_emissivity_times_planck(
    make: Make, inputs: RadianceInputs, wavenumber_cm1: Array
) -> None:
    """A clear column at night; factors and units show here."""
    for emissivity, kelvin in ((1.0, 290.0), (0.9, 275.0)):
        scene = _scene(make, inputs, sea=PlainSea(emissivity), sea_temperature_K=kelvin)
        expected = emissivity * planck(wavenumber_cm1, kelvin)
        _near(scene.clear(wavenumber_cm1), expected)


def isothermal_air_radiates_what_it_absorbs(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """Clear column: T B(sea) + (1 - T) B(air); B where sea and air have one temperature."""
    for zenith, sea_K in ((0.0, 300.0), (50.0, 300.0), (50.0, 250.0)):
        view = View(zenith, 90.0)
        scene = _scene(make, inputs, 0.7, 250.0, view=view, sea_temperature_K=sea_K)
        through = np.exp(-0.7 / np.cos(np.radians(zenith)))
        sea, air = (planck(wavenumber_cm1, kelvin) for kelvin in (sea_K, 250.0))
        _near(scene.clear(wavenumber_cm1), through * sea + (1.0 - through) * air)


def nothing_at_night_is_brighter_than_the_hottest_thing(
    make: Make, inputs: RadianceInputs, wavenumber_cm1: Array
) -> None:
    """Not the clear column nor clouds; and clouds in isothermal surroundings are not much darker either."""
    thickness = np.array([[50.0], [400.0], [800.0]])
    black = planck(wavenumber_cm1, 280.0)
    scene = _scene(make, inputs, 0.5, 280.0, sea_temperature_K=280.0)
    cloudy = _total(scene.cloudy(wavenumber_cm1, thickness))
    at_most("radiance of a cloud in surroundings of 280 K", cloudy, 1.02 * black)
    at_least("radiance of a cloud in surroundings of 280 K", cloudy, (1.0 - CLOUD_LOSS) * black)


def black_cloud_absorbs_by_its_thickness(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """Seen from above through transparent air: exp(-kz) B(sea) + (1 - exp(-kz)) B(cloud)."""
    layer = dataclasses.replace(sample_layer(), temperature_K=250.0)
    optics = PlainOptics(cross_section_m2=2.5e-11, albedo=0.0, asymmetry=0.0)
    scene = _scene(make, inputs, optics=optics, layers=(layer,), view=View(0.0, 90.0), sea_temperature_K=295.0)
    thickness = np.array([[60.0], [400.0], [780.0]])
    through = np.exp(-layer.microphysics.number_density_m3 * 2.5e-11 * thickness)
    sea, cloud = (planck(wavenumber_cm1, kelvin) for kelvin in (295.0, 250.0))
    expected = through * sea + (1.0 - through) * cloud
    terms = scene.cloudy(wavenumber_cm1, thickness)
    require(_total(terms).shape == expected.shape, f"shape {_total(terms).shape}; expected {expected.shape}")
    _near(terms, expected)


def slanted_cloud_absorbs_by_its_slant_path(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """A black cloud seen at 40 and 60 degrees absorbs as one of thickness over cosine; thicker ones pass less."""
    layer = dataclasses.replace(sample_layer(), temperature_K=250.0)
    optics = PlainOptics(cross_section_m2=2.5e-11, albedo=0.0, asymmetry=0.0)
    thickness = np.array([[60.0], [200.0], [400.0], [780.0]])
    sea, cloud = (planck(wavenumber_cm1, kelvin) for kelvin in (295.0, 250.0))
    for zenith in (40.0, 60.0):
        view = View(zenith, 90.0)
        scene = _scene(make, inputs, optics=optics, layers=(layer,), view=view, sea_temperature_K=295.0)
        slant = thickness / np.cos(np.radians(zenith))
        through = np.exp(-layer.microphysics.number_density_m3 * 2.5e-11 * slant)
        seen = _total(scene.cloudy(wavenumber_cm1, thickness))
        near(f"radiance at zenith {zenith:g} deg", seen, through * sea + (1.0 - through) * cloud, rtol=EXACT)
        at_most("change of radiance of a colder cloud as it grows", np.diff(seen, axis=0), 0.0)


def opaque_cloud_has_the_temperature_of_its_top(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """Air and cloud at the altitude of the top, for clouds that grow upward and for those that hang from a top."""
    optics = PlainOptics(cross_section_m2=1e-5, albedo=0.0, asymmetry=0.0)
    hanging = dataclasses.replace(sample_high_layer(), anchor="top")
    for layer, thickness in ((sample_high_layer(), 500.0), (sample_high_layer(), 1900.0), (hanging, 500.0)):
        scene = _scene(make, inputs, optics=optics, layers=(layer,))
        top_m = float(layer.cloud_top_m(np.array(thickness)))
        expected = planck(wavenumber_cm1, float(sample_profile().temperature_at(top_m)))
        seen = _total(scene.cloudy(wavenumber_cm1, np.array([[thickness]])))[0]
        near(f"radiance of an opaque cloud with its top at {top_m:g} m", seen, expected, rtol=EXACT)


def opaque_cloud_has_a_temperature_of_its_altitude(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """Between that of the air at its top and at its base, through transparent air."""
    layer = sample_high_layer()
    optics = PlainOptics(cross_section_m2=1e-6, albedo=0.0, asymmetry=0.0)
    scene = _scene(make, inputs, optics=optics, layers=(layer,))
    for thickness in (500.0, 1900.0):
        seen = _total(scene.cloudy(wavenumber_cm1, np.array([[thickness]])))[0]
        base, top = sample_profile().temperature_at(np.array([layer.base_m, layer.base_m + thickness]))
        what = f"radiance of an opaque cloud of {thickness:g} m"
        at_most(what, seen, (1.0 + EXACT) * planck(wavenumber_cm1, float(base)))
        at_least(what, seen, (1.0 - EXACT) * planck(wavenumber_cm1, float(top)))


def sunlight_of_the_sea_is_irradiance_times_brdf(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """Clear column by day less that by night: mu0 E f T / d^2, T of the whole path down and up."""
    sea = SidedSea()
    for depth, view, sun in (
        (0.0, View(30.0, 90.0), Sun(40.0, 200.0, 1.0)),
        (0.0, View(30.0, 90.0), Sun(70.0, 290.0, 1.3)),
        (0.4, View(50.0, 10.0), Sun(50.0, 60.0, 1.0)),
    ):
        scene = _scene(make, inputs, depth, sea=sea, view=view)
        if not scene.model.solar_terms:
            raise Inapplicable("the model has no sunlight")
        day, night = (_total(scene.clear(wavenumber_cm1, source)) for source in (sun, None))
        mu, mu0 = (np.cos(np.radians(direction.zenith_deg)) for direction in (view, sun))
        azimuth = np.array([relative_azimuth_rad(view.azimuth_deg, sun.azimuth_deg)])
        brdf = sea.brdf(wavenumber_cm1, np.array([mu]), np.array([mu0]), azimuth)[0]
        through = np.exp(-depth * (1.0 / mu + 1.0 / mu0))
        expected = mu0 * flat_sun(wavenumber_cm1) * brdf * through / sun.distance_au**2
        near("sunlight reflected by the sea", day - night, expected, rtol=0.1)


def sunlight_adds(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """No solar term is negative, and sunlight of a cloud is less than the irradiance per steradian."""
    scene, sun = _scene(make, inputs, 0.3), Sun(40.0, 200.0, 1.0)
    thickness = np.array([[60.0], [400.0], [780.0]])
    for terms in (scene.clear(wavenumber_cm1, sun), scene.cloudy(wavenumber_cm1, thickness, sun)):
        for name in scene.model.solar_terms:
            at_least(f"solar term '{name}'", terms[name], 0.0)
            at_most(f"solar term '{name}'", terms[name], flat_sun(wavenumber_cm1))


def declared_sun_matters(make: Make, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
    """Zenith and azimuth of the sun change the radiance, if the model declares them."""
    scene = _scene(make, inputs, 0.3, sea=SidedSea())
    usual = _total(scene.clear(wavenumber_cm1, Sun(40.0, 200.0, 1.0)))
    others = {"sun_zenith": Sun(60.0, 200.0, 1.0), "relative_azimuth": Sun(40.0, 290.0, 1.0)}
    for name in others.keys() & (scene.model.declares.depends_on or set()):
        changed = np.any(_total(scene.clear(wavenumber_cm1, others[name])) != usual)
        require(changed, f"declares {name}, which does not matter")


def _total(terms: Mapping[str, Array]) -> Array:
    result: Array = np.sum(list(terms.values()), axis=0)
    return result


def _near(terms: Mapping[str, Array], expected: Array) -> None:
    near("radiance", _total(terms), expected, rtol=EXACT)


LAWS: tuple[Law, ...] = (
    below_a_transparent_sky_the_scene_is_emissivity_times_planck,
    isothermal_air_radiates_what_it_absorbs,
    nothing_at_night_is_brighter_than_the_hottest_thing,
    black_cloud_absorbs_by_its_thickness,
    slanted_cloud_absorbs_by_its_slant_path,
    opaque_cloud_has_the_temperature_of_its_top,
    opaque_cloud_has_a_temperature_of_its_altitude,
    sunlight_of_the_sea_is_irradiance_times_brdf,
    sunlight_adds,
    declared_sun_matters,
)
