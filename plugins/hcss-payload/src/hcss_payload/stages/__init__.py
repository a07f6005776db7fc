"""Stages of detectors and optics for ``[[sensor.stages]]``, which the radiometer does not have."""
