"""Comparison of a real image or sequence with a simulated one."""
