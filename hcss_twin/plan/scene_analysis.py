"""Analysis of a scene before it is computed: a few columns show what fails and what can be omitted."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import compress
from typing import Any

import numpy as np

from hcss_twin.core.cache import kept_result
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem, ProviderDefect, ProviderError, ScenarioError
from hcss_twin.cube.variables import TERM_PREFIX, VariableSpec
from hcss_twin.plan.accuracy import RequestedAccuracy, requested_accuracy, share_out
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import NotComputed
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.numerics import (
    GridRefinement,
    NumericalLevel,
    choose_level,
    choose_refinement,
    finest,
    refine_toward,
)
from hcss_twin.plan.omissions import list_omissions, negligible_shadows, without_certificate
from hcss_twin.plan.output import computed_variables, cube_variables, quantized, wants_radiance
from hcss_twin.plan.packing import RadianceRange, radiance_range, widest
from hcss_twin.plan.sunlight import COMPUTED, SunFrames, Sunlight, negligible_sunlight
from hcss_twin.plan.views import EDGES, EXTREMES, ONE_VIEW, OneView, ViewAxis, choose_views
from hcss_twin.plan.waves import WAVES, choose_waves, wants_waves
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

SUNS = 5
"""Number of frames with a sun for the bound on waves."""

LEFT_FOR_VIEWS = 0.5
"""Part of what the spectral grid leaves of its share that views may use: a glory in the image needs many of them."""


TOO_MANY_VIEWS = NotComputed("waves would need tables toward more views than there can be", "accuracy: a lower one")


@dataclass(frozen=True)
class SceneAnalysis:
    """Decisions that depend on the radiance of a few columns.

    Attributes
    ----------
    accuracy : RequestedAccuracy
        Relative to the radiance of every band.
    sunlight : Sunlight
        Computed, or omitted because it is faint.
    resolves_waves : bool
        Whether clear pixels show resolved waves.
    numerics : NumericalLevel
        Level of the radiance model.
    spectral_grid : GridRefinement
        Refinement of the spectral grid.
    views : ViewAxis
        Views with tables.
    faint_shadows : NotComputed or None
        Why the plan skips shadows that the scene can have.
    notes : tuple of str
        On what the radiance model does not use of a provider.
    expected : RadianceRange or None
        Radiance of the pixels, for packing; None if nothing is packed.
    """

    accuracy: RequestedAccuracy
    sunlight: Sunlight
    resolves_waves: bool
    omissions: tuple[Omission, ...]
    numerics: NumericalLevel
    spectral_grid: GridRefinement
    views: ViewAxis = ONE_VIEW
    faint_shadows: NotComputed | None = None
    notes: tuple[str, ...] = ()
    expected: RadianceRange | None = None


def strictest(first: SceneAnalysis, analyses: Sequence[SceneAnalysis]) -> SceneAnalysis:
    """Return an analysis with the strictest choices of several, for states of one scene.

    Parameters
    ----------
    first : SceneAnalysis
        Its omissions are kept, and its notes come first.
    """
    axes = [analysis.views for analysis in (first, *analyses)]
    most = {field.name: max(getattr(axis, field.name) for axis in axes) for field in dataclasses.fields(ViewAxis)}
    return replace(
        first,
        accuracy=min((analysis.accuracy for analysis in analyses), key=lambda accuracy: accuracy.relative),
        sunlight=max((analysis.sunlight for analysis in analyses), key=lambda light: (light.is_computed, light.share)),
        views=replace(max(axes, key=lambda axis: axis.varies), **most),
        faint_shadows=first.faint_shadows if all(analysis.faint_shadows for analysis in analyses) else None,
        notes=tuple(dict.fromkeys(note for analysis in (first, *analyses) for note in analysis.notes)),
        numerics=finest([analysis.numerics for analysis in analyses]),
        expected=widest(analysis.expected for analysis in (first, *analyses)),
        spectral_grid=max(
            (analysis.spectral_grid for analysis in analyses), key=lambda grid: (grid.refinement, grid.error)
        ),
    )


def analyse_scene(scenario: Scenario, assembly: Assembly, catalog: Catalog, sun: SunFrames) -> SceneAnalysis:
    """Return the analysis of a scene, from the cache if possible.

    Raises
    ------
    ScenarioError
        If a provider cannot compute what the scene needs; names the field.
    """
    parts = inputs_of_analysis(scenario, assembly, catalog)
    classes = (
        SceneAnalysis,
        Sunlight,
        NotComputed,
        RequestedAccuracy,
        Omission,
        ViewAxis,
        OneView,
        NumericalLevel,
        GridRefinement,
        RadianceRange,
    )

    def compute() -> SceneAnalysis:
        try:
            return _analyse(scenario, assembly, catalog, sun)
        except ProviderDefect:
            raise
        except ProviderError:
            explain_lowest_sun(assembly, sun)
            raise

    analysis = kept_result(parts, catalog, compute, classes)
    if scenario.output.certificate:
        return analysis
    return replace(analysis, omissions=without_certificate(analysis.omissions))


def inputs_of_analysis(scenario: Scenario, assembly: Assembly, catalog: Catalog) -> dict[str, Any]:
    """Return everything that the analysis of a scene depends on.

    Columns depend only on whether there are cloudy and clear ones, not on where the clouds are.
    """
    text = json.loads(scenario.to_json())
    for layer in text["clouds"]["layers"]:
        layer["coverage"] = "some" if 0.0 < layer["coverage"] < 1.0 else layer["coverage"]
        for name in ("edge_taper", "coverage_mode", "wind_speed", "wind_from"):
            del layer[name]
    # They depend on all views of the image, and on which terms there are, not on how light between columns is computed.
    del text["image"]["window"], text["output"]["certificate"]
    # Which variables there are depends on the providers of elements; columns do not know where elements are.
    for element in text.get("elements", ()):
        del element["parameters"]
    for section, names in (
        ("motion", ("wind_speed", "wind_from", "evolution_time")),
        ("radiance", ("light", "light_accuracy", "light_profile")),
    ):
        for name in names:
            del text[section][name]
    parts: dict[str, Any] = {
        "scenario": {name: value for name, value in text.items() if name not in ("title", "seed", "sensor")},
        "filled_in": [item.as_dict() for item in assembly.filled_in],
        "files": dict(catalog.used),
        "between_columns": scenario.radiance.is_between_columns,
        "code": assembly.code,
        "layers": [(layer.base_m, layer.top_m) for layer in assembly.layers],
    }
    if assembly.surface is not None:
        parts["surface"] = [assembly.surface.name, assembly.surface.temperature_K]
    if assembly.alterations:
        parts["altered"] = [[effect.name, effect.code, value] for effect, value in assembly.alterations]
    if assembly.directions is not None:
        parts["views"] = repr(assembly.directions.at(EXTREMES + EDGES))
    if assembly.family is not None:
        parts["family"] = assembly.family.key
    return parts


def _analyse(scenario: Scenario, assembly: Assembly, catalog: Catalog, sun: SunFrames) -> SceneAnalysis:
    requested = cube_variables(scenario, assembly, True)
    radiance = wants_radiance(computed_variables(scenario, assembly, True, requested))
    if radiance:
        probe_particles(assembly)
    extreme_suns = [position for _, position in sun.extremes(assembly.view)] if radiance else []
    accuracy = requested_accuracy(scenario, assembly, extreme_suns)
    shares = share_out(accuracy.relative)
    numerics = choose_level(assembly, extreme_suns, shares.numerics)
    # A sun for which wavenumbers are chosen, too: the model may then keep its clouds.
    lit = [sun.checked() or extreme_suns[0]] if radiance else []
    refinement = choose_refinement(assembly, lit, shares.spectral_grid)
    assembly = assembly.at_level(numerics.level).on_grid(refinement.refinement)
    left = LEFT_FOR_VIEWS * max(shares.spectral_grid - refinement.error, 0.0)
    faint_shadows = negligible_shadows(scenario, assembly, sun, accuracy.relative) if radiance else None
    assembly = replace(assembly, slant=assembly.slant.without("shadows", faint_shadows))
    left += shares.faint_sunlight + (0.0 if assembly.slant.shadows else shares.shadows)  # neither is there
    suns: list[Sun | None] = [position for _, position in sun.evenly(SUNS)] if radiance else []
    omitted_waves: tuple[Omission, ...] = (Omission(WAVES, "the surface is not the scenario's sea", 0.0),)
    if assembly.surface is None:
        omitted_waves = choose_waves(scenario, assembly, suns, accuracy.relative)
    waves = not omitted_waves
    views_for = partial(choose_views, scenario, assembly, extreme_suns, shares.views, left)
    try:
        views = views_for(waves)
    except ScenarioError:
        if not waves or wants_waves(scenario):
            raise
        # The mirror images of the sun in tilted facets may need more views than tables can have.
        views = views_for(False)
        omitted_waves = choose_waves(scenario, assembly, suns, accuracy.relative, TOO_MANY_VIEWS)
        waves = False
    if views.varies:
        near = views.over(assembly).at(views.extremes + views.edges)
        numerics = refine_toward(assembly, numerics, near, extreme_suns, shares.numerics)
        assembly = assembly.at_level(numerics.level).with_finer_sunlight(numerics.sunlight_steps)
    drawn = waves or assembly.surface is not None  # beside such a surface there may be sea with waves
    variables = quantized(cube_variables(scenario, assembly, drawn), scenario, accuracy)
    variables = computed_variables(scenario, assembly, drawn, variables)
    sunlight = COMPUTED
    # The share of sunlight is evaluated for one view.
    if radiance and not waves and not views.varies and _can_omit_sunlight(assembly, variables):
        sunlight = negligible_sunlight(assembly, sun, shares.faint_sunlight)
    possible = cube_variables(scenario, assembly, drawn, ("all",))
    omissions = tuple(
        list_omissions(scenario, assembly, variables, possible, sun, sunlight, waves, accuracy.relative, views.varies)
    )
    # Without radiance there are no waves to omit.
    of_waves = omitted_waves if radiance else ()
    darkest = extreme_suns[-1] if radiance and sunlight.is_computed else None
    notes: tuple[str, ...] = ()
    if radiance:
        from hcss_twin.plan.path_radiance import unused_path_radiance

        notes = unused_path_radiance(assembly, darkest, accuracy.relative)
    omissions = (*omissions, *of_waves)
    expected = radiance_range(scenario, assembly, extreme_suns, waves)
    return SceneAnalysis(
        accuracy, sunlight, waves, omissions, numerics, refinement, views, faint_shadows, notes, expected
    )


def _can_omit_sunlight(assembly: Assembly, variables: tuple[VariableSpec, ...]) -> bool:
    """Whether faint sunlight may be omitted: not with shadows, which need it, or if a solar term is requested."""
    terms = {TERM_PREFIX + name for name in assembly.model.solar_terms}
    return not assembly.slant.shadows and not any(spec.name in terms for spec in variables)


def probe_particles(assembly: Assembly) -> None:
    """Compute the optics of each layer's particles at one wavenumber, so that errors occur early."""
    wavenumber = assembly.spectral_grid.wavenumber_cm1[:1]
    problems = []
    fields = zip(assembly.particle_fields, assembly.optics_fields, strict=True)
    for layer, cloudy, (field, provider) in zip(assembly.layers, assembly.cloudy_layers, fields, strict=True):
        if cloudy:
            try:
                assembly.optics.single_scattering(layer.microphysics, wavenumber)
            except ProviderError as error:
                # Optics refuse particles that they do not have by ProviderError or ValueError; others are accidents.
                if isinstance(error, ProviderDefect) and not isinstance(error.__cause__, ValueError):
                    raise
                problems.append(Problem(field, str(error)))
            except CatalogError as error:
                problems.append(Problem(provider, str(error)))
    if problems:
        raise ScenarioError(list(dict.fromkeys(problems)))


