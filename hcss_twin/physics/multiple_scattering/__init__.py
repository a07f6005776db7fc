"""Multiple scattering in homogeneous layers; imports nothing of ours but physics."""
