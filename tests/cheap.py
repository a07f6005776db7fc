"""The models of the HCSS paper, which compile in a tenth of a second: for tests of anything but radiance.

The default models take seconds to minutes for the same scene. Tests that hold for any models name these.
"""

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
"""Overrides of a scenario."""

NARROW = [{"name": "mwir", "limits": [3.6, 3.8]}, {"name": "lwir", "limits": [10.5, 11.0]}]
"""Bands under the names of wide ones, for laws that hold in any: the time of a scene grows with its wavenumbers."""

CHEAP_OPTIONS = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
"""The same for the command line."""
