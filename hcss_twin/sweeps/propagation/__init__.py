"""Uncertainty of radiance due to uncertain cloud parameters and other inputs of a scenario."""
