"""Recomputation of random pixels of a cube on the reference path, and the certificate made from it.

The certificate states the error of the engine relative to an evaluation of the selected providers that is finer in all
numerical choices, for the exact column of each pixel and without tables
(:mod:`~hcss_twin.engine.certificate.reference_columns`). It does not include the providers' own errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.engine.certificate.certificate import DARK_W_M2_SR, DIGITS, Certificate, StratumCheck, share_of_all
from hcss_twin.engine.certificate.certificate_pixels import SampledPixels
from hcss_twin.engine.certificate.many_points import solve_many
from hcss_twin.engine.certificate.part_sample import strata_of
from hcss_twin.engine.certificate.reference_columns import References, columns_afresh
from hcss_twin.engine.stages.stage import REASONS
from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.engine.tables.radiance_tables import TOTAL, Quantities, RadianceTables
from hcss_twin.engine.tables.scene_axes import point_axes
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.error_budget import beyond_accuracy, error_budget
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun, View


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
    reasons = REASONS if not plan.is_grid else REASONS[:3] if plan.assembly.elements else REASONS[:2]
    quantities = tables.quantities
    nothing = np.empty((0, len(quantities.names), bands))
    written = np.concatenate([nothing, *(pixels.radiance.astype(np.float64) for pixels in frames)])
    axes = point_axes(plan)
    one_model = plan.views is None and not axes
    references = References(from_curves and one_model, columns_afresh(plan.scenario) if from_curves else 0)
    exact = _exact(plan, axes, quantities, frames, references) if frames else nothing
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
            reason: sum(int(pixels.left_out[row, number]) for pixels in frames) for row, reason in enumerate(reasons)
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
        sides=plan.light.check(plan, tables, frames[0].frame) if plan.light is not None and frames else {},
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
    return replace(certificate, beyond=beyond_accuracy(plan, budget), budget=budget)


def _exact(
    plan: Plan,
    axes: Sequence[PointAxis[Any]],
    quantities: Quantities,
    frames: Sequence[SampledPixels],
    references: References,
) -> Array:
    """Band radiances (M, Q, B) of the pixels of all frames on the reference path: total and requested terms."""
    if axes:
        return np.concatenate([_of_points(plan, axes, quantities, pixels, references) for pixels in frames])
    if plan.is_grid and (plan.views is None or plan.assembly.air_over_field is None):  # all pixels together
        return _means(plan, quantities, _states_of(plan, frames), references)
    every = [np.empty((0, len(quantities.names), len(plan.bands)))]
    for pixels in frames:
        if plan.views is None:
            every.append(_means(plan, quantities, _states_of(plan, [pixels]), references))
            continue
        for index, view in enumerate(_views(plan, pixels)):
            toward = plan.toward(view)
            every.append(_means(toward, quantities, _states_of(toward, [pixels.only(index)]), references))
    return np.concatenate(every)


def _views(plan: Plan, pixels: SampledPixels) -> Sequence[View]:
    if plan.views is None:
        return [plan.view] * pixels.row.size
    return plan.rays.views_of_pixels(*_in_image(plan, pixels), pixels.time_s)


def _thickness(plan: Plan, pixels: SampledPixels) -> Array:
    """Thickness (M, points, L); what single precision rounds beyond the limits is clipped, as in the look-up."""
    thickness = np.moveaxis(pixels.thickness_m, 1, 2).astype(np.float64)
    for index, layer in enumerate(plan.layers):
        of_layer = thickness[..., index]
        np.clip(of_layer, layer.thickness_min_m, layer.thickness_max_m, out=of_layer, where=of_layer > 0)
    return thickness


def _in_image(plan: Plan, pixels: SampledPixels) -> tuple[list[int], list[int]]:
    """Rows and columns (M,) of pixels in the image, of which the cube may be a window."""
    return (pixels.row + plan.extent[0].start).tolist(), (pixels.column + plan.extent[1].start).tolist()


def _perturbations(plan: Plan, pixels: SampledPixels) -> Array:
    """Perturbation (M, 2) of each pixel by the texture of clear sky, in steps; (M, 0) without texture."""
    if plan.texture is None:
        return np.empty((pixels.row.size, 0))
    from hcss_twin.plan.texture import TextureFields  # not for scenes without texture

    fields = TextureFields(plan.scenario, plan.assembly, plan.texture)
    at_pixels = [
        np.ravel(fields.at(pixels.time_s, slice(row, row + 1), slice(column, column + 1)))
        for row, column in zip(*_in_image(plan, pixels), strict=True)
    ]
    return np.array(at_pixels, dtype=np.float64).reshape(-1, 2)


@dataclass(frozen=True)
class PixelStates:
    """Thickness (M, P, L) at the points of M pixels, and sun, view and perturbation (M, 2) of each pixel."""

    thickness_m: Array
    suns: Sequence[Sun | None]
    views: Sequence[View]
    perturbation: Array


def _states_of(plan: Plan, frames: Sequence[SampledPixels]) -> PixelStates:
    return PixelStates(
        np.concatenate([_thickness(plan, pixels) for pixels in frames]),
        [plan.sun_up_at(pixels.time_s) for pixels in frames for _ in pixels.row],
        [view for pixels in frames for view in _views(plan, pixels)],
        np.concatenate([_perturbations(plan, pixels) for pixels in frames]),
    )


def _means(plan: Plan, quantities: Quantities, states: PixelStates, references: References) -> Array:
    """Pixel means (M, Q, B) of the columns at their points."""
    pixels, points, layers = states.thickness_m.shape
    if not pixels:
        return np.empty((0, len(quantities.names), len(plan.bands)))
    seen = list(zip(states.suns, states.views, strict=True))
    different = list(dict.fromkeys(seen))
    number = {state: index for index, state in enumerate(different)}
    of_pixel = np.repeat([number[state] for state in seen], points)
    rows = np.column_stack((of_pixel, states.thickness_m.reshape(pixels * points, layers)))
    both, which = np.unique(rows, axis=0, return_inverse=True)
    columns = np.asarray(both[:, 1:], dtype=np.float64)
    suns = [different[index][0] for index in both[:, 0].astype(int)]
    views = [different[index][1] for index in both[:, 0].astype(int)] if plan.views is not None else ()

    def under_one_sun(columns: Array) -> Array:
        return quantities.of(references.terms(plan, columns, suns[:1] * len(columns)))

    if plan.is_grid:
        known = quantities.of(references.terms(plan, columns, suns, views))
    else:  # a pixel of other rays is the mean of many points, all with thicknesses of their own
        known = solve_many(under_one_sun, columns, plan.accuracy.relative)
    at_points = known[which.ravel()]
    if states.perturbation.size:
        from hcss_twin.plan.texture import Expansion  # not for scenes without texture

        of_columns = quantities.of(references.perturbed(plan, columns, suns, views))
        warmer, drier = np.repeat(states.perturbation.T, points, axis=1)[..., None, None]
        at_points = at_points + Expansion(of_columns[:, which.ravel()])(warmer, drier)
    means: Array = np.mean(at_points.reshape(pixels, points, *known.shape[1:]), axis=1)
    return means


def _of_points(
    plan: Plan, axes: Sequence[PointAxis[Any]], quantities: Quantities, pixels: SampledPixels, references: References
) -> Array:
    """Pixel means (M, Q, B) of columns that are each in a state of its own."""
    rows, columns = _in_image(plan, pixels)
    thickness_m, views = _thickness(plan, pixels), _views(plan, pixels)
    points = thickness_m.shape[1]
    groups: dict[tuple[tuple[Any, ...], View], list[int]] = {}
    for pixel, (row, column, view, layers) in enumerate(zip(rows, columns, views, thickness_m, strict=True)):
        on_axes = [axis.of_pixel(pixels.time_s, row, column, layers) for axis in axes]
        for point, states in enumerate(zip(*on_axes, strict=True)):
            groups.setdefault((states, view), []).append(pixel * points + point)
    of_points = thickness_m.reshape(len(rows) * points, len(plan.layers))
    exact = np.empty((len(of_points), len(quantities.names), len(plan.bands)))
    perturbations = np.repeat(_perturbations(plan, pixels), points, axis=0)
    for (states, view), members in groups.items():
        alone = plan if plan.views is None else plan.toward(view)
        for axis, state in zip(axes, states, strict=True):
            alone = axis.plan_in(alone, state)
        thickness = np.minimum(of_points[members], [layer.thickness_max_m for layer in alone.layers])
        suns = [alone.sun_up_at(pixels.time_s)] * len(members)
        seen = PixelStates(thickness[:, None], suns, [alone.view] * len(members), perturbations[members])
        exact[members] = _means(alone, quantities, seen, references)
    means: Array = np.mean(exact.reshape(-1, points, *exact.shape[1:]), axis=1)
    return means


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
