"""Multiple scattering in homogeneous layers; this package imports only hcss_twin.physics."""
