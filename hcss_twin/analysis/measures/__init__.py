"""Judging images: fractal dimension, histogram metrics, morphology."""
