"""What is kept: name of its folder in the cache, and how its files end."""

TABLES = ("tables", ".npz")
"""Compiled tables of scenes."""

PLANS = ("plans", ".npz")
"""What plans found out about scenes."""

REFERENCES = ("references", ".npz")
"""Columns that certificates were made from."""

OPTICS = ("optics", ".nc")
"""Bulk properties of cloud particles."""
