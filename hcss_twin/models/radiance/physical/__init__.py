"""Radiance model ``physical``: multiple scattering over a rough sea, with exact energy conservation."""
