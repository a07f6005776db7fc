"""Decides what a scene needs, and builds its providers; computes no frame."""
