"""Cloud optics: scattering by spheres and ice crystals, integrated over sizes, by wavelength."""
