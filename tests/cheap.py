"""The models of the HCSS paper, which compile in a tenth of a second: for tests of anything but radiance.

The default models take seconds to minutes for the same scene. Tests that hold for any models name these. Pixels are
columns, each for itself over one sea: shadows, parallax and texture are on in the tests of them.
"""

APART = {"slant.shadows": "off", "slant.parallax": "off", "sea.waves": "off", "sea.temperature_texture": 0.0}
"""Overrides of a scenario whose pixels are columns, each for itself over the mean sea."""

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"} | {
    key: value for key, value in APART.items() if key != "sea.waves"
}
"""Overrides of a scenario; the sea has no waves as shapes."""

NARROW = [{"name": "mwir", "limits": [3.6, 3.8]}, {"name": "lwir", "limits": [10.5, 11.0]}]
"""Bands under the names of wide ones, for laws that hold in any: the time of a scene grows with its wavenumbers."""

CHEAP_OPTIONS = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
"""The same for the command line."""
