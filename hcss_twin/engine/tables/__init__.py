"""Radiance tables: choice of columns and wavenumbers, and interpolation for frames."""
