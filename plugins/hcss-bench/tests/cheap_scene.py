"""A scene that compiles in a tenth of a second."""

CHEAP = {
    "radiance.model": "as-printed",
    "sea.model": "cox-munk",
    "optics.provider": "mie",
    "slant.shadows": "off",
    "slant.parallax": "off",
}
"""Overrides: the models of the HCSS paper, each pixel a column for itself."""
