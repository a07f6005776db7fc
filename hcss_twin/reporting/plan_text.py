"""The plan as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from hcss_twin.providers import CloudLayer
from hcss_twin.scene.budget import SHARES
from hcss_twin.scene.building.particles import told
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.quantization import quantization_lines


def plan_text(plan: Plan) -> str:
    """Describe what a scene needs, what was filled in and what is left out."""
    return "\n".join(_lines(plan))


def _lines(plan: Plan) -> Iterator[str]:
    scenario, grid = plan.scenario, plan.grid
    yield scenario.title or scenario.origin
    rows, columns = plan.pixels
    yield f"  frames      {plan.frame_times_s.size} x {rows} x {columns} pixels of {grid.pixel_size_m:g} m"
    if plan.is_window:
        first = " and ".join(
            f"{name} {each.start}" for name, each in zip(("row", "column"), plan.extent, strict=True)
        )
        yield f"              a window of {grid.rows} x {grid.columns} pixels, from {first} on"
    points = plan.samples_per_pixel
    if points > 1:
        yield f"  pixel       mean of {points} x {points} points, {grid.pixel_size_m / points:g} m apart"
    for band in plan.bands:
        yield f"  band        {band.name}: {band.lower_um:g}-{band.upper_um:g} um"
    yield f"  view        zenith {plan.view.zenith_deg:g} deg, azimuth {plan.view.azimuth_deg:g} deg"
    yield (
        f"  sun         zenith {plan.sun_zenith_deg[0]:.3f}..{plan.sun_zenith_deg[-1]:.3f} deg, "
        f"azimuth {plan.sun_azimuth_deg[0]:.3f}..{plan.sun_azimuth_deg[-1]:.3f} deg"
    )
    for layer in plan.layers if len(plan.layers) > 1 else ():
        yield f"  layer       {layer.name}: {layer.base_m:g}-{layer.top_m:g} m, coverage {layer.coverage:g}"
    for layer in plan.layers:
        yield f"  particles   {_particles(layer)}"
    for kind, entry in plan.assembly.entries.items():
        yield f"  {kind:<11} {entry.name} [{entry.origin}]"
    if plan.needs_radiance:
        known = plan.spectral_grid.wavenumber_cm1.size
        yield f"  accuracy    {plan.accuracy}; of it {_shares(plan)}"
        yield f"  spectrum    a few weighted wavenumbers of {known}, chosen by the run"
    yield f"  variables   {', '.join(spec.name for spec in plan.variables)}"
    yield f"  cube        {_size(plan.uncompressed_bytes)} before compression"
    for line in quantization_lines(plan.variables, plan.scenario.output.compression > 0):
        yield f"  rounding    {line}"
    for item in plan.filled_in:
        yield f"  filled in   {item.field} = {item.value} ({item.why})"
    for note in plan.notes:
        yield f"  note        {note}"
    for skipped in plan.skipped:
        yield f"  skipped     {skipped.what}: {skipped.why}{_bound(skipped.bound)}"


def _particles(layer: CloudLayer) -> str:
    about = told(layer)
    return (
        f"{about['name']}: {about['phase']}, effective radius {about['effective_radius_um']:.4g} um, variance "
        f"{about['effective_variance']:.3g}, {about['water_content_g_m3']:.3g} g m-3; extinction "
        f"{about['large_particle_extinction_m1']:.3g} m-1 of large particles"
    )


def _shares(plan: Plan) -> str:
    """What each approximation that the scene makes may have of the accuracy."""
    several = sum(plan.cloudy_layers) > 1
    made = {
        "thickness": any(plan.cloudy_layers),
        "two_layers": several,
        "faint_sunlight": plan.faint_sunlight is not None,
        "waves": plan.waves is not None,
        "shadows": plan.scenario.slant.shadows,
        "time": plan.sun_matters and plan.frame_times_s.size > 1,
        "other_instants": plan.sun_matters and plan.frame_times_s.size > 1 and any(plan.cloudy_layers),
    }
    shares = (
        f"{100 * share:g} % {name.replace('_', ' ')}"
        for name, share in SHARES.items()
        if made.get(name, True)
    )
    return ", ".join(shares)


def _bound(bound: float | None) -> str:
    if bound is None:
        return ""
    return " (nothing lost)" if bound == 0 else f" (at most {bound:.1e} of the radiance)"


def _size(count: int) -> str:
    for unit, factor in (("TB", 1e12), ("GB", 1e9)):
        if count >= factor:
            return f"{count / factor:.1f} {unit}"
    return f"{count / 1e6:.1f} MB"
