"""The models of the HCSS paper, which compile in a tenth of a second: for tests of anything but radiance.

The default models take seconds to minutes for the same scene. Tests that hold for any models name these.
"""

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
"""Overrides of a scenario."""

CHEAP_OPTIONS = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
"""The same for the command line."""
