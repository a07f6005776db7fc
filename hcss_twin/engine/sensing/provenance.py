"""What a sensor's cube says about how it came to be."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from hcss_twin.core.environment import versions
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE, Attribute
from hcss_twin.cube.metadata import creation_time
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.engine.recorded import CERTIFICATE, CLEAN_CERTIFICATE
from hcss_twin.plan.sensor import MadeSensor


def sensor_attributes(
    clean: Mapping[str, Any], sensor: MadeSensor, files: Mapping[str, str], clean_name: str
) -> dict[str, Attribute | None]:
    """Return global attributes that differ from those of the clean cube; None for those that go.

    The certificate speaks of clean radiance, which a measured cube does not hold: it is quoted as the clean cube's.

    Parameters
    ----------
    clean : mapping
        Global attributes of the clean cube.
    sensor : MadeSensor
    files : mapping of str to str
        SHA-256 of the files read for the sensor, by name.
    clean_name : str
        Of the clean cube, without its folder; empty if it has no file.
    """
    stamp = creation_time().isoformat(timespec="seconds").replace("+00:00", "Z")
    about = json.dumps(sensor.as_dict())
    scenario = json.loads(str(clean[SCENARIO_ATTRIBUTE]))
    scenario["sensor"] = sensor.section.model_dump(mode="json")
    entry = sensor.entry
    providers = json.loads(str(clean["hcss_providers"]))
    providers[str(entry.kind)] = {"name": entry.name, "distribution": entry.distribution, "version": entry.version}
    identifier = hashlib.sha256(f"{clean.get('id', '')}\n{about}".encode()).hexdigest()[:16]
    title = str(clean.get("title", ""))
    found: dict[str, Attribute | None] = {
        "title": f"{title} - as measured by {sensor.title}" if title else f"As measured by {sensor.title}",
        "summary": f"Measured by the simulated sensor '{sensor.title}' (model '{entry.name}'), not the radiance that "
        f"reaches it: {clean.get('summary', '')}",
        "processing_level": "simulated radiance as measured, with the effects of optics, detector and converter",
        "instrument": sensor.title,
        "id": f"hcss-{identifier}",
        "history": f"{stamp} measured by hcss_twin from {clean_name or 'a clean cube'}\n{clean.get('history', '')}",
        "date_created": stamp,
        "clean_cube": clean_name,
        "clean_cube_id": str(clean.get("id", "")),
        SCENARIO_ATTRIBUTE: json.dumps(scenario, indent=1),
        SENSOR_ATTRIBUTE: about,
        "hcss_providers": json.dumps(providers),
        "hcss_versions": json.dumps({**json.loads(str(clean["hcss_versions"])), **versions()}),
        "hcss_files_sha256": json.dumps(dict(sorted({**json.loads(str(clean["hcss_files_sha256"])), **files}.items()))),
    }
    if "hcss_certificate" in clean:
        found[CLEAN_CERTIFICATE] = str(clean["hcss_certificate"])
    return {**found, **{name: None for name in CERTIFICATE if name in clean}}
