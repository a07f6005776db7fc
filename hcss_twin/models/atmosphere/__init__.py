"""Atmosphere models: profiles, transmittance and path radiance between sea, clouds and sensor."""
