"""Decides what to compute for a scene and builds its providers; computes no frames."""
