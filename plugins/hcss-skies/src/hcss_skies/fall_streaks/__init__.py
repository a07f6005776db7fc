"""Cirrus by fall streaks: see ``generator.py``."""