HIGH_SUN_DEG = 30.0
"""Zenith of a sun that every radiance model supports."""


def explain_lowest_sun(assembly: Assembly, sun: SunFrames) -> None:
    """Tell whether a provider failed because of the lowest sun above the horizon, by columns at one wavenumber.

    Raises
    ------
    ScenarioError
        If a provider fails for this sun but not for a high one; names ``time``.
    ProviderError
        If it fails for both, or by accident.
    """
    up = sun.up
    if up.size == 0:
        return
    frame = up[np.argmax(sun.zenith_deg[up])]
    lowest = sun.track.at(float(sun.time_s[frame]))
    try:
        _probe(assembly, lowest)
    except ProviderDefect:
        raise
    except ProviderError as error:
        high = replace(lowest, zenith_deg=min(HIGH_SUN_DEG, lowest.zenith_deg))
        if _fails(lambda: _probe(assembly, high)):
            raise
        message = (
            f"with the sun at zenith {sun.zenith_deg[frame]:.2f} deg (frame {frame}): {error}; allowed: times with the "
            "sun higher or below the horizon"
        )
        raise ScenarioError([Problem("time", message)]) from error


def _probe(assembly: Assembly, sun: Sun) -> None:
    wavenumber = assembly.spectral_grid.wavenumber_cm1[:1]
    assembly.clear(wavenumber, sun)
    if assembly.has_cloud:
        assembly.cloudy(wavenumber, assembly.extreme_thicknesses_m, sun)


def probe_last_frame(assembly: Assembly, last_s: float) -> None:
    """Compute one pixel of the last frame with each windowed generator, whose range of motion may be limited.

    Raises
    ------
    ScenarioError
        If a generator fails there but not at the start; names ``frames``.
    ProviderError
        If it fails at both times, or by accident.
    """
    pixel = slice(0, 1), slice(0, 1)
    for generator in compress(assembly.generators, assembly.cloudy_layers):
        if generator.declares.tileable:
            try:
                generator.thickness_m(last_s, *pixel)
            except ProviderDefect:
                raise
            except ProviderError as error:
                if _fails(partial(generator.thickness_m, 0.0, *pixel)):
                    raise
                raise ScenarioError([Problem("frames", str(error))]) from error


def _fails(ask: Callable[[], object]) -> bool:
    try:
        ask()
    except ProviderError:
        return True
    return False
