"""Image measures: fractal dimension, histogram metrics, morphology."""
