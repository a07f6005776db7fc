"""Whether frames may be written while the next are computed."""

from __future__ import annotations

from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import OWN_DISTRIBUTION
from hcss_twin.scene.plan import Plan


def overlaps(plan: Plan) -> bool:
    """Return whether what is called while frames are computed is known not to read NetCDF files.

    The library is not thread safe, so that no frame can be written while a provider reads. Ours read their files
    when they are made; of those from other packages that is not known, and their frames are written in between.
    """
    asked = (Kind.CLOUDS,) if plan.waves is None else (Kind.CLOUDS, Kind.SEA)
    entries = plan.assembly.entries.values()
    return all(entry.distribution == OWN_DISTRIBUTION for entry in entries if entry.kind in asked)
