"""The gas between sea, clouds and sensor: profile, paths, transmittance, path radiance."""
