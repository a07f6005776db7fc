"""What is kept: name of its folder in the cache, and how its files end."""

TABLES = ("tables", ".npz")
"""Compiled tables of scenes."""

OPTICS = ("optics", ".nc")
"""Bulk properties of cloud particles."""
