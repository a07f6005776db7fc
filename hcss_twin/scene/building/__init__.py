"""Providers of a scene, built from what the scenario names."""
