"""Choice of the light between columns of cloud: the plugin that a scenario selects, and scenes that are refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import HcssError, Problem, ProviderError, ScenarioError, choose_from
from hcss_twin.core.plugins import FAILURES, describe, installed
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.models.radiance.spectral_grid import SpectralNodes, all_nodes
from hcss_twin.plan.clouds import sums_up
from hcss_twin.plan.error_budget import COLUMNS as ERROR_OF_COLUMNS
from hcss_twin.plan.error_budget import error_budget
from hcss_twin.plan.light import PlannedLight
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import reference_height_m
from hcss_twin.providers import Sun
from hcss_twin.providers.light import LightInputs, LightTransport

GROUP = "hcss_twin.light"
"""Entry point group of classes of light transport; the name of an entry point is the value of ``radiance.light``."""

COLUMNS = "columns"
_FIELD = "radiance.light"


def with_light(plan: Plan) -> Plan:
    """Return a plan with the light between columns that its scenario selects.

    Raises
    ------
    ScenarioError
        If no installed package has it, or it cannot compute the scene.
    """
    name, section = plan.scenario.radiance.light, plan.scenario.radiance
    if name == COLUMNS:
        if section.light_profile != "uniform":
            message = f"'{section.light_profile}' has no effect on independent columns; allowed: 'uniform', or {_FIELD}"
            raise ScenarioError([Problem("radiance.light_profile", message)])
        return replace(plan, notes=(*plan.notes, *_notes_of_columns(plan, section.light_accuracy)))
    offered = {each.name: (origin, each) for origin, each in installed(GROUP) if not isinstance(each, BaseException)}
    if name not in offered:
        hint = "" if offered else "; 'slant' and 'source' come with hcss-light: pip install hcss-light"
        message = f"'{name}' is not installed{hint}; {choose_from(name, [COLUMNS, *offered])}"
        raise ScenarioError([Problem(_FIELD, message)])
    problems = [
        Problem(field, f"{what} cannot be computed with {_FIELD} = '{name}'; allowed: {allowed}")
        for field, what, allowed in _unsupported(plan)
    ]
    if problems:
        raise ScenarioError(problems)
    if not (plan.needs_radiance and plan.assembly.has_cloud):
        return plan
    origin, entry = offered[name]
    try:
        light = PlannedLight(name, origin, entry.load())
        transport = light_transport(plan, light, all_nodes(plan.spectral_grid))
    except HcssError as error:
        raise ScenarioError([Problem(_FIELD, str(error))]) from error
    except FAILURES as error:
        raise ProviderError(f"light '{name}' of {origin}: import failed: {describe(error)}") from error
    if hasattr(transport, "expected_errors"):
        bands = (band.name for band in plan.bands)
        light = replace(light, expected=dict(zip(bands, map(float, transport.expected_errors()), strict=True)))
    notes, allowed = [light.note], section.light_accuracy
    beyond = [each for each, error in (light.expected or {}).items() if allowed is not None and error > allowed]
    if beyond:
        notes.append(f"radiance.light_accuracy: the error of '{name}' is expected to be larger in {', '.join(beyond)}")
    return replace(plan, light=light, notes=(*plan.notes, *notes))


def _notes_of_columns(plan: Plan, allowed: float | None) -> Iterator[str]:
    """Yield a note if independent columns are known to err by more than the scene allows."""
    if allowed is None or not plan.needs_radiance:
        return
    beyond = [
        f"{of} {band} {100.0 * each.relative:.2g} % ({each.kelvin or 0.0:.2g} K)"
        for (of, band), own in error_budget(plan).contributions.items()
        for each in own
        if each.name == ERROR_OF_COLUMNS and each.relative is not None and each.relative > allowed
    ]
    if beyond:
        yield (
            f"radiance.light_accuracy = {allowed:g}: independent columns err by more than that in {', '.join(beyond)}; "
            f'{_FIELD} = "source" of the plugin hcss-light computes clouds with sides'
        )


def light_transport(plan: Plan, light: PlannedLight, nodes: SpectralNodes) -> LightTransport:
    """Return the transport of a plan for the weighted wavenumbers of its radiance tables."""
    try:
        transport: LightTransport = light.transport(light_inputs(plan, nodes))
    except HcssError:
        raise
    except FAILURES as error:
        raise ProviderError(f"light '{light.name}' of {light.origin}: {describe(error)}") from error
    return transport


def light_inputs(plan: Plan, nodes: SpectralNodes) -> LightInputs:
    """Return the inputs of a light transport for a scene with one cloud layer."""
    assembly, (layer,) = plan.assembly, plan.layers
    up = (plan.sun_zenith_deg < 90.0) & plan.sun_matters

    def clear(sun: Sun | None) -> Array:
        total: Array = np.sum(
            [np.asarray(each) for each in assembly.model.clear(nodes.wavenumber_cm1, sun).values()], axis=0
        )
        return total

    return LightInputs(
        layer=layer,
        shape=plan.scenario.radiance.light_profile,
        view=plan.view,
        sun_zenith_deg=plan.sun_zenith_deg[up],
        sun_azimuth_deg=plan.sun_azimuth_deg[up],
        reference_m=reference_height_m(layer),
        point_m=plan.grid.pixel_size_m / plan.samples_per_pixel,
        wavenumber_cm1=nodes.wavenumber_cm1,
        weights_cm1=nodes.weights_cm1,
        profile=assembly.profile,
        transmittance=assembly.transmittance,
        optics=assembly.optics,
        solar_irradiance=assembly.solar_irradiance,
        clear=clear,
    )


def _unsupported(plan: Plan) -> Iterator[tuple[str, str, str]]:
    """Yield field, what is not supported, and what is allowed."""
    columns, assembly, scenario = f"{_FIELD} = '{COLUMNS}'", plan.assembly, plan.scenario
    if len(plan.layers) > 1:
        yield "clouds.layers", f"light between {len(plan.layers)} cloud layers", f"one layer, or {columns}"
    if plan.surfaces is not None:
        yield "surfaces", "a map of the ground", f"sea everywhere, or {columns}"
    if plan.tops is not None:
        yield _FIELD, "a generator with cloud tops of its own", columns
    if assembly.elements:
        yield "elements", "what elements add and hide among broken cloud", f"no elements, or {columns}"
    if plan.waves is not None:
        yield "sea.waves", "a sea of resolved waves", f"'averaged', or {columns}"
    if plan.views is not None:
        yield "platform.altitude", "an image whose view varies so much", f"a smaller image, or {columns}"
    if scenario.slant.shadows:
        yield "slant.shadows", "the shadow of clouds on the sea", f"false, or {columns}"
    terms = [spec.name for spec in plan.computed if spec.name.startswith(TERM_PREFIX)]
    if terms:
        yield "output.variables", f"'{terms[0]}'", f"the total radiance, or {columns}"
    for layer, generator, cloudy in zip(plan.layers, assembly.generators, assembly.cloudy_layers, strict=True):
        windows = generator.declares.tileable or sums_up(generator)
        if cloudy and not (windows and hasattr(generator, "thickness_around_m")):
            what = f"'{layer.name}', whose clouds are known within the image only,"
            yield "clouds.generator", what, f"a generator whose clouds go on (closest is 'fractal'), or {columns}"
