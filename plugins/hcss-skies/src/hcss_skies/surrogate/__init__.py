"""Surrogates of a measured cloud image: same amplitudes and spectrum, random phases."""
