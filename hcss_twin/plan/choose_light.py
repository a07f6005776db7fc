"""Choice of the light between columns of cloud: the plugin that a scenario selects, and scenes that are refused."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NoReturn

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import HcssError, Problem, ProviderError, ScenarioError, choose_from
from hcss_twin.core.own_packages import LIGHT, how_to_install
from hcss_twin.core.plugins import FAILURES, describe, installed
from hcss_twin.models.radiance.physical.sunlight_in_air import scattered_once
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.physics.geometry import relative_azimuth_rad
from hcss_twin.plan.clouds import sums_up
from hcss_twin.plan.combinations import LAYER_TOPS, Excluded, goes_on_with, present
from hcss_twin.plan.displaced_clouds import upright
from hcss_twin.plan.error_budget import COLUMNS as ERROR_OF_COLUMNS
from hcss_twin.plan.error_budget import error_budget
from hcss_twin.plan.hanging_levels import spanning, spread
from hcss_twin.plan.plan import Plan, PlannedLight
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.providers import Sun
from hcss_twin.providers.light import LightInputs, LightTransport

GROUP = "hcss_twin.light"
"""Entry point group of classes of light transport; the name of an entry point is the value of ``radiance.light``."""

GROUP_OF_LAYERS = "hcss_twin.light_of_layers"
"""The same for scenes with several layers of cloud."""

AUTO, COLUMNS, _FIELD = "auto", "columns", "radiance.light"

_SUNS = 2
"""Suns whose light over clear sky stays in memory: tiers, and their terms, ask for it one after the other."""


def with_light(plan: Plan) -> Plan:
    """Return a plan with the light between columns that its scenario selects, or the cheapest that is accurate enough.

    Raises
    ------
    ScenarioError
        If no installed package has it, it cannot compute the scene, or none is as accurate as the scene requires.
    """
    section, name = plan.scenario.radiance, plan.scenario.radiance.light
    several = len(plan.cloudy_layers) > 1
    of_one = _installed_light(GROUP)
    offered = _installed_light(GROUP_OF_LAYERS) if several else of_one
    table, cloudy = excluded_beside_light(plan), plan.needs_radiance and plan.assembly.has_cloud
    errors: dict[str, float] = {}
    choice = "as the scenario says"
    if name == AUTO:
        name = COLUMNS
        choice = _why_not_chosen(plan, bool(offered), table) if section.light_accuracy is not None and cloudy else ""
        if section.light_accuracy is not None and cloudy and not choice:
            name, errors = _cheapest(plan, offered, section.light_accuracy)
            choice = f"the cheapest within radiance.light_accuracy = {section.light_accuracy:g}" if errors else ""
    if name == COLUMNS:
        if section.light_profile != "uniform":
            message = f"'{section.light_profile}' has no effect on independent columns; allowed: 'uniform', or {_FIELD}"
            raise ScenarioError([Problem("radiance.light_profile", message)])
        within = [f"independent columns are within radiance.light_accuracy: {_percent(errors)}"]
        of_columns = within if errors else _notes_of_columns(plan, section.light_accuracy)
        columns = replace(plan.light, expected_rms=errors, choice=choice if cloudy else "")
        return replace(plan, light=columns, notes=(*plan.notes, *of_columns))
    if name in of_one and name not in offered:
        choice = "".join(f"'{light}', " for light in offered)
        message = f"'{name}' computes one layer of cloud; allowed: {choice}'{COLUMNS}', or one layer in clouds.layers"
        raise ScenarioError([Problem(_FIELD, message)])
    if name not in offered:
        known = name in LIGHT
        message = f"'{name}' is {'not installed' if known else 'unknown'}; "
        message += choose_from(name, [AUTO, COLUMNS, *offered])
        for package in sorted({LIGHT[light] for light in ({name} if known else LIGHT.keys() - of_one.keys())}):
            message += f". {'It comes' if known else 'Others come'} with {package}: {how_to_install(package)}"
        raise ScenarioError([Problem(_FIELD, message)])
    over_surfaces = bool(plan.surfaces) and _knows("surfaces", *offered[name])
    along_rays = not plan.is_grid and _knows("rays", *offered[name])
    under_tops = _knows("tops", *offered[name])
    beside = excluded_beside_light(plan, over_surfaces, along_rays, under_tops)
    Excluded.require_none(f"{_FIELD} = '{name}'", beside, f"{_FIELD} = '{COLUMNS}'")
    if not cloudy:
        return plan
    light, transport = _loaded(plan, name, *offered[name])
    notes: list[str] = []
    if plan.views.varies:
        rms, note = _over_views(plan, name, transport)
        notes.append(f"{_FIELD}: {note}")
    else:
        rms = transport.expected_errors()
    expected = _of_bands(plan, rms)
    light = replace(light, expected_rms=expected, choice=choice)
    beyond = {band: error for band, error in expected.items() if error > (section.light_accuracy or math.inf)}
    if beyond:
        notes.append(f"radiance.light_accuracy: the error of '{name}' is larger: {_percent(beyond)}")
    notes.append(
        f"clouds have sides ({_FIELD} = '{name}' of {light.provider}); expected error of this effect, rms over pixels: "
        f"{_percent(expected)}. The certificate checks independent columns, to which the effect of sides is added"
    )
    if plan.assembly.elements:
        notes.append(
            f"elements ({_FIELD} = '{name}'): before an element are the clouds of its own column, above its altitude; "
            "sides of clouds beside its line of sight neither hide nor light it"
        )
    if plan.surfaces:
        notes.append(
            f"surfaces ({_FIELD} = '{name}'): clouds shade the direct sunlight that the ground at each point reflects; "
            "they are mirrored in it as in a flat sea of its emissivity"
        )
    if plan.waves.varies:
        notes.append(
            f"waves ({_FIELD} = '{name}'): drawn where the column of a point is clear, over the mean sea below clouds "
            "with sides, which hide or show the sea up to the parallax of their height beside the edge of a column"
        )
    return replace(plan, light=light, notes=(*plan.notes, *notes))


def _installed_light(group: str) -> dict[str, tuple[Any, Any]]:
    """Return the origin and the entry point of each class of light transport, by its name."""
    return {entry.name: (origin, entry) for origin, entry in installed(group) if not isinstance(entry, BaseException)}


def _loaded(plan: Plan, name: str, origin: object, entry: Any) -> tuple[PlannedLight, LightTransport]:
    try:
        light = PlannedLight(name, str(origin), entry.load())
        return light, light.transport(light_inputs(plan, plan.spectral_grid.all_nodes()))
    except HcssError as error:
        raise ScenarioError([Problem(_FIELD, str(error))]) from error
    except FAILURES as error:
        raise ProviderError(f"light '{name}' of {origin}: {describe(error, entry.value)}") from error


def _knows(what: str, origin: object, entry: Any) -> bool:
    """Return whether a class of light transport says that it knows classes of surface, other rays, or own tops."""
    try:
        return bool(getattr(entry.load(), f"knows_{what}", False))
    except FAILURES as error:
        raise ProviderError(f"light of {origin}: {describe(error, entry.value)}") from error


def _over_views(plan: Plan, name: str, transport: LightTransport) -> tuple[Sequence[float], str]:
    """Return the errors and the note of a transport for an image whose view varies."""

    def refuse(_: Plan) -> NoReturn:
        raise HcssError(f"'{name}' needs one view for all pixels; allowed: a smaller image, or {_FIELD} = '{COLUMNS}'")

    try:
        errors, note = getattr(transport, "over_views", refuse)(plan)
    except HcssError as error:
        raise ScenarioError([Problem("platform.altitude" if plan.is_grid else _FIELD, str(error))]) from error
    return errors, note


def _why_not_chosen(plan: Plan, offered: bool, table: Sequence[Excluded]) -> str:
    """Return why a scene that gives an accuracy stays columns without a choice; empty if there is one."""
    if not offered:
        return "as no installed package has light between columns to choose"
    if plan.views.varies:
        return f"as the view varies over the image, for which {_FIELD} is not chosen by its error"
    first = next(present(table), None)
    return f"as the scene has {first.what.rstrip(',')}" if first else ""


def _cheapest(plan: Plan, offered: Mapping[str, tuple[object, Any]], allowed: float) -> tuple[str, dict[str, float]]:
    """Return the cheapest light that is accurate enough, or columns, and the errors of its bands."""
    stated: dict[str, dict[str, float]] = {}
    costs = {name: float(entry.load().cost) for name, (_, entry) in offered.items()}
    for name in sorted((name for name in costs if costs[name] < math.inf), key=lambda name: costs[name]):
        _, transport = _loaded(plan, name, *offered[name])
        stated.setdefault(COLUMNS, _of_bands(plan, transport.errors_of_columns()))
        stated[name] = _of_bands(plan, transport.expected_errors())
    if not stated:
        return COLUMNS, {}
    largest = {name: max(errors.values()) for name, errors in stated.items()}
    if fine := [name for name in stated if largest[name] <= allowed]:
        return fine[0], stated[fine[0]]
    best = min(largest, key=lambda name: largest[name])
    message = f"{allowed:g} is less than the error of any light in this scene; allowed: at least {largest[best]:.2g}"
    hint = f"that of '{best}', or {_FIELD}, which selects one whatever its error"
    raise ScenarioError([Problem("radiance.light_accuracy", f"{message}, {hint}")])


def _of_bands(plan: Plan, errors: Sequence[float]) -> dict[str, float]:
    return {band.name: float(error) for band, error in zip(plan.bands, errors, strict=True)}


def _percent(errors: dict[str, float]) -> str:
    return ", ".join(f"{name} {100.0 * error:.2g} %" for name, error in errors.items())


def _notes_of_columns(plan: Plan, allowed: float | None) -> Iterator[str]:
    """Yield a note if independent columns are known to err by more than the scene allows."""
    if allowed is None or not plan.needs_radiance:
        return
    beyond = {
        f"{of} {band}": error.relative
        for (of, band), errors in error_budget(plan).contributions.items()
        for error in errors
        if error.name == ERROR_OF_COLUMNS and error.relative is not None and error.relative > allowed
    }
    if beyond:
        needs = f"{_FIELD} = 'source' of the plugin hcss-light computes clouds with sides"
        yield f"radiance.light_accuracy: the error of independent columns is larger: {_percent(beyond)}; {needs}"


def light_inputs(
    plan: Plan, nodes: SpectralNodes, number: int | None = None, meets_m: float | None = None
) -> LightInputs:
    """Return the inputs of a light transport for a layer with cloud, by default the lowest, and for those above it.

    Parameters
    ----------
    meets_m : float, optional
        Altitude at which lines of sight meet the columns of the layer; by default as the layer itself is seen.
    """
    assembly, numbers = plan.assembly, plan.cloudy_layers
    number = numbers[0] if number is None else number
    higher, generator = [above for above in numbers if above > number], assembly.generators[number]
    layer = spanning(plan.layers[number], generator)
    tops_vary = layer is not plan.layers[number]
    reference_m = layer.reference_height_m
    if tops_vary:  # lines of sight are those through the points of the sea, or without parallax through the clouds
        through_sea = plan.is_grid and assembly.slant.parallax
        reference_m = 0.0 if through_sea else 0.5 * (layer.base_m + layer.top_m)
    if meets_m is not None:
        reference_m = meets_m
    # Columns of all layers stand at the points of a scene that rays of a camera see.
    above_m = None if plan.is_grid else reference_m
    up = (plan.sun_zenith_deg < 90.0) & plan.sun_matters

    @lru_cache(_SUNS)
    def terms_of(sun: Sun | None) -> Mapping[str, Array]:
        return assembly.clear(nodes.wavenumber_cm1, sun)

    def clear(sun: Sun | None, names: Collection[str] = assembly.model.terms) -> Array:
        terms = terms_of(sun)
        total: Array = np.sum(
            [np.zeros(nodes.wavenumber_cm1.size), *(np.asarray(terms[name]) for name in names)], axis=0
        )
        return total

    def clouds(rows: slice, columns: slice, edges_m: Array) -> tuple[Any, Any]:
        time_s, shares = float(plan.frame_times_s[0]), getattr(generator, "height_shares", None)
        of_frame: Any = generator
        summary = None if generator.declares.tileable else of_frame.frame_summary(time_s)
        if tops_vary:
            own = upright(generator, time_s, rows, columns, summary)
            return own[0], spread(*own, edges_m)
        thickness = of_frame.thickness_around_m(time_s, rows, columns, summary)
        return thickness, None if shares is None else shares(time_s, rows, columns, thickness, edges_m)

    @lru_cache(_SUNS)
    def air_sun(sun: Sun, altitude_m: float) -> Array:
        turned = relative_azimuth_rad(plan.view.azimuth_deg, sun.azimuth_deg)
        of_air = assembly.transmittance, assembly.profile, plan.view.zenith_deg
        share = scattered_once(*of_air, sun, turned, nodes.wavenumber_cm1)(altitude_m)
        scattered: Array = share * assembly.solar_irradiance(nodes.wavenumber_cm1) / sun.distance_au**2
        return scattered

    return LightInputs(
        layer=layer,
        shape=plan.scenario.radiance.light_profile,
        view=plan.view,
        sun_zenith_deg=plan.sun_zenith_deg[up],
        sun_azimuth_deg=plan.sun_azimuth_deg[up],
        reference_m=reference_m,
        point_m=plan.scene.point_m,
        points=math.prod(plan.pixels) * plan.samples_per_pixel**2 * plan.frame_times_s.size,
        accuracy=plan.scenario.radiance.light_accuracy,
        wavenumber_cm1=nodes.wavenumber_cm1,
        weights_cm1=nodes.weights_cm1,
        profile=assembly.profile,
        transmittance=assembly.transmittance,
        optics=assembly.optics,
        solar_irradiance=assembly.solar_irradiance,
        clear=clear,
        sea_sun=lambda sun: clear(sun, sea_sun_terms(assembly.model)),
        air_sun=air_sun,
        sea=assembly.sea,
        image=(plan.grid.rows * plan.scene.samples, plan.grid.columns * plan.scene.samples),
        clouds=clouds,
        number=number,
        tops_vary=tops_vary,
        above=light_inputs(plan, nodes, higher[0], above_m) if higher else None,
    )


def excluded_beside_light(
    plan: Plan, over_surfaces: bool = False, along_rays: bool = False, under_tops: bool = False
) -> tuple[Excluded, ...]:
    """Return what cannot be computed with light between columns.

    Parameters
    ----------
    over_surfaces : bool
        Whether its transport knows several classes of surface.
    along_rays : bool
        Whether it knows rays that form no grid on the ground.
    under_tops : bool
        Whether it knows clouds with tops of their own.
    """
    tops = plan.assembly.tops_vary and not under_tops
    assembly = plan.assembly
    ends = [
        generator
        for generator, cloudy in zip(assembly.generators, assembly.cloudy_layers, strict=True)
        if cloudy
        and not ((generator.declares.tileable or sums_up(generator)) and hasattr(generator, "thickness_around_m"))
    ]
    go_on = goes_on_with(ends[0]) if ends else ""
    return (
        Excluded(_FIELD, not plan.is_grid and not along_rays, "an image that is no grid on the ground", "no camera"),
        Excluded(_FIELD, plan.rays.may_miss_ground, "an image that may miss the ground", "one of the ground alone"),
        Excluded("surfaces", bool(assembly.surfaces) and not over_surfaces, "a map of the ground", "sea everywhere"),
        Excluded("clouds.generator", tops, "cloud with tops of its own", LAYER_TOPS),
        Excluded("clouds.generator", bool(ends), "cloud that ends with the image", go_on),
    )
