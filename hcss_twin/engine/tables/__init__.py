"""Radiance tables: which columns are computed, at which wavenumbers, and how frames look between them."""
