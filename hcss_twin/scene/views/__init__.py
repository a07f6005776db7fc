"""Directions of view over a wide field: every pixel is seen along its own."""
