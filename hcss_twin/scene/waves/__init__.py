"""Waves that pixels resolve."""
