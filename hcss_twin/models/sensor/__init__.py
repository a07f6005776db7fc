"""Sensor model: the default radiometer and its stages, one file each."""
