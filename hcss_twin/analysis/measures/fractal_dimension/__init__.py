"""Estimators of the fractal dimension of a grey-level surface or of a mask's boundary."""
