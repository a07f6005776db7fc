"""Radiance model ``physical``: multiple scattering, a rough sea, and rows that sum to one."""
