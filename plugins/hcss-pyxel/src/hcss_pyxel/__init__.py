"""Cubes of hcss_twin in Pyxel: ``func: hcss_pyxel.load_cube`` in the photon collection of a pipeline."""

from hcss_pyxel.loader import load_cube

__all__ = ["load_cube"]
