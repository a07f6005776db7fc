"""What a cube says about how it came to be."""

from __future__ import annotations

import json

from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.description import describe_particles, describe_providers
from hcss_twin.plan.plan import Plan


def provenance(plan: Plan, tables: RadianceTables | None) -> dict[str, str | float | int]:
    """Global attributes: scenario, seed, versions, plugin distributions, hashes of the files used.

    Call it after the tables are compiled: files are read when they are needed.
    """
    scenario = plan.scenario
    attributes: dict[str, str | float | int] = {
        "title": scenario.title or "Simulated infrared image sequence of clouds over sea",
        "summary": _summary(plan),
        "hcss_scenario": scenario.to_json(),
        "hcss_seed": str(scenario.seed),
        "hcss_versions": json.dumps(plan.catalog.shelf.versions()),
        "hcss_providers": json.dumps(describe_providers(plan.assembly.entries)),
        "hcss_files_sha256": json.dumps(plan.catalog.used),
        "hcss_filled_in": json.dumps([vars(item) for item in plan.filled_in]),
        "hcss_skipped": json.dumps([vars(item) for item in plan.omissions]),
        "hcss_particles": json.dumps([describe_particles(layer) for layer in plan.layers]),
        "hcss_notes": json.dumps(plan.notes),
    }
    if plan.needs_radiance:
        attributes["hcss_accuracy_requested"] = plan.accuracy.relative
    if plan.needs_radiance and plan.accuracy.kelvin is not None:
        attributes["hcss_accuracy_requested_kelvin"] = plan.accuracy.kelvin
    wave_height = getattr(plan.assembly.sea, "significant_wave_height_m", None)
    if wave_height is not None:
        attributes["hcss_significant_wave_height_m"] = float(wave_height)
    if tables is not None:
        attributes["hcss_table_error_estimated"] = tables.estimated_error
        attributes["hcss_table_errors"] = json.dumps(vars(tables.errors))
        attributes["hcss_wavenumbers_used"] = int(tables.spectrum.nodes.wavenumber_cm1.size)
        attributes["hcss_wavenumbers_known"] = tables.spectrum.dense
    return attributes


def _summary(plan: Plan) -> str:
    names = [layer.name for layer in reversed(plan.layers)]
    clouds = f"{' over '.join(names)} clouds" if names else "clear sky"
    bands = ", ".join(f"{band.lower_um:g}-{band.upper_um:g} um" for band in plan.bands)
    points = plan.samples_per_pixel
    averaged = f", each pixel the mean of {points} x {points} points" if points > 1 else ""
    return (
        f"Band-integrated radiance at the sensor of {clouds} over sea in {bands}{averaged}, computed by hcss_twin with "
        f"the radiance model '{plan.scenario.radiance.model}'."
    )
