"""Optics of clouds: scattering by spheres and ice crystals, over sizes and wavelengths."""
