"""A scene that compiles in a tenth of a second."""

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
"""Overrides: the models of the HCSS paper."""
