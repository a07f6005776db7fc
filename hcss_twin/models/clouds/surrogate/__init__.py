"""Surrogates of a measured cloud image: its amplitudes and its spectrum with random phases."""
