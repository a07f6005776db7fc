"""Cubes in the formats of other programs: one file per format, and what all of them are told."""
