"""Recomputation of random pixels of a cube on the reference path, and the certificate made from it.

The certificate states the error of the engine relative to an evaluation of the selected providers that is finer in all
numerical choices, for the exact column of each pixel and without tables
(:mod:`~hcss_twin.engine.certificate.reference_columns`). It does not include the providers' own errors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.cube.variables import TOTAL
from hcss_twin.engine.certificate.certificate import DARK_W_M2_SR, DIGITS, Certificate, StratumCheck, share_of_all
from hcss_twin.engine.certificate.certificate_pixels import SampledPixels
from hcss_twin.engine.certificate.clear_points import ClearPoint, ClearPoints, changes, computed_at_once
from hcss_twin.engine.certificate.many_points import solve_many
from hcss_twin.engine.certificate.part_sample import strata_of
from hcss_twin.engine.certificate.reference_columns import References, columns_afresh
from hcss_twin.engine.scene_points import seen_fields
from hcss_twin.engine.stages.scene_stages import SceneTables
from hcss_twin.engine.stages.stage import NOT_SEEN, REASONS, WITH_ELEMENTS
from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.engine.tables.radiance_tables import Quantities, RadianceTables
from hcss_twin.engine.tables.scene_axes import point_axes
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.error_budget import beyond_accuracy, error_budget, left_out
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import View


@in_one_thread
def certify(
    plan: Plan, tables: RadianceTables, frames: Sequence[SampledPixels], from_curves: bool = False
) -> Certificate:
    """Recompute the sampled pixels on the reference path and compare.

    Parameters
    ----------
    frames : sequence of SampledPixels
        Sampled pixels from the run of this plan.
    from_curves : bool
        Whether reference columns may be read from curves that the points of a sweep share. Curves pay only if all
        pixels have the same view and surface; other scenes have none. Certificates of a random tenth of the scenes
        solve some columns nevertheless.

    Raises
    ------
    ProviderError
        If a provider breaks its contract.
    """
    names, bands = strata_of(plan), len(plan.bands)
    possible = {WITH_ELEMENTS: bool(plan.assembly.elements), NOT_SEEN: not plan.is_grid}
    quantities = tables.quantities
    nothing = np.empty((0, len(quantities.names), bands))
    written = np.concatenate([nothing, *(pixels.radiance.astype(np.float64) for pixels in frames)])
    axes = point_axes(plan)
    one_model = not plan.views.varies and not axes
    references = References(from_curves and one_model, columns_afresh(plan.scenario) if from_curves else 0)
    exact = _exact(SceneTables(plan, tables, axes), frames, references) if frames else nothing
    away, total = np.abs(written - exact), np.abs(exact[:, :1])
    whole = np.broadcast_to(total, away.shape)
    errors = np.divide(away, whole, out=np.where(away > 0, np.inf, 0.0), where=whole != 0)
    error = errors[:, 0]
    # The cube has single precision: one rounding step does not count as an error of the engine.
    rounding = np.spacing(np.abs(exact).astype(np.float32)).astype(np.float64)
    # NaN counts as exceeding.
    over = ~(away <= plan.accuracy.relative * total + rounding)
    achieved_K: dict[str, float] = {}
    exceeding = np.any(over, axis=(1, 2))
    if plan.accuracy.kelvin is not None:
        away_K, rounding_K = _in_kelvin(plan, written[:, 0], exact[:, 0])
        # The kelvin limit applies to the total; terms use the corresponding fraction of the radiance.
        warm = np.isfinite(away_K)
        over[:, 0] = np.where(warm, away_K > plan.accuracy.kelvin + rounding_K, over[:, 0])
        exceeding = np.any(over, axis=(1, 2))
        away_K = np.where(warm, away_K, 0.0)
        if away_K.size:
            worst_K = np.max(away_K, axis=0)
            achieved_K = {band.name: _rounded(kelvin) for band, kelvin in zip(plan.bands, worst_K, strict=True)}
    worst_of = np.max(errors, axis=(0, 2), initial=0.0)
    terms = {
        name: _rounded(error_of_term)
        for name, error_of_term in zip(quantities.names, worst_of, strict=True)
        if name != TOTAL
    }
    stratum = np.concatenate([np.empty(0, np.int64), *(pixels.stratum for pixels in frames)])
    size = np.array([pixels.pixels for pixels in frames]).reshape(len(frames), len(names))
    checked = np.array([np.bincount(pixels.stratum, minlength=len(names)) for pixels in frames])
    checks = []
    for number, name in enumerate(names):
        in_stratum = stratum == number
        left_out = {
            reason: sum(int(pixels.left_out[row, number]) for pixels in frames)
            for row, reason in enumerate(REASONS)
            if possible[reason]
        }
        pixels_of = int(np.sum(size[:, number])) + sum(left_out.values())
        if pixels_of:
            worst = (
                tuple(_rounded(largest) for largest in np.max(error[in_stratum], axis=0)) if np.any(in_stratum) else ()
            )
            checks.append(
                StratumCheck(
                    name, pixels_of, int(np.sum(in_stratum)), int(np.sum(exceeding[in_stratum])), worst, left_out
                )
            )
    return Certificate(
        requested=plan.accuracy,
        estimated=tables.estimated_error,
        bands=tuple(band.name for band in plan.bands),
        strata=tuple(checks),
        frames=tuple(pixels.frame for pixels in frames),
        open_share=share_of_all(size.ravel(), checked.reshape(size.shape).ravel()),
        terms=terms if error.size else {},
        achieved_K=achieved_K,
        own_errors=plan.assembly.own_errors,
        reference=references.origin,
        sides=plan.light.check(plan, tables, frames[0].frame) if frames else {},
        interpolation=references.interpolation,
        dark=tuple(
            band.name
            for band, brightest in zip(plan.bands, np.max(total[:, 0], axis=0, initial=0.0), strict=True)
            if error.size and brightest < DARK_W_M2_SR
        ),
    )


def with_verdict(plan: Plan, certificate: Certificate) -> Certificate:
    """Return the certificate with what the plan leaves out, and the budget with the achieved error of the engine."""
    budget = error_budget(plan, certificate.achieved)
    return replace(certificate, beyond=beyond_accuracy(plan), left_out=left_out(plan, budget), budget=budget)


class SampledPoint(NamedTuple):
    """What the exact column of a point depends on.

    Attributes
    ----------
    thickness_m : ndarray (L,)
    time_s : float
    view : View
    perturbation : ndarray (2,)
        By the texture of clear sky, in steps.
    states : tuple
        On each axis along which points differ.
    alone : tuple
        View and time, each None unless columns of others cannot be solved with it.
    clear : ClearPoint or None
        Its wave and shadow; None under cloud, and if the scene has neither.
    """

    thickness_m: Array
    time_s: float
    view: View
    perturbation: Array
    states: tuple[Any, ...]
    alone: tuple[View | None, float | None]
    clear: ClearPoint | None


def _exact(scene: SceneTables, frames: Sequence[SampledPixels], references: References) -> Array:
    """Band radiances (M, Q, B) of the pixels of all frames on the reference path: total and requested terms."""
    assert scene.tables is not None
    plan, axes, quantities, clear_points = scene.plan, scene.axes, scene.tables.quantities, ClearPoints(scene)
    points = [point for pixels in frames for point in _points(plan, axes, pixels, clear_points)]
    exact = np.empty((len(points), len(quantities.names), len(plan.bands)))
    groups: dict[tuple[Any, ...], list[int]] = {}
    for number, point in enumerate(points):
        groups.setdefault((point.states, point.alone), []).append(number)
    for (states, (view, _)), members in groups.items():
        in_state = plan if view is None else plan.toward(view)
        for axis, state in zip(axes, states, strict=True):
            in_state = axis.plan_in(in_state, state)
        exact[members] = _columns(in_state, quantities, [points[member] for member in members], references)
        clear = {member: of_point for member in members if (of_point := points[member].clear) is not None}
        if clear:
            exact[list(clear)] += quantities.of(changes(in_state, list(clear.values()), references))
    pixels = sum(pixels.row.size for pixels in frames)
    if not pixels:
        return exact
    means: Array = np.mean(exact.reshape(pixels, -1, *exact.shape[1:]), axis=1)
    return means


def _points(
    plan: Plan, axes: Sequence[PointAxis[Any]], pixels: SampledPixels, clear_points: ClearPoints
) -> Iterator[SampledPoint]:
    """Yield the points of each pixel of a frame."""
    rows, columns = ((at + of.start).tolist() for at, of in zip((pixels.row, pixels.column), plan.extent, strict=True))
    views = plan.views_of_pixels(rows, columns, pixels.time_s)
    time_s, in_other_air = pixels.time_s, plan.assembly.air_over_field.varies
    perturbations = _perturbations(plan, time_s, rows, columns)
    of_pixels = zip(rows, columns, views, _thickness(plan, pixels), perturbations, strict=True)
    for row, column, view, thickness_m, perturbation in of_pixels:
        own_view = view if plan.views.varies and (in_other_air or not plan.is_grid) else None
        # A pixel of other rays is the mean of many points, whose columns follow from few under one sun.
        alone = own_view, None if plan.is_grid else time_s
        on_axes = [axis.of_pixel(time_s, row, column, thickness_m) for axis in axes]
        states = zip(*on_axes, strict=True) if axes else [()] * len(thickness_m)
        cloudless = ~np.any(thickness_m, axis=1)
        clear = clear_points.of_pixel(time_s, row, column, view, perturbation) if np.any(cloudless) else None
        for number, (of_point, state) in enumerate(zip(thickness_m, states, strict=True)):
            of_clear = clear[number] if clear is not None and cloudless[number] else None
            yield SampledPoint(of_point, time_s, view, perturbation, state, alone, of_clear)


def _thickness(plan: Plan, pixels: SampledPixels) -> Array:
    """Thickness (M, points, L); what single precision rounds beyond the limits is clipped, as in the look-up."""
    thickness = np.moveaxis(pixels.thickness_m, 1, 2).astype(np.float64)
    for index, layer in enumerate(plan.layers):
        of_layer = thickness[..., index]
        np.clip(of_layer, layer.thickness_min_m, layer.thickness_max_m, out=of_layer, where=of_layer > 0)
    return thickness


def _perturbations(plan: Plan, time_s: float, rows: Sequence[int], columns: Sequence[int]) -> Array:
    """Perturbation (M, 2) of each pixel by the texture of clear sky, in steps."""
    fields = plan.texture.fields(plan.scenario, plan.assembly)
    if computed_at_once(plan):
        whole = np.stack(seen_fields(plan, fields, time_s, plan.extent), axis=-1)
        first_row, first_column = (of.start for of in plan.extent)
        found: Array = whole[np.subtract(rows, first_row), np.subtract(columns, first_column)].astype(np.float64)
        return found
    at_pixels = [
        np.ravel(seen_fields(plan, fields, time_s, (slice(row, row + 1), slice(column, column + 1))))
        for row, column in zip(rows, columns, strict=True)
    ]
    return np.array(at_pixels, dtype=np.float64).reshape(-1, 2)


def _columns(plan: Plan, quantities: Quantities, points: Sequence[SampledPoint], references: References) -> Array:
    """Return the columns (N, Q, B) of points, each different one solved once."""
    sun_at = {time_s: plan.sun_up_at(time_s) for time_s in {point.time_s for point in points}}
    seen = [(sun_at[point.time_s], point.view) for point in points]
    different = list(dict.fromkeys(seen))
    number = {one: index for index, one in enumerate(different)}
    thickest = [layer.thickness_max_m for layer in plan.layers]  # of this state: higher tops may be thicker
    thickness_m = np.minimum(np.array([point.thickness_m for point in points]), thickest)
    rows = np.column_stack(([number[one] for one in seen], thickness_m))
    both, which = np.unique(rows, axis=0, return_inverse=True)
    columns = np.asarray(both[:, 1:], dtype=np.float64)
    suns = [different[index][0] for index in both[:, 0].astype(int)]
    views = [different[index][1] for index in both[:, 0].astype(int)] if plan.views.varies else ()

    def solved(terms_of: Callable[..., Array]) -> Array:
        """Quantities (S, N, Q, B) of the columns in S states; of rays without a grid from few, under one sun."""
        if plan.is_grid:
            return quantities.of(terms_of(columns, suns, views))

        def of_some(some: Array) -> Array:
            states = quantities.of(terms_of(some, suns[:1] * len(some), ()))
            return np.moveaxis(states, 0, 1).reshape(len(some), -1, states.shape[-1])

        few = solve_many(of_some, columns, plan.accuracy.relative)
        return np.moveaxis(few.reshape(len(columns), -1, len(quantities.names), few.shape[-1]), 1, 0)

    (known,) = solved(lambda *of_columns: references.terms(plan, *of_columns)[None])
    of_points: Array = known[which.ravel()] + plan.texture.change(
        np.array([point.perturbation for point in points]),
        lambda: solved(partial(references.perturbed, plan))[:, which.ravel()],
    )
    return of_points


def _in_kelvin(plan: Plan, written: Array, exact: Array) -> tuple[Array, Array]:
    """Errors of the brightness temperature and one step of single precision of the radiance, both (M, B) in K.

    NaN if either radiance has no brightness temperature: the relative error then decides.
    """
    temperature = BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])

    def kelvin(radiance: Array) -> Array:
        return temperature.where_known(radiance.T).T

    if not exact.size:
        return exact, exact
    true = kelvin(exact)
    step = kelvin(exact + 2.0 * np.spacing(np.abs(exact).astype(np.float32))) - true
    return np.abs(kelvin(written) - true), np.abs(step)


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
