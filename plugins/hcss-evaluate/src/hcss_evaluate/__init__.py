"""Comparison of simulated with real images: similarity metrics (``hcss evaluate``) and the realism test."""
